"""Initial models by the method of moments: white Gaussian, Wang 2025, baseline."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np
from scipy.optimize import nnls

from dnanalyze.fitting.moments import Moments, temperature_knots
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.loaders.thermometer import tells_slope
from dnanalyze.model.effects.quantization import ROUNDING_VARIANCE
from dnanalyze.model.laws import TableLaw, value_at
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import BASE, built_in

# Shot noise has this share of the temporal variance at least, for of none a fit sees no slope; but
# where there is hardly any charge no share makes a gain of more than that, DN/e-.
SEEN, FAINT = 0.02, 0.1
LEAST = 0.01  # DN^2, of a variance of the readout: an eighth of that of rounding


def _table(points: list[OperatingPoint], values: np.ndarray) -> TableLaw:
    return TableLaw(tuple(points), tuple(float(v) for v in values))


def gaussian_model(m: Moments) -> NoiseModel:
    """White Gaussian noise of the measured mean and standard deviation, new in every frame."""
    read = built_in()["read_noise"]
    noise = read(sigma=_table(m.points, np.sqrt(m.total)))  # type: ignore[call-arg]
    return NoiseModel((noise,), _table(m.points, m.pedestal + m.signal), m.reference)


def paper_models(m: Moments) -> list[NoiseModel]:
    """The Wang 2025 model by moments, every parameter a table over the operating points.

    Several, for pedestals farther and farther below the signal: the farther, the nearer the seed is
    to a Gaussian. The series may not pin the pedestal, and then the shape has to.
    """
    sd = float(np.sqrt(np.min(m.total)))
    return [
        _paper(replace(m, pedestal=m.pedestal - shift, signal=m.signal + shift))
        for shift in (0.0, sd, 5.0 * sd, 30.0 * sd)
    ]


def _paper(m: Moments) -> NoiseModel:
    spread = np.sqrt(np.log1p(np.minimum(m.pattern / m.signal**2, np.exp(6.0))))
    spread = np.maximum(spread, 0.02)
    square = m.signal**2 * np.exp(spread**2)
    sigma = np.sqrt(np.maximum(m.temporal, 1e-6) / (9.0 * square))
    base = built_in()[BASE](  # type: ignore[call-arg]
        mu=_table(m.points, _mu(m.signal, spread)),
        delta=_table(m.points, spread),
        phi=_table(m.points, np.full(len(m.points), 2e-3)),
        sigma=_table(m.points, np.clip(sigma, 1e-5, 1e5)),
        exposure="none",
    )
    return NoiseModel((base,), m.pedestal, m.reference)


def _mu(mean: np.ndarray, spread: np.ndarray | float) -> np.ndarray:
    """mu of log-normal seeds of these means, DN, within its bounds (e^12 DN)."""
    known = built_in()[BASE].parameters()["mu"]
    return np.clip(np.log(mean) - spread**2 / 2, known.lower, known.upper)


def baseline_by_moments(
    m: Moments,
    bits: int = 16,
    read: Mapping[str, Any] = MappingProxyType({}),
    gain: float | None = None,
) -> NoiseModel:
    """The log-normal seed with the four baseline effects, by moments.

    The seed's mean follows a table over temperature, its spread and kernel are constant; shot and
    read noise are slope and intercept of temporal variance over signal, pixel offsets what remains
    of the pattern where there is no signal. ``bits`` are the converter's; ``read`` is what else of
    read noise is measured; ``gain`` is that of photon transfer, DN/e-, where the frames tell it.
    """
    known = built_in()
    weight = 1.0 / np.maximum(m.total, 1e-6)
    black = m.pedestal if m.black is None else m.black
    above = m.pedestal + m.signal - [value_at(black, p) for p in m.points]
    m = replace(m, signal=np.maximum(above, 0.01 * np.sqrt(np.min(m.total)) + 1e-3))
    charge = m.gains * m.signal  # times K: the variance of its shot noise
    *floors, slope = _shares(m.temporal, weight, m.readout, charge)
    brightest = int(np.argmax(charge))
    slope = max(slope, min(SEEN * m.temporal[brightest] / charge[brightest], FAINT))
    if gain is not None:
        slope = gain
        floors = _shares(np.maximum(m.temporal - slope * charge, 0.0), weight, m.readout)
    *offsets, relative = _shares(m.pattern, weight, m.readout, m.signal**2)
    floors[-1] -= ROUNDING_VARIANCE
    read_sd, offset_sd = (_deviations(v) for v in (floors, offsets))
    delta = math.sqrt(math.log1p(min(max(relative, 1e-3), 50.0)))
    lit = [i for i, p in enumerate(m.points) if p.exposure_s is None or p.exposure_s > 0]
    reference = m.reference
    rate = m.signal / np.array([p.exposure_over(reference) or 1.0 for p in m.points])
    mu = _mu(np.maximum(rate, 1e-4), delta)
    rows = _by_temperature(m.points, mu, lit)
    base = known[BASE](mu=rows, delta=delta, phi=1e-3, sigma=1e-6)  # type: ignore[call-arg]
    effects = (
        base,
        known["dark_shot_noise"](dn_per_e=float(np.clip(slope, 1e-3, 50))),  # type: ignore[call-arg]
        known["read_noise"](**read_sd, **read),
        known["pixel_fpn"](**offset_sd),
        known["quantization"](bits=bits),  # type: ignore[call-arg]
    )
    return NoiseModel(effects, black, reference)


def _deviations(variances: Sequence[float]) -> dict[str, float]:
    """Standard deviations before the analog gain and after it; the fit sees none of 0."""
    names = ("sigma", "converter")
    return {n: math.sqrt(max(v, LEAST)) for n, v in zip(names, variances, strict=False)}


def _shares(values: np.ndarray, weight: np.ndarray, *terms: np.ndarray) -> list[float]:
    """Terms, none below 0, whose sum is nearest to the values."""
    design = np.column_stack(terms) * weight[:, None]
    return [float(v) for v in nnls(design, values * weight)[0]]


def _by_temperature(points: list[OperatingPoint], mu: np.ndarray, lit: list[int]) -> TableLaw:
    """One row a temperature (and gain, channel), from the longest exposure near it.

    Between rows the table is a straight line over 1/T, an activation energy of its own. Even where
    two currents with energies .6 eV apart mix, that is within 1 % over `NEAR_C`, so temperatures
    nearer than that to the next need no row: it would hang on the frames of one short exposure.
    Temperatures too near each other for a slope have rows where the longest exposure was taken.
    """
    rows: dict[OperatingPoint, tuple[tuple[float, float], float]] = {}
    for kind in dict.fromkeys((points[i].gain, points[i].channel) for i in lit):
        alike = [i for i in lit if (points[i].gain, points[i].channel) == kind]
        timed = [
            (t, points[i].exposure_s) for i in alike if (t := points[i].temperature_c) is not None
        ]
        if not tells_slope(t for t, _ in timed):
            longest = max((e or 0.0 for _, e in timed), default=0.0)
            timed = [(t, e) for t, e in timed if (e or 0.0) == longest]
        knots = temperature_knots([t for t, _ in timed])
        for i in alike:
            p = points[i]
            at, away = p.temperature_c, 0.0
            if at is not None:
                away, at = min((abs(t - at), t) for t in knots)
            key, worth = OperatingPoint(at, None, *kind), (p.exposure_s or 1.0, -away)
            if key not in rows or worth > rows[key][0]:
                rows[key] = worth, float(mu[i])
    if not rows:
        rows[OperatingPoint()] = (1.0, 0.0), float(np.median(mu))
    return TableLaw(tuple(rows), tuple(v for _, v in rows.values()))
