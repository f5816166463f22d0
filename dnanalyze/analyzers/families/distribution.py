"""The distribution of the DSNU, of the temporal dark noise and of single frames."""

from __future__ import annotations

import math

import numpy as np

from dnanalyze.analyzers.accumulators.accumulated import Accumulated
from dnanalyze.analyzers.estimators.quantiles import Counted, Ordered
from dnanalyze.analyzers.estimators.steps import pattern_steps
from dnanalyze.analyzers.estimators.uncertainty import QuantileErrors, block_sums, mean_error
from dnanalyze.analyzers.families.family import FamilyResult
from dnanalyze.analyzers.families.level import floor
from dnanalyze.analyzers.plan import TAIL_CLIP
from dnanalyze.analyzers.statistics import Scale, StatisticInfo, Value

PROBABILITIES = np.array([0.001, 0.01, 0.05, 0.1, 0.25, 0.5, 0.75, 0.9, 0.95, 0.99, 0.999, 0.9999])
MEDIAN = 5
LESS_MEDIAN = np.eye(PROBABILITIES.size) - np.eye(PROBABILITIES.size)[:, [MEDIAN]]
LEVELS = ("0.001", "0.01", "0.1", "0.25", "0.75", "0.9", "0.99", "0.999", "0.9999")
PLACES = [PROBABILITIES.tolist().index(float(level)) for level in LEVELS]
TEMPORAL_LEVELS = ("0.001", "0.01", "0.99", "0.999")
DRIFTING = 0.5  # scatter of the excess kurtosis of a few normal differences
FEWEST = 4.0  # pixels expected beyond a quantile for it to be stated
CURVE_BINS = 512

_SUBJECT = {
    "pattern": "the DSNU",
    "temporal": "the temporal dark noise",
    "frame": "a single frame",
}
_TITLE = {"pattern": "the DSNU", "temporal": "the temporal noise", "frame": "a single frame"}


def _quantile_info(what: str, level: str, compared: bool = True) -> StatisticInfo:
    p = float(level)
    upper = p > 0.5
    share = f"{100 * min(p, 1 - p):.3g} %"
    side = "brightest" if upper else "darkest"
    far = "{difference} " + ("longer" if upper else "shorter")
    near = "{difference} " + ("shorter" if upper else "longer")
    where = f"the {side} {share} of {_SUBJECT[what]}"
    return StatisticInfo(
        f"{what}_q{level}", "distribution", "DN", f"{p:g} quantile of {_TITLE[what]}",
        high=f"{where}: the tail is {far} than the model's",
        low=f"{where}: the tail is {near} than the model's",
        compared=compared,
    )  # fmt: skip


INFOS = (
    *(_quantile_info("pattern", level) for level in LEVELS),
    *(_quantile_info("temporal", level) for level in TEMPORAL_LEVELS),
    *(_quantile_info("frame", level) for level in LEVELS),
    StatisticInfo(
        "temporal_kurtosis", "distribution", "1", "excess kurtosis of the temporal dark noise",
        high="the temporal dark noise has heavier tails than the model's",
        low="the temporal dark noise has lighter tails than the model's",
    ),
    StatisticInfo(
        "temporal_skewness", "distribution", "1", "skewness of the temporal dark noise",
        high="the temporal dark noise is more skewed towards bright values than the model's",
        low="the temporal dark noise is less skewed towards bright values than the model's",
    ),
    StatisticInfo(
        "temporal_third_cumulant", "distribution", "DN^3",
        "third cumulant of the temporal dark noise", compared=False,
    ),
    StatisticInfo(
        "pattern_steps", "distribution", "1", "equally spaced peaks of the DSNU", Scale.LOG,
        high="the DSNU's histogram has equally spaced peaks that the model lacks",
        low="the DSNU's histogram lacks the equally spaced peaks of the model",
    ),
    StatisticInfo("pattern_step_dn", "distribution", "DN", "spacing of the peaks", compared=False),
    *(
        StatisticInfo(
            f"{what}_{name}", "distribution", "1", f"{text} of {_TITLE[what]}", compared=False
        )
        for what in ("frame", "pattern")
        for name, text in (
            ("skewness", "skewness"),
            ("kurtosis", "excess kurtosis"),
            ("robust_skewness", "robust skewness (q0.99 + q0.01 − 2 q0.5) / (q0.99 − q0.01)"),
            ("robust_kurtosis", "robust kurtosis (q0.99 − q0.01) / (q0.75 − q0.25) / 3.45"),
        )
    ),
    StatisticInfo("lognormal_mu", "distribution", "ln DN", "log-normal fit, mu", compared=False),
    StatisticInfo("lognormal_delta", "distribution", "1", "log-normal fit, delta", compared=False),
    StatisticInfo("lognormal_shift", "distribution", "DN", "log-normal fit, shift", compared=False),
    StatisticInfo("peak_count", "distribution", "1", "peaks of the DSNU", compared=False),
)  # fmt: skip

NORMAL_RATIO = 3.4490  # (q.99 - q.01) / (q.75 - q.25) of the normal law


def finish(acc: Accumulated) -> FamilyResult:
    """Quantiles, shape and histograms of the accumulated frames."""
    out = FamilyResult()
    law = acc.pattern_ordered if acc.frames == 1 else acc.values
    frames = QuantileErrors(acc.plan, acc.end_frames, law, PROBABILITIES, acc.frames)
    _quantiles(acc, "frame", frames, out)
    told = acc.plan.errors  # what is given for information alone is wanted
    if told:
        _shape("frame", frames, power_means(acc.values), out)
    out.curves["histogram_codes"] = acc.values.centres
    out.curves["histogram_counts"] = acc.values.counts
    if acc.frames == 1:
        _absent(out, "one frame does not separate DSNU from temporal noise")
        return out
    pattern = QuantileErrors(acc.plan, (acc.pattern,), acc.pattern_ordered, PROBABILITIES)
    _quantiles(acc, "pattern", pattern, out)
    _temporal(acc, out)
    if told:
        _shape("pattern", pattern, power_means(acc.pattern), out)
        _lognormal(pattern, out)
        x, counts = histogram(acc.pattern_ordered, acc.pattern_sigma)
        out.curves["pattern_hist_x"], out.curves["pattern_hist_n"] = x, counts
        out.values["peak_count"] = Value(float(peaks(counts)), 1.0)
    residue = math.sqrt(acc.temporal_mean / acc.frames)
    steps = pattern_steps(acc.pattern_ordered, residue)
    if steps is None:
        out.missing["pattern_steps"] = "the DSNU is not above the remaining temporal noise"
        out.missing["pattern_step_dn"] = out.missing["pattern_steps"]
    else:
        out.values["pattern_steps"], out.values["pattern_step_dn"] = steps
    return out


def _absent(out: FamilyResult, reason: str) -> None:
    for info in INFOS:
        if info.name not in out.values:
            out.missing.setdefault(info.name, reason)


def _quantiles(acc: Accumulated, what: str, errors: QuantileErrors, out: FamilyResult) -> None:
    """Quantiles less the median, DN."""
    values = errors.values - errors.values[MEDIAN]
    se = errors.of(LESS_MEDIAN)
    if what == "frame" and acc.plan.errors:  # pooled frames, which drift
        se = np.hypot(se, values * acc.drift_error(acc.values.robust_sigma() ** 2) / 2)
    se = np.maximum(se, floor(acc))
    for level, k in zip(LEVELS, PLACES, strict=True):
        p = float(level)
        name = f"{what}_q{level}"
        if min(p, 1 - p) * acc.plan.pixels < FEWEST:
            out.missing[name] = f"fewer than {FEWEST:g} pixels are expected beyond it"
        else:
            out.values[name] = Value(float(values[k]), float(se[k]))


def _temporal(acc: Accumulated, out: FamilyResult) -> None:
    law, differences = acc.differences, acc.end_differences
    p = np.array([float(level) for level in TEMPORAL_LEVELS])
    errors = QuantileErrors(acc.plan, differences, law, p, acc.frames - 1)
    se = errors.of(np.eye(p.size))
    if acc.plan.errors:
        shift = math.sqrt(acc.drift_variance) / (acc.frames - 1)  # of whole differences, averaged
        wide = errors.values * acc.drift_error(acc.difference_sigma**2) / 2
        se = np.sqrt(se**2 + wide**2 + shift**2)
    se = np.maximum(se, floor(acc))
    for k, level in enumerate(TEMPORAL_LEVELS):
        name = f"temporal_q{level}"
        if min(p[k], 1 - p[k]) * law.total < FEWEST:
            out.missing[name] = f"fewer than {FEWEST:g} differences are expected beyond it"
        else:
            out.values[name] = Value(float(errors.values[k]), float(se[k]))
    out.curves["difference_hist_x"], out.curves["difference_hist_n"] = law.centres, law.counts
    reach = TAIL_CLIP * acc.difference_sigma
    x, w = law.centres.clip(-reach, reach), law.counts / law.total
    d = x - float(w @ x)
    m2, m4 = float(w @ d**2), float(w @ d**4)
    skewed = ("temporal_skewness", "temporal_third_cumulant")
    if m2 <= 0:
        reason = "the frames are identical"
        out.missing.update(dict.fromkeys(("temporal_kurtosis", *skewed), reason))
        return
    if acc.frames < 3:
        out.missing.update(dict.fromkeys(skewed, "needs at least three frames"))
    elif not acc.maps.cumulants[:, 0].any():
        out.missing.update(dict.fromkeys(skewed, "the frames differ by their levels alone"))
    else:
        _skewness(acc, out)
    ratio = m4 / m2**2
    error = _kurtosis_error(acc, np.float32(reach), m2, ratio) if acc.plan.errors else 0.0
    moved = min(2.0 * acc.drift_variance / m2, 1.0)  # share of whole frames that move
    error = math.hypot(error, DRIFTING * moved**2)
    out.values["temporal_kurtosis"] = Value(ratio - 3.0, max(error, 1e-4))


def _skewness(acc: Accumulated, out: FamilyResult) -> None:
    """Third cumulant within three successive frames over the power 3/2 of the variance there."""
    second, third = acc.maps.cumulants.mean(axis=0)
    cubed = second**1.5
    skewness = float(third / cubed)
    error = _skewness_error(acc, second, skewness) if acc.plan.errors else 0.0
    out.values["temporal_skewness"] = Value(skewness, max(error, 1e-4))
    out.values["temporal_third_cumulant"] = Value(float(third), float(max(error, 1e-4) * cubed))


def _skewness_error(acc: Accumulated, second: float, skewness: float) -> float:
    """Standard error of the skewness, from the blocks of one triple of frames."""
    (one, two), three = acc.maps.head, acc.maps.tail[-1]
    first, later = np.diff(acc.frame_means[[0, 1, -1]]).astype(np.float32)
    reach = np.float32(TAIL_CLIP * math.sqrt(2.0) * acc.plan.difference_sigma)
    third, share = np.float32(1 / (6 * second**1.5)), np.float32(skewness / (2 * second))

    def influence(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
        u = np.clip(b - a - first, -reach, reach)
        v = np.clip(c - b - later, -reach, reach)
        k3 = (2 * u + v) * (v - u) * (u + 2 * v) * third
        return np.asarray(k3 - share * (u * u + u * v + v * v))

    # Variance of k3 of three normal values: 9 sigma^6; of two triples that share two of them the
    # covariance is 7/3, one 2/3 (Hoeffding's decomposition: 2/3, 1 and 4 of the orders 1 to 3)
    n = acc.frames - 2
    repeats = n / (1 + ((n - 1) * 14 + max(n - 2, 0) * 4) / 27 / n)
    sums = block_sums(acc.plan, influence, one, two, three)
    return mean_error(acc.plan, sums) / math.sqrt(repeats)


def _kurtosis_error(acc: Accumulated, reach: np.float32, m2: float, ratio: float) -> float:
    """Standard error of m4 / m2^2 of the differences cut to +-reach."""
    scale, twice = np.float32(1 / m2), np.float32(2 * ratio)

    def influence(rows: np.ndarray) -> np.ndarray:
        z2 = np.square(np.clip(rows, -reach, reach)) * scale
        return z2 * (z2 - twice)

    sums = [block_sums(acc.plan, influence, each) for each in acc.end_differences]
    return mean_error(acc.plan, *sums, repeats=acc.difference_repeats)


def power_means(law: Counted | np.ndarray) -> tuple[float, np.ndarray, int]:
    """Number of the sample, and means of z^0 ... z^8 of the standardised sample; (sd, means, n)."""
    from dnanalyze.analyzers.kernels import pixel_loops

    if isinstance(law, Counted):
        x, w = law.centres, law.counts / law.total
        d = x - float(w @ x)
        sd = math.sqrt(float(w @ (d * d)))
        if sd == 0:
            return 0.0, np.zeros(9), law.total
        z = d / sd
        return sd, np.array([float(w @ z**k) for k in range(9)]), law.total
    flat = law.ravel()
    mean = float(flat.mean(dtype=np.float64))
    raw = np.array([flat.size, *pixel_loops.power_sums(flat, mean)]) / flat.size
    sd = math.sqrt(raw[2])
    if sd == 0:
        return 0.0, np.zeros(9), flat.size
    return sd, raw / sd ** np.arange(9), flat.size


def _shape(
    what: str, errors: QuantileErrors, moments: tuple[float, np.ndarray, int], out: FamilyResult
) -> None:
    """Skewness and kurtosis, plain and from quantiles, for information."""
    sd, m, _ = moments
    if sd > 0:
        n = errors.plan.pixels  # frames share their pixels
        skew = m[3]
        influence = np.array([1.5 * skew - skew, -3.0, -1.5 * skew, 1.0])
        out.values[f"{what}_skewness"] = Value(float(skew), _polynomial_error(influence, m, n))
        influence = np.array([2 * m[4] - m[4], -4 * skew, -2 * m[4], 0.0, 1.0])
        out.values[f"{what}_kurtosis"] = Value(float(m[4] - 3), _polynomial_error(influence, m, n))
    q = dict(zip(PROBABILITIES.tolist(), errors.values.tolist(), strict=True))
    wide, inner = q[0.99] - q[0.01], q[0.75] - q[0.25]
    if wide <= 0 or inner <= 0:
        return
    lean = (q[0.99] + q[0.01] - 2 * q[0.5]) / wide
    tails = wide / inner / NORMAL_RATIO
    gradient = np.zeros((PROBABILITIES.size, 2))
    index = {p: k for k, p in enumerate(PROBABILITIES.tolist())}
    gradient[index[0.99], 0], gradient[index[0.01], 0] = (1 - lean) / wide, (1 + lean) / wide
    gradient[index[0.5], 0] = -2 / wide
    gradient[index[0.99], 1], gradient[index[0.01], 1] = tails / wide, -tails / wide
    gradient[index[0.75], 1], gradient[index[0.25], 1] = -tails / inner, tails / inner
    se = np.maximum(errors.of(gradient), 1e-6)
    out.values[f"{what}_robust_skewness"] = Value(lean, float(se[0]))
    out.values[f"{what}_robust_kurtosis"] = Value(tails, float(se[1]))


def _polynomial_error(influence: np.ndarray, moments: np.ndarray, n: int) -> float:
    """Standard error of the mean of a polynomial in z, from the moments of z."""
    square = np.convolve(influence, influence)
    return math.sqrt(max(float(square @ moments[: square.size]), 1e-12) / n)


def _lognormal(errors: QuantileErrors, out: FamilyResult) -> None:
    """Three-parameter log-normal through the quantiles at .05, .5 and .95."""
    at = [2, MEDIAN, 8]
    names = ("lognormal_mu", "lognormal_delta", "lognormal_shift")
    q = errors.values[at]
    fit = lognormal_through(q)
    if fit is None:
        out.missing.update(dict.fromkeys(names, "the DSNU is not skewed to the right"))
        return
    gradient = np.zeros((PROBABILITIES.size, 3))
    for k in range(3):
        step = 1e-4 * (q[2] - q[0])
        up = lognormal_through(q + step * np.eye(3)[k])
        gradient[at[k]] = 0.0 if up is None else (np.array(up) - fit) / step
    se = np.maximum(errors.of(gradient), 1e-9)
    for k, name in enumerate(names):
        out.values[name] = Value(fit[k], float(se[k]))


def lognormal_through(q: np.ndarray) -> tuple[float, float, float] | None:
    """Parameters (mu, delta, shift) of the log-normal with these .05, .5 and .95 quantiles, DN."""
    left, right = q[1] - q[0], q[2] - q[1]
    if left <= 0 or right <= left * (1 + 1e-6):
        return None
    delta = math.log(right / left) / 1.6448536
    scale = right / math.expm1(1.6448536 * delta)
    return math.log(scale), delta, float(q[1] - scale)


def histogram(ordered: Ordered, sigma: float) -> tuple[np.ndarray, np.ndarray]:
    """Bin centres, DN, and counts, from the lowest value to the highest, finer in the core.

    Bins are equal up to 12 sigma from the median and grow by a constant factor beyond.
    """
    middle, step = float(ordered.quantile(0.5)), ordered.step
    width = 24 * sigma / CURVE_BINS
    if step:
        width = step * max(1, round(width / step))
    half = int(12 * sigma / width) + 1
    edges = middle + width * (np.arange(-half, half + 1) + 0.5)
    low, high = float(ordered.sorted[0]), float(ordered.sorted[-1])
    grown = edges[-1] - middle
    above = middle + grown * 1.1 ** np.arange(1, 2 + max(0, _powers(high - middle, grown)))
    below = middle - grown * 1.1 ** np.arange(1, 2 + max(0, _powers(middle - low, grown)))
    edges = np.concatenate([below[::-1], edges, above])
    counts = np.diff(np.searchsorted(ordered.sorted, edges))
    return (edges[1:] + edges[:-1]) / 2, counts


def _powers(distance: float, start: float) -> int:
    return math.ceil(math.log(distance / start) / math.log(1.1)) if distance > start else 0


def peaks(counts: np.ndarray) -> int:
    """Maxima of a histogram that stand 5 standard errors above the valley to the next one."""
    from scipy.ndimage import gaussian_filter1d

    smooth = 2 * np.sqrt(gaussian_filter1d(counts.astype(float), 3.0))
    return summits(smooth, 5.0 / math.sqrt(2 * 3.0 * math.sqrt(math.pi)))


def summits(curve: np.ndarray, prominence: float) -> int:
    """Maxima of at least this topographic prominence in a curve >= 0 that is 0 beyond its ends."""
    peaks_seen, climbing, turn = 0, False, 0.0
    for height in (*curve.tolist(), 0.0):
        turn = max(turn, height) if climbing else min(turn, height)
        if abs(height - turn) >= prominence:
            peaks_seen += climbing
            climbing, turn = not climbing, height
    return peaks_seen
