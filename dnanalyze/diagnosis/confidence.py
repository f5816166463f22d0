"""From gains on data that no fit saw to a confidence, and to what cannot be told apart."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dnanalyze.diagnosis.trial import Trial

# The statistics are correlated, so a gain overstates the log likelihood ratio; the divisor and the gain
# that "nothing is missing" is credited with were set on random virtual sensors, see docs/accuracy.md.
DEFLATION = 8.0
NOTHING = 25.0
ALIKE = 0.75  # share of the best gain from which a rival is named as a possible confusion


def confidences(trials: Sequence[Trial]) -> np.ndarray:
    """Probability of each candidate, and of none of them in the last place.

    Parameters
    ----------
    trials : sequence of Trial

    Returns
    -------
    ndarray
        (candidates + 1,), sums to 1.
    """
    gains = np.array([t.gain for t in trials] + [NOTHING])
    weight = np.exp((gains - gains.max()) / (2.0 * DEFLATION))
    return weight / weight.sum()


def significant(found: Trial) -> bool:
    """Whether the gain, on both halves, is beyond what a useless effect could reach by chance."""
    return found.gain > NOTHING and found.fitted_gain > NOTHING


def rivals(best: Trial, trials: Sequence[Trial]) -> list[str]:
    """Candidates that explain nearly as much as the best."""
    return [t.effect for t in trials if t is not best and t.gain > ALIKE * best.gain > 0]
