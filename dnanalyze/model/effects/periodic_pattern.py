"""A sine wave over the frame: interference picked up during readout."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.clues import Located
from dnanalyze.model.effect import Effect, Site, Stage, Told, choice, parameter
from dnanalyze.model.fingerprints import LINE_BANDS, named
from dnanalyze.model.wave import strongest_wave

PERIODS = 1.5  # over the field; less is no pattern but a slope, or one under every other line
PARTS = {"temporal": "random", "pattern": "fixed"}  # of the spectrum, and the phase there


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
        "still. It does not depend on exposure or temperature; the analog gain raises it where it "
        "enters before the gain. Remedy: find the source by its frequency f = (v + u x columns) x "
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
        "cfa_mismatch": (
            "fixed lines at (1/2,0), (0,1/2), (1/2,1/2) exactly; a line that beats with these less "
            "than 1.5 times over the field is a slope of theirs"
        ),
        "flicker_noise": "a slope, not a line",
    }

    amplitude: float = parameter(0.5, "DN", 1e-4, 1e3, "amplitude A of the sine")
    u: float = parameter(0.05, "cycles/pixel", -0.5, 0.5, "frequency along a row", "held")
    v: float = parameter(0.17, "cycles/pixel", -0.5, 0.5, "frequency along a column", "held")
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

    def told(self, measured: Located) -> dict[str, Told]:
        """The frequency of the line within a mode of its own, or else of the strongest."""
        if not (isinstance(self.u, (int, float)) and isinstance(self.v, (int, float))):
            return {}
        part = next(part for part, phase in PARTS.items() if phase == self.phase)
        rows, columns = measured.shape
        seen = [w.turned(self.u, self.v) for w in measured.waves(part)]
        near = [
            w for w in seen if abs(w.u - self.u) < 1.0 / columns and abs(w.v - self.v) < 1.0 / rows
        ]
        patterns = [w for w in seen if beats(w.v, w.u, measured.shape) >= PERIODS]
        line = strongest_wave(near or patterns)
        if line is None:
            return {}
        return {"u": Told(line.u, line.u_error), "v": Told(line.v, line.v_error)}


def beats(v: float, u: float, field: tuple[int, int]) -> float:
    """Periods over the field of what is left beside a pattern that every one or two lines repeat.

    Of a sine a fraction of a mode beside it any slope of such a pattern over the field is made.
    """
    return max(min(abs(f), 0.5 - abs(f)) * lines for f, lines in zip((v, u), field, strict=True))
