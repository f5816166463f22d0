"""Hot pixels that come in clusters."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.bounds import clip
from dnanalyze.model.effect import Effect, Placing, Site, Stage, parameter
from dnanalyze.model.hot_signal import HotSignal
from dnanalyze.model.hot_tail import HotTail, amplitude

MAX_RADIUS = 8
MAX_OFFSPRING = 64  # offspring of one parent; P(more) < 1e-9 within the bounds


@dataclass(frozen=True)
class HotClusters(HotTail):
    """Neyman-Scott process: parents at random, a Poisson number of hot pixels around each."""

    name: ClassVar[str] = "hot_clusters"
    stage: ClassVar[Stage] = Stage.CHARGE
    varies: ClassVar[str] = "fixed"
    placing: ClassVar[Placing] = Placing.ANYWHERE
    summary: ClassVar[str] = "hot pixels in clusters: more hot neighbours than chance allows"
    physics: ClassVar[str] = (
        "A dislocation, a particle or a cascade of displaced atoms damages several pixels at "
        "once, so hot pixels come in groups a few pixels wide, with irregular amplitudes. "
        "Like single hot pixels they are the same in every frame, grow with exposure and "
        "follow an Arrhenius law. The pair correlation of hot pixels exceeds 1 within the "
        "radius of a cluster. Defect correction that compares the 8 neighbours fails on them: "
        "use a defect map with interpolation from farther away, or a dark frame."
    )
    formula: ClassVar[str] = (
        "parents: Poisson, density d a pixel; offspring of each: Pois(m), uniform within radius "
        "r; each adds Exp(nu) t/t_ref e^(-Ea/k (1/T - 1/T_ref)), or with a tail s > 0 a "
        "generalised Pareto law as in hot_pixels"
    )
    references: ClassVar[tuple[str, ...]] = ("Neyman and Scott, J. R. Stat. Soc. B 20 (1958)",)
    fingerprint: ClassVar[tuple[str, ...]] = (
        "hot_pairs",
        "hot_halo",
        "hot_halo_2",
        "hot_count_8",
        "hot_count_16",
        "pattern_q0.999",
        "pattern_psd_0.04_0.08",
    )
    confused_with: ClassVar[dict[str, str]] = {
        "transfer_tails": "tails of deferred charge lie on one side of every hot pixel",
        "scaled_lines": "whole lines, not short runs of pixels",
        "hot_pixels": "single defects have hot neighbours only by chance",
        "crosstalk": "a halo by crosstalk has the same relative height around every hot pixel",
        "cosmic_rays": "a hit is in one frame only",
    }
    reach: ClassVar[int] = MAX_RADIUS

    density: float = parameter(2e-4, "1/pixel", 1e-8, 0.05, "clusters per pixel of the field")
    members: float = parameter(4.0, "1", 0.1, 25.0, "mean number of hot pixels in a cluster")
    radius: float = parameter(1.5, "pixel", 0.5, float(MAX_RADIUS - 1), "radius of a cluster")
    scale: float = parameter(
        50.0, "DN", 1e-2, 1e6, "mean extra signal at the reference temperature, exposure and gain"
    )
    ea_ev: float = parameter(
        0.55, "eV", 0.0, 1.6, "activation energy of the extra signal", "linear"
    )

    tail: float = parameter(
        0.0, "1", 0.0, 1.5, "exponent s of a power-law tail; 0 for an exponential", "linear"
    )

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Add the clusters."""
        signal += site.keep("map", lambda: self._map(site))
        return signal

    def _map(self, site: Site) -> np.ndarray:
        at = np.flatnonzero(site.fixed_uniform("parent") < self.value("density", site.point))
        row, column = np.divmod(at, site.window.shape[1])
        index = (row + site.window.top) * site.shape[1] + column + site.window.left
        stream = site.fixed_stream.child("offspring")
        # arrival times of a unit Poisson process: the number before ``members`` is Pois(members),
        # and a change of ``members`` adds or removes only the last ones
        arrival = np.zeros(index.size)
        scale = self.scale_at(site)
        out = np.zeros(site.window.shape)
        for n in range(MAX_OFFSPRING):
            arrival -= np.log(stream.child(n, "arrival").uniform_at(index))
            alive = arrival < self.value("members", site.point)
            if not alive.any():
                break
            index, row, column, arrival = (a[alive] for a in (index, row, column, arrival))
            far = self.value("radius", site.point) * np.sqrt(stream.child(n, "r").uniform_at(index))
            angle = 2 * np.pi * stream.child(n, "angle").uniform_at(index)
            y = row + np.rint(far * np.sin(angle)).astype(int)
            x = column + np.rint(far * np.cos(angle)).astype(int)
            share = 1.0 / stream.child(n, "amplitude").uniform_at(index)
            hot = scale * amplitude(share, self.value("tail", site.point))
            inside = (y >= 0) & (y < out.shape[0]) & (x >= 0) & (x < out.shape[1])
            np.add.at(out, (y[inside], x[inside]), hot[inside])
        return out.astype(np.float32)

    @classmethod
    def odds(cls, others: Collection[str]) -> float:
        """Fewer sensors have clusters than single hot pixels, which a cluster of two may be."""
        return 0.3

    def variance(self, point: OperatingPoint) -> float | None:
        """DN^2 at the reference: d nu^2 (m E a^2 + m^2 (E a)^2 c), a the amplitude over nu (E a^2 =
        2 without a tail), c = chance that two share a pixel; none from s = 1/2 on.
        """
        d, m, s = (self.value(n, point) for n in ("density", "members", "tail"))
        if s >= 0.5:
            return None
        mean = 1 / (1 - s)
        square = 2 * mean / (1 - 2 * s)
        return (
            d
            * self.value("scale", point) ** 2
            * (m * square + (m * mean) ** 2 * self._shared(point))
        )

    def _shared(self, point: OperatingPoint) -> float:
        """Chance that two offspring fall on one pixel, by quadrature over the disc."""
        n = 400
        r = self.value("radius", point)
        far = r * np.sqrt((np.arange(n) + 0.5) / n)[:, None]
        angle = 2 * np.pi * (np.arange(n) + 0.5)[None, :] / n
        y = np.rint(far * np.sin(angle)).astype(int) + MAX_RADIUS
        x = np.rint(far * np.cos(angle)).astype(int) + MAX_RADIUS
        share = np.bincount((y * (2 * MAX_RADIUS + 1) + x).ravel()) / n**2
        return float((share**2).sum())

    @classmethod
    def of_hot_signal(cls, hot: HotSignal) -> list[Effect]:
        """As small and as large clusters."""
        return [
            cls(**clip(cls, density=hot.fraction / m, members=m, radius=r,
                             scale=hot.scale, ea_ev=hot.ea_ev))
            for m, r in ((3.0, 1.2), (8.0, 2.5))
        ]  # fmt: skip
