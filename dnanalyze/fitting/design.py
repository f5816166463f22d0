"""Operating points, frames and halves of the field that a fit uses."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from dnanalyze.fitting.placement import middle, placed, surveyed
from dnanalyze.fitting.pooling import pooled
from dnanalyze.loaders.captures import CaptureSet, OperatingPoint, Sensor, Setting, Window
from dnanalyze.loaders.code_unit import code_unit, in_codes

# One simulation then takes about 0.6 s of processor time. Of 8 operating points a law over
# temperature and one over exposure are told; 8 frames know the noise of a pixel to 27 %.
BUDGET_PIXELS = 12_000_000
MOST_SETTINGS, MOST_FRAMES = 8, 8
# Pixels of a simulation from which a fit begins on a part of the field
PART_FROM_PIXELS = 3_000_000
BAND = 32  # rows of a part at the least: frequencies down the columns from .03 c/px on
ALIGNED = 4  # pixels by which a part may be moved: whole blocks of a colour filter


@dataclass(frozen=True)
class Design:
    """Operating points and frames of a fit, and the two halves of the field.

    The fit sees ``train``, the upper half; the error is measured on ``test``, the lower half. So
    either half has every column: what is peculiar to some of them (a level that settles, readout
    taps, a defect line) is fitted on one half and tested on the other.
    Large-scale shading, which has only one realisation over the field, is split by a checkerboard
    of blocks. ``everything``: the captures with all settings and frames. All are in
    codes, each of ``unit`` in the files. ``members``: operating points that each setting stands
    for (see `pooled`).
    """

    captures: CaptureSet
    train: Window
    test: Window
    everything: CaptureSet
    unit: float = 1.0
    members: tuple[int, ...] = ()

    @property
    def shape(self) -> tuple[int, int]:
        """Full frame."""
        return self.captures.sensor.shape

    @property
    def windows(self) -> tuple[Window, Window]:
        """(train, test)."""
        return self.train, self.test

    @property
    def window(self) -> Window:
        """What both halves make up."""
        return Window(self.train.top, self.test.bottom, self.train.left, self.train.right)

    @property
    def period(self) -> int:
        """Rows and columns after which the colour filter repeats; 1 without one."""
        return _period(self.captures.sensor)

    @property
    def pixels(self) -> int:
        """Over all frames and both halves."""
        return sum(n for _, n in self.settings) * sum(w.shape[0] * w.shape[1] for w in self.windows)

    @property
    def part(self) -> Design | None:
        """The middle quarter of the rows of either half; None where the whole is small.

        It has every column, as the halves have.
        """
        if self.pixels < PART_FROM_PIXELS or self.train.shape[0] < 4 * BAND:
            return None
        return replace(self, train=_band(self.train), test=_band(self.test))

    @property
    def settings(self) -> list[tuple[OperatingPoint, int]]:
        """Operating points with their number of frames."""
        return [(s.point, len(s.frames)) for s in self.captures.settings]


def design(
    captures: CaptureSet,
    budget: int = BUDGET_PIXELS,
    most_settings: int = MOST_SETTINGS,
    unit: float | None = None,
    pool: bool = True,
) -> Design:
    """Choose settings, frames and halves within a budget of pixels.

    Parameters
    ----------
    captures : CaptureSet
    budget : int
        Pixels over all frames; large captures are thinned: settings first, then frames, then area.
    most_settings : int
        Settings kept, spread over the operating points.
    unit : float, optional
        Value of a code in the files: that of a model, where one is given; by default as the frames
        tell it.
    pool : bool
        Whether operating points that frames do not tell apart are one (see `pooled`).
    """
    unit = code_unit(captures) if unit is None else unit
    captures = in_codes(captures, unit)
    pools = [(setting, 1) for setting in captures.settings]
    if pool:
        pools = pooled(captures.settings, captures.sensor.shape)
    chosen = _spread(tuple(setting for setting, _ in pools), most_settings)
    members = {setting.point: count for setting, count in pools}
    rows, cols = captures.sensor.shape
    per_frame = budget / (len(chosen) * rows * cols)
    count = int(min(MOST_FRAMES, max(3, per_frame)))
    thinned = tuple(Setting(s.point, s.frames[:count]) for s in chosen)
    frames = sum(len(s.frames) for s in thinned)
    shrink = min(1.0, np.sqrt(budget / (frames * rows * cols)))
    step = 4 if captures.sensor.cfa else 2
    wide = max(step, int(cols * shrink) // step * step) if cols >= step else cols
    half = max(step, int(rows * shrink) // (2 * step) * step) if rows >= 2 * step else rows
    around = middle((rows, cols), (min(rows, 2 * half), wide), step)
    if shrink < 1.0:
        seen = surveyed(captures, thinned)
        around = placed(seen, (rows, cols), around.shape, step, _period(captures.sensor))
        half = around.shape[0] // 2
    train = replace(around, bottom=around.top + half)
    test = replace(around, top=around.bottom - half)
    counts = tuple(members[s.point] for s in thinned)
    return Design(replace(captures, settings=thinned), train, test, captures, unit, counts)


def _period(sensor: Sensor) -> int:
    """Rows and columns after which the colour filter repeats; 1 without one."""
    return 1 if sensor.cfa is None else len(sensor.cfa)


def _band(window: Window) -> Window:
    """The middle quarter of its rows."""
    rows = window.shape[0] // (4 * ALIGNED) * ALIGNED
    top = window.top + (window.shape[0] - rows) // (2 * ALIGNED) * ALIGNED
    return Window(top, top + rows, window.left, window.right)


def _spread(settings: tuple[Setting, ...], most: int) -> tuple[Setting, ...]:
    """Settings far apart in temperature and log exposure; those with frames to spare first."""
    if len(settings) <= most:
        return settings
    place = np.array([_place(s.point) for s in settings])
    span = np.ptp(place, axis=0)
    place = place / np.where(span > 0, span, 1)
    several = np.array([min(len(s.frames), 3) for s in settings], float)
    picked = [int(np.argmax(several + 0.5 * place[:, 0]))]
    while len(picked) < most:
        far = np.min(np.linalg.norm(place[:, None] - place[picked], axis=2), axis=1)
        score = far * several
        score[picked] = -1
        picked.append(int(np.argmax(score)))
    return tuple(settings[i] for i in sorted(picked))


def _place(point: OperatingPoint) -> tuple[float, float, float, float]:
    exposure = (
        np.log10(max(point.exposure_s or 1e-6, 1e-6)) if point.exposure_s is not None else 0.0
    )
    channel = float(sum(map(ord, point.channel or "")))
    return point.temperature_c or 0.0, exposure, float(point.gain or 0.0), channel
