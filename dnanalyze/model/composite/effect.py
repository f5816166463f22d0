"""The composite effect: parameters only, for structure that no effect of the catalogue makes."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.composite import elements, geometry
from dnanalyze.model.composite.geometry import polynomial
from dnanalyze.model.effect import Effect, Site, Stage, choice, parameter

FORMS = {
    "wave": geometry.wave,
    "rings": geometry.rings,
    "surface": geometry.surface,
    "blob": geometry.blob,
    "pixel": elements.pixel,
    "row": elements.row,
    "column": elements.column,
    "block": elements.block,
    "quadrants": elements.quadrants,
    "halves": elements.halves,
    "diagonal": elements.diagonal,
    "smooth": elements.smooth,
    "row_segments": elements.row_segments,
    "column_segments": elements.column_segments,
}
ECHOES = {"row_before": elements.row_before}  # of the signal itself
KNOWN_FORM = ("wave", "rings", "surface", "blob")
LINES = ("row", "column", "row_segments", "column_segments")
OWN = {
    "wave": ("u", "v", "phase", "envelope"),
    "rings": ("centre_y", "centre_x", "period", "phase", "envelope"),
    "surface": ("coefficients",),
    "blob": ("centre_y", "centre_x", "radius"),
    "block": ("height", "width", "top", "left", "mask"),
    "halves": ("axis", "coefficients"),
    "quadrants": ("coefficients",),
    "diagonal": ("slant",),
    **dict.fromkeys(LINES, ("lines",)),
    "smooth": ("alpha",),
}  # parameters of each geometry
MOST_LINE = 1e6
MOST_COEFFICIENT = 1e6  # only their ratios count
WORDS = ("what", "when", "where", "law")


@dataclass(frozen=True)
class CompositeEffect(Effect):
    """y += A p, y *= 1 + g p, or noise of variance A^2 w(p), p a pattern in space and time."""

    name: ClassVar[str] = "composite"
    stage: ClassVar[Stage] = Stage.LINE_READ
    varies: ClassVar[str] = "both"
    summary: ClassVar[str] = "Structure outside the catalogue, composed of words."
    physics: ClassVar[str] = (
        "A structure that no effect of the catalogue has is stated by what it changes (the level, "
        "the noise, the gain), when (in every frame alike, new in each, persisting, drifting, "
        "switching), where (lines, blocks, a wave, rings, a surface, ...), by which law it follows "
        "temperature, exposure and analog gain, and how its values are distributed. "
        "`dnanalyze describe` estimates these from captures. The words state the geometry and the "
        "law; they do not state the cause."
    )
    formula: ClassVar[str] = (
        "level: y += A law p;  gain: y *= 1 + g law p;  noise: y += A law sqrt(w) N(0,1), w = "
        "1 + p / max |p| of waves, rings and surfaces, p of a spot, p^2 of random elements"
    )

    what: str = choice("level", "what it changes", "level", "noise", "gain")
    when: str = choice(
        "fixed", "how it changes over the frames",
        "fixed", "frame", "persisting", "drifting", "switching",
    )  # fmt: skip
    where: str = choice("pixel", "geometry", *FORMS, *ECHOES)
    law: str = choice(
        "constant", "dependence on the operating point", "constant", "gain", "exposure", "thermal"
    )
    distribution: str = choice(
        "normal", "distribution of the values", "normal", "heavy", "two_level", "on_off"
    )
    amplitude: float = parameter(0.5, "DN", 1e-4, 1e4, "rms of level or noise; height of a spot")
    gain: float = parameter(0.01, "1", 1e-6, 10.0, "rms of the relative change of the gain")
    ea_ev: float = parameter(0.6, "eV", -2.0, 2.0, "activation energy of law thermal", "linear")
    tau: float = parameter(3.0, "frame", 0.05, 1e4, "time constant over the frames")
    share: float = parameter(1.0, "1", 1e-7, 1.0, "share of the elements that have it", "held")
    u: float = parameter(0.1, "cycles/pixel", -0.5, 0.5, "frequency along a row", "held")
    v: float = parameter(0.0, "cycles/pixel", -0.5, 0.5, "frequency along a column", "held")
    phase: float = parameter(0.0, "rad", -7.0, 7.0, "phase at pixel (0, 0) or at radius 0", "held")
    centre_y: float = parameter(0.0, "pixel", -1e6, 1e6, "row of the centre", "held")
    centre_x: float = parameter(0.0, "pixel", -1e6, 1e6, "column of the centre", "held")
    period: float = parameter(20.0, "pixel", 2.0, 1e6, "period of the rings", "held")
    radius: float = parameter(20.0, "pixel", 0.3, 1e6, "radius of the spot (standard deviation)")
    alpha: float = parameter(2.0, "1", 0.3, 4.0, "exponent of the power spectrum", "linear")
    height: int = choice(2, "rows of a block")
    width: int = choice(2, "columns of a block")
    top: int = choice(0, "rows by which the first block is cut")
    left: int = choice(0, "columns by which the first block is cut")
    mask: str = choice("all", "pixels of a block that have it", "all", "diagonal", "antidiagonal")
    axis: str = choice("rows", "halves: of the rows or of the columns", "rows", "columns")
    slant: str = choice("down", "diagonals that fall or rise to the right", "down", "up")
    envelope: str = choice(
        "flat", "towards which side the pattern grows from 0", "flat", "down", "up", "right", "left"
    )
    coefficients: tuple[float, ...] = choice(
        (), "surface: of x, y, x^2, x y, y^2; halves, quadrants: known steps"
    )

    lines: tuple[float, ...] = choice(
        (), "first and last row or column of each group that has it; without: a share of all"
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if len(self.lines) % 2 or any(
            not 0 <= first <= last <= MOST_LINE
            for first, last in zip(self.lines[::2], self.lines[1::2], strict=False)
        ):
            raise InputError(
                f"{self.name}.lines: valid: pairs of a first and a last line, 0 to {MOST_LINE:g}"
            )
        if self.where in ECHOES and (self.what != "gain" or self.when != "fixed"):
            raise InputError(f"{self.name}.what, when: valid with where: {self.where}: gain, fixed")
        if self.height < 1 or self.width < 1:
            raise InputError(f"{self.name}.height, width: valid: 1 pixel or more")
        if self.where == "surface" and (len(self.coefficients) != 5 or not any(self.coefficients)):
            raise InputError(f"{self.name}.coefficients: valid: five numbers, not all 0")
        steps = {"halves": 1, "quadrants": 3}.get(self.where)
        wrong = len(self.coefficients) != steps or not any(self.coefficients)
        if steps and self.coefficients and wrong:
            raise InputError(f"{self.name}.coefficients: valid: none or {steps}, not all 0")
        if any(abs(c) > MOST_COEFFICIENT for c in self.coefficients):
            raise InputError(f"{self.name}.coefficients: valid: up to {MOST_COEFFICIENT:g}")
        if self.where == "wave" and self.u == 0.0 and self.v == 0.0:
            raise InputError(f"{self.name}.u, v: valid: not both 0")
        if self.when == "persisting" and self.distribution != "normal":
            raise InputError(f"{self.name}.distribution: valid with when: persisting: normal")
        if self.what == "noise" and self.when != "fixed":
            raise InputError(f"{self.name}.when: valid with what: noise: fixed")

    def inactive_parameters(self) -> tuple[str, ...]:
        """What the words do not use."""
        used = {*WORDS, *OWN.get(self.where, ()), "gain" if self.what == "gain" else "amplitude"}
        varied = self.when in ("frame", "persisting", "switching")
        if self.where == "blob" and self.when == "frame":
            used -= {"centre_y", "centre_x"}
            varied = False
        steps = self.where in ("halves", "quadrants") and bool(self.coefficients)
        if self.where not in (*KNOWN_FORM, *ECHOES, "smooth") and not steps:
            used |= {"share", "distribution"}
        elif varied and self.where not in ECHOES and self.where != "smooth":
            used |= {"distribution"}
        if self.law == "thermal":
            used |= {"ea_ev"}
        if self.when in ("persisting", "switching"):
            used |= {"tau"}
        return tuple(name for name in self.parameters() if name not in used)

    def to_plain(self) -> dict[str, Any]:
        """As written in YAML, without what the words do not use."""
        idle = self.inactive_parameters()
        return {name: value for name, value in super().to_plain().items() if name not in idle}

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Add the pattern, scale by it, or add noise that follows it."""
        return changed(self, signal, site, form_of(self.where))

    def margin(self) -> int:
        """The row before."""
        return 1 if self.where in ECHOES else 0

    def variance(self, point: OperatingPoint) -> float | None:
        """A^2 share where the law is constant, DN^2."""
        if self.what == "gain" or self.law != "constant" or self.when == "drifting":
            return None
        if self.where == "blob" or self.distribution == "on_off":
            return None
        share = self.value("amplitude", point) ** 2 * self.share
        return share / 2.0 if self._of_half() else share

    def _of_half(self) -> bool:
        """Whether half of the pixels of a block have it."""
        return self.where == "block" and self.mask != "all" and self.height == self.width == 2


def form_of(where: str) -> Callable[..., np.ndarray]:
    """The function that makes a geometry."""
    return FORMS[where] if where in FORMS else ECHOES[where]


def changed(
    effect: Any, signal: np.ndarray, site: Site, form: Callable[..., np.ndarray]
) -> np.ndarray:
    """The signal with the effect, its pattern made by ``form``."""
    law = factor(effect, site)
    if effect.where == "row_before":
        size = np.float32(effect.value("gain", site.point) * law)
        return signal + size * form(signal)
    if effect.when == "fixed":
        pattern = site.keep("pattern", lambda: form(effect, site))
    else:
        pattern = form(effect, site)
    if effect.what == "gain":
        size = np.float32(effect.value("gain", site.point) * law)
        signal *= np.float32(1.0) + size * pattern
        return signal
    size = np.float32(effect.value("amplitude", site.point) * law)
    if effect.what == "noise":
        signal += size * site.keep("root", lambda: root(effect, pattern)) * site.normal("noise")
    else:
        signal += size * pattern
    return signal


def factor(effect: Any, site: Site) -> float:
    """Growth from the reference to this operating point by the effect's law."""
    if effect.law == "gain":
        return site.gain_ratio
    if effect.law == "exposure":
        return site.exposure_ratio
    if effect.law == "thermal":
        return site.exposure_ratio * site.thermal(effect.value("ea_ev", site.point))
    return 1.0


def root(effect: Any, pattern: np.ndarray) -> np.ndarray:
    """Standard deviation of the noise over the pixels, for an rms of 1 where it is all over."""
    if effect.where in ("wave", "rings"):
        weight = 1.0 + pattern / np.float32(math.sqrt(2.0))
    elif effect.where == "surface":
        weight = 1.0 + pattern / np.float32(peak(effect))
    elif effect.where == "blob":
        weight = pattern
    else:
        weight = pattern * pattern
    return np.sqrt(np.maximum(weight, np.float32(0.0)))


def peak(effect: Any) -> float:
    """Largest size of the normalised surface, on a lattice over the frame."""
    grid = np.arange(64)
    whole = polynomial(effect, grid, grid, (64, 64))
    made = (whole - whole.mean()) / whole.std()
    return float(np.abs(made).max())
