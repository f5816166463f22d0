"""Saturation, found from the frames of a setting: crowded end codes, and a full-well plateau.

Codes. Of noise without an end fewer pixels lie at the outermost code than at the next one; more lie
there where values beyond it were clipped.

Plateau. Where the signal grows, so does its shot noise, until the pixels are full: then the
temporal variance collapses (the maximum of the photon transfer curve is where EMVA 1288 puts
saturation). It happens below the converter's full scale, at a level that differs between pixels,
and blooming spreads it. So pixels are sorted by level, and the plateau begins
where the variance, having risen with the level, falls and stays low up to the highest.
"""

from __future__ import annotations

import math
from bisect import insort
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy import stats

CROWDED = 20  # pixels of all frames at an outermost code below which they are strays
BIN = 64  # pixels; the median of their variances is good to 30 % for two frames
FEWEST = 8  # bins of a plateau: chance does not keep that many low
FALL = 9.0  # of the variance to the plateau; noise of amplifiers of a sensor differs by less than 3
PLATEAU_SHARE = 0.9  # of the pixels from its begin on are on the plateau
# Standard deviations of their noise that the pixels below a plateau lie below it. A pixel that is
# as exposed, but left noisy by a denoise, lies sqrt(K) below with its outlier in one of K <= 16
# frames.
PLATEAU_GAP = 4.5
LEVELS = 2048  # bins at most
MAJORITY = 0.5  # of the pixels clipped or saturated: the median and the noise are not a sensor's
SAMPLE = 1 << 18  # pixels of a frame that are sorted: BIN for each of the levels, and more


@dataclass(frozen=True)
class Saturation:
    """From where pixels are clipped or saturated.

    Parameters
    ----------
    low, high : float
        Values at or below ``low`` are clipped, at or above ``high`` saturated, DN; infinite where
        there are none.
    low_share, high_share : float
        Shares of the pixels there, over all frames.
    plateau : bool
        ``high`` is where the temporal noise collapses, not the highest code.
    """

    low: float = -math.inf
    high: float = math.inf
    low_share: float = 0.0
    high_share: float = 0.0
    plateau: bool = False

    @property
    def share(self) -> float:
        """Share of the pixels at either end."""
        return self.low_share + self.high_share

    @property
    def most(self) -> bool:
        """Most pixels are clipped or saturated: neither level nor noise are the sensor's."""
        return self.share > MAJORITY

    def words(self) -> str:
        """Where and how many, for a note; empty for none."""
        said = []
        if self.low_share:
            said.append(
                f"{_percent(self.low_share)} of the pixels at the lowest code, {self.low:g} DN"
            )
        if self.high_share and self.plateau:
            said.append(
                f"{_percent(self.high_share)} of the pixels on a plateau from {self.high:.0f} DN, "
                "where the temporal noise collapses"
            )
        elif self.high_share:
            said.append(
                f"{_percent(self.high_share)} of the pixels at the highest code, {self.high:g} DN"
            )
        return " and ".join(said)


def _percent(share: float) -> str:
    return f"{100 * share:.2g} %" if share < 0.995 else f"{100 * share:.4g} %"


def saturation(stack: np.ndarray, repeats: bool = True) -> Saturation:
    """Of the frames of one setting, (frames, rows, columns), DN as recorded.

    ``repeats``: whether they are. Frames at neighbouring temperatures, in order, differ by more
    than noise: then the plateau is looked for in pairs, of which the nearest differ least.
    """
    codes = outermost(stack)
    begins = math.inf
    step = max(1, math.isqrt(stack[0].size // SAMPLE))
    some = stack[:, ::step, ::step]
    parts = [some] if repeats else [some[n : n + 2] for n in range(len(some) - 1)]
    for part in parts if len(some) > 1 else ():
        variance = part.var(axis=0, ddof=1, dtype=np.float64)
        begins = min(begins, _begins(part.min(axis=0), variance, len(part), codes[1]))
    return _of(codes, begins, lambda limit: float(np.mean(stack <= limit)))


def of_maps(
    least: np.ndarray, variance: np.ndarray | None, frames: int, values: np.ndarray,
    counts: np.ndarray,
) -> Saturation:  # fmt: skip
    """From what one pass over the frames keeps.

    Parameters
    ----------
    least, variance : ndarray
        Of each pixel over the frames, DN, DN^2; no variance for one frame.
    frames : int
    values, counts : ndarray
        Histogram of the recorded values over all frames.
    """
    seen = np.flatnonzero(counts)
    codes, often = values[seen], counts[seen]
    if seen.size < 2:
        return Saturation()
    low = float(codes[0]) if often[0] > max(CROWDED, often[1]) else -math.inf
    high = float(codes[-1]) if often[-1] > max(CROWDED, often[-2]) else math.inf
    begins = math.inf
    if variance is not None:
        step = max(1, math.isqrt(least.size // SAMPLE))
        some = (slice(None, None, step),) * 2
        begins = _begins(least[some], variance[some], frames, high)
    total = often.sum()
    return _of((low, high), begins, lambda limit: float(often[codes <= limit].sum() / total))


def _begins(least: np.ndarray, variance: np.ndarray, frames: int, high: float) -> float:
    """A hit raises the mean of a pixel with its variance: the least of the frames is its level."""
    free = least < high
    return plateau(least[free], variance[free], frames)


def _of(codes: tuple[float, float], begins: float, up_to: Callable[[float], float]) -> Saturation:
    """``up_to``: share of the values at or below a limit."""
    low, high = codes
    low_share = up_to(low) if math.isfinite(low) else 0.0
    if begins < high:
        return Saturation(low, begins, low_share, 1 - up_to(np.nextafter(begins, low)), True)
    high_share = 1 - up_to(np.nextafter(high, low)) if math.isfinite(high) else 0.0
    return Saturation(low, high, low_share, high_share)


def outermost(stack: np.ndarray) -> tuple[float, float]:
    """The lowest and the highest code where values pile up there; infinite where they do not."""
    lowest, highest = stack.min(), stack.max()
    if lowest == highest:
        return -math.inf, math.inf
    second = np.min(stack, where=stack > lowest, initial=highest)
    last_but_one = np.max(stack, where=stack < highest, initial=lowest)
    low = float(lowest) if _crowded(stack, lowest, second) else -math.inf
    high = float(highest) if _crowded(stack, highest, last_but_one) else math.inf
    return low, high


def _crowded(stack: np.ndarray, end: float, following: float) -> bool:
    beside = int(np.count_nonzero(stack == following))
    return bool(np.count_nonzero(stack == end) > max(CROWDED, beside))


def plateau(level: np.ndarray, variance: np.ndarray, frames: int) -> float:
    """Level from which pixels are on a plateau, DN; infinite for none.

    Parameters
    ----------
    level, variance : ndarray
        (pixels,), DN and variance over the frames, DN^2.
    frames : int
        At least 2.
    """
    size = max(BIN, -(-level.size // LEVELS))
    bins = level.size // size
    if bins < 2 * FEWEST:
        return math.inf
    order = np.argsort(level, kind="stable")[level.size - bins * size :].reshape(bins, size)
    usual = stats.chi2.median(frames - 1) / (frames - 1)
    noise = np.median(variance[order], axis=1) / usual
    smooth = np.median(np.stack([noise[:-2], noise[1:-1], noise[2:]]), axis=0)
    begins = _collapse(smooth)
    if begins is None or bins - begins < FEWEST:
        return math.inf
    before = level[order[:begins]]
    apart = level[order[begins, 0]] - np.median(before)
    if apart < PLATEAU_GAP * math.sqrt(np.median(noise[:begins])):
        return math.inf
    return float(level[order[begins, 0]])


def _collapse(noise: np.ndarray) -> int | None:
    """Bin at which the variance, sorted by level, collapses; None: nowhere.

    Most bins from there on lie ``FALL`` times below the middle one before, where the lowest quarter
    is not the noisiest: shot noise rises. Not all need lie low: on a plateau too some pixels drift,
    and the readout's own charge lies above it.
    """
    ordered = sorted(noise[:FEWEST])
    for begins in range(FEWEST, noise.size - FEWEST + 1):
        limit = (ordered[(begins - 1) // 2] + ordered[begins // 2]) / 2 / FALL
        insort(ordered, noise[begins])
        if noise[begins] > limit or np.mean(noise[begins:] <= limit) < PLATEAU_SHARE:
            continue
        quarters = [np.median(part) for part in np.array_split(noise[:begins], 4)]
        # of the last median's three bins the last
        return begins + 2 if max(quarters[1:]) >= quarters[0] else None
    return None
