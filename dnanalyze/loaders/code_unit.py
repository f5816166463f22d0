"""The unit in which files store codes: 12-bit codes times 16, 8-bit ones times 257, or fractions.

A model, its bounds and its statistics are in codes of the converter. What camera programs multiply
them by to fill 16 bits, or divide them by for floats from 0 to 1, is taken off before.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from dnanalyze.loaders.captures import CaptureSet, Frame, Sensor, Setting, Window

# Least factor of whole numbers: 2 may be a digital gain, or the sum of two pixels; converters of 14
# bits and fewer in 16-bit files leave 4 and more.
LEAST_FACTOR = 4
EXACT = 0.02  # of a code that a float32 of 16 bits may be off a multiple
SMALL, LARGE = 0.05, 1000.0  # noise, as recorded, beyond which bounds in codes do not fit
FINE = 16.0  # units of the noise of values that are no codes: rounding to these adds .02 % to it
MOST_CODES = 65_536.0  # of floats: a float32 has seven digits
STRIP = 8  # rows of a frame that are looked at
FEWEST = 4  # different values, without which a common divisor is that of one or two levels


def code_unit(captures: CaptureSet) -> float:
    """Value of one code in the unit of the files; 1 where they hold codes.

    Parameters
    ----------
    captures : CaptureSet
        One frame of each setting is read.

    Returns
    -------
    float
        For whole numbers their greatest common divisor, if that is 4 or more; for floats of 0 to 1
        the number of which all are multiples; for other floats whose noise is below .05 or above
        1,000, a power of two near a sixteenth of their noise.
    """
    frames = [_sampled(s, captures.sensor.shape) for s in captures.settings if s.frames]
    if not frames:
        return 1.0
    if np.unique(np.concatenate(frames)).size < FEWEST:
        return 1.0
    if all(np.array_equal(y, np.rint(y)) for y in frames):
        return _divided(frames)
    largest = max(float(np.abs(y).max()) for y in frames)
    if largest <= 1.0:
        spacing = _spacing(np.unique(np.concatenate(frames)))
        if spacing is not None:
            return spacing
    noise = min(float(np.subtract(*np.quantile(y, (0.75, 0.25)))) / 1.349 for y in frames)
    if noise > 0.0 and not SMALL <= noise <= LARGE:
        return 2.0 ** math.floor(math.log2(noise / FINE))
    return 1.0


def _spacing(values: np.ndarray) -> float | None:
    """Number of which all of the values, in order, are multiples; None where there is none.

    The least difference is it, to its last digits; each value that is a whole multiple gives it to
    more digits.
    """
    steps = np.diff(values)
    if not steps.size:
        return None
    spacing = float(np.median(steps[steps < 1.5 * steps.min()]))
    positive = values[values > 0.0]
    for reach in 10.0 ** np.arange(1, 6):
        near = positive[positive < reach * spacing]
        if near.size:
            codes = np.rint(near / spacing)
            spacing = float(np.sum(near * codes) / np.sum(codes**2))
    codes = values / spacing
    whole = np.abs(codes - np.rint(codes)).max() < EXACT
    return spacing if whole and np.abs(codes).max() <= MOST_CODES else None


def _sampled(setting: Setting, shape: tuple[int, int]) -> np.ndarray:
    """Pixels of the first frame of a setting, from its middle rows."""
    rows, columns = shape
    count = min(rows, STRIP)
    top = (rows - count) // 2
    pixels = setting.frames[0].read(Window(top, top + count, 0, columns))
    return np.asarray(pixels, np.float64).ravel()


def _divided(frames: list[np.ndarray]) -> float:
    """Greatest common divisor of whole numbers, from `LEAST_FACTOR` on; else 1."""
    found = 0
    for codes in frames:
        found = int(np.gcd.reduce(np.unique(codes).astype(np.int64), initial=found))
        if 0 < found < LEAST_FACTOR:
            return 1.0
    return float(found) if found >= LEAST_FACTOR else 1.0


def in_codes(captures: CaptureSet, unit: float) -> CaptureSet:
    """The captures in codes: values, black level, gain and bits over the unit.

    Parameters
    ----------
    captures : CaptureSet
    unit : float
        From `code_unit`.
    """
    if unit == 1.0:
        return captures
    settings = tuple(_setting(s, unit) for s in captures.settings)
    return replace(captures, sensor=_sensor(captures.sensor, unit), settings=settings, source=None)


def _setting(setting: Setting, unit: float) -> Setting:
    black = setting.black_level
    frames = tuple(_frames(setting, unit))
    return replace(setting, frames=frames, black_level=None if black is None else black / unit)


def _frames(setting: Setting, unit: float) -> Iterator[Frame]:
    for frame in setting.frames:

        def load(window: Window | None, frame: Frame = frame) -> np.ndarray:
            return divided(frame.read(window), unit)

        yield replace(frame, load=load)


def divided(values: np.ndarray, unit: float) -> np.ndarray:
    """Values in codes, whole where they are multiples of the unit; float32."""
    codes = np.asarray(values, np.float64) / unit
    whole = np.rint(codes)
    return np.where(np.abs(codes - whole) < EXACT, whole, codes).astype(np.float32)


def _sensor(sensor: Sensor, unit: float) -> Sensor:
    def over(value: float | None) -> float | None:
        return None if value is None else value / unit

    bits = sensor.bits
    if bits is not None:
        bits = max(1, round(math.log2(2.0**bits / unit))) if unit > 1.0 else None
    return replace(
        sensor,
        bits=bits,
        black_level=over(sensor.black_level),
        white_level=over(sensor.white_level),
        system_gain_dn_e=over(sensor.system_gain_dn_e),
        black_levels=tuple((p, v / unit) for p, v in sensor.black_levels),
    )
