"""What the filter seems to be, and the model effect that mimics it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from dnanalyze.detection.edge import tightest_line
from dnanalyze.detection.evidence import ViewEvidence
from dnanalyze.detection.excess import SLOPES, Excess, StandingOut
from dnanalyze.detection.replaced import RULES
from dnanalyze.detection.results import FilterEstimate, TailBound
from dnanalyze.detection.tests import LEAST_SITES, FilterTest
from dnanalyze.detection.verdict import CAUSES, TestResult
from dnanalyze.significance import NOTICEABLE, SIGN

REPLACEMENTS = {"mean": "mean", "median": "midpoint", "fifth": "median"}  # of 8 values


def estimate(kind: str, flags: list[TestResult], evidence: list[ViewEvidence]) -> FilterEstimate:
    """From the answers that speak for the kind (at least one)."""
    at = [a.asked.evidence.point.temperature_c for a in flags]
    known = [t for t in at if t is not None]
    coldest = min(known) if known else None
    if kind == "denoise":
        return _denoise(flags, coldest, evidence)
    view = _view(flags)
    if kind == "dpc":
        return _correction(flags, view, coldest, evidence)
    memory = float(np.median([a.asked.at for a in flags]))
    return FilterEstimate("recursive", view, strength=memory, from_temperature_c=coldest)


def _view(flags: list[TestResult]) -> str:
    """Where it is stronger: in the frame, or within the colours.

    Neighbours of one colour are among the 24 of the frame, so a cap to these caps some of those.
    """
    capped = [a for a in flags if a.asked.test == "cap_to_neighbours"]
    score = {"frame": 0.0, "planes": 0.0}
    for a in capped or flags:
        e = a.asked
        score[e.evidence.view] += min(e.effect / e.limit, 50.0) if np.isfinite(e.limit) else 0.0
    return max(score, key=lambda v: score[v])


def _correction(
    flags: list[TestResult], view: str, coldest: float | None, evidence: list[ViewEvidence]
) -> FilterEstimate:
    mine = [a for a in flags if a.asked.evidence.view == view and a.asked.test in CAUSES] or flags
    tests = {t: [a.asked for a in mine if a.asked.test == t] for t in CAUSES}
    replaced = [e.replaced for e in evidence if e.view == view and e.replaced is not None]
    rule, ppm = None, None
    if tests["static_replacement"]:
        rule = RULES[int(np.bincount([int(a.at) for a in tests["static_replacement"]]).argmax())]
        seen_by = [a.sites for a in tests["static_replacement"] if a.sites is not None]
        ppm = float(np.median([1e6 * r.own[RULES.index(rule)] / max(r.tried, 1) for r in seen_by]))
    base = FilterEstimate(
        "static", view, replacement=rule, site_ppm=ppm, from_temperature_c=coldest
    )
    if tests["cap_to_neighbours"]:
        neighbours = min(a.neighbours for a in tests["cap_to_neighbours"])
        return replace(base, subkind="clamp", threshold_dn=0.0, neighbours=neighbours)
    cut = [a for t in ("dynamic_threshold", "ratio_rule", "ratio_and_threshold") for a in tests[t]]
    seen = [e for e in evidence if e.view == view]
    neighbours = min((a.neighbours for a in cut), default=24 if rule == "mean of 24" else 8)
    tops = [(e.noise, e.above8 if neighbours == 8 else e.above24) for e in seen]
    lines = [(_line(out, noise), noise, out) for noise, out in tops]
    known = [(line, noise, out) for line, noise, out in lines if line is not None]
    if cut or 2 * len(known) > len(seen):
        return _cut(replace(base, neighbours=neighbours), known, tests["dynamic_threshold"])
    if tests["static_replacement"] and _grows(replaced, rule):
        bound, noise = min((_highest(e, neighbours), e.noise) for e in seen)
        return replace(
            base, subkind="dynamic", threshold_dn=bound, threshold_sigma=bound / noise,
            neighbours=neighbours,
        )  # fmt: skip
    return base


def _cut(
    base: FilterEstimate, lines: list[tuple[tuple[float, float], float, StandingOut]],
    dynamic: list[FilterTest],
) -> FilterEstimate:  # fmt: skip
    """The line x = slope max + bound that (almost) nothing crosses, both above the base level."""
    slopes = [a for (a, _), _, _ in lines]
    slope = float(np.quantile(slopes, 0.5, method="lower")) if slopes else 1.0
    if slope <= 1:
        at = [(b, noise) for (a, b), noise, _ in lines if a <= 1]
        at = at or [(a.at, a.evidence.noise) for a in dynamic]
        if not at:
            return replace(base, subkind="dynamic")
        bound, noise = min(at)  # where warm, it may follow the fixed pattern
        return replace(
            base, subkind="dynamic", threshold_dn=float(bound), threshold_sigma=float(bound / noise)
        )
    own = [(b, out) for (a, b), _, out in lines if a == slope]
    level = min(out.base for _, _, out in lines)
    k = SLOPES.index(slope)
    pairs = np.concatenate([out.pairs for _, out in own]) - np.float32(level)
    # a bound above one base is another above a lower one
    coarse = float(np.median([b - (slope - 1) * (out.base - level) for b, out in own]))
    slope, bound = tightest_line(
        pairs, SLOPES[max(0, k - 2)], SLOPES[min(k + 2, len(SLOPES) - 1)]
    ) or (slope, coarse)
    return replace(base, subkind="ratio", ratio=slope, threshold_dn=max(0.0, bound), level_dn=level)


def _line(out: StandingOut, noise: float) -> tuple[float, float] | None:
    """Slope and bound of the rule (DN above the base); None where the tail ends nowhere abruptly.

    Below the rule's own slope the bound falls as fast as the hottest survivors' neighbours are
    hot; above it only as fast as neighbours rise above the base by noise.
    """
    bounds = np.array([_end(top, noise) for top in out.sloped])
    for k in range(len(SLOPES) - 1):
        if not np.isfinite(bounds[k]):
            continue
        step = SLOPES[k + 1] - SLOPES[k]
        ladder = 0.12 * bounds[k]  # its steps are of 10 %; no quiet neighbour rises by 4 sigma
        if not bounds[k] - bounds[k + 1] > NOTICEABLE * noise * step + ladder:
            return SLOPES[k], float(bounds[k])
    return None


def _end(top: Excess, noise: float) -> float:
    """The least bound, DN, beyond which (almost) nothing is left of a tail that is still there
    elsewhere; infinite: none.
    """
    ends = (top.own < 0.05 * top.control) & (top.control >= LEAST_SITES * top.frames)
    ends &= top.bounds >= SIGN * noise
    return float(top.bounds[ends][0]) if ends.any() else np.inf


def _highest(e: ViewEvidence, neighbours: int) -> float:
    """Beyond what excess fewer than one pixel in two frames stands out, DN."""
    top = (e.above8 if neighbours == 8 else e.above24).difference
    empty = np.flatnonzero(top.own < 0.5 * top.frames)
    return max(float(top.bounds[empty[0] if empty.size else -1]), e.step)


def _grows(replaced: list[Any], rule: str | None) -> bool:
    """Replaced sites differ between settings beyond chance: a list would not."""
    if rule is None or len(replaced) < 2:
        return False
    counts = np.array([f.own[RULES.index(rule)] for f in replaced], float)
    low, high = counts.min(), counts.max()
    return bool(high > 2 * low + 10)


def _denoise(
    flags: list[TestResult], coldest: float | None, evidence: list[ViewEvidence]
) -> FilterEstimate:
    """From the quietest flagged setting, in the view whose next neighbours share more noise."""
    tests = {a.asked.test for a in flags}
    quietest = min((a.asked.evidence for a in flags), key=lambda e: e.correlation.variance)
    seen = [e for e in evidence if e.point == quietest.point]
    if tests == {"row_phase"}:
        seen = [quietest]
    e = max(seen, key=lambda e: min(e.correlation.along_rows[0], e.correlation.along_columns[0]))
    removed = float(-np.expm1(e.spectrum.suppression[0]))
    lag = e.correlation
    # 1/f noise over the scan reaches far along rows: the direction that is free of it
    side, far, _ = min(lag.along_rows, lag.along_columns, key=lambda r: r[1])
    if tests == {"row_phase"}:
        subkind = "some_rows"
        removed = float(np.median([a.asked.effect for a in flags]))
    elif "median_equality" in tests:
        subkind = "median"
    elif far > 0.3 * abs(side):
        subkind = "edge_preserving"  # they reach farther than a 3x3 median or a slight blur
    elif lag.diagonal < 0.5 * side:
        subkind = "gaussian"
    else:
        subkind = "median"
    return FilterEstimate(subkind, e.view, strength=removed, from_temperature_c=coldest)


def effect_of(kind: str, estimated: FilterEstimate, evidence: list[ViewEvidence]) -> dict[str, Any]:
    """The model effect and parameters that mimic the filter, as plain values."""
    spacing = 2 if estimated.view == "planes" else 1
    if kind == "temporal_denoise":
        return {"temporal_denoise": {"share": round(min(estimated.strength or 0.0, 0.7), 3)}}
    if kind == "denoise":
        kinds = {"gaussian": "gaussian", "median": "median"}
        model_kind = kinds.get(estimated.subkind, "bilateral")
        strength = float(np.clip(estimated.strength or 0.5, 0.05, 1.0))
        plain: dict[str, Any] = {
            "kind": model_kind,
            "strength": round(strength, 3),
            "spacing": spacing,
        }
        if model_kind == "bilateral":
            plain["range"] = round(3 * min(e.noise for e in evidence), 3)
        return {"denoise": plain}
    plain = {"spacing": spacing}
    replacement = REPLACEMENTS.get((estimated.replacement or "").split(" of")[0], "median")
    if estimated.subkind == "clamp":
        plain |= {"kind": "clamp", "threshold": 0.01, "neighbours": estimated.neighbours or 8}
    elif estimated.subkind == "ratio":
        plain |= {
            "kind": "ratio", "factor": round(estimated.ratio or 2.0, 3),
            "threshold": round(max(estimated.threshold_dn or 0.0, 0.01), 3),
            "black": round(estimated.level_dn or 0.0, 3),
            "neighbours": estimated.neighbours or 8, "replacement": replacement,
        }  # fmt: skip
    elif estimated.subkind == "static":
        plain |= {
            "kind": "static",
            "fraction": float(np.clip((estimated.site_ppm or 500) * 1e-6, 1e-6, 0.05)),
            "replacement": replacement,
        }  # fmt: skip
    else:
        threshold = estimated.threshold_dn or 4 * float(np.median([e.noise for e in evidence]))
        plain |= {
            "kind": "excess", "threshold": round(threshold, 3),
            "neighbours": estimated.neighbours or 8, "replacement": replacement,
        }  # fmt: skip
    return {"dpc": plain}


def tail_bounds(estimated: FilterEstimate, evidence: list[ViewEvidence]) -> tuple[TailBound, ...]:
    """Pixels that stood out by more than the threshold before the correction, in parts per million.

    Lower: those still seen. Upper: with every site that was replaced, each of which may have been
    hot.
    """
    bounds = []
    for e in evidence:
        if e.view != estimated.view or e.replaced is None or not e.replaced.tried:
            continue
        level = estimated.threshold_dn or 4 * e.noise
        top = e.above8.difference
        k = min(int(np.searchsorted(top.bounds, level)), top.bounds.size - 1)
        seen = 1e6 * top.own[k] / (top.frames * e.replaced.tried)
        surplus = np.maximum(e.replaced.own - e.replaced.control, 0)
        sites = float(surplus.max())
        upper = seen + 1e6 * (sites + 2 * np.sqrt(sites + 1)) / e.replaced.tried
        bounds.append(TailBound(e.point.temperature_c, float(level), seen, seen, upper))
    return tuple(bounds)
