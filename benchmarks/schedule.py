"""What further processes would save of a refinement: its schedule, simulated from measured tasks.

    python benchmarks/schedule.py captures/ [--processes 1,2,4,8,16]

One process computes every part of every simulation, and every task of the classifier, and takes
their times. The parts of each batch are then dealt to n processes as `dnanalyze` deals them; what
is between the batches (reading, linear algebra, the decisions of the search) is of one process.
Transfers are not counted: of a batch they are a model and some hundred numbers a part.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from time import perf_counter
from typing import Any

import dnanalyze
from dnanalyze.analyzers.statistics import SettingStatistics
from dnanalyze.diagnosis.refine import refine_on
from dnanalyze.fitting.design import design
from dnanalyze.fitting.problem import fit_problem
from dnanalyze.fitting.processes import Helpers
from dnanalyze.fitting.simulated import Job, Part, shared
from dnanalyze.model.memo import Memo

PROCESSES = (1, 2, 4, 8, 16)


@dataclass
class Batch:
    """Simulations that do not wait for each other, or calls: seconds of each part or call."""

    jobs: Sequence[Job]
    parts: list[dict[Part, float]] = field(default_factory=list)
    calls: list[float] = field(default_factory=list)

    @property
    def alone(self) -> float:
        """Seconds of one process."""
        return sum(self.calls) + sum(sum(taken.values()) for taken in self.parts)

    def lasts(self, processes: int) -> float:
        """Seconds until the last of so many processes has done its share."""
        if self.calls:
            return max(sum(self.calls[n::processes]) for n in range(processes))
        return max(
            sum(taken[part] for taken, own in zip(self.parts, share, strict=True) for part in own)
            for share in shared(self.jobs, processes)
        )


class Timed(Helpers):
    """This process, which takes the time of all that could be another's."""

    def __init__(self) -> None:
        super().__init__()
        self.batches: list[Batch] = []

    def statistics(
        self, jobs: Sequence[Job], memo: Memo
    ) -> list[dict[Part, list[SettingStatistics]]]:
        """All parts of some jobs."""
        batch, found = Batch(jobs), []
        for job in jobs:
            made, taken = {}, {}
            for part in job.parts():
                begun = perf_counter()
                (made[part],) = job.statistics([part], memo)
                taken[part] = perf_counter() - begun
            found.append(made)
            batch.parts.append(taken)
        self.batches.append(batch)
        return found

    def each(self, function: Callable[..., Any], arguments: Sequence[tuple[Any, ...]]) -> list[Any]:
        """A function of each tuple of arguments."""
        batch, found = Batch(()), []
        for some in arguments:
            begun = perf_counter()
            found.append(function(*some))
            batch.calls.append(perf_counter() - begun)
        self.batches.append(batch)
        return found

    @property
    def shares(self) -> int:
        """As many operating points of the classifier at a time as there may be processes."""
        return max(PROCESSES)


def main() -> None:
    """Print seconds and speed-up for each number of processes."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("captures")
    parser.add_argument("--processes", default=",".join(map(str, PROCESSES)))
    given = parser.parse_args()
    captures = dnanalyze.load(given.captures)
    timed = Timed()
    begun = perf_counter()
    refine_on(captures, problem=fit_problem(design(captures), timed))
    whole = perf_counter() - begun
    batches = [b for b in timed.batches if b.parts or b.calls]
    serial = whole - sum(b.alone for b in batches)
    print(f"{len(batches)} batches; between them {serial:.1f} of {whole:.1f} s")
    print(f"{'processes':>9}{'seconds':>9}{'times faster':>14}")
    for count in map(int, given.processes.split(",")):
        lasts = serial + sum(b.lasts(count) for b in batches)
        print(f"{count:9d}{lasts:9.1f}{whole / lasts:14.2f}")


if __name__ == "__main__":
    main()
