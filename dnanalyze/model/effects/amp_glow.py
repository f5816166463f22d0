"""Light from the readout circuits at a corner or an edge."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effect import Effect, Site, Stage, choice, parameter
from dnanalyze.thermal import arrhenius

# (row, column) of the source in units of the frame; None: all along that direction
SOURCES: dict[str, tuple[float | None, float | None]] = {
    "nw": (0, 0),
    "n": (0, None),
    "ne": (0, 1),
    "e": (None, 1),
    "se": (1, 1),
    "s": (1, None),
    "sw": (1, 0),
    "w": (None, 0),
}
TOGETHER: dict[str, tuple[str, ...]] = {
    "edges": ("n", "e", "s", "w"),
    "corners": ("nw", "ne", "se", "sw"),
    "n+s": ("n", "s"),
    "e+w": ("e", "w"),
    "nw+ne": ("nw", "ne"),
    "se+sw": ("se", "sw"),
    "nw+sw": ("nw", "sw"),
    "ne+se": ("ne", "se"),
    "nw+se": ("nw", "se"),
    "ne+sw": ("ne", "sw"),
}
"""Sources that are alike, by one word."""
NEAREST = "border"  # light from the nearest edge alone, as through a seal all around
PLACES: dict[str, tuple[str, ...]] = {
    **dict(zip(SOURCES, zip(SOURCES, strict=True), strict=True)),  # each alone
    **TOGETHER,
    NEAREST: TOGETHER["edges"],
}


@dataclass(frozen=True)
class AmpGlow(Effect):
    """h += a e^(-r/l), r the distance from a corner, or from an edge; of several, their sum."""

    name: ClassVar[str] = "amp_glow"
    stage: ClassVar[Stage] = Stage.CHARGE
    varies: ClassVar[str] = "fixed"
    summary: ClassVar[str] = "glow that fades from corners or edges, growing with exposure"
    physics: ClassVar[str] = (
        "Transistors under high field (output amplifiers, column circuits) emit near-infrared "
        "light, and warm ones raise the dark current beside them. The pixels nearest to them "
        "collect a signal that fades with distance, the same in every frame and proportional to "
        "the exposure. Emission hardly depends on temperature (activation energy near 0); a glow "
        "that follows the dark current is heat. Its power lies below 0.01 cycles/pixel and in the "
        "block means. Several sources add (`location`: edges, corners, or a pair of them); light "
        "that leaks in all around depends on the distance from the nearest edge (border). An "
        "amplifier that is on while a frame is read, and off while it is exposed, leaves the same "
        "glow in every frame, bias frames too (exposure: none). The "
        "charge of the glow has shot noise: the slope "
        "of the temporal variance of blocks over their mean is the conversion gain, whatever the "
        "pedestal and the read noise are. Remedies: switch the amplifier off during the "
        "exposure, subtract a dark frame of the same exposure."
    )
    formula: ClassVar[str] = (
        "h += t/t_ref e^(-Ea/k (1/T - 1/T_ref)) a e^(-r/l); r from the corner (nw, ne, se, sw) "
        "or to the edge (n, e, s, w), l in units of the frame's larger side; of several sources "
        "the sum, of the border the largest; exposure none: without t/t_ref"
    )
    references: ClassVar[tuple[str, ...]] = (
        "Janesick, Scientific Charge-Coupled Devices, SPIE Press (2001)",
    )
    fingerprint: ClassVar[tuple[str, ...]] = (
        "shading_1_0",
        "shading_0_1",
        "shading_1_1",
        "shading_2_0",
        "shading_0_2",
        "shading_mid",
        "pattern_psd_0_0.01",
    )
    confused_with: ClassVar[dict[str, str]] = {
        "dark_gradient": "a temperature map is a low-order surface that follows the dark current",
        "dark_shading": "random shading has no source and is proportional to the dark current",
        "offset_gradient": "a surface of the offset does not grow with exposure",
        "flicker_fpn": (
            "a random low-frequency field has no source; its power falls as a power of frequency"
        ),
        "column_fpn": "column offsets do not fade along the column",
    }

    amplitude: float = parameter(
        10.0, "DN", 1e-3, 1e5, "at the source, at the reference temperature, exposure and gain"
    )
    length: float = parameter(
        0.2, "1", 0.005, 3.0, "fading length over the larger side of the frame"
    )
    ea_ev: float = parameter(0.0, "eV", 0.0, 1.6, "activation energy; 0 for light", "linear")
    location: str = choice("se", "corner or edge of the source, or several", *PLACES)
    exposure: str = choice("proportional", "glow over exposure", "proportional", "none")

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Add the glow."""
        signal += site.keep("map", lambda: self._map(site))
        return signal

    def _map(self, site: Site) -> np.ndarray:
        height = self.value("amplitude", site.point) * site.thermal(self.value("ea_ev", site.point))
        height *= site.gain_ratio * (site.exposure_ratio if self.exposure != "none" else 1.0)
        length = self.value("length", site.point)
        shape = glow(self.location, length, site.row_index, site.column_index, site.shape)
        return (height * shape).astype(np.float32)

    def black_shift(
        self, point: OperatingPoint, reference: OperatingPoint, shape: tuple[int, int]
    ) -> float:
        """Median of the glow that is in bias frames too."""
        if self.exposure != "none":
            return 0.0
        length, energy = self.value("length", point), self.value("ea_ev", point)
        height = self.value("amplitude", point) * point.gain_over(reference)
        height *= arrhenius(point.temperature_c, reference.temperature_c, energy)
        every = glow(self.location, length, np.arange(shape[0]), np.arange(shape[1]), shape)
        return height * float(np.median(every))


def glow(
    location: str, length: float, rows: np.ndarray, columns: np.ndarray, shape: tuple[int, int]
) -> np.ndarray:
    """Glow of each pixel over that of one source at its place, (rows, columns)."""
    each = [np.exp(-distance(p, rows, columns, shape) / length) for p in PLACES[location]]
    light: np.ndarray = np.max(each, axis=0) if location == NEAREST else np.sum(each, axis=0)
    return light


def distance(
    location: str, rows: np.ndarray, columns: np.ndarray, shape: tuple[int, int]
) -> np.ndarray:
    """Distance of each pixel from the source over the frame's larger side."""
    row, column = SOURCES[location]
    side = max(shape)
    y = 0.0 if row is None else rows[:, None] - row * (shape[0] - 1)
    x = 0.0 if column is None else columns[None, :] - column * (shape[1] - 1)
    return np.hypot(y, x) / side + np.zeros((rows.size, columns.size))
