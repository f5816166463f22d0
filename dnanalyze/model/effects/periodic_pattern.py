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

_PERIODS = 1.5  # over the field; less is no pattern but a slope, or one under every other line
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
        "cfa_mismatch": (
            "fixed lines at (1/2,0), (0,1/2), (1/2,1/2) exactly; a line that beats with these less "
            "than 1.5 times over the field is a slope of theirs"
        ),
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
        """The strongest line of the spectrum, off or on its axes, placed between its modes."""
        found: list[Effect] = []
        for family, phase in (("temporal", "random"), ("pattern", "fixed")):
            line = _off_axis(clues, family) or _on_axis(clues, family)
            if line is None:
                continue
            amplitude, u, v = line
            if _beats(v, u, clues.field) >= _PERIODS:
                found.append(cls(bounded(cls, "amplitude", amplitude), u, v, phase))
        return found


def _beats(v: float, u: float, field: tuple[int, int]) -> float:
    """Periods over the field of what is left beside a pattern that every one or two lines repeat.

    Of a sine a fraction of a mode beside it any slope of such a pattern over the field is made.
    """
    return max(min(abs(f), 0.5 - abs(f)) * lines for f, lines in zip((v, u), field, strict=True))


def _off_axis(clues: Clues, family: str) -> tuple[float, float, float] | None:
    """(A, u, v) of the strongest mode off the axes, where it stands out."""
    if not shows(clues, [f"{family}_line"]):
        return None
    i = strongest(clues, [f"{family}_line"]) or 0
    amplitude, u, v = (
        float(np.asarray(clues.measured(f"{family}_line_{k}"), float)[i])
        for k in ("amplitude", "u", "v")
    )
    if not math.isfinite(amplitude + u + v):
        return None
    noise = 3.0 / math.sqrt(min(clues.shape))  # of a profile, relative to its floor, three times
    u, lost_u = _between(clues, f"{family}_horizontal_spectrum", "column_spectrum_f", i, u, noise)
    v, lost_v = _between(clues, f"{family}_vertical_spectrum", "row_spectrum_f", i, v, noise)
    return amplitude / (lost_u * lost_v), u, v


def _between(
    clues: Clues, spectrum: str, frequency: str, setting: int, at: float, noise: float
) -> tuple[float, float]:
    """The frequency between two modes from their amplitudes, and the share of it that is seen.

    A sine d modes off a mode has the amplitude sinc(d) there and sinc(1 - d) in the next one. A
    next mode within ``noise`` times the floor counts as none.
    """
    power, modes = curve(clues, spectrum, setting), curve(clues, frequency, setting)
    if power is None or modes is None or power.shape != modes.shape:
        return at, 1.0
    k = int(np.argmin(np.abs(modes - abs(at))))
    if not 0 < k < power.size - 1:
        return at, 1.0
    floor = float(np.median(power))
    below, here, above = (float(p) - floor for p in power[k - 1 : k + 2])
    beside = max(below, above)
    if here <= 0 or beside < noise * floor:
        return at, 1.0
    ratio = math.sqrt(min(beside / here, 1.0))
    off = ratio / (1.0 + ratio) * (1 if above > below else -1)
    moved = abs(at) + off * float(modes[k + 1] - modes[k])
    return math.copysign(moved, at), float(np.sinc(off))


def _on_axis(clues: Clues, family: str) -> tuple[float, float, float] | None:
    """(A, u, v) of the strongest line of the row or column spectrum, where it stands out."""
    best: tuple[float, float, float] | None = None
    for lines in ("rows", "columns"):
        names = named(f"{family}_{lines}", LINE_BANDS)
        if not shows(clues, names):
            continue
        setting = strongest(clues, names) or 0
        spectrum = curve(clues, f"{family}_{lines[:-1]}_spectrum", setting)
        frequencies = curve(clues, f"{lines[:-1]}_spectrum_f", setting)
        if spectrum is None or frequencies is None or spectrum.shape != frequencies.shape:
            continue
        power = np.where(frequencies > 0, spectrum, 0.0)
        peak = int(np.argmax(power))
        if power[peak] < _PEAK * np.median(power) / math.log(2.0):
            continue
        amplitude = 2.0 * math.sqrt(float(power[peak]) / (clues.shape[0] * clues.shape[1]))
        frequency, lost = _between(
            clues,
            f"{family}_{lines[:-1]}_spectrum",
            f"{lines[:-1]}_spectrum_f",
            setting,
            float(frequencies[peak]),
            _PEAK / 2.0,
        )
        amplitude /= lost
        if best is None or amplitude > best[0]:
            at = (0.0, frequency) if lines == "rows" else (frequency, 0.0)
            best = (amplitude, *at)
    return best
