"""Results of a diagnosis and of a refinement."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

from dnanalyze.classifier.result import Classification
from dnanalyze.diagnosis.detectability import DetectionLimit
from dnanalyze.diagnosis.selection import Trial
from dnanalyze.digits import number
from dnanalyze.fitting.agreement import Agreement, agreements
from dnanalyze.fitting.fit import Fit, Parameters, uncertain
from dnanalyze.fitting.level import Level
from dnanalyze.fitting.problem import FitProblem
from dnanalyze.fitting.state import State
from dnanalyze.fitting.whole_field import Coverage, coverage
from dnanalyze.loaders.captures import CaptureSet
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.result import Result


@dataclass(frozen=True)
class Candidate:
    """An effect that may be missing, with the evidence for it.

    Parameters
    ----------
    effect : str
    error_after : float
        Model error on the held-out half after a refit with the effect.
    explained : float
        Share of the model error above 1 that it removes, 0 to 1.
    confidence : float
        Probability that this is the effect to add next.
    confused_with : list of str
        Candidates that explain nearly as much of the same statistics.
    evidence : list of str
        Sentences.
    leaves : list of str
        Statistics that the model leaves and that the effect does not correct, worst first.
    """

    effect: str
    error_after: float
    explained: float
    confidence: float
    confused_with: list[str]
    evidence: list[str]
    leaves: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class Step:
    """One step of a refinement, and the model error after it.

    Parameters
    ----------
    added : str, optional
        Effect; "-name" if it was removed; None for the starting model.
    error : float
        Model error, dimensionless.
    confidence : float, optional
        Probability that the effect was missing; None where nothing was tested.
    evidence : list of str
        Sentences.
    confused_with : list of str
        Effects that explained nearly as much of the same statistics.
    supported : bool
        Whether the captures support it; an effect that the user adds may not be.
    model : NoiseModel, optional
        The model after the step, before what a later step refits.
    """

    added: str | None
    error: float
    confidence: float | None = None
    evidence: list[str] = field(default_factory=list)
    confused_with: list[str] = field(default_factory=list)
    supported: bool = True
    model: NoiseModel | None = field(default=None, repr=False)


@dataclass(frozen=True, repr=False)
class Diagnosis(Result):
    """Diagnosis of a model: verdict and candidates.

    Parameters
    ----------
    captures : CaptureSet
        The measured frames.
    error : float
        Model error, dimensionless.
    verdict : str
        "adequate", "missing" or "unexplained".
    candidates : list of Candidate
        In the order of confidence, the identified effect first. If the model has no baseline
        effects, these follow an effect that is missing in addition. Empty where the model is
        adequate.
    unexplained : list of str
        Statistics not explained, worst first: by the identified effect, or by the model where the
        captures support no candidate.
    detection_limits : dict
        Effect to its detection limit.
    next_capture : list of str
        Recommended captures.
    model : NoiseModel
        The refitted model, to which the candidates were added.
    begun : NoiseModel
        The starting model, refitted.
    trials : list of Trial
        The candidates as they were refitted.
    ordinary : list of str
        Baseline effects that the model lacked; they were added before other effects were tested.
    level : Level, optional
        Difference of the mean dark signal, which is within limits for an adequate model.
    law : str
        Sentence on the relative standard deviation of the dark current over temperature, where the
        model includes this dependence; else empty.
    direct : list of Agreement
        Quantities that the frames determine without a model, beside the model's; those of an
        adequate model agree.
    coverage : Coverage, optional
        What of the captures the verdict rests on.
    finished : bool
        Whether every candidate was tested; False where the time limit ended the search.
    screened : list of str
        If not finished: effects in the order of the fall of the error that first-order screening
        expects; no refit has confirmed them.
    """

    captures: CaptureSet = field(compare=False)
    error: float
    verdict: str
    candidates: list[Candidate]
    unexplained: list[str]
    detection_limits: dict[str, DetectionLimit] = field(default_factory=dict)
    next_capture: list[str] = field(default_factory=list)
    model: NoiseModel | None = None
    begun: NoiseModel | None = None
    trials: list[Trial] = field(default_factory=list)
    ordinary: list[str] = field(default_factory=list)
    level: Level | None = None
    law: str = ""
    direct: list[Agreement] = field(default_factory=list)
    coverage: Coverage | None = None
    finished: bool = True
    screened: list[str] = field(default_factory=list)

    def _brief(self) -> str:
        best = f", {self.candidates[0].effect}" if self.candidates else ""
        return f"{self.captures.name}, model error {number(self.error)}, {self.verdict}{best}"


@dataclass(frozen=True, repr=False)
class Refinement(Result):
    """Result of a stepwise refinement.

    Parameters
    ----------
    captures : CaptureSet
        The measured frames.
    steps : list of Step
        The first entry is the starting model.
    effects : list of str
        In the final model.
    verdict : str
        "adequate", "missing" (stopped early) or "unexplained".
    model : NoiseModel
        The final model.
    diagnosis : Diagnosis or None
        Of the final model; None where the refinement is not finished.
    problem : FitProblem
        The statistics that were fitted, by the yardstick of the last error, and their simulation.
    state : State
        The last step of the fit.
    by_hand : bool
        Of `add`: the user chose the effect.
    timed_out : bool
        Whether the time limit ended the search, or the computation of the standard errors.
    classification : Classification, optional
        Whether a classifier tells the frames of the final model from the measured ones; None where
        it was not asked.
    """

    captures: CaptureSet = field(compare=False)
    steps: list[Step]
    effects: list[str]
    verdict: str
    model: NoiseModel
    diagnosis: Diagnosis | None
    problem: FitProblem
    state: State
    by_hand: bool = False
    timed_out: bool = False
    classification: Classification | None = None

    def _brief(self) -> str:
        first, last = (number(self.steps[i].error) for i in (0, -1))
        return f"{self.captures.name}, model error {first} to {last}, {', '.join(self.effects)}"

    @property
    def finished(self) -> bool:
        """Whether the search came to its end."""
        return self.diagnosis is not None

    @property
    def unexplained(self) -> list[str]:
        """Statistics that the final model leaves unexplained, worst first."""
        return [] if self.diagnosis is None else self.diagnosis.unexplained

    @cached_property
    def _fitted(self) -> Fit:
        return uncertain(self.problem, self.state, self.finished and not self.timed_out)

    @property
    def parameters(self) -> Parameters:
        """The fitted numbers with their standard errors; simulates when first asked.

        The errors are NaN where the refinement is not finished, or its time limit was reached.
        """
        return self._fitted.parameters

    @property
    def undetermined(self) -> list[str]:
        """Sentences on parameters that are not determined or confounded in these captures."""
        return self._fitted.undetermined

    @cached_property
    def direct(self) -> list[Agreement]:
        """Quantities that the frames determine without a model, beside the final model's."""
        if self.diagnosis is not None:
            return self.diagnosis.direct
        return agreements(self.problem, self.state)

    @property
    def coverage(self) -> Coverage:
        """What of the captures the verdict rests on."""
        known = None if self.diagnosis is None else self.diagnosis.coverage
        return known or coverage(self.problem.plan)

    @property
    def level(self) -> Level | None:
        """Difference of the mean dark signal of the final model."""
        return None if self.diagnosis is None else self.diagnosis.level
