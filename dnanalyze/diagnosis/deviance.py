"""Misfit as evidence, and how much of it is left where an effect was put in."""

from __future__ import annotations

import numpy as np

DOUBT = 6.0  # floors from which a difference tells less and less
TOLERABLE = 1.3  # an error below this is never called unexplained on its own
# Statistics are correlated, so a gain overstates twice the log likelihood ratio: neighbouring
# quantiles and bands move together, about eight at a time. Reasoned.
DEFLATION = 8.0


def deviance(z: np.ndarray) -> float:
    """Misfit as evidence: z^2 for small differences, growing as their log beyond `DOUBT` floors.

    However far off, one statistic is one witness: a saturated quantile, a floor that is too small
    by luck. (Twice the negative log likelihood of Student's t, but for a constant factor.)
    """
    return float(np.sum(_witness(z)))


def _witness(z: np.ndarray) -> np.ndarray:
    """The deviance of each statistic."""
    return DOUBT**2 * np.log1p((z / DOUBT) ** 2)


def falls(names: np.ndarray, before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """Fall of the deviance of each statistic, over all settings.

    Parameters are those of `dispersion`.

    Returns
    -------
    ndarray
        One a name, in their order.
    """
    _, was, now = _by_name(names, before, after)
    return was - now


def _by_name(names: np.ndarray, *z: np.ndarray) -> tuple[np.ndarray, ...]:
    """How many numbers a statistic has, and its deviance by each of several misfits."""
    _, which = np.unique(names, return_inverse=True)
    return tuple(np.bincount(which, w) for w in (np.ones(names.size), *map(_witness, z)))


def dispersion(names: np.ndarray, before: np.ndarray, after: np.ndarray) -> float:
    """Misfit per statistic that an effect leaves where it changes the fit, at least 1.

    While more than one effect is missing, differences of gain measure how a candidate bends around
    what is still wrong, and count for less (the overdispersion of a quasi-likelihood). What is
    wrong with statistics that it leaves as they are says nothing against it: the misfit is that of
    the statistics as it moves their deviance, or of all of them if that is less.

    Parameters
    ----------
    names : ndarray of str
        (statistics,).
    before, after : ndarray
        (statistics,), differences in floors without and with the effect.
    """
    if not names.size:
        return 1.0
    count, was, now = _by_name(names, before, after)
    moved = np.abs(was - now)
    there = float(np.sum(moved * now / count) / np.sum(moved)) if moved.any() else np.inf
    left = min(there, float(now.sum() / names.size))
    return max(1.0, left)
