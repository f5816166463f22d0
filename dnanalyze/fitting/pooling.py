"""Operating points of few frames that these frames do not tell apart, taken as one.

An operating point of one frame has no temporal noise, so that nothing of it separates noise from
pattern. A sensor without cooling control has many such points, and so has a series of exposures
without dark signal. Where level, noise and outliers of their frames agree, they are frames of one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import label
from scipy.stats import binomtest, t

from dnanalyze.loaders.captures import Frame, Setting, Window
from dnanalyze.loaders.files import natural_key
from dnanalyze.loaders.health import MOVED
from dnanalyze.robust import robust_deviation
from dnanalyze.significance import CERTAIN, RARE

MOST = 128  # operating points whose frames are compared; a fit takes 8 of what is left
FEW = 3  # frames from which an operating point tells its noise: of two, drift is noise too
STRIPS = 16  # all over the frame; their scatter is the error of a level, whatever correlates in it
PIXELS = 1 << 18  # of a frame that are looked at: eleven hits of one frame alone are a difference
DRIFT = MOVED**0.5  # noises: within an operating point it would be no note of the loader's
TINY = 1e-6  # DN, of a strip without noise


@dataclass(frozen=True)
class _Sample:
    """Strips of a frame, (strips, rows, columns), and the level and log noise of each."""

    strips: np.ndarray
    levels: np.ndarray
    noises: np.ndarray


def pooled(settings: Sequence[Setting], shape: tuple[int, int]) -> list[tuple[Setting, int]]:
    """Settings with those pooled that their frames do not tell apart.

    Parameters
    ----------
    settings : sequence of Setting
    shape : (int, int)
        Of a frame, (rows, columns).

    Returns
    -------
    list of (Setting, int)
        Each with the number of operating points that it stands for. The operating point of a pool
        is that in the middle of its members in the given order. Of more than `MOST` operating
        points so many are looked at, in equal steps, and the others left out.
    """
    if all(len(s.frames) >= FEW for s in settings) or shape[0] < STRIPS:
        return [(s, 1) for s in settings]
    settings = settings[:: math.ceil(len(settings) / MOST)]
    samples = [_sample(s.frames[0], shape) for s in settings]
    pools: list[list[int]] = []  # by their first members, to which all others are compared
    for n, setting in enumerate(settings):
        alike = (
            pool
            for pool in pools
            if _may_share(setting, settings[pool[0]])
            and _alike(samples[n], samples[pool[0]], _drift(setting, settings[pool[0]]))
        )
        home = next(alike, None)
        if home is None:
            pools.append([n])
        else:
            home.append(n)
    return [(_together([settings[n] for n in pool]), len(pool)) for pool in pools]


def _may_share(one: Setting, other: Setting) -> bool:
    """Whether two settings have one readout, and either too few frames."""
    few = min(len(one.frames), len(other.frames)) < FEW
    a, b = one.point, other.point
    return (
        few
        and (a.gain, a.channel) == (b.gain, b.channel)
        and (one.black_level == other.black_level)
    )


def _together(members: Sequence[Setting]) -> Setting:
    middle = members[len(members) // 2]
    if len(members) == 1:
        return middle
    frames = sorted((f for s in members for f in s.frames), key=lambda f: natural_key(f.name))
    return replace(middle, frames=tuple(frames))


def _sample(frame: Frame, shape: tuple[int, int]) -> _Sample:
    rows, columns = shape
    height = max(1, min(PIXELS // (STRIPS * columns), rows // STRIPS))
    tops = np.linspace(0, rows - height, STRIPS).astype(int)
    windows = [Window(int(top), int(top) + height, 0, columns) for top in tops]
    strips = np.array([frame.read(window) for window in windows], np.float32)
    noise = _clipped(np.diff(strips, axis=2)).std(axis=(1, 2), dtype=float)
    levels = _clipped(strips).mean(axis=(1, 2), dtype=float)
    return _Sample(strips, levels, np.log(np.maximum(noise, TINY)))


def _drift(one: Setting, other: Setting) -> float:
    """Step of the level that is no difference, in noises: of equal exposures it may be a drift."""
    return DRIFT if one.point.exposure_s == other.point.exposure_s else 0.0


def _alike(one: _Sample, other: _Sample, drift: float) -> bool:
    """Whether two frames differ by noise alone: level, noise and outliers, each by its own test.

    ``drift``: step of the level, in noises, that may be beside it.
    """
    step = one.levels - other.levels
    near = abs(step.mean()) <= drift * np.exp(other.noises.mean())  # the pattern is in both
    if not (near or _zero(step)) or not _zero(one.noises - other.noises):
        return False
    difference = one.strips - other.strips
    noise = _clipped(difference).std() / 2.0**0.5
    return (abs(step.mean()) <= drift * noise or _zero(step)) and _same_outliers(difference)


def _clipped(values: np.ndarray) -> np.ndarray:
    """Values without outliers; codes that half of the pixels share have no robust deviation."""
    middle = np.median(values)
    spread = robust_deviation(values) or values.std()
    return np.clip(values, middle - CERTAIN * spread, middle + CERTAIN * spread)


def _zero(values: np.ndarray) -> bool:
    """Student's test of a mean of 0 over the strips."""
    if not np.isfinite(values).all():
        return False
    error = values.std(ddof=1) / STRIPS**0.5
    return bool(abs(values.mean()) <= t.isf(RARE / 2.0, STRIPS - 1) * error)


def _same_outliers(difference: np.ndarray) -> bool:
    """Binomial test of clumps of pixels that one frame has above the other, and the other way."""
    off = difference - np.median(difference)
    spread = robust_deviation(off) or off.std()
    counts = [_clumps(sign * off > CERTAIN * spread) for sign in (1.0, -1.0)]
    total = sum(counts)
    return total == 0 or bool(binomtest(counts[0], total).pvalue > RARE)


def _clumps(mask: np.ndarray) -> int:
    near = np.zeros((3, 3, 3), bool)
    near[1] = True  # strips are no neighbours
    return int(label(mask, near)[1])
