"""What stays unexplained at the end of a diagnosis or a refinement, described."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from dnanalyze.diagnosis.results import Diagnosis, Refinement
    from dnanalyze.fitting.problem import FitProblem
    from dnanalyze.fitting.state import State
    from dnanalyze.loaders.captures import CaptureSet
    from dnanalyze.model.effect import Effect
    from dnanalyze_cli.session import Session

MOST = 30.0  # s for its refits; the search itself is bounded by the pixels that a fit looks at


def describe_residual(
    session: Session,
    captures: CaptureSet,
    problem: FitProblem,
    result: Diagnosis | Refinement,
    known: dict[str, type[Effect]],
    budget: float | None,
    state: State | None = None,
) -> dict[str, Any]:
    """Print the description and give its document under "description"; {} where there is none.

    Parameters
    ----------
    session : Session
    captures : CaptureSet
    problem : FitProblem
        The statistics that the model was fitted to.
    result : Diagnosis or Refinement
        Only a finished one whose verdict is "unexplained" is described.
    known : dict
        Effects by name.
    budget : float or None
        Seconds of the whole command.
    state : State, optional
        The fitted model, by the yardstick of ``problem``; it is simulated by default.
    """
    from dnanalyze.model.composite.effect import CompositeEffect

    over = budget is not None and (session.remaining(budget) or 0.0) < 1.0
    done = result.verdict == "unexplained" and result.finished and not over
    model = result.model
    if not done or model is None or model.get(CompositeEffect.name) is not None:
        return {}
    from dnanalyze.description.describe import described
    from dnanalyze.fitting.state import start
    from dnanalyze.fitting.time_limit import TimeLimit
    from dnanalyze.report.results.description import in_short

    left = min(MOST, session.remaining(budget) or MOST)
    with session.progress("Describing the unexplained residual") as progress:
        limit, fitted = TimeLimit.after(left), state or start(problem, model)
        found = described(captures, problem, fitted, known, limit, progress.now, rivals=False)
    session.print(in_short(found))
    return {"description": found.to_dict()}
