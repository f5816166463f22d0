"""Describe effects that are in no catalogue: are the words, the numbers and the model right?

    python benchmarks/describe.py [NAME ...] [--models FOLDER] [--json OUT.json]

One sensor each of the effects outside the catalogue and two ordinary ones, 256 x 256 pixels, four
temperatures, six frames. Each is refined first; ``--models`` keeps and reads the refined models.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path
from typing import Any

import numpy as np

import dnanalyze
from dnanalyze.demo import VirtualSensor, generate
from dnanalyze.demo.virtual_sensor import OUTSIDE, resolve

SENSOR = VirtualSensor(temperatures_c=(25.0, 45.0, 65.0, 85.0))
SHAPE, FRAMES, SEED = (256, 256), 6, 5
ORDINARY = {"ordinary_a": 5, "ordinary_b": 6}
# what, when, where; the law is constant but of what=gain, which follows the dark signal
TRUTH = {
    "concentric_rings": ("level", "fixed", "rings"),
    "reset_ramp": ("level", "fixed", "wave"),
    "moving_blob": ("level", "frame", "blob"),
    "quadrant_jitter": ("gain", "frame", "quadrants"),
    "column_modulated_noise": ("noise", "fixed", "wave"),
    "column_telegraph": ("level", "frame", "column_segments"),
    "drifting_shading": ("level", "frame", "surface"),
    "pair_noise": ("level", "frame", "block"),
}


def numbers(name: str) -> dict[str, float]:
    """The true numbers of an effect, in the parameters of a description; conversion gain 1."""
    given = resolve(SENSOR, {name: "strong"}, SEED)[name]
    if name == "concentric_rings":
        centre = given["centre"]
        return {"amplitude": given["e"], "period": given["period"],
                "centre_y": centre[0] * SHAPE[0], "centre_x": centre[1] * SHAPE[1]}  # fmt: skip
    if name == "moving_blob":
        return {"amplitude": given["e"], "radius": given["radius"] * SHAPE[1]}
    if name == "quadrant_jitter":
        return {"gain": given["relative"]}
    if name == "column_modulated_noise":
        return {"u": 1.0 / given["period"]}
    return {"amplitude": given["e"]}


def one(name: str, models: Path | None) -> dict[str, Any]:
    """Refine, describe, compare with the truth."""
    ordinary = name in ORDINARY
    captures = generate(
        SENSOR, {} if ordinary else {name: "strong"}, SHAPE, frames=FRAMES,
        seed=ORDINARY.get(name, SEED),
    )  # fmt: skip
    kept = models / f"{name}.yaml" if models else None
    if kept is not None and kept.exists():
        model = dnanalyze.load_model(kept)
    else:
        model = dnanalyze.refine(captures).model
        if kept is not None:
            kept.write_text(dnanalyze.dump_model(model))
    begun = time.perf_counter()
    found = dnanalyze.describe(captures, model)
    row: dict[str, Any] = {
        "name": name,
        "verdict": found.verdict,
        "text": found.text,
        "before": found.error_before,
        "after": found.error_after,
        "model": found.after,
        "confidence": found.confidence,
        "seconds": time.perf_counter() - begun,
        "false": ordinary and found.confidence >= 0.9,
    }
    if not ordinary and found.effect is not None:
        e = found.effect
        law = e.law == "constant"
        row["words"] = [e.what, e.when, e.where, e.law]
        row["right"] = [*(a == b for a, b in zip(row["words"], TRUTH[name], strict=False)), law]
        told = {n.name: n for n in found.numbers}
        row["numbers"] = {
            key: {
                "true": true,
                "found": told[key].value,
                "se": told[key].se,
                "sigmas": (told[key].value - true) / told[key].se,
                "relative": told[key].value / true - 1.0,
            }
            for key, true in numbers(name).items()
            if key in told
        }
    return row


def main() -> None:
    """Print a line an effect; write all as JSON."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", default=[*OUTSIDE, *ORDINARY])
    parser.add_argument("--models", type=Path)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    rows = []
    for name in options.names:
        row = one(name, options.models)
        rows.append(row)
        right = "".join("+" if r else "-" for r in row.get("right", []))
        told = ", ".join(
            f"{key} {n['found']:.4g} (true {n['true']:.4g}, {n['sigmas']:+.1f} sigma, "
            f"{100 * n['relative']:+.1f} %)"
            for key, n in row.get("numbers", {}).items()
        )
        after = "-" if np.isnan(row["after"]) else f"{row['after']:.3g}"
        print(
            f"{name:24} {row['verdict']:10} {right:5} error {row['before']:.3g} -> {after} "
            f"{row['model']:11} {row['seconds']:.0f} s  {told}", flush=True,
        )  # fmt: skip
        if options.json:
            options.json.write_text(json.dumps(rows, indent=1))


if __name__ == "__main__":
    main()
