"""First guesses of offset_drift: its parameters as the statistics suggest them."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.offset_drift import OffsetDrift
from dnanalyze.model.guesses.evidence import curve, over_signal, shows, typical_positive
from dnanalyze.significance import NOTICEABLE


def guess(effect: type[OffsetDrift], clues: Clues) -> list[Effect]:
    """The step from the spread of frame means, K frames of a walk having step^2 (K^2-1)/6K; a
    transient where the first frame stands apart in the same direction in most settings. Offsets
    that are new in each frame instead, where successive frames differ as those do.
    """
    if not shows(clues, effect.fingerprint):
        return []
    spread2 = clues.measured("drift") ** 2
    spread2 = spread2 - np.nan_to_num(clues.simulated("drift")) ** 2
    means = [curve(clues, "frame_means", i) for i in range(len(clues.points))]
    frames = max([len(m) for m in means if m is not None], default=4)
    frames = max(frames, 2)
    walk, white = math.sqrt(6.0 * frames / (frames**2 - 1.0)), _are_white(means)
    added, scaled = math.sqrt(typical_positive(spread2)), _relative(clues, spread2)
    sizes = {"added": added} if scaled is None else {"added": added, "scaled": scaled}
    least = effect.parameters()["step"].lower
    guesses: list[Effect] = []
    for form, size in sizes.items():
        guesses.append(effect.within(step=walk * size, form=form))
        if white:
            guesses.insert(0, effect.within(step=least, white=size, form=form))
    jumps = np.array([_jump(m) for m in means if m is not None and len(m) >= 4])
    if jumps.size and abs(np.sign(jumps).sum()) > 0.6 * jumps.size:
        step = 0.1 * (walk * added)
        guesses.insert(0, effect.within(step=step, transient=np.median(jumps)))
    share = _share(clues, means)
    if share is not None:
        start = share / (1.0 - math.exp(-1.0 / effect.settling))
        guesses.append(effect.within(step=0.1 * abs(share), transient=start, form="scaled"))
    return guesses


def _relative(clues: Clues, spread2: np.ndarray) -> float | None:
    """Spread of the frame means over the dark signal, by least squares in the signal above that of
    the coldest setting; None where that hardly moves or the spread does not grow with it.
    """
    both = over_signal(clues, spread2)
    if both is None:
        return None
    x2 = both[0] ** 2
    square = float(x2 @ both[1] / (x2 @ x2))
    return math.sqrt(square) if square > 0 else None


def _are_white(means: Sequence[np.ndarray | None]) -> bool:
    """Whether frame means are rather independent than a walk, over all settings.

    The mean square difference of successive frames over their variance (von Neumann, Ann. Math.
    Stat. 12 (1941) 367) is 2 where they are independent and 6 / (K + 1) for a walk of K frames.
    They are taken as independent where it is nearer to 2; fewer than three frames tell nothing.
    """
    series = [m for m in means if m is not None and len(m) >= 3]
    differences = sum(float(np.mean(np.diff(m) ** 2)) for m in series)
    middle = sum((1.0 + 3.0 / (len(m) + 1)) * float(np.var(m, ddof=1)) for m in series)
    return differences > middle


def _share(clues: Clues, means: Sequence[np.ndarray | None]) -> float | None:
    """Share by which the first frame's dark signal exceeds the next's: the slope of their
    difference over the level; None where the level hardly moves or the slope is not seen.
    """
    jump = np.array([np.nan if m is None or len(m) < 2 else m[0] - m[1] for m in means])
    both = over_signal(clues, jump)
    if both is None or both[1].size < 3:
        return None
    x, jump = both
    slope = float(x @ jump / (x @ x))
    rest = jump - slope * x
    error = math.sqrt(float(rest @ rest) / (x.size - 1) / float(x @ x))
    return slope if abs(slope) > NOTICEABLE * error else None


def _jump(means: np.ndarray) -> float:
    """First frame mean less the others' where it is outside 3 times their range, else 0."""
    rest = means[1:]
    away = float(means[0] - np.median(rest))
    return away if abs(away) > 3.0 * float(np.ptp(rest)) / 2.0 else 0.0
