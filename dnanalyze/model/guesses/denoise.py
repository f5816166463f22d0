"""First guesses of denoise: its parameters as the statistics suggest them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from dnanalyze.model.bounds import bounded
from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.denoise import (
    PLAIN,
    WIDE,
    Denoise,
    kernel_line,
    noise_unfiltered,
)
from dnanalyze.model.guesses.evidence import quietest, shows, typical
from dnanalyze.model.white_codes import left_of, likeness, reached

_RANGES = 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 5.0, 8.0  # over the noise left
_BY_SIZE: tuple[dict[str, Any], ...] = (
    {"kind": "bilateral", "space": 1.5}, {"kind": "wavelet"}, {"kind": "nlm"},
    {"kind": "nlm", "patch": 2, "window": 7}, {"kind": "bilateral", "space": 0.8}, {"kind": "db2"},
    {"kind": "nlm", "patch": 4, "window": 13},
)  # fmt: skip


def guess(effect: type[Denoise], clues: Clues) -> list[Effect]:
    """Each kind, scaled to the noise; spacing 2 where pixels two apart are the more alike."""
    high = ("temporal_psd_0.35_0.5", "temporal_psd_0.5_0.71", "pattern_psd_0.5_0.71")
    near_by = ("temporal_corr_10", "temporal_corr_01", "temporal_corr_20", "temporal_corr_02")
    signs = (
        shows(clues, (*high, "temporal_pmax8", "frame_pmax8"), -1)
        or shows(clues, (*near_by, "local_variance_cv", "hh_kurtosis"))
    )  # fmt: skip
    if not signs:
        return []
    corr = {k: clues.measured(f"temporal_corr_{k}") for k in ("10", "20")}
    near, far = (typical(corr[k]) for k in ("10", "20"))
    spacing = 2 if far > max(near, 0.0) + 0.02 else 1
    lag1 = max(near, far, 0.01)
    # what goes by the size of noise may see all of it where that is least, and none elsewhere
    noise, place = _least(clues)
    alike = max(float(np.nan_to_num(corr[f"{spacing}0"][place])), 0.01)
    wide = _space(alike)
    wide_range = bounded(effect, "range", 1.5 * WIDE * noise / np.sum(kernel_line(wide) ** 2))
    sized = [_with_range(effect(**shape), noise, alike, spacing) for shape in _BY_SIZE]
    # like patches lie anywhere: a mean of many leaves neighbours no more alike than one of few
    wider = [replace(s, range=bounded(effect, "range", 2.0 * s.range)) for s in sized]
    return [
        *sized,
        *(e for e in wider if e.kind == "nlm"),
        effect(1.0, wide_range, wide, "bilateral", spacing),
        effect(min(1.0, 2.0 * lag1), kind="median", spacing=spacing),
        # codes mixed are rounded to codes: what is left of few changes by steps that stop a fit
        *(effect(share, kind="median", spacing=spacing) for share in (*PLAIN, 1.0)),
        effect(space=_space(lag1), kind="gaussian", spacing=spacing),
    ]


def _with_range(shape: Denoise, noise: float, alike: float, spacing: int) -> Denoise:
    """The range with which neighbours of white noise are so much ``alike`` where ``noise`` is left.

    Found on a field of codes: what is left of few codes follows no formula.
    """

    def lag1(range_dn: float) -> float:
        tried = replace(shape, range=range_dn)
        return likeness(left_of(tried.filtered, noise_unfiltered(tried, noise)))

    tried = [bounded(Denoise, "range", noise * r) for r in _RANGES]
    return replace(shape, range=reached(alike, lag1, tried), spacing=spacing)


def _space(lag1: float) -> float:
    """Sigma of the kernel after which neighbours of white noise have this correlation."""
    tried = np.linspace(0.2, 2.0, 181)
    lines = [kernel_line(float(s)) for s in tried]
    correlations = [float(np.sum(x[1:] * x[:-1]) / np.sum(x * x)) for x in lines]
    return float(np.interp(lag1, correlations, tried))


def _least(clues: Clues) -> tuple[float, int]:
    """Temporal noise of the quietest setting that tells it, DN, and which that is."""
    measured = clues.measured("temporal_noise")
    place = quietest(measured)
    noise = measured[place] if measured[place] > 0 else 1.0
    return min(max(float(noise), 0.02), 5e3), place
