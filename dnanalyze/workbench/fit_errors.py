"""Model errors before and after a fit, by the yardstick of the fitted model.

Errors by two yardsticks do not tell which model is closer: with a model that scatters more the same
difference is fewer sigma.
"""

from __future__ import annotations

from collections.abc import Callable

from dnanalyze.comparator.error import way
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.report.words import number
from dnanalyze.workbench.evaluation import Evaluation, error_by
from dnanalyze.workbench.history import History, Node


def with_errors_before(
    history: History, found: Evaluation, kept: Callable[[NoiseModel], Evaluation | None]
) -> History:
    """The history with what fits that ended at an evaluated model began with.

    ``kept``: the evaluation of another model, None where it is no longer held.
    """
    for node in history.nodes:
        if node.model != found.model or node.command[:1] != ("fit",) or node.before is not None:
            continue
        assert node.parent is not None
        known = kept(history.node(node.parent).model)
        if known is not None:
            history = history.beside(node.number, error_by(found.problem, known))
    return history


def rises(fit: Node, after: float | None) -> bool:
    """Whether the error rises with a fit; False where that before is not computed."""
    return fit.before is not None and after is not None and way(fit.before, after) == "rises"


def refused(fit: Node) -> str:
    """That the model before a fit was kept, in a sentence."""
    assert fit.before is not None
    assert fit.error is not None
    return (
        f"The model was kept: with the fit the model error rises from {number(fit.before)} to "
        f"{number(fit.error)}."
    )


def two_yardsticks(fit: Node, parent: Node) -> str:
    """Why a fit that is closer has the larger stated error; nothing where it has not."""
    if fit.before is None or fit.error is None or parent.error is None or not parent.exact:
        return ""
    if way(parent.error, fit.error) != "rises" or rises(fit, fit.error):
        return ""
    return (
        f"The fit is closer: by the σ of this model the error falls from {number(fit.before)} to "
        f"{number(fit.error)}; {number(parent.error)} was by the larger σ of the model before."
    )
