"""Tracks of charged particles, each in one frame only."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.special import ndtri, pdtrik

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effect import Effect, Placing, Site, Stage, choice, parameter

SPACING = 0.25  # of the points along a track, pixels
WIDTH = 0.25  # of Moyal's law of the charge in a pixel of path, over its most probable charge
MOYAL_MEAN = 1.2703628454614782  # Euler's constant and ln 2
MOST_STEPS = 1 << 16  # of a track, that have a charge of their own
STEPPED = "even", "landau"  # charges that go pixel by pixel


@dataclass(frozen=True)
class CosmicRays(Effect):
    """A Poisson number of straight tracks a frame, each with an exponential length and energy."""

    name: ClassVar[str] = "cosmic_rays"
    stage: ClassVar[Stage] = Stage.CHARGE
    varies: ClassVar[str] = "temporal"
    placing: ClassVar[Placing] = Placing.ANYWHERE
    summary: ClassVar[str] = "hits of particles: bright, elongated, in one frame only"
    physics: ClassVar[str] = (
        "Muons (about one per square centimetre and minute at sea level), natural radioactivity "
        "of the packaging, and in space protons leave thousands of electrons along a straight "
        "track. The charge (`charge`) is the remaining energy of a particle that stops in the "
        "silicon (track), or in proportion to its path (path). Minimum-ionizing particles leave "
        "the same charge in every pixel of the path (even), or with Landau's fluctuations "
        "(landau; Moyal's law with a width of a quarter of the most probable charge). A length far "
        "below 1 makes hits of single pixels, with even and landau of exactly one. A hit is in "
        "one frame only, lights one pixel or a line of "
        "them, and the number of hits grows with exposure and area but not with temperature. A "
        "frame also has the hits of the time for which it waits to be read (`readout_s`): a bias "
        "frame of a CCD has some. The "
        "median of several frames removes them; single frames need a detector of sharp edges."
    )
    formula: ClassVar[str] = (
        "number ~ Pois(rate x Mpx x (exposure + readout time)); each: uniform place and "
        "direction, length Exp(l), charge Exp(E), or Exp(E) (1 + length) / (1 + l), spread evenly "
        "along it and bilinearly over the pixels; or of round(length) + 1 steps a pixel apart, "
        "each in the pixel that it "
        "is in, of one charge (even) or times Moyal's law (landau); mean added a pixel "
        "rate x (exposure + readout time) x E / 1e6"
    )
    references: ClassVar[tuple[str, ...]] = (
        "Groom, Experimental Astronomy 14 (2002)",
        "Moyal, Theory of ionization fluctuations, Phil. Mag. 46 (1955)",
    )
    fingerprint: ClassVar[tuple[str, ...]] = (
        "transient_high",
        "transient_adjacent",
        "temporal_q0.999",
        "temporal_kurtosis",
        "hot_repeat",
        "temporal_noise",
    )
    confused_with: ClassVar[dict[str, str]] = {
        "rts": "an RTS pixel returns to its upper level; a hit does not return",
        "heavy_tailed_read_noise": "heavy tails go both ways and hit single pixels",
        "hot_pixels": "a hot pixel is in every frame",
    }

    rate: float = parameter(
        1.0,
        "1/(Mpx s)",
        1e-6,
        1e5,
        "hits per million pixels and second; per frame if the exposure is unknown",
    )
    energy: float = parameter(1000.0, "DN", 1.0, 1e7, "mean charge of a hit at the reference gain")
    length: float = parameter(2.0, "pixel", 0.05, 200.0, "mean length of a track")
    charge: str = choice(
        "track",
        "drawn for the track, or in proportion to it; one charge a pixel of path, or Moyal's law",
        "track",
        "path",
        "even",
        "landau",
    )
    readout_s: float = parameter(
        0.0, "s", 0.0, 1e4, "mean time beyond the exposure in which a frame collects hits", "linear"
    )

    def inactive_parameters(self) -> tuple[str, ...]:
        """The time of the readout where it is none."""
        return ("readout_s",) if self.readout_s == 0.0 else ()

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Add the tracks of this frame that cross the window."""
        y, x, charge = self._points(site)
        rows, columns = site.window.shape
        out = np.zeros((rows, columns), np.float32)
        if self.charge in STEPPED:  # each step lies in one pixel
            y, x = np.rint(y), np.rint(x)
        top = np.floor(y).astype(int)
        left = np.floor(x).astype(int)
        fy, fx = y - top, x - left
        for dy, dx, share in (
            (0, 0, (1 - fy) * (1 - fx)),
            (0, 1, (1 - fy) * fx),
            (1, 0, fy * (1 - fx)),
            (1, 1, fy * fx),
        ):
            r = top + dy - site.window.top
            c = left + dx - site.window.left
            inside = (r >= 0) & (r < rows) & (c >= 0) & (c < columns)
            np.add.at(out, (r[inside], c[inside]), (charge * share)[inside])
        signal += out
        return signal

    def _points(self, site: Site) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Row, column (pixel centres are whole) and charge, DN, of the points of all tracks.

        A higher rate adds tracks and leaves the others as they are.
        """
        rows, columns = site.shape
        exposure = site.point.exposure_s
        mean = self.value("rate", site.point) * rows * columns * 1e-6
        mean *= 1.0 if exposure is None else exposure + self.value("readout_s", site.point)
        random = site.frame_stream.generator()
        number = poisson_quantile(random.random(), mean)
        u = random.random((number, 5))
        mean_length = self.value("length", site.point)
        length = -mean_length * np.log1p(-u[:, 3])
        mean_energy = self.value("energy", site.point) * site.gain_ratio
        if self.charge in STEPPED:
            steps = np.rint(length).astype(int) + 1
            length = steps - 1.0
            energy = mean_energy / (1.0 + mean_rounded(mean_length)) * steps
        else:
            steps = np.ceil(length / SPACING).astype(int) + 1
            energy = -mean_energy * np.log1p(-u[:, 4])
        if self.charge == "path":  # the silicon is about a pixel deep
            energy *= (1.0 + length) / (1.0 + mean_length)
        track = np.repeat(np.arange(number), steps)
        along = np.arange(track.size) - np.repeat(np.cumsum(steps) - steps, steps)
        offset = (along / np.maximum(steps - 1, 1)[track] - 0.5) * length[track]
        angle = 2 * np.pi * u[track, 2]
        y = u[track, 0] * rows - 0.5 + offset * np.sin(angle)
        x = u[track, 1] * columns - 0.5 + offset * np.cos(angle)
        charge = energy[track] / steps[track]
        if self.charge == "landau":
            place = track * MOST_STEPS + np.minimum(along, MOST_STEPS - 1)
            charge *= moyal(site.frame_stream.child("landau").uniform_at(place))
        return y, x, charge

    def variance(self, point: OperatingPoint) -> float | None:
        """None: it depends on how a track falls on the pixels."""
        return None


def mean_rounded(length: float) -> float:
    """Mean of an exponential length after rounding: the sum of P(L > n + 1/2), pixels."""
    return float(-np.exp(-0.5 / length) / np.expm1(-1.0 / length))


def moyal(u: np.ndarray) -> np.ndarray:
    """Charges of Moyal's law with mean 1, from uniform deviates; none is negative."""
    z = ndtri(0.5 + 0.5 * u.astype(np.float64))
    law: np.ndarray = np.maximum(1.0 - 2.0 * WIDTH * np.log(z), 0.0)
    return law / (1.0 + WIDTH * MOYAL_MEAN)


def poisson_quantile(u: float, mean: float) -> int:
    """Smallest count whose distribution function reaches ``u``: grows with the mean, one by one."""
    return max(0, int(np.ceil(pdtrik(u, mean)))) if u > np.exp(-mean) else 0
