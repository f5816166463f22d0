"""Describe effects that are in no catalogue, made here with NumPy alone.

    python benchmarks/describe_new_sensors.py [NAME ...] [--json OUT] [--models FOLDER]
    python benchmarks/describe_new_sensors.py [NAME ...] [--seeds 20,21,22,23,24] --search

The generator shares no code with the package: a plain sensor electron by electron, 256 x 256
pixels, four temperatures, six frames, and one effect in it. The model without the effect is what
every sensor has (``refine`` with no effect added). One line a sensor: words right (what, when,
where, law), numbers beside the truth, model error without and with the description. ``ordinary``
is a sensor without an effect. ``--models`` keeps and reads the models without the effect.
``--search`` compares the structure with most evidence in the layers only, without a model: 2 s a
sensor, no model error. ``--blind`` takes the eight effects of `describe_blind`, written by someone
who had seen neither the estimators nor the effects here.
"""

from __future__ import annotations

import argparse
import json
import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import describe_blind
import numpy as np

import dnanalyze
from dnanalyze.description.layers import Layers, Taken
from dnanalyze.description.search import by_chance, searched
from dnanalyze.loaders.captures import CaptureSet, Frame, OperatingPoint, Sensor, Setting, Window

SHAPE, FRAMES, TEMPERATURES = (256, 256), 6, (25.0, 45.0, 65.0, 85.0)
READ_E, OFFSET_E, DARK_E, SPREAD, EA_EV, PEDESTAL = 2.0, 0.8, 0.5, 0.4, 0.62, 64.0
BOLTZMANN_EV = 8.617333e-5
ROW, COLUMN = np.indices(SHAPE).astype(float)
Rng = np.random.Generator
Map = Callable[[float, Rng], np.ndarray]  # of temperature and moment


@dataclass
class Case:
    """What is hidden: maps in electrons, or a change of the read frame, and its truth."""

    words: tuple[str, tuple[str, ...], str, str]  # what, when (all that is right), where, law
    numbers: dict[str, float] = field(default_factory=dict)
    choices: dict[str, Any] = field(default_factory=dict)
    add: Map | None = None
    scale: np.ndarray | None = None  # of the charge
    after: Callable[[np.ndarray], np.ndarray] | None = None  # of the frame less its pedestal


def growth(celsius: float, energy: float) -> float:
    """Arrhenius growth from 25 C."""
    return math.exp(energy / BOLTZMANN_EV * (1.0 / 298.15 - 1.0 / (celsius + 273.15)))


def diagonal_stripes(rng: Rng) -> Case:
    """Every diagonal has a level of its own."""
    size, slant = rng.uniform(1.0, 2.0), str(rng.choice(["down", "up"]))
    number = (ROW - COLUMN + 255 if slant == "down" else ROW + COLUMN).astype(int)
    stripes = size * rng.standard_normal(511)[number]
    words = ("level", ("fixed",), "diagonal", "constant")
    return Case(words, {"amplitude": size}, {"slant": slant}, lambda t, now: stripes)


def stitched_halves(rng: Rng) -> Case:
    """One half of the frame lies higher than the other."""
    size, axis = rng.uniform(1.0, 2.0), str(rng.choice(["rows", "columns"]))
    step = size * np.where((ROW if axis == "rows" else COLUMN) < 128, -1.0, 1.0)
    step = step * rng.choice([-1.0, 1.0])
    words = ("level", ("fixed",), "halves", "constant")
    return Case(words, {"amplitude": size}, {"axis": axis}, lambda t, now: step)


def row_lag(rng: Rng) -> Case:
    """Each row keeps a share of the row before, noise included."""
    share = rng.uniform(0.06, 0.12)

    def lag(frame: np.ndarray) -> np.ndarray:
        kept = frame.copy()
        kept[1:] += share * frame[:-1]
        return kept

    return Case(("gain", ("fixed",), "row_before", "constant"), {"gain": share}, after=lag)


def tiled_gain(rng: Rng) -> Case:
    """Blocks with a gain of their own."""
    height, width = (int(n) for n in rng.integers(3, 13, 2))
    top, left = int(rng.integers(height)), int(rng.integers(width))
    size = rng.uniform(0.05, 0.1)
    values = 1.0 + size * rng.standard_normal((256 // height + 2, 256 // width + 2))
    tiles = values[((ROW + top) // height).astype(int), ((COLUMN + left) // width).astype(int)]
    form = {"height": height, "width": width, "top": top, "left": left}
    words = ("gain", ("fixed",), "block", "constant")
    return Case(words, {"gain": size}, form, scale=tiles)


def noisy_bands(rng: Rng) -> Case:
    """Bands of eight rows with additional noise."""
    size, noisy = rng.uniform(2.0, 3.0), rng.permutation(32) < int(rng.integers(3, 8))
    rows = np.repeat(noisy, 8)
    words = ("noise", ("fixed",), "row", "constant")
    numbers = {"amplitude": size, "share": float(rows.mean())}
    return Case(
        words, numbers, add=lambda t, now: size * rows[:, None] * now.standard_normal(SHAPE)
    )


def blinking_spot(rng: Rng) -> Case:
    """A soft spot that is there in half of the frames, always at one place."""
    size, radius = rng.uniform(4.0, 6.0), rng.uniform(12.0, 25.0)
    centre = rng.uniform(40, 216, 2)
    spot = size * np.exp(-((ROW - centre[0]) ** 2 + (COLUMN - centre[1]) ** 2) / (2 * radius**2))
    words = ("level", ("switching", "frame"), "blob", "constant")
    numbers = {"amplitude": size, "radius": radius,
               "centre_y": float(centre[0]), "centre_x": float(centre[1])}  # fmt: skip
    return Case(words, numbers, add=lambda t, now: spot * float(now.random() < 0.5))


def jumping_columns(rng: Rng) -> Case:
    """A few columns lie high in some frames and low in the others."""
    size, chosen = rng.uniform(2.0, 3.0), rng.random(256) < rng.uniform(0.06, 0.15)
    words = ("level", ("switching", "frame"), "column", "constant")
    numbers = {"amplitude": size, "share": float(chosen.mean())}

    def jump(celsius: float, now: Rng) -> np.ndarray:
        return size * chosen * np.where(now.random(256) < 0.5, -1.0, 1.0) + 0.0 * ROW

    return Case(words, numbers, add=jump)


def thermal_wave(rng: Rng) -> Case:
    """A fixed oblique wave with an activation energy of its own."""
    size, energy = rng.uniform(0.5, 0.8), rng.uniform(0.25, 0.35)
    period, angle = rng.uniform(7.0, 25.0), rng.uniform(0.3, 1.2)
    u, v = math.cos(angle) / period, math.sin(angle) / period
    start = rng.uniform(0, 2 * math.pi)
    wave = size * math.sqrt(2.0) * np.cos(2 * math.pi * (u * COLUMN + v * ROW) + start)
    words = ("level", ("fixed",), "wave", "thermal")
    numbers = {"amplitude": size, "ea_ev": energy, "u": u, "v": v}
    return Case(words, numbers, add=lambda t, now: growth(t, energy) * wave)


EFFECTS: dict[str, Callable[[Rng], Case]] = {
    made.__name__: made
    for made in (
        diagonal_stripes, stitched_halves, row_lag, tiled_gain, noisy_bands, blinking_spot,
        jumping_columns, thermal_wave,
    )
}  # fmt: skip
ORDINARY = "ordinary"


def sensor(name: str, seed: int) -> tuple[list[np.ndarray], Case | None]:
    """Frames at each temperature, (frames, rows, columns) of codes, and what is in them."""
    fixed = np.random.default_rng([seed, *name.encode()])
    of, _, own = name.rpartition(":")
    known: dict[str, Callable[[Rng], Any]] = describe_blind.EFFECTS if of else EFFECTS
    case = known[own](fixed) if own in known else None
    read, spread = READ_E, SPREAD
    if case is None:  # ordinary sensors differ among themselves
        read, spread = fixed.uniform(1.2, 3.0), fixed.uniform(0.2, 0.5)
    rate = DARK_E * np.exp(spread * fixed.standard_normal(SHAPE))
    offset = OFFSET_E * fixed.standard_normal(SHAPE)
    made = []
    for number, celsius in enumerate(TEMPERATURES):
        stack = []
        for count in range(FRAMES):
            now = np.random.default_rng([seed, 77, number, count, *name.encode()])
            charge = now.poisson(rate * growth(celsius, EA_EV)).astype(float)
            if case is not None and case.scale is not None:
                charge *= case.scale
            frame = charge + offset + read * now.standard_normal(SHAPE)
            if case is not None and case.add is not None:
                frame += case.add(celsius, now)
            if case is not None and case.after is not None:
                frame = case.after(frame)
            stack.append(np.clip(np.rint(frame + PEDESTAL), 0, 4095).astype(np.uint16))
        made.append(np.stack(stack))
    return made, case


def captures(stacks: list[np.ndarray]) -> CaptureSet:
    """The frames as the package takes them."""

    def frame(name: str, point: OperatingPoint, codes: np.ndarray) -> Frame:
        def load(window: Window | None) -> np.ndarray:
            return codes.copy() if window is None else np.ascontiguousarray(codes[window.slices])

        return Frame(name, point, load)

    settings = []
    for celsius, stack in zip(TEMPERATURES, stacks, strict=True):
        point = OperatingPoint(celsius, 0.05, 1.0)
        frames = (frame(f"{celsius:.0f}C/{n}.tif", point, y) for n, y in enumerate(stack))
        settings.append(Setting(point, tuple(frames)))
    return CaptureSet("made anew", Sensor(SHAPE), tuple(settings))


def compared(case: Case, effect: Any, told: dict[str, Any], reference_c: float) -> dict[str, Any]:
    """Which words are right, and every number beside its truth."""
    words = [effect.what, effect.when, effect.where, effect.law]
    what, when, where, law = case.words
    right = [words[0] == what, words[1] in when, words[2] == where, words[3] == law]
    true = dict(case.numbers)
    if law == "thermal":
        true["amplitude"] *= growth(reference_c, true["ea_ev"])
    if "u" in true and "u" in told and told["u"].value * true["u"] < 0:
        true |= {"u": -true["u"], "v": -true["v"]}  # the same wave
    numbers = {}
    for key, value in true.items():
        if key in told:
            found, se = told[key].value, told[key].se
            off, share = (found - value) / max(se, 1e-12), found / value - 1.0
            numbers[key] = {
                "true": value, "found": found, "se": se, "sigmas": off, "relative": share,
                "good": abs(off) <= 3 and abs(share) <= 0.15,
            }  # fmt: skip
        else:
            numbers[key] = {"true": value, "good": False}
    for key, value in case.choices.items():
        made = getattr(effect, key)
        numbers[key] = {"true": value, "found": made, "good": made == value}
    return {"words": words, "right": right, "numbers": numbers}


def one(name: str, seed: int, models: Path | None) -> dict[str, Any]:
    """Model without the effect, describe, compare with the truth."""
    stacks, case = sensor(name, seed)
    frames = captures(stacks)
    begun = time.perf_counter()
    kept = models / f"{name}_{seed}.yaml" if models else None
    if kept is not None and kept.exists():
        model = dnanalyze.load_model(kept)
    else:
        model = dnanalyze.refine(frames, limits=dnanalyze.SearchLimits(max_effects=0)).model
        if kept is not None:
            kept.write_text(dnanalyze.dump_model(model))
    middle = time.perf_counter()
    found = dnanalyze.describe(frames, model)
    row: dict[str, Any] = {
        "name": name, "seed": seed, "verdict": found.verdict, "text": found.text,
        "before": found.error_before, "after": found.error_after, "model": found.after,
        "confidence": found.confidence, "others": found.others,
        "nearest": [(n.effect, n.error_after, n.why) for n in found.nearest],
        "removed": found.removed,
        "refine_s": middle - begun, "describe_s": time.perf_counter() - middle,
    }  # fmt: skip
    if case is not None and found.effect is not None:
        told = {n.name: n for n in found.numbers}
        at = model.reference.temperature_c
        row |= compared(case, found.effect, told, 25.0 if at is None else at)
    return row


def layers(name: str, seed: int) -> tuple[Layers, Case | None]:
    """The residual layers of a sensor."""
    stacks, case = sensor(name, seed)
    points = [OperatingPoint(celsius, 0.05, 1.0) for celsius in TEMPERATURES]
    taken = (Taken(p, s.astype(np.float32)) for p, s in zip(points, stacks, strict=True))
    dark = np.array([s.mean() - PEDESTAL for s in stacks])
    return Layers(tuple(taken), Window.whole(SHAPE), SHAPE, dark), case


def searched_only(names: list[str], seeds: list[int]) -> None:
    """Words and numbers of the structure with most evidence; chance from one ordinary sensor."""
    chance = by_chance(layers(ORDINARY, 999)[0])
    right: dict[str, list[bool]] = {}
    for name in names:
        for seed in seeds:
            seen, case = layers(name, seed)
            found = searched(seen, chance, seen.points[-1])
            if case is None:
                right.setdefault(name, []).append(not found)
                continue
            good = False
            if found:
                best = found[0]
                told = {key: Told(getattr(best.effect, key), se) for key, se in best.errors.items()}
                row = compared(case, best.effect, told, TEMPERATURES[-1])
                good = all(row["right"]) and all(n["good"] for n in row["numbers"].values())
            right.setdefault(name, []).append(good)
        print(f"{name:17} right {sum(right[name])} of {len(right[name])}", flush=True)


@dataclass
class Told:
    """A number with its standard error."""

    value: float
    se: float


def line(row: dict[str, Any]) -> str:
    """What is printed of a sensor."""
    right = "".join("+" if r else "-" for r in row.get("right", []))
    parts = []
    for key, n in row.get("numbers", {}).items():
        if "sigmas" in n:
            parts.append(f"{key} {n['found']:.4g} (true {n['true']:.4g}, {n['sigmas']:+.1f} sigma)")
        else:
            parts.append(f"{key} {n.get('found', '-')} (true {n['true']})")
    after = "-" if math.isnan(row["after"]) else f"{row['after']:.3g}"
    return (
        f"{row['name']:23} {row['seed']} {row['verdict']:9} {right:4} "
        f"error {row['before']:.3g} -> {after} {row['model']:11} confidence "
        f"{row['confidence']:.2f} {row['refine_s']:.0f} + {row['describe_s']:.0f} s  "
        + ", ".join(parts)
    )


def main() -> None:
    """Print a line a sensor; keep each as a JSON line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", default=[*EFFECTS, ORDINARY])
    parser.add_argument("--seeds", default="0,1,2")
    parser.add_argument("--json", type=Path)
    parser.add_argument("--models", type=Path)
    parser.add_argument("--search", action="store_true")
    parser.add_argument("--blind", action="store_true")
    options = parser.parse_args()
    seeds = [int(s) for s in options.seeds.split(",")]
    blind = [f"blind:{name}" for name in describe_blind.EFFECTS]
    if options.blind:
        options.names = blind
    valid = [*EFFECTS, ORDINARY, *blind]
    unknown = sorted({*options.names} - {*valid})
    if unknown:
        parser.error(f"unknown: {', '.join(unknown)}; valid: {', '.join(valid)}")
    if options.search:
        searched_only(options.names, seeds)
        return
    for seed in seeds:
        for name in options.names:
            row = one(name, seed, options.models)
            print(line(row), flush=True)
            if options.json:
                with options.json.open("a") as out:
                    out.write(json.dumps(row, default=float) + "\n")


if __name__ == "__main__":
    main()
