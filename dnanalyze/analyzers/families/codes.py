"""The codes of the converter: missing codes, periodic components, clipping."""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from dnanalyze.analyzers.accumulators.accumulated import Accumulated
from dnanalyze.analyzers.estimators.quantiles import Counted
from dnanalyze.analyzers.families.family import FamilyResult
from dnanalyze.analyzers.statistics import Scale, StatisticInfo, Value

CENTRAL = 0.98  # share of a histogram that counts as its body
GAUSSIAN = 3.45  # codes of the body over those between the quartiles, of a normal distribution
TAIL_COUNTS = 30  # counts
STEEP = 4.0  # times what is smooth over it that a code counts for at most
OVERUSED = 5.0  # standard errors above its neighbours

INFOS = (
    StatisticInfo(
        "lattice", "codes", "1", "whole-number codes",
        high="the values are whole codes, and the model's are not",
        low="the model's values are whole codes, and the measured ones are not",
    ),
    StatisticInfo(
        "unused_codes", "codes", "1", "share of codes that never occur",
        high="codes are missing: a share of {measured} of the central codes never occurs",
        low="the model leaves codes unused that the sensor gives",
    ),
    StatisticInfo(
        "code_roughness", "codes", "1", "roughness of the histogram of codes", Scale.LOG,
        high="the frequencies of neighbouring codes differ {ratio} times as much as in the model",
        low="the frequencies of neighbouring codes differ less than in the model",
    ),
    StatisticInfo(
        "code_comb", "codes", "1", "strongest periodic component of that roughness", Scale.LOG,
        high="the histogram of codes has a periodic component {ratio} times the model's",
        low="the histogram of codes lacks the periodic component of the model",
    ),
    StatisticInfo(
        "low_spike", "codes", "1", "pile-up at the lowest code", Scale.LOG,
        high="values pile up at the lowest code: the black level is clipped",
        low="the model piles up values at the lowest code, the sensor does not",
    ),
    StatisticInfo(
        "high_spike", "codes", "1", "pile-up at the highest code", Scale.LOG,
        high="values pile up at the highest code: the converter saturates",
        low="the model piles up values at the highest code, the sensor does not",
    ),
    StatisticInfo(
        "code_comb_period", "codes", "DN", "period of the histogram of codes", compared=False
    ),
    StatisticInfo("effective_bits", "codes", "bits", "entropy of the histogram", compared=False),
    StatisticInfo("clipped_low", "codes", "1", "share at the lowest code", compared=False),
    StatisticInfo("clipped_high", "codes", "1", "share at the highest code", compared=False),
    StatisticInfo("lowest_code", "codes", "DN", "lowest code", compared=False),
    StatisticInfo("highest_code", "codes", "DN", "highest code", compared=False),
    StatisticInfo("overused_codes", "codes", "codes", "codes that occur too often", compared=False),
)  # fmt: skip


def finish(acc: Accumulated) -> FamilyResult:
    """Statistics of the histogram of codes over all frames."""
    out = FamilyResult()
    if not acc.plan.integer:
        out.values["lattice"] = Value(lattice(acc.end_frames[0]), 0.05)
        reason = "the values are not whole codes"
        out.missing.update(dict.fromkeys((i.name for i in INFOS[1:]), reason))
        return out
    out.values["lattice"] = Value(1.0, 0.05)
    counts = acc.values
    repeats = _overdispersion(acc)
    _ends(counts, repeats, acc, out)
    _body(counts, repeats, out)
    return out


def lattice(frame: np.ndarray) -> float:
    """|mean exp(2 pi i y)|: 1 for whole numbers, near 0 for continuous values."""
    phase = 2 * np.pi * (frame - np.rint(frame))
    return float(np.hypot(np.cos(phase).mean(dtype=float), np.sin(phase).mean(dtype=float)))


def _overdispersion(acc: Accumulated) -> float:
    """Variance of a code's count over Poisson's: pixels that stay in their code count K times."""
    if acc.frames == 1:
        return 1.0
    p = acc.values.counts / acc.values.total
    chance = float(p @ p)
    same = float(acc.differences.share_below(0.3) - acc.differences.share_below(-0.3))
    stays = min(max((same - chance) / max(1 - chance, 1e-9), 0.0), 1.0)
    return 1 + (acc.frames - 1) * stays


def _ends(counts: Counted, repeats: float, acc: Accumulated, out: FamilyResult) -> None:
    n, total = counts.counts, counts.total
    p = n[n > 0] / total
    bits = np.log2(p)
    entropy = -float(p @ bits)
    spread = float(p @ bits**2) - entropy**2
    values = out.values
    se = math.sqrt(max(spread, 1e-6) / acc.plan.pixels)
    values["effective_bits"] = Value(max(entropy, 0.0), se)
    values["lowest_code"] = Value(float(counts.centres[0]), 1.0)
    values["highest_code"] = Value(float(counts.centres[-1]), 1.0)
    for name, at in (("clipped_low", 0), ("clipped_high", -1)):
        values[name] = Value(n[at] / total, math.sqrt(repeats * (n[at] + 1)) / total)
    if n.size < 3:
        reason = "fewer than three codes occur"
        out.missing.update(dict.fromkeys(("low_spike", "high_spike"), reason))
        return
    for name, inwards in (("low_spike", n), ("high_spike", n[::-1])):
        values[name] = _spike(inwards, acc.frames, repeats)


def _spike(inwards: np.ndarray, frames: int, repeats: float) -> Value:
    """Counts of the last code over the next one's: how much more often the last is given.

    Fewer counts than frames are strays, no pixel that stays there: they count with the next code. A
    few more may be chance, without which the second would be the last: the ratio goes from that of
    both to the third to that of the last to the second as counts grow, for no count may jump it.
    """
    reached = np.cumsum(inwards)
    at = min(int(np.searchsorted(reached, frames)), inwards.size - 3)
    last, second, third = int(reached[at]), int(inwards[at + 1]), int(inwards[at + 2])
    outer = math.log((last + 1) / (second + 1))
    inner = math.log((last + second + 1) / (third + 1))
    above = max(last - frames, 0) + TAIL_COUNTS
    w = 1.0 - TAIL_COUNTS / above
    # Poisson, with some counts more: which code is the last one seen is itself chance
    steps = (
        abs(outer - inner) * TAIL_COUNTS / above**2 + w / (last + 5) + (1 - w) / (last + second + 5)
    )
    others = (w**2 + (1 - w) ** 2) / (second + 5) + (1 - w) ** 2 / (third + 5)
    se = math.sqrt(repeats * (steps**2 * (last + 5) + others))
    return Value(math.exp(w * outer + (1 - w) * inner), max(se, 0.02))


def _body(counts: Counted, repeats: float, out: FamilyResult) -> None:
    """Codes beside what is smooth over them, each with the weight of its counts."""
    ends = np.array([(1 - CENTRAL) / 2, 0.25, 0.75, (1 + CENTRAL) / 2])
    low, first, last, high = np.searchsorted(counts.cumulative[1:], counts.total * ends)
    body = counts.counts[low : high + 1].astype(float)
    names = ("unused_codes", "code_roughness", "code_comb", "code_comb_period", "overused_codes")
    if body.size < 5:
        reason = "fewer than five codes make up the body of the histogram"
        out.missing.update(dict.fromkeys(names, reason))
        return
    core = min(body.size, GAUSSIAN * (last - first + 1))  # a long tail makes it no smoother
    # as far as a normal distribution reaches: one hot pixel more or less may put the end of the
    # body before or behind a gap, whose codes no sensor of the design gives
    beyond = math.ceil((GAUSSIAN - 1.0) / 2.0 * (last - first + 1))
    near = counts.counts[max(low, first - beyond) : min(high, last + beyond) + 1]
    unused = float(np.sum(near == 0))
    se = math.sqrt(max(unused, 1.0) * max(1 - unused / near.size, 1 / near.size)) / near.size
    out.values["unused_codes"] = Value(unused / near.size, se)
    width = int(min(max(5, 2 * (core // 8) + 1), 129))
    smooth = smoothed(counts.counts.astype(float), width)[low : high + 1]
    smooth = np.maximum(smooth, body / STEEP)  # a cubic falls through 0 where a histogram ends
    rough = body / smooth - 1
    noise, weight = repeats / smooth, smooth / smooth.sum()
    power = float(weight @ rough**2)
    spread = math.sqrt(float(weight**2 @ (4 * rough**2 * noise + 2 * noise**2)))
    relative = spread / max(power, float(weight @ noise)) / 2
    if power <= 0:
        out.missing["code_roughness"] = "the histogram of codes is perfectly smooth"
    else:
        out.values["code_roughness"] = Value(math.sqrt(power), max(relative, 0.05))
    _comb(rough, noise, weight, out)
    over = float(np.sum(rough > OVERUSED * np.sqrt(noise)))
    out.values["overused_codes"] = Value(over, 1.0)


def _comb(rough: np.ndarray, noise: np.ndarray, weight: np.ndarray, out: FamilyResult) -> None:
    """Largest amplitude of a period of 2 codes or more in the ratio to the smooth histogram."""
    n, codes = rough.size, 1.0 / float(weight @ weight)
    amplitude = 2 * np.abs(np.fft.rfft(weight * rough))
    # near half a period a code both signs are one
    amplitude /= 1 + np.abs(np.fft.fft(weight))[-2 * np.arange(amplitude.size) % n]
    first = min(math.ceil(2 * n / codes), amplitude.size - 1)
    best = first + int(np.argmax(amplitude[first:]))
    value = float(amplitude[best])
    if value <= 0:
        out.missing["code_comb"] = out.missing["code_comb_period"] = "the histogram has no period"
        return
    trials = max((codes / 2 - 1) / 2, 1.3)  # half, for neighbouring periods are alike
    extreme = 0.64 / (math.log(trials) + 0.577)  # Gumbel's law, half for an amplitude
    direct = math.sqrt(2 * float(weight**2 @ noise)) / value
    out.values["code_comb"] = Value(value, min(extreme, max(direct, 0.1)))
    out.values["code_comb_period"] = Value(n / best, (n / best) ** 2 / codes / 2)


def smoothed(counts: np.ndarray, width: int) -> np.ndarray:
    """Cubic Savitzky-Golay smooth of a histogram over ``width`` codes; > 0."""
    margin = np.zeros(width // 2)
    padded = np.concatenate([margin, counts, margin])
    return np.maximum(np.convolve(padded, _savitzky_golay(width), "valid"), 0.5)


@cache
def _savitzky_golay(width: int) -> np.ndarray:
    """Cubic smoothing kernel: the first row of the pseudo-inverse of the powers 0 to 3."""
    at = np.linspace(-1.0, 1.0, width)
    return np.asarray(np.linalg.pinv(np.vander(at, 4, increasing=True))[0])
