"""From gains on data that no fit saw to a confidence, and to what cannot be told apart."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dnanalyze.comparator.error import LUCK
from dnanalyze.diagnosis.deviance import DEFLATION
from dnanalyze.diagnosis.trial import Trial, standings

# "Nothing is missing" is credited with a gain that noise does not reach, in proportion to the
# misfit that is left. Where nothing, or nothing more, was missing in 60 virtual sensors, 19
# candidates were refitted: their lesser half gained 10 at the most, the mean of both 28.
NOTHING = 25.0
WITNESS = 20.0  # gain of the lesser half, twice what chance reached there
CERTAIN = 60.0  # evidence that leaves "nothing is missing" less than one chance in ten
PLAIN = 300.0  # evidence, in units of the misfit left, that the luck of one sensor does not make
# Of names given where something stayed unexplained, 13 of 19 were there on virtual sensors with an
# effect of the catalogue, and 0 of 24 where it is in none: even odds that it stands in for another.
STANDS_IN = 0.5
# Of six names that took so small a share of an error above 3, and left wrong what they moved, one
# was there: a crosstalk or a blinking for a correction, of which no guess had come near.
HARDLY = 0.2
APART = 0.25  # share of the lesser's gain that both have, below which each explains its own
ALIKE = 0.75  # share of the best gain from which a rival is named as a possible confusion


def confidences(trials: Sequence[Trial], error: float) -> np.ndarray:
    """Probability of each candidate, and of none of them in the last place.

    Parameters
    ----------
    trials : sequence of Trial
    error : float
        Of the model without any of them; what does not lower it gains nothing.

    Returns
    -------
    ndarray
        (candidates + 1,), sums to 1.
    """
    worse = [not lowers(t, error) for t in trials]
    known = np.append(np.where(worse, np.minimum(s := standings(trials), 0.0), s), NOTHING)
    excess = known - known.max()
    weight = np.exp(excess / (2.0 * DEFLATION))
    return weight / weight.sum()


def confidence_of(found: Trial, trials: Sequence[Trial], error: float) -> float:
    """Probability that a candidate is missing; even odds at best where it hardly lowers the error.

    What explains other statistics may be missing beside it, and is no rival. Parameters are those
    of `confidences`.
    """
    others = [t for t in trials if t is not found and not apart(found, t)]
    sure = float(confidences([found, *others], error)[0])
    hardly = not found.tolerable and error - found.error < HARDLY * (error - 1.0)
    return min(sure, STANDS_IN) if hardly else sure


def lowers(found: Trial, error: float) -> bool:
    """Whether a model that stands at ``error`` is better with the effect, on the unseen half.

    The few defects or tracks of a half may be more or fewer than their density says: where the
    evidence is certain the error may rise by what it scatters over simulated sensors of one make.
    """
    return found.error < error * (1.0 + (LUCK if found.evidence > CERTAIN * found.spread else 0.0))


def significant(found: Trial, error: float, least: float = CERTAIN) -> bool:
    """Whether an effect is worth adding to a model that stands at ``error``.

    The mean of its gains must be beyond what a useless effect could reach by chance, and leave
    "nothing is missing" less than one chance in ten (``least``); either half must give its part of
    it, and the pooled error of the unseen half must fall. Chance reaches farther in proportion to
    the misfit that is left (`Trial.spread`): a useless effect bends with it. Where none is left
    there is chance alone, not alike in both halves: two witnesses, each beyond it, are enough to
    make the effect likelier than nothing.
    """
    lesser = min(found.gain, found.fitted_gain) / found.spread
    enough = found.evidence > max(NOTHING, least) * found.spread
    witnesses = found.tolerable and lesser > WITNESS and found.evidence > NOTHING * found.spread
    return (enough or witnesses) and lesser > NOTHING / 4 and lowers(found, error)


def apart(one: Trial, other: Trial) -> bool:
    """Whether two candidates explain different statistics: neither stands in for the other."""
    a, b = (np.maximum(t.falls, 0.0) for t in (one, other))
    return bool(np.minimum(a, b).sum() < APART * min(a.sum(), b.sum()))


def rivals(best: Trial, trials: Sequence[Trial]) -> list[str]:
    """Candidates that explain nearly as much as the best, and of the same."""
    near = [t for t in trials if t is not best and t.evidence > ALIKE * best.evidence > 0]
    return [t.effect for t in near if not apart(best, t)]
