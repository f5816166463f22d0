"""How often the classifier test tells sensors that it should, and that it should not.

    python benchmarks/classifier.py pairs --count 200        # two simulated sensors of one model
    python benchmarks/classifier.py true --count 40          # virtual sensors, their true model
    python benchmarks/classifier.py ordinary --count 40      # the same, fitted model
    python benchmarks/classifier.py missing --levels middling,strong   # one effect not in the model

`pairs` also tells how often the area lies above its lower limit at 95 %, for each cell with a limit
of its own and for the cell that tells most. The virtual sensors share no code with the models.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial
from statistics import NormalDist
from typing import Any

import numpy as np
from third_party.score import wilson

import dnanalyze
from dnanalyze import NoiseModel, OperatingPoint, catalogue
from dnanalyze.demo import CATALOGUED, VirtualSensor, draw_sensor, generate
from dnanalyze.model.laws import TableLaw

SHAPE, FRAMES = (128, 128), 4
POINTS = [OperatingPoint(t, 0.1, 1.0) for t in (25.0, 60.0)]  # one in turn is judged
# By which a model of the pairs is more than the baseline; each is drawn in another way.
DESIGNS: dict[str, tuple[tuple[str, dict[str, Any]], ...]] = {
    "baseline": (),
    "lines": (("column_fpn", {"sigma": 0.8}), ("row_fpn", {"sigma": 0.4}),
              ("row_noise", {"sigma": 0.6})),
    "hot pixels": (("hot_pixels", {"fraction": 0.005}),),
    "hot clusters": (("hot_clusters", {}),),
    "flicker_fpn": (("flicker_fpn", {"rms": 1.0}),),
    "random phase": (("periodic_pattern", {"amplitude": 1.0, "phase": "random"}),),
    "rts": (("rts", {"fraction": 0.02}),),
    "drift": (("offset_drift", {}),),
}  # fmt: skip
NOT_SEEN = {"offset_drift"}  # an offset of whole frames, which must not count


def design(name: str) -> NoiseModel:
    """The model of a pair."""
    known = catalogue()
    effects = [
        known["convolved_lognormal"](mu=TableLaw(tuple(POINTS), (0.0, 4.0)), delta=0.4, sigma=1e-6),
        known["dark_shot_noise"](dn_per_e=0.8),
        known["read_noise"](sigma=2.0),
        known["pixel_fpn"](sigma=1.0),
        known["quantization"](bits=12),
        *(known[effect](**numbers) for effect, numbers in DESIGNS[name]),
    ]
    return NoiseModel(tuple(effects), 100.3, POINTS[0])


def pair(number: int, size: int) -> dict[str, Any]:
    """Two sensors of one model against each other."""
    name = list(DESIGNS)[number % len(DESIGNS)]
    model = design(name)
    points = [(POINTS[number // len(DESIGNS) % len(POINTS)], FRAMES)]
    other = dnanalyze.simulate(replace(model, seed=10_000 + number), (size, size), points)
    found = dnanalyze.classify(other, model, seed=number)
    return row(name, found)


def true_model(sensor: VirtualSensor) -> NoiseModel:
    """What every virtual sensor has, with its true numbers."""
    known, gain = catalogue(), sensor.gain_dn_e
    points = tuple(OperatingPoint(t, sensor.exposure_s, 1.0) for t in sensor.temperatures_c)
    spread = np.exp(sensor.dark_spread**2 / 2)
    medians = (float(np.log(gain * sensor.dark_e(p.temperature_c) / spread)) for p in points)
    effects = (
        known["convolved_lognormal"](
            mu=TableLaw(points, tuple(medians)), delta=sensor.dark_spread, phi=0.0, sigma=1e-6
        ),
        known["dark_shot_noise"](dn_per_e=gain),
        known["read_noise"](sigma=gain * sensor.read_noise_e),
        known["pixel_fpn"](sigma=gain * sensor.pixel_offset_e),
        known["quantization"](bits=12),
    )
    return NoiseModel(effects, sensor.pedestal_dn, points[0])


def true(number: int, size: int) -> dict[str, Any]:
    """A virtual sensor with nothing but what every sensor has, and its true model."""
    sensor = draw_sensor(np.random.default_rng([number, 54]))
    captures = generate(sensor, {}, (size, size), frames=6, seed=number)
    return row("true", dnanalyze.classify(captures, true_model(sensor)))


def ordinary(number: int, size: int) -> dict[str, Any]:
    """A virtual sensor with nothing but what every sensor has, and the model fitted to it."""
    sensor = draw_sensor(np.random.default_rng([number, 54]))
    captures = generate(sensor, {}, (size, size), frames=6, seed=number)
    return row(
        "ordinary", dnanalyze.classify(captures, dnanalyze.fit(captures, replicates=0).model)
    )


def missing(task: tuple[str, str, int], size: int) -> dict[str, Any]:
    """A virtual sensor with one effect, and the model without it refitted."""
    name, level, number = task
    sensor = draw_sensor(np.random.default_rng([number, 55]))
    captures = generate(sensor, {name: level}, (size, size), frames=6, seed=number)
    fitted = dnanalyze.fit(captures, true_model(sensor), replicates=0).model
    found = dnanalyze.classify(captures, fitted)
    return row(f"{name} {level}", found)


def row(case: str, found: dnanalyze.Classification) -> dict[str, Any]:
    """What is counted."""
    joint = NormalDist().inv_cdf(1 - 0.05 / len((*found.cells, *found.together)))
    single = NormalDist().inv_cdf(0.95) / joint
    z = [single * (c.auc - c.low) for c in found.cells]
    return {
        "case": case,
        "tells": found.tells,
        "above": any(c.low > 0.5 for c in (*found.cells, *found.together)),
        "cells above": sum(c.auc - h > 0.5 for c, h in zip(found.cells, z, strict=True)),
        "cells below": sum(c.auc + h < 0.5 for c, h in zip(found.cells, z, strict=True)),
        "cells": len(found.cells),
        "auc": found.auc,
        "control": found.control,
        "sentence": found.sentence(),
    }


def table(rows: list[dict[str, Any]]) -> None:
    """Print the shares by case, and of all."""
    print("| case | tells | 95 % | any cell above its joint limit | cells above their own 95 % "
          "limit | cells below it |\n|---|---|---|---|---|---|")  # fmt: skip
    cases = dict.fromkeys(r["case"] for r in rows)
    for case in [*cases, "all"]:
        own = [r for r in rows if case in ("all", r["case"])]
        told = sum(r["tells"] for r in own)
        low, high = wilson(told, len(own))
        cells = sum(r["cells"] for r in own)
        print(f"| {case} | {told} of {len(own)} | {low:.0%} to {high:.0%} "
              f"| {sum(r['above'] for r in own)} "
              f"| {sum(r['cells above'] for r in own) / cells:.1%} "
              f"| {sum(r['cells below'] for r in own) / cells:.1%} |")  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("what", choices=("pairs", "true", "ordinary", "missing"))
    parser.add_argument("--count", type=int, default=0, help="pairs, or sensors (of each effect)")
    parser.add_argument("--first", type=int, default=0, help="number of the first")
    parser.add_argument("--size", type=int, default=0, help="pixels of a side")
    parser.add_argument("--levels", default="middling", help="weak, middling, strong; with commas")
    parser.add_argument("--effects", default="", help="names, with commas; all by default")
    parser.add_argument("--jobs", type=int, default=2)
    given = parser.parse_args()
    size = given.size or (SHAPE[0] if given.what == "pairs" else 192)
    numbers = range(given.first, given.first + (given.count or {"pairs": 200}.get(given.what, 1)))
    names = given.effects.split(",") if given.effects else [*CATALOGUED]
    tasks: Iterator[Any] = (
        iter([(n, level, s) for n in names for level in given.levels.split(",") for s in numbers])
        if given.what == "missing"
        else iter(numbers)
    )
    run = {"pairs": pair, "true": true, "ordinary": ordinary, "missing": missing}[given.what]
    rows = []
    with ProcessPoolExecutor(given.jobs) as pool:
        for made in pool.map(partial(run, size=size), tasks):
            rows.append(made)
            print(made["case"], made["sentence"], file=sys.stderr, flush=True)
    table(rows)
    if given.what == "missing":
        told = Counter(r["case"].split()[0] for r in rows if r["tells"])
        seen = [n for n in names if n not in NOT_SEEN]
        print(f"effects told at some level: {sum(told[n] > 0 for n in seen)} of {len(seen)}")


if __name__ == "__main__":
    main()
