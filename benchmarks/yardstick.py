"""Whether the stated errors of the statistics are those that repeated captures and sensors show.

    python benchmarks/yardstick.py                          every design, as a Markdown table
    python benchmarks/yardstick.py --design four_edge_glow --worst 20
    python benchmarks/yardstick.py --moved                  errors of 10 % in what is placed

The virtual sensor, which shares no code with the model, makes 40 sensors of one design and 40
captures of one sensor, for each design: ordinary and with each structure that real fields have. The
standard deviation of a statistic over the 40 is divided by the stated one (root mean square): that
of sensors by the standard error of the frames alone, and by the yardstick of a model that was
fitted to one of them; that of captures by the repeatability. A ratio is calibrated within .8 and
1.25, widened by two standard errors of a deviation of 40 values. A statistic of one and the same
value on all of the 40, such as the flag of whole codes, is not counted.

``--moved`` fits the model to one sensor and changes what it places by 10 %: the largest misfit of a
statistic of level or shape, in sigma, and the change over the repeatability.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from dnanalyze.analyzers.analyze import analyze
from dnanalyze.analyzers.catalogue import catalogue
from dnanalyze.analyzers.repeatability import repeatability
from dnanalyze.analyzers.statistics import Scale
from dnanalyze.demo import VirtualSensor, generate
from dnanalyze.demo.hidden import Scene
from dnanalyze.demo.virtual_sensor import resolve
from dnanalyze.diagnosis.refine import add_on
from dnanalyze.fitting.design import design
from dnanalyze.fitting.fit import baseline_model
from dnanalyze.fitting.from_part import converge, fitted
from dnanalyze.fitting.problem import fit_problem
from dnanalyze.fitting.yardstick import by_design
from dnanalyze.loaders.captures import CaptureSet, Frame, Setting, Window
from dnanalyze.model.noise_model import NoiseModel

LOW, HIGH = 0.8, 1.25  # ratios that count as calibrated
FEWEST = 4.0  # mean of a count below which its root has no stable error (Anscombe 1948)
SHAPE = (256, 256)
CELSIUS = (45.0, 75.0, 105.0)
FRAMES = 6
TAPS_DN = (-5.0, 1.0, 3.0, 1.0)  # levels of interleaved readout taps
EDGE_E, EDGE_PX = 18.0, 30.0  # four edges: amplitude at the edge, and length
CLOUD_DN, CLOUD_PX = 2.0, 40.0  # smooth shading, another in each sensor: deviation and length
MOVED = 1.10
SHAPES = ("level", "shading", "distribution", "lines", "spectrum")
VIRTUAL = VirtualSensor()  # 1 DN/e-


@dataclass(frozen=True)
class Design:
    """What is hidden in the virtual sensor, and the effects of the model that stand for it.

    ``placed``: the parameter of the model that is its amplitude, where it places what it adds.
    """

    hidden: dict[str, Any]
    effects: tuple[str, ...] = ()
    placed: str = ""
    surface: str = ""


DESIGNS = {
    "ordinary": Design({}),
    "glow": Design({"amp_glow": "strong"}, ("amp_glow",), "amplitude"),
    "four_edge_glow": Design({}, ("amp_glow",), "amplitude", "edges"),
    "dark_gradient": Design({"dark_gradient": "strong"}, ("dark_gradient",), "x y xx yy"),
    "offset_gradient": Design({}, ("offset_gradient",), "x y xx yy", "plane"),
    "smooth_shading": Design({}, ("flicker_fpn",), "", "cloud"),
    "flicker_fpn": Design({"flicker_fpn": "middling"}, ("flicker_fpn",)),
    "column_taps": Design({}, ("column_taps",), "sigma", "taps"),
    "column_fpn": Design({"column_fpn": "middling"}, ("column_fpn",)),
    "row_fpn": Design({"row_fpn": "middling"}, ("row_fpn",)),
    "periodic_pattern": Design({"periodic_pattern": "middling"}, ("periodic_pattern",)),
    "hot_pixels": Design({"hot_pixels": "middling"}, ("hot_pixels",)),
    "hot_clusters": Design({"hot_clusters": "middling"}, ("hot_clusters",)),
}


def surface(kind: str, shape: tuple[int, int], seed: int) -> np.ndarray:
    """What is added to the field, DN; a cloud is another one in each sensor."""
    scene = Scene(VIRTUAL, shape)
    rows, columns = scene.row, scene.column
    if kind == "edges":
        ends = (rows, shape[0] - 1 - rows, columns, shape[1] - 1 - columns)
        return EDGE_E * sum(np.exp(-d / EDGE_PX) for d in ends)
    if kind == "taps":
        return np.asarray(TAPS_DN)[np.broadcast_to(columns % len(TAPS_DN), shape)]
    if kind == "plane":
        return 10.0 * (rows / shape[0] + 0.5 * columns / shape[1])
    rng = np.random.default_rng([seed, 7])
    y, x = (np.fft.fftfreq(n) for n in shape)
    gain = np.exp(-2.0 * (np.pi * CLOUD_PX) ** 2 * (y[:, None] ** 2 + x**2))
    field = np.fft.ifft2(np.fft.fft2(rng.standard_normal(shape)) * gain).real
    return CLOUD_DN * (field - field.mean()) / np.sqrt(np.mean(gain**2))


def captured(of: Design, seed: int, capture: int) -> CaptureSet:
    """One capture of one sensor."""
    first = capture * len(CELSIUS)
    hidden = resolve(VIRTUAL, of.hidden)  # the same places and frequencies in every sensor
    made = generate(VIRTUAL, hidden, SHAPE, CELSIUS, frames=FRAMES, seed=seed, first=first)
    if not of.surface:
        return made
    added = surface(of.surface, SHAPE, seed)
    light = of.surface == "edges"
    settings = tuple(
        Setting(s.point, tuple(_added(f, added, light, (seed, first)) for f in s.frames))
        for s in made.settings
    )
    return CaptureSet(made.name, made.sensor, settings)


def _added(frame: Frame, added: np.ndarray, light: bool, key: tuple[int, int]) -> Frame:
    """The frame with Poisson charge, or with an offset that is rounded at random."""
    codes = frame.read(None)
    rng = np.random.default_rng([*key, *frame.name.encode()])
    more = rng.poisson(added) if light else np.floor(added + rng.random(codes.shape))
    moved = (codes + more).astype(np.uint16)

    def load(window: Window | None) -> np.ndarray:
        return moved.copy() if window is None else np.ascontiguousarray(moved[window.slices])

    return Frame(frame.name, frame.point, load)


def model_of(of: Design, captures: CaptureSet) -> NoiseModel:
    """The baseline with the effects of a design, fitted."""
    problem = fit_problem(design(captures))
    model = fitted(problem, baseline_model(problem), converge).model
    for name in of.effects:
        model = add_on(captures, name, model, problem=problem).model
    return model


Key = tuple[str, float, str]  # half of the field, temperature, statistic
Row = dict[Key, tuple[float, float]]  # coordinate and stated error


def halves(captures: CaptureSet) -> Row:
    """Statistics as they are fitted and judged, on either half of the field."""
    problem = fit_problem(design(captures))
    points = [p for p, _ in problem.plan.settings]
    return {
        (half, points[k.setting].temperature_c or 0.0, k.name): (c, f / np.sqrt(2.0))
        for half, target in (("fitted", problem.train), ("judged", problem.test))
        for k, c, f in zip(target.keys, target.coordinates, target.reproducibility_sd, strict=True)
    }


def sensor(task: tuple[str, int]) -> Row:
    """One of the sensors of a design."""
    name, seed = task
    return halves(captured(DESIGNS[name], seed, 0))


def capture(task: tuple[str, int]) -> Row:
    """One of the captures of one sensor, whole field, with the repeatability."""
    name, number = task
    captures, infos = captured(DESIGNS[name], 0, number), catalogue()
    again = repeatability(captures, analyze(captures, workers=1), workers=1)
    return {
        ("whole", s.point.temperature_c or 0.0, n): (
            infos[n].scale.coordinate(v.value),
            v.repeatability,
        )
        for s in again.settings
        for n, v in s.values.items()
        if n in infos and infos[n].compared and v.repeatability is not None
    }


def yardstick(name: str) -> dict[Key, float]:
    """Standard deviations between sensors by a model fitted to one of them."""
    captures = captured(DESIGNS[name], 1, 0)
    problem = by_design(fit_problem(design(captures)), model_of(DESIGNS[name], captures))
    points = [p for p, _ in problem.plan.settings]
    return {
        (half, points[k.setting].temperature_c or 0.0, k.name): f / np.sqrt(2.0)
        for half, target in (("fitted", problem.train), ("judged", problem.test))
        for k, f in zip(target.keys, target.reproducibility_sd, strict=True)
    }


def moved(name: str) -> dict[str, float]:
    """Largest misfit of a statistic of level or shape where an amplitude is off by 10 %."""
    of = DESIGNS[name]
    captures = captured(of, 1, 0)
    model = model_of(of, captures)
    problem = by_design(fit_problem(design(captures)), model)
    effect = model.get(of.effects[0])
    assert effect is not None
    change = {p: MOVED * effect.value(p, model.reference) for p in of.placed.split()}
    other = model.with_effect(replace(effect, **change))
    right, wrong = problem.coordinates(model), problem.coordinates(other)
    z = np.concatenate([t.z(w) for t, w in zip((problem.train, problem.test), wrong, strict=True)])
    own = np.concatenate(
        [t.z(w) for t, w in zip((problem.train, problem.test), right, strict=True)]
    )
    shaped = np.isin(np.concatenate([problem.train.families, problem.test.families]), SHAPES)
    return {"right": float(np.abs(own[shaped]).max()), "moved": float(np.abs(z[shaped]).max())}


def ratios(rows: list[Row], stated: dict[Key, float] | None = None) -> dict[Key, float]:
    """Standard deviation over the stated one."""
    infos, out = catalogue(), {}
    for key in rows[0]:
        pairs = np.array([r[key] for r in rows if key in r])
        if len(pairs) < len(rows) or not np.isfinite(pairs).all():
            continue
        counts = infos[key[2]].scale is Scale.ROOT
        if counts and np.mean([Scale.ROOT.plain(c) for c, _ in pairs]) < FEWEST:
            continue
        spread, own = float(pairs[:, 0].std(ddof=1)), float(np.sqrt(np.mean(pairs[:, 1] ** 2)))
        of = own if stated is None else stated.get(key)
        if of is not None and spread > 0.0:  # else a flag, such as whole codes
            out[key] = spread / max(of, 1e-30)
    return out


def measured(pool: ProcessPoolExecutor, name: str, count: int) -> dict[str, dict[Key, float]]:
    """Ratios of sensors and of captures of one design."""
    stated = pool.submit(yardstick, name)
    sensors = list(pool.map(sensor, [(name, seed) for seed in range(1, count + 1)]))
    captures = list(pool.map(capture, [(name, n) for n in range(count)]))
    return {
        "frames alone": ratios(sensors),
        "yardstick": ratios(sensors, stated.result()),
        "captures": ratios(captures),
    }


def calibrated(values: np.ndarray, count: int) -> float:
    """Share of the ratios within the limits and their sampling error."""
    wide = 1.0 + 2.0 / np.sqrt(2.0 * (count - 1))
    return float(np.mean((values > LOW / wide) & (values < HIGH * wide)))


def lines(name: str, found: dict[str, dict[Key, float]], count: int, worst: int) -> Iterator[str]:
    """A row of the table, and the ratios farthest from 1."""
    cells = []
    for kind in found:
        values = np.array(list(found[kind].values()))
        cells += [f"{100 * calibrated(values, count):.0f} % of {values.size}"]
        cells += [f"{np.median(values):.2f}"]
    yield f"| {name} | " + " | ".join(cells) + " |"
    for kind in found:
        ranked = sorted(found[kind].items(), key=lambda kv: -abs(np.log(max(kv[1], 1e-9))))
        for (half, celsius, statistic), value in ranked[:worst]:
            yield f"    {kind}: {statistic} ({half}) at {celsius:g} C {value:.2f}"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--design", action="append", choices=list(DESIGNS))
    parser.add_argument("--moved", action="store_true")
    parser.add_argument("--count", type=int, default=40)
    parser.add_argument("--worst", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--json", type=Path)
    asked = parser.parse_args()
    if asked.moved:
        print("| placed by the model | largest misfit, sigma | with an amplitude off by 10 % |")
        print("|---|---|---|")
        for name in asked.design or [n for n, d in DESIGNS.items() if d.placed]:
            found = moved(name)
            print(f"| {name} | {found['right']:.1f} | {found['moved']:.1f} |", flush=True)
        return 0
    out = {}
    heads = ("frames alone", "yardstick of a model", "captures, repeatability")
    print("| design | " + " | ".join(f"{h} | median" for h in heads) + " |")
    print("|" + "---|" * 7)
    with ProcessPoolExecutor(asked.jobs) as pool:
        for name in asked.design or DESIGNS:
            ratio = measured(pool, name, asked.count)
            for line in lines(name, ratio, asked.count, asked.worst):
                print(line, flush=True)
            out[name] = {
                k: {" ".join(map(str, i)): v for i, v in r.items()} for k, r in ratio.items()
            }
    if asked.json:
        asked.json.write_text(json.dumps(out, indent=1))
    return 0


if __name__ == "__main__":
    sys.exit(main())
