"""The kinds of pictures that are judged, and the patches cut from them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dnanalyze.classifier.descriptors import Described, of_lines, of_pixels, of_shading
from dnanalyze.classifier.pictures import CLIP, middle_and_sides
from dnanalyze.classifier.places import FOLDS, Places

MAX_PATCHES = 2048  # patches of a kind of picture and operating point, for the time that they take
LEAST_FRAMES = 3  # frames of a mean, where there are as many
LONG = 64  # pixels of a strip along; with a quarter of the side across it holds what a patch does

Stack = np.ndarray  # (planes, frames, rows, columns) around 0
FRAME, PAIR, MEAN = "single frame", "difference of two frames", "mean frame"
Pictures = dict[str, np.ndarray]  # by name, each (pictures, rows, columns), DN


def pictures_of(stack: Stack) -> Pictures:
    """The pictures of a stack, of which views show one kind or two."""
    made = {FRAME: stack, MEAN: _means(stack)}
    if stack.shape[1] > 1:
        made[PAIR] = _pairs(stack)
    return {name: p.reshape(-1, *p.shape[2:]) for name, p in made.items()}


def _pairs(stack: Stack) -> Stack:
    """Each frame less the next and less the one after that, around the end."""
    lags = range(1, min(2, stack.shape[1] - 1) + 1)
    apart = [(stack - np.roll(stack, -lag, axis=1)) / np.float32(np.sqrt(2.0)) for lag in lags]
    return np.concatenate(apart, axis=1)


def _means(stack: Stack) -> Stack:
    """Means of half of the frames, three at the least, from each frame on, around the end.

    The patches are cut from one after another, so that what a few frames have in common by chance
    (the phase of an interference) differs between them.
    """
    count = stack.shape[1]
    part = min(count, max(LEAST_FRAMES, count // 2))
    total = np.mean([np.roll(stack, -n, axis=1) for n in range(part)], axis=0)
    return total if part < count else total[:, :1]


@dataclass(frozen=True)
class View:
    """A kind of patches.

    Parameters
    ----------
    key, name : str
        In files, in words.
    frames : int
        That it needs at the least.
    shows : tuple of str
        Kinds of pictures that a patch is cut from; of one frame alone there is no difference.
    strip : str
        "tall", "wide", or "" for square patches.
    repeats : int
        Pictures that a place is cut from at the most: those of a fixed pattern repeat it.
    """

    key: str
    name: str
    frames: int
    shows: tuple[str, ...]
    strip: str = ""
    repeats: int = 1

    def size(self, places: Places) -> tuple[int, int]:
        """Rows and columns of a patch."""
        if not self.strip:
            return places.side, places.side
        rows, columns = (n // 2 for n in places.shape)
        across = places.side // 4
        return (min(LONG, rows), across) if self.strip == "tall" else (across, min(LONG, columns))

    def shown(self, pictures: Pictures) -> Pictures:
        """Those of the pictures that the view shows."""
        return {name: pictures[name] for name in self.shows if name in pictures}


# Frames that a patch is made of, and how often patches are drawn
VIEWS = (
    View("frame", FRAME, 2, (FRAME,), repeats=8),
    View("pair", PAIR, 2, (PAIR,), repeats=8),
    View("mean", MEAN, 1, (MEAN,)),
    View("tall", "tall strips", 1, (MEAN, PAIR), "tall", 2),
    View("wide", "wide strips", 1, (MEAN, PAIR), "wide", 2),
)


@dataclass(frozen=True)
class Samples:
    """The patches of one fold's half of the bands.

    Parameters
    ----------
    described : Described
        A row a patch.
    patches : dict
        Name of the picture to (patches, rows, columns), DN.
    places : ndarray of int
        (patches, 2): row and column in the grid of all patches.
    regular : ndarray of bool
        Whether the patch is one of those that do not overlap; only these test.
    """

    described: Described
    patches: dict[str, np.ndarray]
    places: np.ndarray
    regular: np.ndarray


@dataclass(frozen=True)
class Cuts:
    """Where the patches of a view are cut: the same for every sensor.

    Parameters
    ----------
    size : tuple of int
        Rows and columns of a patch.
    grid : tuple of int
        Rows and columns of patches that do not overlap, of all folds.
    corners : dict
        Fold to (patches, 3): picture, top, left in its half of the bands.
    regular : dict
        Fold to (patches,): whether it belongs to those that do not overlap.
    """

    size: tuple[int, int]
    grid: tuple[int, int]
    corners: dict[tuple[int, int], np.ndarray]
    regular: dict[tuple[int, int], np.ndarray]


def cuts(view: View, places: Places, pictures: int, rng: np.random.Generator) -> Cuts:
    """Choose patches: those that do not overlap, then overlapping ones, up to `MAX_PATCHES` in all.

    Parameters
    ----------
    view : View
    places : Places
    pictures : int
        Of the stack.
    rng : Generator
        Chooses among overlapping patches.
    """
    size = view.size(places)
    half = places.shape[0] // 2, places.shape[1] // 2
    steps = max(1, size[0] // 4), max(1, size[1] // 4)
    tidy = _corners(half, size, size, places, view)
    dense = _corners(half, steps, size, places, view)
    share = MAX_PATCHES // len(FOLDS)
    corners, regular = {}, {}
    for fold in FOLDS:
        own = _over_pictures(tidy, pictures, share, view.repeats)
        more = _over_pictures(rng.permutation(dense), pictures, share - len(own), view.repeats)
        corners[fold] = np.concatenate((own, more))
        regular[fold] = np.arange(len(corners[fold])) < len(own)
    grid = 2 * (half[0] // size[0]), 2 * (half[1] // size[1])
    return Cuts(size, grid, corners, regular)


def _corners(
    half: tuple[int, int], steps: tuple[int, int], size: tuple[int, int], places: Places, view: View
) -> np.ndarray:
    """(patches, 2): every corner on a grid of steps whose patch lies within its bands.

    A strip may run on over several bands along, not across.
    """
    axes = []
    for n, step, reach, width, long in zip(
        half, steps, size, (places.rows.width, places.columns.width),
        (view.strip == "tall", view.strip == "wide"), strict=True,
    ):  # fmt: skip
        starts = np.arange(0, n - reach + 1, step)
        axes.append(starts if long else starts[starts % width <= width - reach])
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)


def _over_pictures(corners: np.ndarray, pictures: int, most: int, repeats: int) -> np.ndarray:
    """Each corner in as many pictures as there is room for, the pictures in turn."""
    if not len(corners) or most <= 0:
        return np.empty((0, 3), int)
    if len(corners) > most:
        corners = corners[np.linspace(0, len(corners) - 1, most).astype(int)]
    times = min(pictures, repeats, most // len(corners))
    made = [
        np.column_stack(((np.arange(len(corners)) + turn) % pictures, corners))
        for turn in range(times)
    ]
    return np.concatenate(made)


def cut(
    view: View, pictures: Pictures, places: Places, where: Cuts, filters: np.ndarray
) -> dict[tuple[int, int], Samples]:
    """The samples of each fold's half of the bands.

    Of two kinds of pictures that with fewer is taken again from its first on.
    """
    made = {}
    for fold in FOLDS:
        index = np.ix_(*places.half(fold))
        number, top, left = where.corners[fold].T
        patches = {
            name: np.lib.stride_tricks.sliding_window_view(
                _along(view, stacked[:, index[0], index[1]]), where.size, axis=(1, 2)
            )[number % len(stacked), top, left]
            for name, stacked in view.shown(pictures).items()
        }
        described = _describe(view, patches, filters)
        rows, columns = where.grid
        grid = np.column_stack(
            (fold[0] * (rows // 2) + top // where.size[0],
             fold[1] * (columns // 2) + left // where.size[1])
        )  # fmt: skip
        made[fold] = Samples(described, patches, grid, where.regular[fold])
    return made


def _along(view: View, pictures: np.ndarray) -> np.ndarray:
    """Pictures of which tall strips show the columns alone, and wide ones the rows.

    The few rows or columns that a strip runs along would be the same in many of them.
    """
    if not view.strip:
        return pictures
    low, _, high = middle_and_sides(np.ascontiguousarray(pictures[:, ::4, ::4]).ravel())
    reach = CLIP * (high - low) / 2.0
    return pictures - np.clip(pictures, -reach, reach).mean(
        axis=2 if view.strip == "tall" else 1, keepdims=True
    )


def _describe(view: View, patches: dict[str, np.ndarray], filters: np.ndarray) -> Described:
    """The descriptors of a view."""
    if view.strip:
        parts = [of_lines(p).of(name) for name, p in patches.items()]
        return parts[0] if len(parts) == 1 else parts[0].beside(parts[1])
    ((name, own),) = patches.items()
    described = of_pixels(own, filters)
    if view.key == "mean":
        described = described.beside(of_shading(own))
    return described.of(name)
