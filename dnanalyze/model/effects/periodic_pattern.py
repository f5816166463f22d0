"""A sine wave over the frame: interference picked up during readout."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import OperatingPoint, Window
from dnanalyze.model.clues import MeasuredLines
from dnanalyze.model.effect import Effect, MeasuredParameter, Site, Stage, choice, parameter
from dnanalyze.model.fingerprints import LINE_BANDS, named
from dnanalyze.model.readout_effect import ADDED, ReadoutEffect
from dnanalyze.model.streams import Stream
from dnanalyze.model.wave import Wave, strongest_wave

PERIODS = 1.5  # over the field; less is no pattern but a slope, or one under every other line
MAX_LINES = 8  # lines, the first among them
RELATIVE = (1e-3, 10.0)  # amplitudes of further lines over the first's
MAX_HARMONIC = 8  # as many as there may be lines
NARROW = 1e-3  # cycles/pixel, of a first form: one mode of 1,000 rows
PARTS = {"temporal": "random", "pattern": "fixed"}  # of the spectrum, and the phase there


@dataclass(frozen=True)
class PeriodicPattern(ReadoutEffect):
    """y += A sin(2 pi (u x + v y) + phase), and further lines of their own frequency and phase."""

    name: ClassVar[str] = "periodic_pattern"
    stage: ClassVar[Stage] = Stage.LINE_READ
    varies: ClassVar[str] = "both"
    summary: ClassVar[str] = (
        "Sine waves across the frame (hum, clock pick-up, switching regulator)."
    )
    physics: ClassVar[str] = (
        "An interfering oscillation - mains hum, a switching regulator, a radio link, a clock - "
        "adds a sine to the signal while pixels are read one after the other. Sampled along the "
        "raster, any frequency in time becomes one point (u, v) of the image's spectrum: slow ones "
        "give horizontal bands (u = 0), fast ones slanted stripes. An interferer that is not "
        "locked to the frame clock has a new phase in every frame; one that is locked stands "
        "still. An oscillation that is no pure sine has harmonics at 2, 3, ... times its "
        "frequency, folded into +-1/2, and a camera may have several sources: `more` holds these "
        "further lines. A free-running oscillator, such as that of a switching regulator, does not "
        "keep its frequency: the phase walks from row to row, and the line is as wide as "
        "`linewidth`; its harmonics walk by as many times more. It does not depend on exposure or "
        "temperature; the analog gain raises it where it enters before the gain. Remedy: find the "
        "source by its frequency f = (v + u x columns) x line rate, then shield, filter or "
        "synchronise it; a notch in the spectrum repairs images already taken."
    )
    formula: ClassVar[str] = (
        "y_ij += A sum_n a_n sin(2 pi (u_n j + v_n i) + phase_n + h_n w_i);  a_0 = 1, "
        "(u_0, v_0) = (u, v), the others from more;  w_i = w_(i-1) + sqrt(2 pi linewidth) N(0,1), "
        "h_n = n for the n-th harmonic of the first line, another walk for other lines;  "
        "variance A^2 / 2 sum_n a_n^2"
    )
    references: ClassVar[tuple[str, ...]] = (
        "EMVA 1288 release 4.0 (horizontal and vertical spectrograms)",
        "Demir, Mehrotra, Roychowdhury, Phase noise in oscillators, IEEE Trans. Circuits Syst. I "
        "47, 655 (2000) (a phase that walks has a Lorentzian line)",
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
        "serial_noise": "with a phase new in every row, no line in the spectrum of a frame",
        "flicker_noise": "a slope, not a line",
    }

    amplitude: float = parameter(0.5, "DN", 1e-4, 1e3, "amplitude A of the sine")
    u: float = parameter(0.05, "cycles/pixel", -0.5, 0.5, "frequency along a row", "held")
    v: float = parameter(0.17, "cycles/pixel", -0.5, 0.5, "frequency along a column", "held")
    phase: str = choice("random", "new in every frame, or the same", "random", "fixed")
    more: tuple[float, ...] = choice(
        (), "u, v and amplitude over A of each further line, as measured; each has its own phase"
    )
    linewidth: float = parameter(
        0.0, "cycles/pixel", 0.0, 0.05, "full width of the line at half its power", "linear"
    )
    added: str = choice("before", ADDED, "before", "after")

    def __post_init__(self) -> None:
        super().__post_init__()
        lines, rest = divmod(len(self.more), 3)
        if rest or lines >= MAX_LINES:
            raise InputError(
                f"periodic_pattern.more: {len(self.more)} numbers; give u, v and relative "
                f"amplitude of each further line, {MAX_LINES - 1} lines at most"
            )
        for u, v, relative in self.further:
            if abs(u) > 0.5 or abs(v) > 0.5:
                raise InputError(
                    f"periodic_pattern.more: frequency ({u:g}, {v:g}) cycles/pixel; valid: -1/2 "
                    "to 1/2"
                )
            if not RELATIVE[0] <= relative <= RELATIVE[1]:
                raise InputError(
                    f"periodic_pattern.more: amplitude {relative:g} over the first's; valid: "
                    f"{RELATIVE[0]:g} to {RELATIVE[1]:g}"
                )

    @property
    def further(self) -> list[tuple[float, float, float]]:
        """Frequencies u, v and relative amplitude of each line of ``more``."""
        return list(zip(self.more[::3], self.more[1::3], self.more[2::3], strict=True))

    def inactive_parameters(self) -> tuple[str, ...]:
        """The width of a line that has none."""
        return ("linewidth",) if self.linewidth == 0.0 else ()

    def relatives(self) -> list[Effect]:
        """A sharp line as a narrow one."""
        return [replace(self, linewidth=NARROW)] if self.linewidth == 0.0 else []

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Add the waves; sin(a + b) is made of one sine a column and one a row."""
        stream = site.fixed_stream if self.phase == "fixed" else site.frame_stream
        amplitude = self.value("amplitude", site.point) * self.amplification(
            site.point, site.reference
        )
        first = self.value("u", site.point), self.value("v", site.point), 1.0
        for n, (u, v, relative) in enumerate([first, *self.further]):
            own = stream.child("phase", n) if n else stream.child("phase")
            start = 2.0 * math.pi * float(own.generator().random())
            along = 2.0 * math.pi * u * site.column_index
            down = 2.0 * math.pi * v * site.row_index + start
            order = harmonic((u, v), first[:2], site.shape) if n else 1
            walk = stream.child("walk", 0 if order else n)
            down = down + max(order, 1) * self._walk(walk, site)
            size = amplitude * relative
            signal += np.outer(size * np.sin(down), np.cos(along)).astype(np.float32)
            signal += np.outer(size * np.cos(down), np.sin(along)).astype(np.float32)
        return signal

    def _walk(self, stream: Stream, site: Site) -> np.ndarray | float:
        """Phase by which the oscillator is ahead at each row of the window, radians.

        exp(i w) has the autocorrelation exp(-s^2 k / 2) for steps of variance s^2: a Lorentzian
        whose full width at half maximum is s^2 / (2 pi) cycles a row.
        """
        width = self.value("linewidth", site.point)
        if width == 0.0:
            return 0.0
        steps = stream.normal(Window(0, 1, 0, site.window.bottom), site.shape[0])[0]
        walk = math.sqrt(2.0 * math.pi * width) * np.cumsum(steps, dtype=float)
        return np.asarray(walk[site.window.top :])

    def variance(self, point: OperatingPoint) -> float:
        """A^2 / 2 times the sum of the squared relative amplitudes, DN^2."""
        relative = 1.0 + sum(a**2 for _, _, a in self.further)
        return self.value("amplitude", point) ** 2 / 2.0 * relative

    def measured_parameters(self, measured: MeasuredLines) -> dict[str, MeasuredParameter]:
        """The frequency of the line within a mode of its own, or else of the strongest."""
        if not (isinstance(self.u, (int, float)) and isinstance(self.v, (int, float))):
            return {}
        part = next(part for part, phase in PARTS.items() if phase == self.phase)
        field = measured.shape
        seen = [w.turned(self.u, self.v) for w in measured.waves(part)]
        near = [w for w in seen if lies_at(w, self.u, self.v, field)]
        others = [w for w in seen if not any(lies_at(w, u, v, field) for u, v, _ in self.further)]
        patterns = [w for w in others if beats(w.v, w.u, field) >= PERIODS]
        line = strongest_wave(near or patterns)
        if line is None:
            return {}
        return {
            "u": MeasuredParameter(line.u, line.u_error),
            "v": MeasuredParameter(line.v, line.v_error),
        }


def lies_at(wave: Wave, u: float, v: float, field: tuple[int, int]) -> bool:
    """Whether a wave lies within a mode of a frequency."""
    here = wave.turned(u, v)
    return abs(here.u - u) < 1.0 / field[1] and abs(here.v - v) < 1.0 / field[0]


def harmonic(line: tuple[float, float], first: tuple[float, float], field: tuple[int, int]) -> int:
    """Which harmonic of a line another one is, folded into +-1/2; 0 if it is none of them."""
    for order in range(2, MAX_HARMONIC + 1):
        if lies_at(Wave(order * first[0], order * first[1], 0.0, 0.0, 1.0, 1.0), *line, field):
            return order
    return 0


def beats(v: float, u: float, field: tuple[int, int]) -> float:
    """Periods over the field of what is left beside a pattern that every one or two lines repeat.

    Of a sine a fraction of a mode beside it any slope of such a pattern over the field is made.
    """
    return max(min(abs(f), 0.5 - abs(f)) * lines for f, lines in zip((v, u), field, strict=True))
