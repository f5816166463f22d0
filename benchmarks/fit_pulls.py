"""Are the fit's uncertainties right? Pulls of the paper's model over simulated series.

    python benchmarks/fit_pulls.py --fits 100 [--seed redrawn] [--json pulls.json]

Each fit sees another virtual sensor of known parameters and begins up to 20 % off them, with
random numbers of its own. The pull of a parameter is (fitted - true) / standard error on the scale
on which the fit moves it: ln(fitted / true) over the relative error for a log parameter. For right
uncertainties pulls have mean 0 and standard deviation 1.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from dnanalyze.fitting.fit import Fit, fit
from dnanalyze.fitting.free_parameters import free_parameters, positions, with_values
from dnanalyze.loaders.captures import CaptureSet, OperatingPoint
from dnanalyze.model.effects.convolved_lognormal import ConvolvedLognormal
from dnanalyze.model.laws import TableLaw
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.simulate import simulate

TEMPERATURES = (25.0, 45.0, 65.0, 85.0, 105.0)
POINTS = tuple(OperatingPoint(t, 0.1) for t in TEMPERATURES)
LEVELS = (1.0, 1.7, 2.4, 3.1, 3.8)  # mu: 2.7 to 45 DN, a doubling every 20 C
SHAPE, FRAMES, OFF = (96, 96), 3, 0.2


def truth(seed: str, sensor: int) -> NoiseModel:
    """The paper's model over five temperatures; ``seed`` "fixed" or "redrawn"."""
    base = ConvolvedLognormal(
        mu=TableLaw(POINTS, LEVELS),  # type: ignore[arg-type]
        delta=0.5,
        phi=0.02,
        sigma=0.05,
        seed=seed,
        exposure="none",
    )
    return NoiseModel((base,), 64.0, POINTS[2], seed=sensor)


def captures(model: NoiseModel, shape: tuple[int, int] = SHAPE, frames: int = FRAMES) -> CaptureSet:
    """The series that the fit sees."""
    return simulate(model, shape, [(p, frames) for p in POINTS])


def begin(model: NoiseModel, number: int, frozen: Sequence[str] = ()) -> NoiseModel:
    """A model up to 20 % off (mu by as much in level, the pedestal by 1 DN), with another seed."""
    rng = np.random.default_rng([number, 1])
    free = free_parameters(model, frozen)
    here = positions(model, free)
    off = rng.uniform(-OFF, OFF, len(free))
    reach = [1.0 if k.log or k.parameter == "mu" else 5.0 if k.effect == "pedestal" else x
             for k, x in zip(free, here, strict=True)]  # fmt: skip
    return replace(
        with_values(model, free, here + off * np.array(reach)), seed=10**6 + 1000 * number
    )


def pulls(fitted: Fit, true: NoiseModel, frozen: Sequence[str] = ()) -> dict[str, float]:
    """(fitted - true) / se of each parameter on its own scale."""
    free = free_parameters(true, frozen)
    there, here = positions(fitted.model, free), positions(true, free)
    told = {p.name: p for p in fitted.parameters}
    out = {}
    for parameter, a, b in zip(free, there, here, strict=True):
        p = told[parameter.name]
        se = p.se / p.value if parameter.log else p.se
        out[parameter.name] = float((a - b) / se)
    return out


def one(
    seed: str, number: int, shape: tuple[int, int], frames: int, replicates: int
) -> tuple[dict[str, float], Fit]:
    """Simulate a sensor, fit it, hold it against the truth."""
    true = truth(seed, number)
    fitted = fit(captures(true, shape, frames), begin(true, number), replicates=replicates)
    return pulls(fitted, true), fitted


def table(rows: Sequence[dict[str, float]]) -> str:
    """Mean and standard deviation of the pulls, Markdown."""
    lines = ["| parameter | mean pull | sd of pulls | largest |", "|---|---|---|---|"]
    for name in rows[0]:
        x = np.array([r[name] for r in rows])
        lines.append(f"| {name} | {x.mean():+.2f} | {x.std(ddof=1):.2f} | {abs(x).max():.1f} |")
    return "\n".join(lines)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--fits", type=int, default=100)
    parser.add_argument("--first", type=int, default=1, help="number of the first sensor")
    parser.add_argument("--seed", choices=("fixed", "redrawn"), default="fixed")
    parser.add_argument("--size", type=int, default=SHAPE[0])
    parser.add_argument("--frames", type=int, default=FRAMES)
    parser.add_argument("--replicates", type=int, default=24)
    parser.add_argument("--json", type=Path, help="also write every pull here")
    options = parser.parse_args()
    rows = []
    for number in range(options.first, options.first + options.fits):
        pull, _ = one(options.seed, number, (options.size, options.size), options.frames,
                       options.replicates)  # fmt: skip
        rows.append(pull)
        if options.json:
            options.json.write_text(json.dumps(rows, indent=1))
        print(f"{len(rows)} of {options.fits} fits", file=sys.stderr, flush=True)
    print(
        f"{options.fits} fits, seed {options.seed}, {options.size}x{options.size}, {len(POINTS)} "
        f"temperatures x {options.frames} frames, {options.replicates} replicates"
    )
    print(table(rows))
