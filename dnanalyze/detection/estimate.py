"""What the filter seems to be, and the model effect that mimics it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from dnanalyze.detection.edge import coarse_line, tightest_line
from dnanalyze.detection.evidence import VIEWS, ViewEvidence
from dnanalyze.detection.excess import SLOPES, StandingOut
from dnanalyze.detection.replaced import RULES, Replaced
from dnanalyze.detection.results import FilterEstimate, Finding, TailBound
from dnanalyze.detection.tests import CAUSES
from dnanalyze.significance import NOTICEABLE

REPLACEMENTS = {"mean": "mean", "median": "midpoint", "fifth": "median"}  # of 8 values
FAR = 0.3  # of the correlation next door, from which that two pixels away is no slight blur's
DIAGONAL = 0.5  # of it, below which that along diagonals is a blur's and no median's


def estimate(kind: str, flags: Sequence[Finding], evidence: list[ViewEvidence]) -> FilterEstimate:
    """From the findings that speak for the kind (at least one)."""
    coldest = min(
        (f.evidence.point.temperature_c for f in flags
         if f.evidence.point.temperature_c is not None), default=None,
    )  # fmt: skip
    if kind == "denoise":
        found = _denoise(flags, evidence)
    elif kind == "dpc":
        found = _correction(flags, evidence)
    else:
        memory = float(np.median([f.at for f in flags]))
        found = FilterEstimate("recursive", _view(flags), strength=memory)
    return replace(found, from_temperature_c=coldest)


def _view(flags: Sequence[Finding]) -> str:
    """Where it is stronger: in the frame, or within the colours.

    Neighbours of one colour are among the 24 of the frame, so a cap to these caps some of those.
    """
    capped = [f for f in flags if f.test == "cap_to_neighbours"]
    score = {"frame": 0.0, "planes": 0.0}
    for f in capped or flags:
        score[f.view] += math.log(f.score)
    return max(score, key=lambda v: score[v])


def _correction(flags: Sequence[Finding], evidence: list[ViewEvidence]) -> FilterEstimate:
    view = _view(flags)
    mine = [f for f in flags if f.view == view and f.test in CAUSES] or flags
    static, capped, dynamic = (
        [f for f in mine if f.test == test]
        for test in ("static_replacement", "cap_to_neighbours", "dynamic_threshold")
    )
    cut = [f for f in mine if f.test in ("dynamic_threshold", "ratio_rule", "ratio_and_threshold")]
    seen = [e for e in evidence if e.view == view]
    rule, base = None, FilterEstimate("static", view)
    if static:
        rule = int(np.bincount([int(f.at) for f in static]).argmax())
        found = [f.sites for f in static if f.sites is not None]
        ppm = float(np.median([1e6 * s.own[rule] / max(s.tried, 1) for s in found]))
        base = replace(base, replacement=RULES[rule], site_ppm=ppm)
    if capped:
        neighbours = min(f.neighbours for f in capped)
        return replace(base, subkind="clamp", threshold_dn=0.0, neighbours=neighbours)
    of_24 = rule is not None and RULES[rule] == "mean of 24"
    neighbours = min((f.neighbours for f in cut), default=24 if of_24 else 8)
    tops = [e.above(neighbours) for e in seen]
    lines = [
        (line, e.noise, out)
        for e, out in zip(seen, tops, strict=True)
        if (line := coarse_line(out, e.noise)) is not None
    ]
    ringed = replace(base, neighbours=neighbours)
    if cut or 2 * len(lines) > len(seen):
        return _cut(ringed, lines, [(f.at, f.evidence.noise) for f in dynamic])
    if rule is not None and _grows([e.replaced for e in seen if e.replaced is not None], rule):
        bounds = [(max(_highest(out), e.step), e.noise) for e, out in zip(seen, tops, strict=True)]
        return _dynamic(ringed, bounds)
    return base


def _dynamic(base: FilterEstimate, bounds: list[tuple[float, float]]) -> FilterEstimate:
    """A threshold, the least of those seen, each with its noise: where warm, it may follow the
    fixed pattern.
    """
    if not bounds:
        return replace(base, subkind="dynamic")
    bound, noise = min(bounds)
    return replace(base, subkind="dynamic", threshold_dn=bound, threshold_sigma=bound / noise)


def _cut(
    base: FilterEstimate, lines: list[tuple[tuple[float, float], float, StandingOut]],
    thresholds: list[tuple[float, float]],
) -> FilterEstimate:  # fmt: skip
    """The line x = slope max + bound that (almost) nothing crosses, both above the base level."""
    slopes = [slope for (slope, _), _, _ in lines]
    slope = float(np.quantile(slopes, 0.5, method="lower")) if slopes else 1.0
    if slope <= 1:
        plain = [(bound, noise) for (slope, bound), noise, _ in lines if slope <= 1]
        return _dynamic(base, plain or thresholds)
    own = [(bound, out) for (a, bound), _, out in lines if a == slope]
    level = min(out.base for _, _, out in lines)
    k = SLOPES.index(slope)
    pairs = np.concatenate([out.pixels[:, :4] for _, out in own]) - np.float32(level)
    # a bound above one base is another above a lower one
    coarse = float(np.median([b - (slope - 1) * (out.base - level) for b, out in own]))
    slope, bound = tightest_line(
        pairs, SLOPES[max(0, k - 2)], SLOPES[min(k + 2, len(SLOPES) - 1)]
    ) or (slope, coarse)
    return replace(base, subkind="ratio", ratio=slope, threshold_dn=max(0.0, bound), level_dn=level)


def _highest(out: StandingOut) -> float:
    """Beyond what excess fewer than one pixel in two frames stands out, DN."""
    top = out.difference
    empty = np.flatnonzero(top.own < 0.5 * top.frames)
    return float(top.bounds[empty[0] if empty.size else -1])


def _grows(replaced: list[Replaced], rule: int) -> bool:
    """Replaced sites differ between settings beyond chance: a list would not."""
    counts = [int(f.own[rule]) for f in replaced]
    return len(counts) > 1 and max(counts) > 2 * min(counts) + 10


def _denoise(flags: Sequence[Finding], evidence: list[ViewEvidence]) -> FilterEstimate:
    """From the quietest flagged setting, in the view whose next neighbours share more noise."""
    tests = {f.test for f in flags}
    quietest = min((f.evidence for f in flags), key=lambda e: e.correlation.variance)
    if tests == {"row_phase"}:
        missing = float(np.median([f.effect_size for f in flags]))
        return FilterEstimate("some_rows", quietest.view, strength=missing)
    seen = [e for e in evidence if e.point == quietest.point]
    e = max(seen, key=lambda e: min(e.correlation.along_rows[0], e.correlation.along_columns[0]))
    lag = e.correlation
    # 1/f noise over the scan reaches far along rows: the direction that is free of it
    side, far, _ = min(lag.along_rows, lag.along_columns, key=lambda r: r[1])
    subkind = "median"
    if "median_equality" not in tests and far > FAR * abs(side):
        subkind = "edge_preserving"  # they reach farther than a 3x3 median or a slight blur
    elif "median_equality" not in tests and lag.diagonal < DIAGONAL * side:
        subkind = "gaussian"
    removed = float(-np.expm1(e.spectrum.suppression[0]))
    return FilterEstimate(subkind, e.view, strength=removed)


def effect_of(kind: str, estimated: FilterEstimate, evidence: list[ViewEvidence]) -> dict[str, Any]:
    """The model effect and parameters that mimic the filter, as plain values."""
    if kind == "temporal_denoise":
        return {kind: {"share": round(min(estimated.strength or 0.0, 0.7), 3)}}
    spacing = VIEWS[estimated.view]
    noise = [e.noise for e in evidence]
    if kind == "denoise":
        named = estimated.subkind if estimated.subkind in ("gaussian", "median") else "bilateral"
        strength = float(np.clip(estimated.strength or 0.5, 0.05, 1.0))
        plain: dict[str, Any] = {"kind": named, "strength": strength, "spacing": spacing}
        if named == "bilateral":
            plain["range"] = 3 * min(noise)
        return {kind: _rounded(plain)}
    replacement = REPLACEMENTS.get((estimated.replacement or "").split(" of")[0], "median")
    threshold = estimated.threshold_dn
    if estimated.subkind == "static":
        share = float(np.clip((estimated.site_ppm or 500) * 1e-6, 1e-6, 0.05))
        plain = {"kind": "static", "fraction": share, "replacement": replacement}
        return {kind: plain | {"spacing": spacing}}
    plain = {"spacing": spacing, "neighbours": estimated.neighbours or 8}
    if estimated.subkind == "clamp":
        return {kind: plain | {"kind": "clamp", "threshold": 0.01}}
    if estimated.subkind == "ratio":
        plain |= {
            "kind": "ratio",
            "factor": estimated.ratio,
            "threshold": max(threshold or 0.0, 0.01),
            "black": estimated.level_dn,
        }
    else:
        typical = NOTICEABLE * float(np.median(noise))
        plain |= {"kind": "excess", "threshold": threshold or typical}
    return {kind: _rounded(plain) | {"replacement": replacement}}


def _rounded(plain: dict[str, Any]) -> dict[str, Any]:
    return {k: round(v, 3) if isinstance(v, float) else v for k, v in plain.items()}


def tail_bounds(estimated: FilterEstimate, evidence: list[ViewEvidence]) -> tuple[TailBound, ...]:
    """Pixels that stood out by more than the threshold before the correction, in parts per million.

    Lower: those still seen. Upper: with every site that was replaced, each of which may have been
    hot.
    """
    bounds = []
    for e in evidence:
        if e.view != estimated.view or e.replaced is None or not e.replaced.tried:
            continue
        level = estimated.threshold_dn or NOTICEABLE * e.noise
        top = e.above8.difference
        k = min(int(np.searchsorted(top.bounds, level)), top.bounds.size - 1)
        seen = 1e6 * top.own[k] / (top.frames * e.replaced.tried)
        sites = float(np.maximum(e.replaced.own - e.replaced.control, 0).max())
        upper = seen + 1e6 * (sites + 2 * np.sqrt(sites + 1)) / e.replaced.tried
        bounds.append(TailBound(e.point.temperature_c, float(level), seen, seen, upper))
    return tuple(bounds)
