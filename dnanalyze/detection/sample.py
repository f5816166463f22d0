"""What the tests look at: a bounded sample of the frames, split into planes of like pixels."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import zip_longest

import numpy as np

from dnanalyze.loaders.captures import CaptureSet, Frame, OperatingPoint

MAX_PIXELS = 1 << 21  # of each frame: far more than the tests need, whatever the sensor
MAX_FRAMES = 16  # of each setting
BAND_ROWS = 48  # bands start at multiples of this, so that colour and row phases stay aligned
SMALLEST = 24  # rows or columns below which a plane tells nothing
NEAR_C = 6.0  # settings of single frames closer than this in temperature count as repeats


@dataclass(frozen=True)
class Group:
    """Frames taken at one operating point, or so close that their differences are noise."""

    point: OperatingPoint
    frames: tuple[Frame, ...]
    repeats: bool  # all at exactly one setting, in the order in which they were taken


def groups(captures: CaptureSet) -> list[Group]:
    """The settings; those of a single frame at neighbouring temperatures are put together."""
    chosen: list[Group] = []
    for setting in captures.settings:
        last = chosen[-1] if chosen else None
        if len(setting.frames) > 1:
            chosen.append(Group(setting.point, setting.frames[:MAX_FRAMES], repeats=True))
        elif last and not last.repeats and _near(last, setting.point):
            chosen[-1] = replace(last, frames=(*last.frames, *setting.frames))
        elif setting.frames:
            chosen.append(Group(setting.point, setting.frames, repeats=False))
    return chosen


def across(captures: CaptureSet) -> Group | None:
    """Frames of all settings in turn: a list of sites is a fact of the sensor, not of a setting.

    None for one setting, or fewer than 3 frames.
    """
    rounds = zip_longest(*(s.frames for s in captures.settings))
    frames = [f for one in rounds for f in one if f is not None]
    if len(captures.settings) < 2 or len(frames) < 3:
        return None
    taken = frames[:: -(-len(captures.settings) // MAX_FRAMES)][:MAX_FRAMES]
    return Group(captures.settings[0].point, tuple(taken), repeats=False)


def _near(group: Group, point: OperatingPoint) -> bool:
    """Whether a single frame may join those of a group: half as many as of one setting."""
    here = group.point
    if here.temperature_c is None or point.temperature_c is None:
        return False
    alike = replace(here, temperature_c=None) == replace(point, temperature_c=None)
    room = 2 * len(group.frames) < MAX_FRAMES
    return room and alike and abs(here.temperature_c - point.temperature_c) <= NEAR_C


def read(group: Group) -> np.ndarray:
    """Frames of a group, (frames, rows, columns), as recorded; large ones as bands of full rows."""
    first = group.frames[0].read()
    rows = _bands(first.shape)
    dtype = first.dtype if first.dtype.itemsize <= 4 else np.dtype(np.float32)
    stack = np.empty((len(group.frames), *first[rows].shape), dtype)
    stack[0] = first[rows]
    for n, frame in enumerate(group.frames[1:], 1):
        stack[n] = frame.read()[rows]
    return stack


def _bands(shape: tuple[int, int]) -> np.ndarray | slice:
    rows, columns = shape
    keep = max(BAND_ROWS, MAX_PIXELS // columns // BAND_ROWS * BAND_ROWS)
    if rows <= keep:
        return slice(None)
    blocks = keep // BAND_ROWS
    bands = min(4, blocks)
    sizes = np.full(bands, blocks // bands) + (np.arange(bands) < blocks % bands)
    starts = np.linspace(0, rows // BAND_ROWS - sizes.max(), bands).astype(int)
    return np.concatenate(
        [np.arange(a, a + n) for a, n in zip(starts * BAND_ROWS, sizes * BAND_ROWS, strict=True)]
    )


def least_step(stack: np.ndarray) -> float:
    """Spacing of the recorded values, DN; 0 where they are not quantised."""
    values = np.unique(stack.ravel()[:: max(1, stack.size // 65536)])
    if values.size < 2:
        return 1.0
    if np.issubdtype(stack.dtype, np.integer):
        return float(np.gcd.reduce(np.diff(values.astype(np.int64))))
    steps = np.diff(values.astype(np.float64))
    least = float(steps.min())
    multiples = steps / least
    return least if np.all(np.abs(multiples - np.round(multiples)) < 1e-3) else 0.0


@dataclass(frozen=True)
class Plane:
    """Like pixels of one group of frames."""

    raw: np.ndarray  # (frames, rows, columns), float32, DN as recorded
    step: float  # spacing of the recorded values, DN

    def dithered(self) -> np.ndarray:
        """With +-1/2 step of uniform noise, so that ties are broken evenly."""
        if not self.step:
            return self.raw
        rng = np.random.default_rng([0, self.raw.size])
        return self.raw + np.float32(self.step) * (
            rng.random(self.raw.shape, dtype=np.float32) - np.float32(0.5)
        )


def planes(stack: np.ndarray, apart: int) -> Iterator[Plane]:
    """One plane for each phase of pixels so far apart: 1 gives the whole frame."""
    step = least_step(stack)
    for y, x in np.ndindex(apart, apart):
        yield Plane(np.ascontiguousarray(stack[:, y::apart, x::apart], np.float32), step)
