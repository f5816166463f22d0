"""Train a classifier on measured and simulated patches, and see whether it can tell them."""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import Executor
from dataclasses import replace
from statistics import fmean

import numpy as np
from scipy.special import stdtrit

from dnanalyze.analyzers.saturated_settings import unsaturated
from dnanalyze.classifier.cells import Judge, Judged, Pool, pools
from dnanalyze.classifier.pictures import compact_frames
from dnanalyze.classifier.places import BANDS, FOLDS, SIDE, places
from dnanalyze.classifier.result import Cell, Classification, Told
from dnanalyze.classifier.training import Halves, Learner, boosting, one_thread, went_by
from dnanalyze.classifier.views import VIEWS
from dnanalyze.fitting.design import design
from dnanalyze.fitting.processes import Helpers, helpers_of, travels
from dnanalyze.fitting.time_limit import TimeLimit
from dnanalyze.loaders.captures import CaptureSet, Setting
from dnanalyze.loaders.mosaic import planes
from dnanalyze.model.channel_models import require
from dnanalyze.model.noise_model import NoiseModel

MOST_POINTS, MOST_FRAMES = 5, 8  # looked at, for the time that they take
UNLIMITED = 10**15  # pixels: the places are few already
CONTROLS = 6  # of a cell that seems to tell: their scatter is then known to a third
TRIED = 5  # such cells at most, for the time that they take
SHOWN = 6  # patches of a kind that a figure shows
NAMED = 0.2  # share of the largest fall of the area from which a descriptor is named
WORDS = 3  # descriptors that are named


def classify(
    captures: CaptureSet,
    model: NoiseModel,
    *,
    seed: int = 0,
    network: bool = False,
    points: int = MOST_POINTS,
    executor: Executor | None = None,
) -> Classification:
    """Ask whether a trained classifier can tell a model's frames from measured ones.

    Parameters
    ----------
    captures : CaptureSet
        Dark frames.
    model : NoiseModel
        Taken as it is.
    seed : int
        Of the simulated sensors, the dither, the filters and the training.
    network : bool
        Train a small convolutional network in place of gradient boosting (extra ``torch``); it
        takes several times as long.
    points : int
        Operating points at most, far apart in temperature and exposure.
    executor : concurrent.futures.Executor, optional
        Takes operating points, one at a time; by default this process.

    Returns
    -------
    Classification
        The area under the ROC curve for each operating point and kind of picture, with its
        interval and its control, and what tells.

    Raises
    ------
    InputError
        Captures of a channel that the model does not know; ``network`` without torch.

    Examples
    --------
    >>> import dnanalyze
    >>> from dnanalyze.demo import tiny
    >>> captures = tiny()
    >>> model = dnanalyze.compare(captures).model
    >>> found = dnanalyze.classify(captures, model)
    >>> found.tells
    True
    """
    helpers = helpers_of(executor)
    return classify_on(captures, model, seed=seed, network=network, points=points, helpers=helpers)


def classify_on(
    captures: CaptureSet,
    model: NoiseModel,
    *,
    seed: int = 0,
    network: bool = False,
    points: int = MOST_POINTS,
    limit: TimeLimit | None = None,
    helpers: Helpers | None = None,
) -> Classification:
    """`classify` by helpers; operating points that were judged before the limit are given."""
    require(model, captures.channels)
    empty = Classification(captures, model, [])
    where = places(planes(captures)[0][1].sensor.shape)
    if where is None:
        least = BANDS * SIDE[1]
        return replace(empty, reason=f"a colour plane has fewer than {least} rows or columns")
    chosen = _chosen(captures, points, model.unit)
    settings = [(s.point, len(s.frames)) for s in chosen.settings]
    judge = Judge(chosen.sensor, settings, model, where, _learner(network), seed)
    if helpers is None or network or not travels(model):
        helpers = Helpers()
    judged, finished = _all(judge, chosen, helpers, limit or TimeLimit())
    every = pools(_confirmed(judge, judged, helpers))
    cells = _cells(every)
    found = replace(
        empty,
        cells=[c for c in cells if c.point is not None],
        together=[c for c in cells if c.point is None],
        finished=finished,
    )
    first = max(zip(cells, every, strict=True), key=lambda pair: (pair[0].tells, pair[0].low))[1]
    best = max(first.parts, key=lambda part: part.tested.area.value)
    telling = _telling(best, seed) if found.tells else []
    return replace(found, telling=telling, patches=_patches(best, telling))


def _all(
    judge: Judge, captures: CaptureSet, helpers: Helpers, limit: TimeLimit
) -> tuple[list[Judged], bool]:
    """The cells that were judged before the time was up, and whether all were.

    Each process judges one operating point before the time is asked for; where fewer are left than
    there are processes, several share the views of one.
    """
    judged: list[Judged] = []
    numbers, step = range(len(captures.settings)), helpers.shares
    for some in (numbers[n : n + step] for n in numbers[::step]):
        values = [compact_frames(captures, captures.settings[n], judge.places) for n in some]
        shares = min(step // len(some), len(VIEWS))
        tasks = [
            (number, own, VIEWS[share::shares])
            for number, own in zip(some, values, strict=True)
            for share in range(shares)
        ]
        found = [cell for cells in helpers.each(judge.cells, tasks) for cell in cells]
        judged += sorted(found, key=lambda cell: (cell.setting, VIEWS.index(cell.view)))
        if limit.over:
            return judged, some[-1] == numbers[-1]
    return judged, True


def _learner(network: bool) -> Learner:
    if not network:
        return boosting
    from dnanalyze.classifier.network import convolutional

    return convolutional


def _chosen(captures: CaptureSet, points: int, unit: float) -> CaptureSet:
    """Operating points far apart and their first frames, without the saturated ones."""
    few = unsaturated(design(captures, UNLIMITED, points, unit, pool=False).captures)[0]
    return replace(
        few, settings=tuple(Setting(s.point, s.frames[:MOST_FRAMES]) for s in few.settings)
    )


def _confirmed(judge: Judge, judged: list[Judged], helpers: Helpers) -> list[Judged]:
    """With more controls for the cells that seem to tell, the clearest first, until one does."""
    done = list(judged)
    for _ in range(TRIED):
        every = pools(done)
        cells = _cells(every)
        seem = [n for n, c in enumerate(cells) if c.above and not c.confirmed]
        if not seem or any(c.tells for c in cells):
            break
        parts = every[max(seem, key=lambda n: cells[n].low)].parts
        short = [n for n, j in enumerate(done) if j in parts and len(j.controls) < CONTROLS]
        more = [(done[n], number) for n in short for number in range(2, CONTROLS + 1)]
        areas = iter(helpers.each(judge.control, more))
        for n in short:
            added = [next(areas) for _ in range(2, CONTROLS + 1)]
            done[n] = replace(done[n], controls=(*done[n].controls, *added))
    return done


def _cells(every: list[Pool]) -> list[Cell]:
    """With limits, each of which holds at 95 % for all cells together (Bonferroni)."""
    made = []
    for pool in every:
        first, auc = pool.parts[0], pool.area.value
        # Rows or columns of patches are few: Student's t (Cameron, Gelbach and Miller 2011).
        half = pool.se * float(stdtrit(max(first.cuts.grid) - 1, 1 - 0.05 / len(every)))
        made.append(
            Cell(
                first.point if len(pool.parts) == 1 else None,
                first.view.key,
                first.view.name,
                auc,
                max(0.0, auc - half),
                min(1.0, auc + half),
                fmean(pool.controls),
                len(pool.controls) >= CONTROLS,
            )
        )
    return made


def _telling(judged: Judged, seed: int) -> list[str]:
    """Words of the descriptors that tell most, with the picture that they are of."""
    with one_thread():
        falls = went_by(judged.measured, judged.simulated, judged.cuts.grid, seed)
    least = NAMED * falls[0][1]
    return [words for words, fall in falls if fall >= least and fall > 0][:WORDS]


def _patches(judged: Judged, telling: list[str]) -> Told:
    """The measured patches that look most measured, the simulated that look most simulated."""
    names = list(judged.measured[FOLDS[0]].patches)
    picture = next((n for n in names if telling and telling[0].endswith(n)), names[0])
    scores = judged.tested.scores
    return Told(
        judged.point,
        picture,
        _extreme(judged.measured, {f: s[0] for f, s in scores.items()}, picture),
        _extreme(judged.simulated, {f: -s[1] for f, s in scores.items()}, picture),
    )


def _extreme(
    halves: Halves, scores: Mapping[tuple[int, int], np.ndarray], picture: str
) -> np.ndarray:
    """Patches of the highest scores, each from a place of its own."""
    patches, values, where = [], [], []
    for fold in FOLDS:
        own = halves[fold]
        patches.append(own.patches[picture][own.regular])
        where.append(own.places[own.regular])
        order = np.argsort(np.argsort(scores[fold]))  # folds have scales of their own
        values.append(order / max(1, len(order)))
    every, spots = np.concatenate(patches), np.concatenate(where)
    shown: dict[tuple[int, int], np.ndarray] = {}
    for index in np.argsort(-np.concatenate(values), kind="stable"):
        shown.setdefault((int(spots[index, 0]), int(spots[index, 1])), every[index])
        if len(shown) == SHOWN:
            break
    return np.stack(list(shown.values()))
