"""Black levels as files state them, one for each operating point, and those that cannot be."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, replace

from dnanalyze.digits import number
from dnanalyze.loaders.captures import Sensor, Setting

ROUNDING = 2.0  # DN: levels are rounded, and averaged over colours
ABOVE = 0.5  # of the noise of a frame: dark signal is not negative, and a median is not so far off
OTHER_SCALE_NOISES = 20.0  # noises of a frame, from which a level of another scale is looked for
SCALE = 0.02  # of a doubling: 1.4 %, more than offsets and dark signal move a level of 20 noises
ZERO = 10.0  # noises of a frame, from which frames have a pedestal


@dataclass(frozen=True)
class Level:
    """What a frame of an operating point shows, DN: median and robust noise."""

    setting: Setting
    median: float
    noise: float


def doubted(levels: Sequence[Level], given: bool) -> tuple[set[int], list[str]]:
    """Which operating points have a black level that cannot be, by number, and a note each.

    The lowest operating point of each channel and gain decides: all dark signal is above the
    black level, and there is least of it.

    Parameters
    ----------
    levels : sequence of Level
    given : bool
        Whether the user states the black level; it is then kept and told.
    """
    groups: dict[object, list[int]] = defaultdict(list)
    for k, level in enumerate(levels):
        point = level.setting.point
        groups[point.channel, point.gain].append(k)
    wrong: set[int] = set()
    notes: dict[str, None] = {}
    for numbers in groups.values():
        stated = [k for k in numbers if levels[k].setting.black_level is not None]
        if not stated:
            continue
        lowest = min((levels[k] for k in stated), key=lambda one: one.median)
        if text := _fault(lowest):
            whose = "sidecar" if given else "files"
            fate = (
                "kept as given" if given else "taken as unknown; state black_level in the sidecar"
            )
            notes[
                f"The black level of the {whose}, {number(lowest.setting.black_level, 6)} DN, "
                f"cannot be right: the median of the frames at {lowest.setting.point.label()} is "
                f"{number(lowest.median, 6)} DN, {text}; {fate}."
            ] = None
            wrong.update(() if given else stated)
    return wrong, list(notes)


def _fault(level: Level) -> str:
    """What is wrong with a black level, seen from the frames; "" if nothing."""
    black, median, noise = level.setting.black_level, level.median, level.noise
    assert black is not None
    if black - median > max(ROUNDING, ABOVE * noise):
        return "and dark signal is not negative"
    if black == 0 and median > ZERO * noise:
        return f"{number(median / max(noise, 1e-9), 2)} times their noise: they have a pedestal"
    if black > 0 and median - black > OTHER_SCALE_NOISES * noise:
        doublings = math.log2(median / black)
        if doublings > 0.5 and abs(doublings - round(doublings)) < SCALE:
            return f"{2 ** round(doublings)} times that: it is of another scale"
    return ""


def common(setting: Setting, stated: Sequence[float | None]) -> tuple[Setting, str]:
    """The setting with the black level that its files state, and a note where they differ."""
    found = list(dict.fromkeys(stated))
    if len(found) == 1:
        return replace(setting, black_level=found[0]), ""
    some = ", ".join("none" if b is None else f"{number(b, 6)} DN" for b in found[:3])
    return setting, (
        f"Files at {setting.point.label()} state different black levels ({some}); it is taken as "
        "unknown."
    )


def with_levels(sensor: Sensor, settings: Sequence[Setting]) -> tuple[Sensor, list[str]]:
    """The sensor with the black level that its settings share, or with that of each.

    Returns
    -------
    sensor : Sensor
    notes : list of str
        That the black levels differ.
    """
    stated = {s.black_level for s in settings}
    if len(stated) == 1:
        return replace(sensor, black_level=stated.pop()), []
    each = tuple((s.point, s.black_level) for s in settings if s.black_level is not None)
    told = dict.fromkeys(f"{number(level, 6)} DN at {point.label()}" for point, level in each)
    some = ", ".join(list(told)[:3]) + (", ..." if len(told) > 3 else "")
    return (
        replace(sensor, black_level=None, black_levels=each),
        [f"The black level differs between operating points ({some}); each has its own."],
    )
