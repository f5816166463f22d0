"""A sine wave over the frame: interference picked up during readout."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect, Site, Stage, choice, parameter
from dnanalyze.model.evidence import LINE_BANDS, bounded, curve, named, shows, strongest

_PEAK = 14.0  # times the floor: by chance in one of 1000 spectra of 1000 exponential modes


@dataclass(frozen=True)
class PeriodicPattern(Effect):
    """y += A sin(2 pi (u x + v y) + phase)."""

    name: ClassVar[str] = "periodic_pattern"
    stage: ClassVar[Stage] = Stage.LINE_READ
    varies: ClassVar[str] = "both"
    summary: ClassVar[str] = (
        "A sine wave across the frame (hum, clock pick-up, switching regulator)."
    )
    physics: ClassVar[str] = (
        "An interfering oscillation - mains hum, a switching regulator, a radio link, a clock - "
        "adds a sine to the signal while pixels are read one after the other. Sampled along the "
        "raster, any frequency in time becomes one point (u, v) of the image's spectrum: slow ones "
        "give horizontal bands (u = 0), fast ones slanted stripes. An interferer that is not "
        "locked to the frame clock has a new phase in every frame; one that is locked stands "
        "still. It does not depend on exposure or temperature; the analogue gain raises it where "
        "it enters before the gain. Cure: find the source by its frequency f = (v + u x columns) x "
        "line rate, then shield, filter or synchronise it; a notch in the spectrum repairs images "
        "already taken."
    )
    formula: ClassVar[str] = "y_ij += A sin(2 pi (u j + v i) + phase);  variance A^2 / 2"
    references: ClassVar[tuple[str, ...]] = (
        "EMVA 1288 release 4.0 (horizontal and vertical spectrograms)",
    )
    fingerprint: ClassVar[tuple[str, ...]] = (
        "temporal_line", "pattern_line", *named("temporal_rows", LINE_BANDS),
    )  # fmt: skip
    confused_with: ClassVar[dict[str, str]] = {
        "row_noise": "power at all frequencies of the u = 0 axis, not at one",
        "column_taps": "fixed lines at exactly u = n/P on the v = 0 axis",
        "cfa_mismatch": "fixed lines at (1/2,0), (0,1/2), (1/2,1/2) exactly",
        "flicker_noise": "a slope, not a line",
    }

    amplitude: float = parameter(0.5, "DN", 1e-4, 1e3, "amplitude A of the sine")
    u: float = parameter(0.05, "cycles/pixel", -0.5, 0.5, "frequency along a row", "linear")
    v: float = parameter(0.17, "cycles/pixel", -0.5, 0.5, "frequency along a column", "linear")
    phase: str = choice("random", "new in every frame, or the same", "random", "fixed")

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Add the wave; sin(a + b) is made of one sine a column and one a row."""
        stream = site.silicon if self.phase == "fixed" else site.moment
        start = 2.0 * math.pi * float(stream.child("phase").generator().random())
        along = 2.0 * math.pi * self.value("u", site.point) * site.column_index
        down = 2.0 * math.pi * self.value("v", site.point) * site.row_index + start
        amplitude = self.value("amplitude", site.point) * site.gain_ratio
        signal += np.outer(amplitude * np.sin(down), np.cos(along)).astype(np.float32)
        signal += np.outer(amplitude * np.cos(down), np.sin(along)).astype(np.float32)
        return signal

    def variance(self, point: OperatingPoint) -> float:
        """A^2 / 2, DN^2."""
        return self.value("amplitude", point) ** 2 / 2.0

    @classmethod
    def guess(cls, clues: Clues) -> list[Effect]:
        """The strongest line of the spectrum, off or on its axes, to half a mode, 1/(2 N)."""
        found: list[Effect] = []
        for family, phase in (("temporal", "random"), ("pattern", "fixed")):
            line = _off_axis(clues, family) or _on_axis(clues, family)
            if line is not None:
                amplitude, u, v = line
                found.append(cls(bounded(cls, "amplitude", amplitude), u, v, phase))
        return found


def _off_axis(clues: Clues, family: str) -> tuple[float, float, float] | None:
    """(A, u, v) of the strongest mode off the axes, where it stands out."""
    if not shows(clues, [f"{family}_line"]):
        return None
    i = strongest(clues, [f"{family}_line"])
    u, v, ratio, noise = (
        float(np.asarray(clues.measured(f"{family}_{k}"), float)[i])
        for k in ("line_u", "line_v", "line", "noise")
    )
    if not (math.isfinite(u) and math.isfinite(v)):
        return None
    return _amplitude(ratio * noise**2, clues.shape), u, v


def _on_axis(clues: Clues, family: str) -> tuple[float, float, float] | None:
    """(A, u, v) of the strongest line of the row or column spectrum, where it stands out."""
    best: tuple[float, float, float] | None = None
    for lines in ("rows", "columns"):
        names = named(f"{family}_{lines}", LINE_BANDS)
        if not shows(clues, names):
            continue
        spectrum = curve(clues, f"{family}_{lines[:-1]}_spectrum", strongest(clues, names) or 0)
        if spectrum is None or spectrum.ndim != 1 or spectrum.size < 16:
            continue
        power = np.asarray(spectrum[1:], float)  # without the mean
        peak = int(np.argmax(power))
        if power[peak] < _PEAK * np.median(power) / math.log(2.0):
            continue
        amplitude = _amplitude(float(power[peak]), clues.shape)
        frequency = 0.5 * (peak + 1) / power.size
        if best is None or amplitude > best[0]:
            at = (0.0, frequency) if lines == "rows" else (frequency, 0.0)
            best = (amplitude, *at)
    return best


def _amplitude(power: float, shape: tuple[int, int]) -> float:
    """A of a wave whose mode has this power: A^2 / 4 times the number of pixels."""
    return 2.0 * math.sqrt(max(power, 0.0) / (shape[0] * shape[1]))
