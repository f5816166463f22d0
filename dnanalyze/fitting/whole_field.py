"""Comparison of a model, fitted to a window, with the whole of a large field.

Means of blocks, rows and columns of measured and simulated mean frames are compared all over the
field. The scatter of their differences within the window is the yardstick, since there the
statistics judge the model; of rows and columns it is that over the field where that is larger.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.stats import norm

from dnanalyze.analyzers.field_profile import BLOCK, FieldProfile, field_profile
from dnanalyze.fitting.design import Design
from dnanalyze.fitting.level import NOISE
from dnanalyze.fitting.placement import FRAMES
from dnanalyze.loaders.captures import OperatingPoint, Window
from dnanalyze.model import bands
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.simulator import Simulator
from dnanalyze.processors import cpu_count
from dnanalyze.robust import robust_deviation
from dnanalyze.significance import UNLIKELY


@dataclass(frozen=True)
class Departure:
    """A deviation of a model from the frames outside the window to which it was fitted.

    Parameters
    ----------
    point : OperatingPoint
    kind : str
        "blocks", "rows" or "columns".
    row, column : int or None
        The farthest pixel block's first pixel, or the line; None for what crosses the field.
    difference_dn : float
        Measured less modelled there, DN.
    sigma : float
        The same in standard deviations of such differences within the window.
    share : float
        Of the blocks, rows or columns of the field, those that depart.
    place : str
        Where that is, such as "top left", "column 5871".
    """

    point: OperatingPoint
    kind: str
    row: int | None
    column: int | None
    difference_dn: float
    sigma: float
    share: float
    place: str


@dataclass(frozen=True)
class Coverage:
    """Part of the captures on which a verdict is based.

    Parameters
    ----------
    settings, all_settings : int
        Operating points that enter, of those there are.
    frames, all_frames : int
        The same of frames.
    window : Window
        Part of the field whose statistics are compared.
    field : (int, int)
        The whole of it, (rows, columns).
    departures : tuple of Departure, optional
        Where the model departs from the rest of the field; None where that was not compared.
    pooled, pools : int
        Operating points that were taken as so many fewer: their frames differ by noise alone.
    """

    settings: int
    all_settings: int
    frames: int
    all_frames: int
    window: Window
    field: tuple[int, int]
    departures: tuple[Departure, ...] | None = None
    pooled: int = 0
    pools: int = 0

    @property
    def share(self) -> float:
        """Of the pixels of a frame, those in the window."""
        rows, columns = self.window.shape
        return rows * columns / (self.field[0] * self.field[1])

    @property
    def whole(self) -> bool:
        """Whether the window is the field."""
        return self.window.shape == self.field

    @property
    def departs(self) -> bool:
        """Whether the model is known to be off outside of the window."""
        return bool(self.departures)


def coverage(plan: Design, model: NoiseModel | None = None) -> Coverage:
    """Coverage of a design; with a model, its deviation from the rest of the field."""
    chosen, every = plan.captures.settings, plan.everything.settings
    return Coverage(
        sum(plan.members),
        len(every),
        sum(len(s.frames) for s in chosen),
        sum(len(s.frames) for s in every),
        plan.window,
        plan.shape,
        None if model is None else tuple(departures(plan, model)),
        sum(n for n in plan.members if n > 1),
        sum(n > 1 for n in plan.members),
    )


def departures(plan: Design, model: NoiseModel) -> list[Departure]:
    """Deviations of the whole field from the model; none where the window is the whole field.

    Parameters
    ----------
    plan : Design
        What the model was fitted to.
    model : NoiseModel

    Returns
    -------
    list of Departure
        The largest of each kind at any operating point, the largest first.
    """
    if plan.window.shape == plan.shape:
        return []
    worst: dict[str, Departure] = {}
    tests = 3 * len(plan.captures.settings)
    for off, point in _differences(plan, model):
        for found in _beyond(off, plan.window, point, plan.period, UNLIKELY / tests):
            if found.kind not in worst or found.sigma > worst[found.kind].sigma:
                worst[found.kind] = found
    return sorted(worst.values(), key=lambda d: -d.sigma)


def _differences(plan: Design, model: NoiseModel) -> Iterator[tuple[FieldProfile, OperatingPoint]]:
    """Measured less simulated, of each operating point."""
    field, threads = Window.whole(plan.shape), cpu_count()
    for setting in plan.captures.settings:
        point, frames = setting.point, setting.frames[:FRAMES]
        simulator = Simulator(model.in_codes, plan.shape)  # its fixed fields go with the setting
        seen = field_profile(f.read() for f in frames)
        drawn = (bands.drawn(simulator, point, n, field, threads) for n in range(len(frames)))
        yield seen.less(field_profile(drawn)), point


def _beyond(
    off: FieldProfile, window: Window, point: OperatingPoint, period: int, chance: float
) -> Iterator[Departure]:
    least = NOISE * off.noise  # as of a level
    own = off.blocks_in(window)
    if own.size > 1:
        away = off.blocks - np.median(own)
        sd = robust_deviation(own)
        own_most = float(np.abs(own - np.median(own)).max())
        at = _farthest(away, sd, own_most, least, chance)
        if at is not None:
            index, share = at
            row, column = (int(i) for i in np.unravel_index(index, away.shape))
            value = float(away.flat[index])
            yield Departure(
                point, "blocks", row * BLOCK, column * BLOCK, value, abs(value) / sd, share,
                _place(row / away.shape[0], column / away.shape[1]),
            )  # fmt: skip
    for axis, where in (("rows", window.slices[0]), ("columns", window.slices[1])):
        lines = off.lines(axis, period)
        own = lines[where]
        sd = max(robust_deviation(own), robust_deviation(lines))
        at = _farthest(lines, sd, float(np.abs(own).max()), least, chance)
        if at is not None:
            index, share = at
            value = float(lines[index])
            row_at, column_at = (index, None) if axis == "rows" else (None, index)
            yield Departure(
                point, axis, row_at, column_at, value, abs(value) / sd, share,
                f"{axis[:-1]} {index}",
            )  # fmt: skip


def _farthest(
    off: np.ndarray, deviation: float, inside: float, least: float, chance: float
) -> tuple[int, float] | None:
    """The number farthest off and the share that are; None where nothing is.

    Off is what chance gives no number of so many, nothing in the window is, and a level may not be.
    """
    if deviation <= 0.0:
        return None
    size = np.abs(off)
    limit = max(float(norm.isf(chance / (2 * off.size))) * deviation, inside, least)
    index = int(np.argmax(size))
    return (index, float(np.mean(size > limit))) if size.flat[index] > limit else None


def _place(down: float, across: float) -> str:
    """Of a ninth of the field.

    Examples
    --------
    >>> from dnanalyze.fitting.whole_field import _place
    >>> _place(0.1, 0.9), _place(0.5, 0.1), _place(0.5, 0.5)
    ('top right', 'left', 'middle')
    """
    vertical = ("top", "", "bottom")[min(int(3 * down), 2)]
    side = ("left", "", "right")[min(int(3 * across), 2)]
    return " ".join(w for w in (vertical, side) if w) or "middle"
