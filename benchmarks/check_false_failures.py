"""How often does `dnanalyze check` fail a correct simulation? It promises once in 1,000 runs.

    python benchmarks/check_false_failures.py --measurements 40 --seeds 60 [--first 0] [--json F]

Each measurement is a small virtual sensor, drawn at random around the paper's model, with targets
made from it as `check --init` makes them; each seed is a correct simulation held against them. The
bound is Clopper and Pearson's, one-sided, 95 %; `--first` numbers the first measurement, so that
runs with other numbers add up.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import dataclass, replace
from pathlib import Path
from unittest.mock import patch

import numpy as np

from dnanalyze.checking.check import check
from dnanalyze.checking.check_data import CheckData
from dnanalyze.checking.margins import propose
from dnanalyze.loaders.captures import CaptureSet, OperatingPoint
from dnanalyze.model.effects.convolved_lognormal import ConvolvedLognormal
from dnanalyze.model.effects.pixel_fpn import PixelFpn
from dnanalyze.model.effects.quantization import Quantization
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.laws import TableLaw
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.simulate import simulate

POINTS = (OperatingPoint(25.0, 1.0), OperatingPoint(65.0, 1.0))
FRAMES, SIDE = 4, 96
STRIDE = 10_000  # seeds between measurements, so that none is drawn twice


@dataclass(frozen=True)
class Tally:
    """What one measurement's targets did."""

    measurement: int
    limits: int
    tried: int
    failed: int
    broken: list[str]


def model_of(number: int) -> NoiseModel:
    """A sensor of its own: dark level, spread, kernel, read noise and offsets at random."""
    rng = np.random.default_rng([number, 6])
    level = rng.uniform(0.5, 1.5)
    return NoiseModel(
        (
            ConvolvedLognormal(
                mu=TableLaw(POINTS, (level, level + rng.uniform(1.5, 2.5))),
                delta=rng.uniform(0.2, 0.6), phi=rng.uniform(0.0, 0.01), sigma=0.01,
            ),
            ReadNoise(sigma=rng.uniform(1.0, 4.0)),
            PixelFpn(sigma=rng.uniform(0.3, 2.0)),
            Quantization(),
        ),
        64.0, replace(POINTS[0], gain=1.0), seed=STRIDE * (number + 1),
    )  # fmt: skip


def drawn(model: NoiseModel) -> CaptureSet:
    """Its frames."""
    return simulate(model, (SIDE, SIDE), [(p, FRAMES) for p in POINTS], "sensor")


def tally(number: int, seeds: int) -> Tally:
    """Targets from one measurement, held against correct simulations with new seeds."""
    model = model_of(number)
    captures = drawn(model)
    targets = propose(captures, replace(model, seed=model.seed + 1))
    failed, broken = 0, []
    once = CheckData(captures, captures, model).measured  # not read anew for every seed
    with patch.object(CheckData, "measured", once):
        for k in range(seeds):
            result = check(captures, targets, replace(model, seed=model.seed + 100 + k))
            failed += not result.passed
            broken += [c.name for c in result.failures]
    return Tally(number, len(targets.targets), seeds, failed, broken)


def bound(failed: int, tried: int, confidence: float = 0.95) -> float:
    """One-sided upper bound of the rate, Clopper and Pearson (1934)."""
    from scipy.stats import beta

    return float(beta.ppf(confidence, failed + 1, tried - failed))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--measurements", type=int, default=40)
    parser.add_argument("--seeds", type=int, default=60)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--json", type=Path)
    asked = parser.parse_args()
    made: list[Tally] = []
    for number in range(asked.first, asked.first + asked.measurements):
        made.append(tally(number, asked.seeds))
        failed, tried = sum(t.failed for t in made), sum(t.tried for t in made)
        print(
            f"{failed} of {tried} failed over {len(made)} measurements; at most "
            f"{1e3 * bound(failed, tried):.2f} in 1,000 with 95 % confidence"
            + "".join(f"\n  {name}" for name in made[-1].broken),
            flush=True,
        )
        if asked.json:
            asked.json.write_text(json.dumps([vars(t) for t in made], indent=1))


if __name__ == "__main__":
    main()
