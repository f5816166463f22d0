"""Gain and activation energy of real captures by NumPy alone, beside those of a refined model.

    python benchmarks/independent_checks.py FOLDER=MODEL.yaml ...

**Photon transfer.** Two frames of one operating point, each less its median: pixels are sorted by
their mean into one bin about 0 and bins of equal ratio above it, so that hot pixels give the range.
The variance of a bin is that of the difference of the two frames, over 2; what lies beyond 5 robust
standard deviations is left out. The gain is the slope of the variance over the mean, weighted by
its error.

**Arrhenius.** Median of the frames less the median of the shortest exposure at that temperature, of
the longest exposure; least squares of its logarithm over 1 / kT. The model's is that of the medians
of its own frames, evaluated in the same way.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

import dnanalyze
from dnanalyze.loaders.captures import CaptureSet
from dnanalyze.thermal import BOLTZMANN_EV, KELVIN

BINS, LEAST = 40, 60  # bins at most, pixels of one at the least
THERMOMETER_C = 0.2  # standard error of a temperature


def pair(captures: CaptureSet) -> tuple[np.ndarray, np.ndarray] | None:
    """Two frames of the operating point with the largest dark signal that has two."""
    several = [s for s in captures.settings if len(s.frames) > 1]
    if not several:
        return None
    warmest = max(several, key=lambda s: (s.point.temperature_c or 0.0, s.point.exposure_s or 0.0))
    first, second = (np.asarray(f.read(), float) for f in warmest.frames[:2])
    return first - np.median(first), second - np.median(second)


def photon_transfer(first: np.ndarray, second: np.ndarray) -> tuple[float, float]:
    """Slope of the variance over the mean, DN/e-, with its standard error."""
    mean, difference = ((first + second) / 2).ravel(), (first - second).ravel()
    top = np.quantile(mean, 1.0 - LEAST / mean.size)
    sigma = (np.quantile(mean, 0.5) - np.quantile(mean, 0.16)) or 1.0
    edges = np.geomspace(2.0 * sigma, max(top, 4.0 * sigma), BINS)
    x, v, se = [], [], []
    for low, high in zip(np.concatenate([[-sigma], edges[:-1]]), edges, strict=True):
        inside = (mean > low) & (mean <= high)
        count = int(inside.sum())
        if count < LEAST:
            continue
        d = difference[inside]
        d -= np.median(d)
        robust = max(1.4826 * float(np.median(np.abs(d))), 1.0)  # frames are of whole numbers
        variance = float(np.var(d[np.abs(d) < 5.0 * robust])) / 2.0
        if variance == 0.0:  # clipped
            continue
        x.append(float(np.median(mean[inside])))
        v.append(variance)
        se.append(variance * np.sqrt(2.0 / count))
    if len(x) < 3:
        return np.nan, np.nan
    weight = 1.0 / np.asarray(se)
    design = np.column_stack([np.ones(len(x)), x]) * weight[:, None]
    numbers, *_ = np.linalg.lstsq(design, np.asarray(v) * weight, rcond=None)
    misfit = np.sum((design @ numbers - np.asarray(v) * weight) ** 2) / (len(x) - 2)
    error = np.sqrt(np.linalg.inv(design.T @ design)[1, 1] * max(1.0, misfit))
    return float(numbers[1]), float(error)


def arrhenius(captures: CaptureSet) -> tuple[float, float, list[tuple[float, float]]]:
    """Energy in eV with its standard error, and the dark signals, (C, DN)."""
    level: dict[tuple[float, float], float] = {}
    for s in captures.settings:
        if s.point.temperature_c is not None and s.point.exposure_s is not None:
            key = (round(s.point.temperature_c, 1), s.point.exposure_s)
            level[key] = float(np.mean([np.median(np.asarray(f.read())) for f in s.frames]))
    if not level:
        return np.nan, np.nan, []
    longest, shortest = max(t for _, t in level), min(t for _, t in level)
    zero = sorted((c, v) for (c, t), v in level.items() if t == shortest)
    signals = [
        (c, v - float(np.interp(c, *np.transpose(zero))))
        for (c, t), v in sorted(level.items())
        if t == longest > shortest
    ]
    signals = [(c, v) for c, v in signals if v > 0.0]
    if len(signals) < 2:
        return np.nan, np.nan, signals
    celsius, dark = np.transpose(signals)
    u = -1.0 / (BOLTZMANN_EV * (celsius + KELVIN))
    slope = float(np.polyfit(u, np.log(dark), 1)[0])
    reach = np.ptp(celsius)
    return slope, slope * np.sqrt(2.0) * THERMOMETER_C / reach, signals


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("pairs", nargs="+", metavar="FOLDER=MODEL")
    options = parser.parse_args()
    print("| captures | gain, DN/e- | of the model | energy, eV | of the model |")
    print("|---|---|---|---|---|")
    for text in options.pairs:
        folder, _, file = text.partition("=")
        captures, model = dnanalyze.load(folder), dnanalyze.load_model(file)
        two = pair(captures)
        gain, gain_se = photon_transfer(*two) if two else (np.nan, np.nan)
        energy, energy_se, seen = arrhenius(captures)
        settings = [(s.point, len(s.frames)) for s in captures.settings]
        drawn = dnanalyze.simulate(model, captures.sensor.shape, settings)
        own, _, simulated = arrhenius(drawn)
        shot = model.get("dark_shot_noise")
        k = shot.value("dn_per_e", model.reference) if shot is not None else np.nan
        print(
            f"| {Path(folder).name} | {gain:.3g} +- {gain_se:.2g} | {k:.3g} "
            f"| {energy:.3g} +- {energy_se:.2g} | {own:.3g} |"
        )
        of_model = dict(simulated)
        for celsius, dark in seen:
            there = of_model.get(celsius, np.nan)
            print(f"    {celsius:g} C: {dark:.4g} DN, model {there:.4g} DN")


if __name__ == "__main__":
    main()
