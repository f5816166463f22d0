"""The statistics of both halves of a simulated capture set, whole or in shares."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

from dnanalyze.analyzers.analyze import analyze_windows
from dnanalyze.analyzers.statistics import SettingStatistics, Statistics
from dnanalyze.loaders.captures import OperatingPoint, Sensor, Window
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.simulate import Memo, simulate

THREADS = 2  # parts taken at a time
FIELD_BYTES = 1 << 30
CHARGE_BYTES = 1 << 28  # a few models' frames
WANTED, SHADING = 5, 2  # about what a frame of a half costs, and one of which only that is asked

Part = tuple[int, int]  # a setting, and a half of the field


def room(shares: int = 1) -> Memo:
    """Where fields, and frames as they are before readout, are kept by one of several processes."""
    return Memo(FIELD_BYTES // shares, charge=Memo(CHARGE_BYTES // shares))


@dataclass(frozen=True)
class Job:
    """What to simulate, and what of it is asked for.

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
    """

    model: NoiseModel
    sensor: Sensor
    windows: tuple[Window, Window]
    settings: Sequence[tuple[OperatingPoint, int]]
    errors: bool = False
    half: int | None = None

    def parts(self, share: int = 0, shares: int = 1) -> list[Part]:
        """The parts of one of several shares, all of which have as much to do."""
        every = [(s, h) for s in range(len(self.settings)) for h in range(len(self.windows))]
        # the dearest first, each to whom has least; halves in turn
        every.sort(key=lambda part: (-self._cost(part), part[0], sum(part) % 2))
        taken: list[list[Part]] = [[] for _ in range(shares)]
        for part in every:
            min(taken, key=lambda own: sum(map(self._cost, own))).append(part)
        return sorted(taken[share])

    def _cost(self, part: Part) -> int:
        setting, half = part
        return self.settings[setting][1] * (WANTED if self.half in (None, half) else SHADING)

    def statistics(
        self, parts: Iterable[Part], memo: Memo, threads: int = 1
    ) -> list[list[SettingStatistics]]:
        """Of each part, the statistics of its planes."""
        made = simulate(
            self.model, self.sensor.shape, self.settings, "simulation", self.sensor, memo
        )

        def one(part: Part) -> list[SettingStatistics]:
            setting, half = part
            alone = replace(made, settings=(made.settings[setting],))
            families = () if self.half in (None, half) else ("shading",)
            (seen,) = analyze_windows(
                alone, [self.windows[half]], workers=1, errors=self.errors, families=families
            )
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
                tuple(s for n in range(len(self.settings)) for s in found[n, half]),
            )
            for half in range(len(self.windows))
        ]
