"""Does a fitted model measure the sensor? Gain, dark signal, energy, read noise against the truth.

    python benchmarks/measured_parameters.py --count 200 [--layout bias_and_dark] [--jobs 2]

Virtual sensors, which share no code with the model, with one or two hidden effects, of which one is
not in the model; captured as one exposure over temperature, as bias and dark frames over
temperature with a black level that drifts, or as bias and exposures at few temperatures. Each fit
begins with a system gain that is off by up to a factor of 30 on either side, where the frames
themselves do not give one.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from dnanalyze.analyzers.estimators.arrhenius import arrhenius_laws
from dnanalyze.demo import VirtualSensor, draw_sensor, generate
from dnanalyze.demo.sensor import arrhenius
from dnanalyze.diagnosis.refine import add_on
from dnanalyze.fitting.agreement import agreements
from dnanalyze.fitting.design import design
from dnanalyze.fitting.fit import baseline_model, uncertain
from dnanalyze.fitting.free_parameters import free_parameters, positions
from dnanalyze.fitting.from_part import converge, fitted
from dnanalyze.fitting.problem import fit_problem
from dnanalyze.loaders.captures import CaptureSet, Frame, Setting, Window
from dnanalyze.model.laws import value_at
from dnanalyze.thermal import KELVIN

SHAPE, FRAMES = (128, 128), 5
# Effects that leave the meaning of the four quantities alone. Charge that the virtual sensor states
# an exposure, whatever its length, is left out where there are several.
READOUT = (
    "column_fpn", "column_taps", "cosmic_rays", "dark_gradient", "flicker_fpn",
    "periodic_pattern", "row_fpn", "row_noise",
)  # fmt: skip
HIDDEN = (*READOUT, "amp_glow", "hot_pixels", "rts")
LAYOUTS = ("series", "bias_and_dark", "exposures")
DRIFT_DN = 10.0  # standard deviation of the black level between temperatures
FACTOR = 30.0
GAIN, ENERGY_EV, SIGNAL, NOISE = 0.15, 0.03, 0.03, 0.05


@dataclass(frozen=True)
class Found:
    """One quantity of one sensor."""

    quantity: str
    true: float
    model: float
    error: float = 0.0

    @property
    def within(self) -> bool:
        """Whether it is within what is asked, or 3 standard errors: those that the fit states."""
        off = abs(self.model - self.true)
        share = {"gain": GAIN, "dark signal": SIGNAL, "read noise": NOISE}.get(self.quantity)
        asked = ENERGY_EV if share is None else share * abs(self.true)
        return off <= max(asked, 3.0 * self.error)


def moved(captures: CaptureSet, offset: float) -> tuple[Setting, ...]:
    """Settings with another black level, whole codes."""

    def frame(own: Frame) -> Frame:
        def load(window: Window | None) -> np.ndarray:
            return (own.read(window) + np.uint16(round(offset))).astype(np.uint16)

        return replace(own, load=load)

    return tuple(replace(s, frames=tuple(map(frame, s.frames))) for s in captures.settings)


def captured(sensor: VirtualSensor, hidden: dict[str, str], layout: str, seed: int) -> CaptureSet:
    """The captures of a layout."""
    rng = np.random.default_rng([seed, 5])
    if layout == "series":
        return generate(sensor, hidden, SHAPE, frames=FRAMES, seed=seed)
    celsius = sensor.temperatures_c if layout == "bias_and_dark" else sensor.temperatures_c[-2:]
    exposures = (0.0, 1.0) if layout == "bias_and_dark" else (0.0, 0.3, 1.0)
    settings: list[Setting] = []
    for t in celsius:
        offset = 100.0 + DRIFT_DN * rng.standard_normal()
        for share in exposures:
            own = replace(sensor, exposure_s=share * sensor.exposure_s)
            first = 100 * (len(settings) + 1)
            made = generate(own, hidden, SHAPE, (t,), frames=FRAMES, seed=seed, first=first)
            settings += moved(made, offset)
    settings.sort(key=lambda s: s.point.sort_key())
    return CaptureSet("virtual sensor", made.sensor, tuple(settings))


def one(task: tuple[str, int]) -> list[Found]:
    """A sensor fitted without one of its effects."""
    layout, seed = task
    rng = np.random.default_rng([seed, 3])
    sensor = draw_sensor(rng)
    names = rng.choice(
        HIDDEN if layout == "series" else READOUT, rng.integers(1, 3), replace=False
    ).tolist()
    captures = captured(sensor, dict.fromkeys(names, "middling"), layout, seed)
    problem = fit_problem(design(captures))
    begun = baseline_model(problem)
    shot = begun.get("dark_shot_noise")
    assert shot is not None
    off = float(np.exp(rng.uniform(-1.0, 1.0) * np.log(FACTOR)))
    low, high = 1e-4, 100.0
    gain = float(np.clip(shot.value("dn_per_e", begun.reference) * off, low, high))
    state = fitted(problem, begun.with_effect(replace(shot, dn_per_e=gain)), converge)
    for name in names[1:]:
        state = add_on(captures, name, state.model, problem=problem).state
    model = state.model
    found = [
        *_noises(model, sensor),
        *_gains(problem, model, sensor),
        *_signals(problem, state, sensor),
    ]
    free = free_parameters(model)
    for k, x in zip(free, positions(model, free), strict=True):
        if k.name == "dark_shot_noise.dn_per_e" and k.plain(x) in (k.lower, k.upper):
            found.append(Found("at a bound", 0.0, 1.0))
    return found


def _noises(model, sensor: VirtualSensor) -> list[Found]:
    noise = model.get("read_noise").value("sigma", model.reference)
    return [Found("read noise", sensor.gain_dn_e * sensor.read_noise_e, noise)]


def _gains(problem, model, sensor: VirtualSensor) -> list[Found]:
    """Where photon transfer determines it."""
    told = [g for _, g in problem.direct.gains if g.source == "photon transfer"]
    gain = model.get("dark_shot_noise").value("dn_per_e", model.reference)
    return [Found("gain", sensor.gain_dn_e, gain, told[0].error)] if told else []


def _signals(problem, state, sensor: VirtualSensor) -> list[Found]:
    """Median dark signal of the ordinary pixels, and its energy.

    Its error holds that of the direct measurement, and what the fit states of the row of ``mu``:
    without bias frames or other exposures the black level is known no better.
    """
    base = state.model.get("convolved_lognormal")
    errors = {a.point: a.error for a in agreements(problem, state) if a.quantity == "dark signal"}
    stated = uncertain(problem, state).parameters
    spread = {p.temperature_c: stated[f"convolved_lognormal.mu[{k}]"].se
              for k, p in enumerate(base.mu.points)}  # fmt: skip
    found, series = [], []
    for point, _ in problem.plan.settings:
        if not point.exposure_s or point.temperature_c is None:
            continue
        rate = sensor.dark_e_s * arrhenius(point.temperature_c, sensor.activation_ev)
        true = sensor.gain_dn_e * rate * point.exposure_s
        mu = value_at(base.mu, point)
        own = float(np.exp(mu)) * point.exposure_over(state.model.reference)
        least = 0.05 * sensor.gain_dn_e * sensor.read_noise_e
        near = min(spread, key=lambda t: abs(t - point.temperature_c))
        direct = errors.get(point, own * spread[near])
        error = float(np.hypot(direct, least / 3.0))
        found.append(Found("dark signal", true, own, error))
        series.append((point.temperature_c, own / point.exposure_s, error / max(own, error)))
    celsius, rate, relative = np.array(series).T
    if np.ptp(celsius) >= 15.0:
        law = arrhenius_laws(celsius + KELVIN, rate, np.maximum(relative, 1e-3))
        energy = law["activation_energy_ev"]
        found.append(Found("energy", sensor.activation_ev, energy.value, energy.se))
    return found


def table(results: Sequence[tuple[str, list[Found]]]) -> str:
    """Share within limits, by layout and quantity."""
    lines = ["| layout | quantity | within | median deviation |", "|---|---|---|---|"]
    for layout in LAYOUTS:
        own = [f for name, found in results if name == layout for f in found]
        for quantity in dict.fromkeys(f.quantity for f in own):
            these = [f for f in own if f.quantity == quantity]
            off = [abs(f.model - f.true) for f in these]
            if quantity != "energy":
                off = [d / max(abs(f.true), 1e-9) for d, f in zip(off, these, strict=True)]
            unit = " eV" if quantity == "energy" else ""
            good = sum(f.within for f in these)
            median = float(np.nanmedian(off))
            lines.append(f"| {layout} | {quantity} | {good} of {len(these)} | {median:.3f}{unit} |")
    return "\n".join(lines)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--layout", action="append", choices=LAYOUTS)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--worst", action="store_true", help="name what is not within limits")
    asked = parser.parse_args()
    layouts = asked.layout or LAYOUTS
    numbers = range(asked.first, asked.first + asked.count)
    tasks = [(layouts[n % len(layouts)], n) for n in numbers]
    with ProcessPoolExecutor(asked.jobs) as pool:
        results = [(t[0], f) for t, f in zip(tasks, pool.map(one, tasks), strict=True)]
    if asked.worst:
        for (layout, seed), (_, found) in zip(tasks, results, strict=True):
            for f in found:
                if not f.within:
                    text = f"{layout} {seed}: {f.quantity} {f.model:.4g} for {f.true:.4g}"
                    print(f"{text} ± {f.error:.2g}")
    print(table(results))
    return 0


if __name__ == "__main__":
    sys.exit(main())
