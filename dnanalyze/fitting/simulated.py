"""The statistics of both halves of a simulated capture set, whole or in shares."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from math import prod

from dnanalyze.analyzers.analyze import analyze_windows
from dnanalyze.analyzers.families.shading import RELATIVE
from dnanalyze.analyzers.statistics import SettingStatistics, Statistics
from dnanalyze.loaders.captures import OperatingPoint, Sensor, Window
from dnanalyze.model.memo import Memo
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.simulate import simulated_by
from dnanalyze.model.simulator import Simulator
from dnanalyze.progress import Progress

THREADS = 2  # parts taken at a time
# Pixels of a simulation from which threads, or a process, are worth their cost. Most statistics are
# small sums, for which two threads of one process wait for each other: a simulation takes 1.56
# times as long as with one at 18,000 pixels, 1.06 times at 390,000 and 0.85 times at 880,000
# (benchmarks/thread_sizes.py). With a process more, `compare` is 0.2 s slower at 37,000 pixels and
# 2 s faster at 2 million.
SHARED_FROM_PIXELS = 500_000
FIELD_BYTES = 1 << 30  # 22 fields of 12 million pixels, float32
CHARGE_BYTES = 1 << 28  # a few models' frames
WANTED, SHADING = 5, 2  # about what a frame of a half costs, and one of which only that is asked
BLOCKS = "block_means", *RELATIVE.values()  # curves over the field, (rows, columns) of blocks
Part = tuple[int, int]  # a setting, and a half of the field


def room(shares: int = 1) -> Memo:
    """Cache of one of several processes for fields and for frames before readout."""
    return Memo(FIELD_BYTES // shares, charge=Memo(CHARGE_BYTES // shares))


@dataclass(frozen=True)
class Job:
    """A simulation, and the statistics that are wanted of it.

    Parameters
    ----------
    model : NoiseModel
    sensor : Sensor
    windows : tuple of Window
        The halves of the field.
    settings : sequence of (OperatingPoint, int)
        Operating points with their number of frames.
    errors : bool
        Whether standard errors are wanted.
    half : int, optional
        The half that is wanted, with the shading of the other, over the whole field; both by
        default.
    even : bool
        Whether the model holds all over the field by the same law: then nothing is simulated of
        the half that is not wanted.
    """

    model: NoiseModel
    sensor: Sensor
    windows: tuple[Window, Window]
    settings: Sequence[tuple[OperatingPoint, int]]
    errors: bool = False
    half: int | None = None
    even: bool = False

    def parts(self) -> list[Part]:
        """Settings and halves, the most expensive first, halves in turn."""
        every = [(s, h) for s in range(len(self.settings)) for h in range(len(self.windows))]
        made = [part for part in every if self._wanted(part) or not self.even]
        return sorted(made, key=lambda part: (-self.cost(part), part[0], sum(part) % 2))

    @property
    def threads(self) -> int:
        """Parts worth taking at a time by one process."""
        pixels = sum(self.settings[s][1] * prod(self.windows[h].shape) for s, h in self.parts())
        return THREADS if pixels >= SHARED_FROM_PIXELS else 1

    def cost(self, part: Part) -> int:
        """Relative cost of a part."""
        return self.settings[part[0]][1] * (WANTED if self._wanted(part) else SHADING)

    def _wanted(self, part: Part) -> bool:
        return self.half in (None, part[1])

    def statistics(
        self,
        parts: Iterable[Part],
        memo: Memo,
        threads: int = 1,
        progress: Progress | None = None,
    ) -> list[list[SettingStatistics]]:
        """Statistics of the colour planes of each part; ``progress`` is told every frame."""
        simulator = Simulator(self.model.in_codes, self.sensor.shape, memo)
        made = simulated_by(simulator, self.settings, sensor=self.sensor)

        def one(part: Part) -> list[SettingStatistics]:
            setting, half = part
            alone = replace(made, settings=(made.settings[setting],))
            families = () if self._wanted(part) else ("shading",)
            (seen,) = analyze_windows(
                alone, [self.windows[half]], workers=1, errors=self.errors, families=families,
                progress=progress,
            )  # fmt: skip
            return list(seen.settings)

        if threads == 1:
            return [one(part) for part in parts]
        with ThreadPoolExecutor(threads) as pool:
            return list(pool.map(one, parts))

    def together(self, found: dict[Part, list[SettingStatistics]]) -> list[Statistics]:
        """The parts as the statistics of either half."""
        return [
            Statistics(
                "simulation",
                self.sensor,
                tuple(s for n in range(len(self.settings)) for s in self._of(found, (n, half))),
            )
            for half in range(len(self.windows))
        ]

    def _of(
        self, found: dict[Part, list[SettingStatistics]], part: Part
    ) -> list[SettingStatistics]:
        if part in found:
            return found[part]
        setting, half = part
        return [mirrored(s) for s in found[setting, 1 - half]]


def mirrored(seen: SettingStatistics) -> SettingStatistics:
    """The mirror image of a half, in place of the shading of the half that is not simulated.

    Of a checkerboard of blocks the image has the colour that is left over of the half itself, so
    that of either colour all blocks of the field are other draws.
    """
    curves = {name: seen.curves[name][::-1] for name in BLOCKS if name in seen.curves}
    return replace(seen, curves=seen.curves | curves)


def shared(jobs: Sequence[Job], shares: int) -> list[list[list[Part]]]:
    """The parts of every job divided into shares of equal cost."""
    taken: list[list[list[Part]]] = [[[] for _ in jobs] for _ in range(shares)]
    load = [0] * shares
    for number, job in enumerate(jobs):
        for part in job.parts():
            least = load.index(min(load))
            taken[least][number].append(part)
            load[least] += job.cost(part)
    return taken
