"""Train on one part of the field, test on another, and ask what the classifier went by."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np

from dnanalyze.classifier.curve import Area, area, mean_area
from dnanalyze.classifier.places import FOLDS
from dnanalyze.classifier.views import Samples

# Of seven kinds of differences, two sensors each, 30 trees at .13 find none with an area that is
# larger by .01, and take 13 % longer; 15 at .25 find one with an area that is smaller by .011.
TREES, LEARNING_RATE = 20, 0.2

Fold = tuple[int, int]
Halves = Mapping[Fold, Samples]
Score = Callable[[Samples], np.ndarray]
Learner = Callable[[Samples, Samples, int], Score]


@contextmanager
def one_thread() -> Iterator[None]:
    """Trees and products this small cost more to share among threads than they take."""
    import sklearn.ensemble  # noqa: F401  its thread pool has to exist to be limited
    from threadpoolctl import threadpool_limits

    with threadpool_limits(1):
        yield


def boosting(measured: Samples, simulated: Samples, seed: int) -> Score:
    """Histogram gradient boosting on the descriptors; higher scores look measured."""
    from sklearn.ensemble import HistGradientBoostingClassifier

    values = np.concatenate((measured.described.values, simulated.described.values))
    labels = np.repeat((1, 0), (len(measured.regular), len(simulated.regular)))
    model: Any = HistGradientBoostingClassifier(
        learning_rate=LEARNING_RATE,
        max_iter=TREES,
        max_leaf_nodes=8,
        max_bins=63,
        min_samples_leaf=max(2, min(20, len(labels) // 40)),
        l2_regularization=1.0,
        early_stopping=False,
        random_state=seed,
    )
    model.fit(values, labels)
    return lambda samples: np.asarray(model.decision_function(samples.described.values))


@dataclass(frozen=True)
class Tested:
    """What the four folds gave.

    Parameters
    ----------
    area : Area
    scores : dict
        Fold that was tested to the scores of its regular patches: (measured, simulated).
    """

    area: Area
    scores: dict[Fold, tuple[np.ndarray, np.ndarray]]


def cross_fit(
    measured: Halves, simulated: Halves, grid: tuple[int, int], learn: Learner, seed: int
) -> Tested:
    """Each fold trains on its half of the bands and is tested on the other half."""
    areas, scores = [], {}
    for fold in FOLDS:
        score = learn(measured[fold], simulated[fold], seed)
        other = 1 - fold[0], 1 - fold[1]
        pair = _regular(measured[other]), _regular(simulated[other])
        scores[other] = score(pair[0]), score(pair[1])
        areas.append(area(*scores[other], pair[0].places, grid))
    return Tested(mean_area(areas), scores)


def _regular(samples: Samples) -> Samples:
    """The patches that do not overlap."""
    keep = samples.regular
    return Samples(
        type(samples.described)(samples.described.values[keep], samples.described.words),
        {name: p[keep] for name, p in samples.patches.items()},
        samples.places[keep],
        keep[keep],
    )


def went_by(
    measured: Halves, simulated: Halves, grid: tuple[int, int], seed: int
) -> list[tuple[str, float]]:
    """Words of the descriptors, by how much the area falls when theirs are shuffled; most first.

    Parameters
    ----------
    measured, simulated : mapping
        Samples by fold.
    grid : tuple of int
    seed : int

    Returns
    -------
    list of (str, float)
        Words, and the fall of the area (Breiman 2001).
    """
    rng = np.random.default_rng(seed)
    words = np.array(measured[FOLDS[0]].described.words)
    falls = dict.fromkeys(words.tolist(), 0.0)
    for fold in FOLDS:
        score = boosting(measured[fold], simulated[fold], seed)
        other = 1 - fold[0], 1 - fold[1]
        pair = _regular(measured[other]), _regular(simulated[other])
        values = np.concatenate([s.described.values for s in pair])
        order = rng.permutation(len(values))

        def value(
            values: np.ndarray,
            score: Score = score,
            pair: tuple[Samples, Samples] = pair,
        ) -> float:
            described = type(pair[0].described)(values, pair[0].described.words)
            found = score(Samples(described, {}, np.empty((0, 2)), np.empty(0, bool)))
            count = len(pair[0].regular)
            return area(found[:count], found[count:], pair[0].places, grid).value

        whole = value(values)
        for name in falls:
            shuffled = np.where(words == name, values[order], values)
            falls[name] += (whole - value(shuffled)) / len(FOLDS)
    return sorted(falls.items(), key=lambda item: -item[1])
