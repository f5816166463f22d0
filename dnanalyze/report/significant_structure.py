"""What a sensor shows that white noise and single hot pixels do not, by its statistics alone."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

from dnanalyze.analyzers.statistics import SettingStatistics, Statistics, Value
from dnanalyze.report.fields import FRAME, MEAN, Place
from dnanalyze.report.statistic_rows import info
from dnanalyze.report.words import number, point_label, varied

SIGMA = 6.0  # standard errors from which a difference from chance counts


@dataclass(frozen=True)
class Sign:
    """A statistic that chance holds at a known value.

    Parameters
    ----------
    name : str
    chance : float
        What white noise gives.
    least : float
        Smallest difference from it that matters, on the scale of the statistic.
    kind : str
        Picture in which it is seen.
    text : str
        What it says; ``{value}`` is the value, ``{percent}`` a hundred times it.
    below : bool
        Whether a value below chance counts too.
    """

    name: str
    chance: float
    least: float
    kind: str
    text: str
    below: bool = False


# With these least differences none is told of 43 ordinary sensors of five generators (256 x 256 to
# 384 x 384 pixels, 3 to 5 temperatures). The count of blinking pixels is no sign: it is 26 to 95 in
# nine of them, which have no RTS.
SHADING = "shading"  # not one statistic: all orders of it, over the noise of a frame
SIGNS = (
    Sign(SHADING, 0.0, 0.25, MEAN,
         "shading: the slow shape of the field scatters {value} times as much as the pixels of a "
         "frame"),
    Sign("column_noise", 1.0, 0.2, MEAN,
         "fixed vertical stripes: columns scatter {value} times as much as their pixels explain"),
    Sign("row_noise", 1.0, 0.2, MEAN,
         "fixed horizontal stripes: rows scatter {value} times as much as their pixels explain"),
    Sign("temporal_column_noise", 1.0, 0.2, FRAME,
         "vertical stripes that change with every frame: columns scatter {value} times as much as "
         "their pixels explain"),
    Sign("temporal_row_noise", 1.0, 0.2, FRAME,
         "banding that changes with every frame: rows scatter {value} times as much as their "
         "pixels explain"),
    Sign("column_outliers", 0.0, 3.0, MEAN,
         "defect columns: {value} lie 6 standard deviations off their neighbours"),
    Sign("row_outliers", 0.0, 3.0, MEAN,
         "defect rows: {value} lie 6 standard deviations off their neighbours"),
    Sign("temporal_corr_10", 0.0, 0.03, FRAME,
         "a filter, or noise along the readout: neighbours in a row are correlated by {value}",
         True),
    Sign("temporal_corr_01", 0.0, 0.03, FRAME,
         "a filter: neighbours in a column are correlated by {value} within a frame", True),
    Sign("pattern_corr_10", 0.0, 0.05, MEAN,
         "fixed structure: neighbours in a row are correlated by {value} in the mean frame", True),
    Sign("pattern_corr_01", 0.0, 0.05, MEAN,
         "fixed structure: neighbours in a column are correlated by {value} in the mean frame",
         True),
    Sign("temporal_r1", 0.0, 0.03, FRAME,
         "memory: each frame is correlated by {value} with the one before", True),
    Sign("unused_codes", 0.0, 0.02, FRAME,
         "missing codes: {percent} % of those within the distribution are never used"),
    Sign("low_spike", 1.0, 3.0, FRAME,
         "clipping: the lowest code is {value} times as frequent as its neighbours suggest"),
)  # fmt: skip
ORDER = re.compile(r"shading_\d_\d")
ALONG = {"column": r"shading_\d_0", "row": r"shading_0_\d"}  # orders across, down
MOSTLY = 0.4  # share of the variance of line means, from which it is shading
HOT = "hot_density_pattern"  # of a million pixels, beyond 5 robust standard deviations


@dataclass(frozen=True)
class Structure:
    """A structure that chance does not make, where it is plainest.

    Parameters
    ----------
    sign : Sign
    setting : SettingStatistics
        The operating point of the largest difference.
    size : float
        Size of the difference, in units of the least that matters.
    points : int
        Operating points at which it is significant.
    """

    sign: Sign
    setting: SettingStatistics
    size: float
    points: int

    @property
    def place(self) -> Place:
        """Where to look."""
        return Place(self.setting.point, self.setting.plane, self.sign.kind)


def structures(measured: Statistics) -> list[Structure]:
    """Every structure that is significant and large enough to matter, plainest first."""
    found = []
    for sign in SIGNS:
        sized = [(size, s) for s in measured.settings if (size := _size(sign, s)) is not None]
        if sized:
            size, setting = max(sized, key=lambda pair: pair[0])
            found.append(Structure(sign, setting, size, len(sized)))
    kept = [f for f in found if not _told_by(f, found)]
    return sorted(kept, key=lambda f: -f.size)


def _told_by(one: Structure, others: Sequence[Structure]) -> bool:
    """Lines that move are seen in single frames too, and said once."""
    moving = {f.sign.name for f in others}
    return one.sign.name in ("row_noise", "column_noise") and f"temporal_{one.sign.name}" in moving


def value_of(sign: Sign, setting: SettingStatistics) -> Value | None:
    """The value that a sign is read off."""
    if sign.name != SHADING:
        return setting.values.get(sign.name)
    noise = setting.values.get("frame_noise_core")
    orders = [v for name, v in setting.values.items() if ORDER.fullmatch(name)]
    if noise is None or not orders or not noise.value > 0:
        return None
    size = math.sqrt(sum(v.value**2 for v in orders))
    # the errors of whole rows and columns hold what another sensor would differ by
    return Value(size / noise.value, min(v.se for v in orders) / noise.value)


def _smooth(sign: Sign, setting: SettingStatistics) -> bool:
    """Whether columns, or rows, differ by the slow shape of the field rather than by stripes."""
    side, _, rest = sign.name.partition("_")
    total = setting.values.get(f"{side}_mean_sd")
    if rest != "noise" or side not in ALONG or total is None:
        return False
    slow = [v.value**2 for n, v in setting.values.items() if re.fullmatch(ALONG[side], n)]
    return sum(slow) > MOSTLY * total.value**2


def _size(sign: Sign, setting: SettingStatistics) -> float | None:
    value = value_of(sign, setting)
    if value is None or not value.se > 0 or _smooth(sign, setting):
        return None
    scale = info(sign.name).scale
    apart = scale.coordinate(value.value) - scale.coordinate(sign.chance)
    apart = abs(apart) if sign.below else apart
    return apart / sign.least if apart >= max(sign.least, SIGMA * value.se) else None


def beyond(measured: Statistics, simulated: Statistics) -> list[Structure]:
    """The structures that a model does not show at the same operating point."""
    there = {(s.point, s.plane): s for s in simulated.settings}

    def lacks(found: Structure) -> bool:
        own = value_of(found.sign, found.setting)
        other = there.get((found.setting.point, found.setting.plane))
        value = None if other is None else value_of(found.sign, other)
        if value is None or own is None:
            return False
        scale = info(found.sign.name).scale
        apart = abs(scale.coordinate(own.value) - scale.coordinate(value.value))
        return apart >= max(found.sign.least, SIGMA * own.se)

    return [f for f in structures(measured) if lacks(f)]


def sentence_of(found: Structure, measured: Statistics) -> str:
    """What it says, its size and where it is plainest."""
    known = value_of(found.sign, found.setting)
    value = math.nan if known is None else known.value
    said = found.sign.text.format(value=number(value, 2), percent=number(100 * value, 2))
    apart = varied(vars(s.point) | {"plane": s.plane} for s in measured.settings)
    if not apart:
        return said
    where = point_label(vars(found.setting.point) | {"plane": found.setting.plane}, apart)
    return f"{said} (plainest at {where})"


def hot_share(measured: Statistics) -> tuple[float, SettingStatistics] | None:
    """Largest share of hot pixels, and its operating point."""
    known = [(s.values[HOT].value / 1e6, s) for s in measured.settings if HOT in s.values]
    return max(known, key=lambda pair: pair[0], default=None)


def plainest(measured: Statistics) -> Place | None:
    """Where structure is plainest; the middle operating point where there is none."""
    found = structures(measured)
    if found:
        return found[0].place
    some = measured.settings
    return Place(some[len(some) // 2].point, some[len(some) // 2].plane) if some else None
