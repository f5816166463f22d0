"""System gain by photon transfer on sensors by NumPy alone: bias, scatter, pulls.

    python benchmarks/system_gain.py [--sensors 8]

A row for each kind of sensor: how the pixels differ, what neighbours share, filters, particles.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import convolve, laplace

import dnanalyze
from dnanalyze.emva.quantity import Quantity

CHARGE_E = (2.0, 20.0, 60.0, 160.0)  # one operating point each
BLACK_DN, HIT_E = 200.0, 800.0


@dataclass(frozen=True)
class Kind:
    """A kind of sensor; noise and charge in e-, offsets in DN."""

    spread: float = 0.3  # of the logarithm of the charge over the pixels
    gain: float = 1.3
    read: float = 3.0
    read_spread: float = 0.0
    offsets: float = 0.0
    frames: int = 6
    size: int = 256
    share: float = 0.0  # of the charge in each neighbour
    kernel: tuple[float, ...] = ()
    hits: float = 0.0  # particle tracks of a frame for each electron of charge

    def captures(self, seed: int) -> dnanalyze.CaptureSet:
        """Frames of one sensor."""
        rng, shape = np.random.default_rng(seed), (self.size, self.size)
        charge = rng.lognormal(-(self.spread**2) / 2, self.spread, shape)
        read = self.read * rng.lognormal(0.0, self.read_spread, shape)
        offset = BLACK_DN + self.offsets * rng.standard_normal(shape)
        frames = {}
        for mean in CHARGE_E:
            point = dnanalyze.OperatingPoint(20.0, mean / 10.0)
            frames[point] = np.stack(
                [self._frame(rng, charge * mean, mean, read, offset) for _ in range(self.frames)]
            )
        return dnanalyze.from_arrays(frames, keep_outliers=True)

    def _frame(
        self,
        rng: np.random.Generator,
        charge: np.ndarray,
        mean: float,
        read: np.ndarray,
        offset: np.ndarray,
    ) -> np.ndarray:
        drawn = rng.poisson(charge).astype(float)
        for _ in range(rng.poisson(self.hits * mean)):
            row, column = rng.integers(0, self.size), rng.integers(0, self.size - 8)
            drawn[row, column : column + rng.integers(1, 8)] += rng.exponential(HIT_E)
        drawn += self.share * laplace(drawn, mode="reflect")
        frame = offset + self.gain * (drawn + read * rng.standard_normal(read.shape))
        if self.kernel:
            weights = np.outer(self.kernel, self.kernel)
            frame = convolve(frame, weights / weights.sum())
        return np.clip(np.rint(frame), 0, 65535).astype(np.uint16)


PLAIN = Kind()
KINDS = {
    **{f"charge spread by {s}": replace(PLAIN, spread=s) for s in (0.1, 0.3, 0.6, 1.0)},
    "charge spread by 0.6, 2 frames": replace(PLAIN, spread=0.6, frames=2),
    "read noise spread by 0.5": replace(PLAIN, read_spread=0.5),
    "offsets of 5 DN": replace(PLAIN, offsets=5.0),
    "K = 0.1": replace(PLAIN, gain=0.1),
    "96 x 96 pixels": replace(PLAIN, size=96),
    **{f"{s:.1%} in each neighbour": replace(PLAIN, share=s) for s in (0.002, 0.005, 0.02, 0.05)},
    "2 % in each neighbour, spread by 1": replace(PLAIN, share=0.02, spread=1.0),
    "filter 1 2 1": replace(PLAIN, kernel=(1.0, 2.0, 1.0)),
    "mean of 3 x 3": replace(PLAIN, kernel=(1.0, 1.0, 1.0)),
    **{f"{h} tracks an electron": replace(PLAIN, hits=h) for h in (0.1, 0.5)},
}


def measured(kind: Kind, seed: int) -> Quantity:
    """The gain of one sensor."""
    families = ("level", "time", "neighbours")
    found = dnanalyze.analyze(kind.captures(seed), workers=1, families=families)
    return found.emva.groups[0].quantities["photon_transfer_gain_dn_e"]


def row(name: str, kind: Kind, sensors: int) -> str:
    """Markdown."""
    found = [measured(kind, seed) for seed in range(sensors)]
    told = np.array([(q.value, q.se) for q in found if q.value is not None]).reshape(-1, 2)
    if not len(told):
        return f"| {name} | 0 of {sensors} | | | | |"
    value, error = told.T
    off = value / kind.gain - 1.0
    pull = float(np.sqrt(np.mean(((value - kind.gain) / error) ** 2)))
    share = 100.0 * float(np.mean(error)) / kind.gain
    return (
        f"| {name} | {len(told)} of {sensors} | {100 * off.mean():.2f} | {100 * off.std():.2f} | "
        f"{share:.2f} | {pull:.1f} |"
    )


def main() -> None:
    """The table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--sensors", type=int, default=8)
    sensors = parser.parse_args().sensors
    print("| sensor | stated | bias, % | scatter, % | stated error, % | pull, rms |")
    print("| --- | --- | --- | --- | --- | --- |")
    for name, kind in KINDS.items():
        print(row(name, kind, sensors), flush=True)


if __name__ == "__main__":
    main()
