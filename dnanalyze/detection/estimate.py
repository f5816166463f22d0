"""What the filter seems to be, and the model effect that mimics it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from dnanalyze.detection.evidence import ViewEvidence
from dnanalyze.detection.replaced import RULES
from dnanalyze.detection.results import FilterEstimate, TailBound
from dnanalyze.detection.verdict import CAUSES, Answer


def estimate(kind: str, flags: list[Answer], evidence: list[ViewEvidence]) -> FilterEstimate:
    """From the answers that speak for the kind (at least one)."""
    view = _view(flags)
    at = [a.asked.evidence.point.temperature_c for a in flags]
    known = [t for t in at if t is not None]
    coldest = min(known) if known else None
    if kind == "dpc":
        return _correction(flags, view, coldest, evidence)
    if kind == "temporal_denoise":
        memory = float(np.median([a.asked.at for a in flags]))
        return FilterEstimate("recursive", view, strength=memory, from_temperature_c=coldest)
    return _denoise(flags, view, coldest)


def _view(flags: list[Answer]) -> str:
    """Where it is stronger: in the frame, or within the colours."""
    score = {"frame": 0.0, "planes": 0.0}
    for a in flags:
        e = a.asked
        score[e.evidence.view] += min(e.effect / e.limit, 50.0) if np.isfinite(e.limit) else 0.0
    return max(score, key=lambda v: score[v])


def _correction(
    flags: list[Answer], view: str, coldest: float | None, evidence: list[ViewEvidence]
) -> FilterEstimate:
    mine = [a for a in flags if a.asked.evidence.view == view and a.asked.test in CAUSES] or flags
    tests = {t: [a.asked for a in mine if a.asked.test == t] for t in CAUSES}
    capped = tests["cap_to_neighbours"]
    dynamic, ratio = tests["dynamic_threshold"], tests["ratio_rule"]
    found = [e.replaced for e in evidence if e.view == view and e.replaced is not None]
    rule, ppm = None, None
    if tests["static_replacement"]:
        rule = RULES[int(np.bincount([int(a.at) for a in tests["static_replacement"]]).argmax())]
        ppm = float(np.median([1e6 * r.own[RULES.index(rule)] / max(r.tried, 1) for r in found]))
    base = FilterEstimate(
        "static", view, replacement=rule, site_ppm=ppm, from_temperature_c=coldest
    )
    if capped:
        neighbours = int(min(a.at for a in capped))
        return replace(base, subkind="clamp", threshold_dn=0.0, neighbours=neighbours)
    if dynamic and (not ratio or _steadier(dynamic, ratio)):
        units = [a.evidence.noise for a in dynamic]
        bounds = np.array([a.at for a in dynamic])
        return replace(
            base, subkind="dynamic", threshold_dn=float(np.median(bounds)),
            threshold_sigma=float(np.median(bounds / units)), neighbours=8,
        )  # fmt: skip
    if ratio:
        factor = float(np.median([a.at for a in ratio]))
        return replace(base, subkind="ratio", ratio=factor, neighbours=8)
    if tests["static_replacement"] and _grows(found, rule):
        level, noise = _highest(mine)
        return replace(
            base, subkind="dynamic", threshold_dn=level, threshold_sigma=level / noise, neighbours=8
        )
    return base


def _highest(flags: list[Answer]) -> tuple[float, float]:
    """Where pixels end to stand out of their neighbours (DN), in the least of the settings, and
    its noise.
    """
    ends = []
    for e in {id(a.asked.evidence): a.asked.evidence for a in flags}.values():
        empty = np.flatnonzero(e.top8.own < 0.5 * e.top8.frames)
        k = int(empty[0]) if empty.size else e.top8.bounds.size - 1
        ends.append((max(float(e.top8.bounds[k]), e.step), e.noise))
    return min(ends)


def _steadier(dynamic: list[Any], ratio: list[Any]) -> bool:
    """A rule by difference explains what is flagged at more settings, or as surely as a ratio."""
    return (len(dynamic), -sum(np.log(a.p + 1e-300) for a in dynamic)) >= (
        len(ratio), -sum(np.log(a.p + 1e-300) for a in ratio),
    )  # fmt: skip


def _grows(found: list[Any], rule: str | None) -> bool:
    """Replaced sites differ between settings beyond chance: a list would not."""
    if rule is None or len(found) < 2:
        return False
    counts = np.array([f.own[RULES.index(rule)] for f in found], float)
    low, high = counts.min(), counts.max()
    return bool(high > 2 * low + 10)


def _denoise(flags: list[Answer], view: str, coldest: float | None) -> FilterEstimate:
    mine = [a for a in flags if a.asked.evidence.view == view] or flags
    tests = {a.asked.test for a in mine}
    e = max((a.asked.evidence for a in mine), key=lambda e: -e.correlation.variance)
    removed = float(-np.expm1(e.spectrum.suppression[0]))
    lag = e.correlation
    side = (lag.along_rows[0] + lag.along_columns[0]) / 2
    far = (lag.along_rows[1] + lag.along_columns[1]) / 2
    if tests == {"row_phase"}:
        subkind = "some_rows"
        removed = float(np.median([a.asked.effect for a in mine]))
    elif "median_equality" in tests:
        subkind = "median"
    elif tests & {"local_variance", "wavelet_kurtosis"} or far > 0.3 * abs(side):
        subkind = "edge_preserving"
    elif lag.diagonal < 0.5 * side:
        subkind = "gaussian"
    else:
        subkind = "median"
    return FilterEstimate(subkind, view, strength=removed, from_temperature_c=coldest)


def effect_of(kind: str, found: FilterEstimate, evidence: list[ViewEvidence]) -> dict[str, Any]:
    """The model effect and parameters that mimic the filter, as plain values."""
    spacing = 2 if found.view == "planes" else 1
    if kind == "temporal_denoise":
        return {"temporal_denoise": {"share": round(min(found.strength or 0.0, 0.7), 3)}}
    if kind == "denoise":
        kinds = {"gaussian": "gaussian", "median": "median"}
        model_kind = kinds.get(found.subkind, "bilateral")
        strength = float(np.clip(found.strength or 0.5, 0.05, 1.0))
        plain: dict[str, Any] = {
            "kind": model_kind,
            "strength": round(strength, 3),
            "spacing": spacing,
        }
        if model_kind == "bilateral":
            plain["range"] = round(3 * min(e.noise for e in evidence), 3)
        return {"denoise": plain}
    plain = {"spacing": spacing}
    replacement = "mean" if (found.replacement or "").startswith("mean") else "median"
    if found.subkind == "clamp":
        plain |= {"kind": "clamp", "threshold": 0.01, "neighbours": found.neighbours or 8}
    elif found.subkind == "ratio":
        plain |= {
            "kind": "ratio", "factor": round(found.ratio or 2.0, 3), "threshold": 0.01,
            "neighbours": found.neighbours or 8, "replacement": replacement,
        }  # fmt: skip
    elif found.subkind == "static":
        plain |= {
            "kind": "static",
            "fraction": float(np.clip((found.site_ppm or 500) * 1e-6, 1e-6, 0.05)),
            "replacement": replacement,
        }  # fmt: skip
    else:
        threshold = found.threshold_dn or 4 * float(np.median([e.noise for e in evidence]))
        plain |= {"kind": "median", "threshold": round(threshold, 3), "replacement": replacement}
    return {"dpc": plain}


def tail_bounds(found: FilterEstimate, evidence: list[ViewEvidence]) -> tuple[TailBound, ...]:
    """Pixels that stood out by more than the threshold before the correction, in parts per million.

    Lower: those still seen. Upper: with every site that was replaced, each of which may have been
    hot.
    """
    bounds = []
    for e in evidence:
        if e.view != found.view or e.replaced is None or not e.replaced.tried:
            continue
        level = found.threshold_dn or 4 * e.noise
        k = min(int(np.searchsorted(e.top8.bounds, level)), e.top8.bounds.size - 1)
        seen = 1e6 * e.top8.own[k] / (e.top8.frames * e.replaced.tried)
        surplus = np.maximum(e.replaced.own - e.replaced.control, 0)
        sites = float(surplus.max())
        upper = seen + 1e6 * (sites + 2 * np.sqrt(sites + 1)) / e.replaced.tried
        bounds.append(TailBound(e.point.temperature_c, float(level), seen, seen, upper))
    return tuple(bounds)
