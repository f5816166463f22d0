"""Times of a simulation with its statistics by one thread and by two, over the size of the field.

    python benchmarks/thread_sizes.py [--repeats 7]

Its pixels are those of half of the field, at three operating points. The two alternate, so that a
machine that slows down slows both.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from statistics import median
from time import perf_counter

from dnanalyze.fitting.simulated import Job, room
from dnanalyze.loaders.captures import OperatingPoint, Sensor, Window
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import BASE, BASELINE, built_in

SIZES = ((64, 3), (96, 3), (128, 3), (192, 3), (256, 4), (384, 4), (512, 8))  # side, frames
LEAST_S = 0.5  # of one timing


def job_of(side: int, frames: int) -> Job:
    """A simulation of the upper half of a square field."""
    effects = tuple(built_in()[name]() for name in (BASE, *BASELINE))
    model = NoiseModel(effects, 64.0, OperatingPoint(25.0, 0.1))
    halves = Window(0, side // 2, 0, side), Window(side // 2, side, 0, side)
    settings = [(OperatingPoint(t, 0.1), frames) for t in (25.0, 45.0, 65.0)]
    return Job(model, Sensor((side, side)), halves, settings, half=0, even=True)


def timed(job: Job, threads: int, count: int, seed: int) -> float:
    """Seconds of a simulation, the mean of some of different seeds."""
    memo = room()
    begun = perf_counter()
    for n in range(count):
        one = replace(job, model=replace(job.model, seed=seed + n))
        one.statistics(one.parts(), memo, threads)
    return (perf_counter() - begun) / count


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=7)
    a = parser.parse_args()
    print("| pixels | 1 thread, ms | 2 threads, ms | ratio |\n|---|---|---|---|")
    for side, frames in SIZES:
        job = job_of(side, frames)
        count = max(2, round(LEAST_S / max(timed(job, threads, 2, 0) for threads in (1, 2))))
        pairs = [[timed(job, threads, count, 100 * n) for threads in (1, 2)]
                 for n in range(a.repeats)]  # fmt: skip
        one, two = (1e3 * median(column) for column in zip(*pairs, strict=True))
        print(f"| {3 * frames * side * side // 2:,} | {one:.0f} | {two:.0f} | {two / one:.2f} |")


if __name__ == "__main__":
    main()
