"""Hidden effects on codes: the converter's widths, gains and clips, and the filters' settings."""

from __future__ import annotations

from typing import Any

import numpy as np

from dnanalyze.demo import filters
from dnanalyze.demo.hidden import HiddenEffect, Moment, Scene, Step
from dnanalyze.demo.sensor import WHITE_DN, VirtualSensor

Generator = np.random.Generator
Plain = dict[str, Any]


def _codes_draw(sensor: VirtualSensor, amount: float, rng: Generator) -> Plain:
    return {"shift": amount, "period": int(2 ** rng.integers(2, 5))}


def _missing_codes(scene: Scene, rng: Generator, shift: float, period: int) -> Step:
    """Width 1 - d of every ``period``-th code and 1 + d of the code below it (a mismatched bit)."""
    upper = np.arange(1, WHITE_DN + 1)
    edges = upper - 0.5 + shift * (upper % period == 0)

    def apply(dn: np.ndarray, now: Moment) -> np.ndarray:
        return np.searchsorted(edges, dn, side="right").astype(float)

    return Step("converter", apply)


def _gain_draw(sensor: VirtualSensor, amount: float, rng: Generator) -> Plain:
    return {"gain": float(amount if rng.random() < 0.7 else 1.0 / amount)}


def _digital_gain(scene: Scene, rng: Generator, gain: float) -> Step:
    """round((in - b) s + b): gaps for s > 1, double codes for s < 1."""
    b = scene.sensor.pedestal_dn
    return Step("codes", lambda y, now: np.rint((y - b) * gain + b))


def _clip_draw(sensor: VirtualSensor, amount: float, rng: Generator) -> Plain:
    spread = np.hypot(sensor.noise_e, sensor.pixel_offset_e) * sensor.gain_dn_e
    return {"black_dn": float(np.rint(sensor.pedestal_dn - amount * spread))}


def _black_clipping(scene: Scene, rng: Generator, black_dn: float) -> Step:
    """max(y, b0)."""
    return Step("codes", lambda y, now: np.maximum(y, black_dn))


def _dpc_draw(sensor: VirtualSensor, amount: float, rng: Generator) -> Plain:
    threshold = max(3.0 * sensor.noise_e, amount * sensor.spread_e(sensor.hottest_c))
    return {
        "mode": str(rng.choice(["median", "clamp", "ratio", "static"])),
        "threshold_dn": float(threshold * sensor.gain_dn_e),
        "ratio": float(1.5 + amount),
        "fraction": float(2e-3 / amount),
    }


def _dpc(
    scene: Scene,
    rng: Generator,
    mode: str,
    threshold_dn: float,
    ratio: float = 2.0,
    fraction: float = 1e-3,
) -> Step:
    """Defective pixels corrected on the fly, or from the list of a hot calibration."""
    sensor = scene.sensor

    def apply(y: np.ndarray, now: Moment) -> np.ndarray:
        if mode == "median":
            return filters.replace_above_neighbours(y, threshold_dn)
        if mode == "clamp":
            return filters.cap_to_neighbours(y, threshold_dn)
        if mode == "ratio":
            return filters.replace_by_ratio(y, sensor.pedestal_dn, ratio, 2.0 * sensor.noise_dn)
        if "sites" not in now.memory:
            now.memory["sites"] = now.hottest > np.quantile(now.hottest, 1.0 - fraction)
        return filters.replace_listed(y, now.memory["sites"])

    return Step("codes", apply)


def _denoise_draw(sensor: VirtualSensor, amount: float, rng: Generator) -> Plain:
    return {
        "kind": str(rng.choice(list(filters.DENOISERS))),
        "range_dn": amount * sensor.noise_dn,
        "sigma_px": 0.25 + 0.2 * amount,
        "mix": min(1.0, amount / 3.0),
    }


def _denoise(
    scene: Scene,
    rng: Generator,
    kind: str,
    range_dn: float = 0.0,
    sigma_px: float = 1.0,
    mix: float = 1.0,
) -> Step:
    """One of `filters.DENOISERS`; each kind uses the setting that is its own."""
    smooth = filters.DENOISERS[kind]
    setting = {"gaussian": sigma_px, "median": mix}.get(kind, range_dn)
    return Step("codes", lambda y, now: np.rint(smooth(y, setting)))


def _temporal_draw(sensor: VirtualSensor, amount: float, rng: Generator) -> Plain:
    return {"past": amount}


def _temporal_denoise(scene: Scene, rng: Generator, past: float) -> Step:
    """y_n = (1 - a) x_n + a y_(n-1), kept unrounded from frame to frame."""

    def apply(y: np.ndarray, now: Moment) -> np.ndarray:
        before = now.memory.get("out", y)
        now.memory["out"] = (1.0 - past) * y + past * before
        return np.rint(now.memory["out"])

    return Step("codes", apply, warm_up=12)


DIGITAL = (
    HiddenEffect("missing_codes", (0.3, 0.6, 1.0), "DN by which an edge is shifted; 1 drops "
                 "the code",
                 _codes_draw, _missing_codes),
    HiddenEffect("digital_gain", (1.06, 1.25, 1.7), "gain, or one over it",
                 _gain_draw, _digital_gain),
    HiddenEffect("black_clipping", (2.2, 1.2, 0.3), "noise from the clip to the pedestal",
                 _clip_draw, _black_clipping),
    HiddenEffect("dpc", (1.5, 0.6, 0.2), "threshold over the spread of a hot frame (at least "
                 "3 times the noise); ratio 1.5 more; listed fraction .002 over it",
                 _dpc_draw, _dpc),
    HiddenEffect("denoise", (0.7, 1.5, 3.0), "range over the noise (bilateral, nlm, wavelet); "
                 "blur .25 + .2 times it (gaussian, pixels); share, a third of it (median)",
                 _denoise_draw, _denoise),
    HiddenEffect("temporal_denoise", (0.15, 0.4, 0.7), "weight of the past",
                 _temporal_draw, _temporal_denoise),
)  # fmt: skip
