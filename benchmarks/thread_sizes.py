"""Times of a simulation with its statistics by one thread and by two, over the size of the field.

    python benchmarks/thread_sizes.py [--pairs 41]

Its pixels are those of half of the field, at three operating points. Simulations by one thread and
by two alternate, and the ratio is the median over the pairs: of a machine whose speed changes, most
pairs fall into one speed.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from statistics import median
from time import perf_counter

from dnanalyze.fitting.simulated import Job, room
from dnanalyze.loaders.captures import OperatingPoint, Sensor, Window
from dnanalyze.model.memo import Memo
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import BASE, BASELINE, built_in

SIZES = ((64, 3), (96, 3), (128, 3), (192, 3), (256, 4), (384, 4), (512, 8))  # side, frames


def job_of(side: int, frames: int) -> Job:
    """A simulation of the upper half of a square field."""
    effects = tuple(built_in()[name]() for name in (BASE, *BASELINE))
    model = NoiseModel(effects, 64.0, OperatingPoint(25.0, 0.1))
    halves = Window(0, side // 2, 0, side), Window(side // 2, side, 0, side)
    settings = [(OperatingPoint(t, 0.1), frames) for t in (25.0, 45.0, 65.0)]
    return Job(model, Sensor((side, side)), halves, settings, half=0, even=True)


def timed(job: Job, threads: int, seed: int, memo: Memo) -> float:
    """Milliseconds of a simulation."""
    one = replace(job, model=replace(job.model, seed=seed))
    begun = perf_counter()
    one.statistics(one.parts(), memo, threads)
    return 1e3 * (perf_counter() - begun)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--pairs", type=int, default=41)
    a = parser.parse_args()
    print("| pixels | 1 thread, ms | 2 threads, ms | ratio |\n|---|---|---|---|")
    for side, frames in SIZES:
        job, memo, pairs = job_of(side, frames), room(), []
        timed(job, 1, 0, memo)  # compiles
        for n in range(1, a.pairs + 1):
            order = (1, 2) if n % 2 else (2, 1)
            took = {threads: timed(job, threads, 2 * n + threads, memo) for threads in order}
            pairs.append((took[1], took[2]))
        one, two = (median(column) for column in zip(*pairs, strict=True))
        ratio = median(both / alone for alone, both in pairs)
        print(f"| {3 * frames * side * side // 2:,} | {one:.0f} | {two:.0f} | {ratio:.2f} |")


if __name__ == "__main__":
    main()
