"""What the tests look at: a bounded sample of the frames, split into planes of like pixels."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
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
    single: list[tuple[OperatingPoint, Frame]] = []

    def close() -> None:
        if single:
            frames = tuple(f for _, f in single)
            chosen.append(Group(single[0][0], frames, repeats=False))
            single.clear()

    for setting in captures.settings:
        if len(setting.frames) > 1:
            close()
            chosen.append(Group(setting.point, setting.frames[:MAX_FRAMES], repeats=True))
        elif setting.frames:
            if single and not _near(single[0][0], setting.point):
                close()
            single.append((setting.point, setting.frames[0]))
            if len(single) == 8:
                close()
    close()
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


def _near(a: OperatingPoint, b: OperatingPoint) -> bool:
    if a.temperature_c is None or b.temperature_c is None:
        return False
    same = (a.exposure_s, a.gain, a.channel) == (b.exposure_s, b.gain, b.channel)
    return same and abs(a.temperature_c - b.temperature_c) <= NEAR_C


def read(group: Group) -> np.ndarray:
    """Frames of a group, (frames, rows, columns), as recorded; large ones as bands of full rows."""
    stack: np.ndarray | None = None
    rows: np.ndarray | slice = slice(None)
    for n, frame in enumerate(group.frames):
        pixels = frame.read()
        if stack is None:
            rows = _bands(pixels.shape)
            first = pixels[rows]
            dtype = first.dtype if first.dtype.itemsize <= 4 else np.dtype(np.float32)
            stack = np.empty((len(group.frames), *first.shape), dtype)
        stack[n] = pixels[rows]
    assert stack is not None  # a group has frames
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


def planes(stack: np.ndarray, mosaic: tuple[int, int] | None) -> Iterator[Plane]:
    """The whole frame for ``None``, else one plane for each phase of a (rows, columns) block."""
    step, (rows, columns) = least_step(stack), mosaic or (1, 1)
    for y in range(rows):
        for x in range(columns):
            part = stack[:, y::rows, x::columns]
            yield Plane(np.ascontiguousarray(part, np.float32), step)
