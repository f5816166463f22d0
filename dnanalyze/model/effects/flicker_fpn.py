"""Fixed pattern with a 1/f spectrum in two dimensions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.loaders.captures import OperatingPoint, Window
from dnanalyze.model import pink
from dnanalyze.model.effect import Site, Stage, choice, parameter
from dnanalyze.model.fingerprints import BANDS, named
from dnanalyze.model.readout_effect import ADDED, ReadoutEffect


@dataclass(frozen=True)
class FlickerFpn(ReadoutEffect):
    """y += pink field of the silicon, power rho^-alpha, or h times 1 + such a field."""

    name: ClassVar[str] = "flicker_fpn"
    stage: ClassVar[Stage] = Stage.LINE_READ
    varies: ClassVar[str] = "fixed"
    summary: ClassVar[str] = (
        "Fixed low-frequency pattern: offsets with 1/f power in both directions."
    )
    physics: ClassVar[str] = (
        "Thresholds, layer thicknesses and stress vary over a chip at all lengths, slow "
        "variations most. The resulting offsets have a power that falls as rho^-alpha with "
        "spatial frequency, equally along rows and columns. The slope remains when the axes u "
        "= 0 and v = 0 are left out; the slope that row and column offsets cause does not. "
        "The offsets do not depend on temperature or exposure, and are proportional to the "
        "analog gain. Where the silicon itself is uneven (thinning, resistivity, stress), the "
        "dark current has such a pattern instead, as a share of itself (`form`: scaled). No "
        "random 3x3 kernel can make such a slope at low frequency. Remedy: subtract a master "
        "dark; blocks of black pixels cannot follow it."
    )
    formula: ClassVar[str] = (
        "S(rho) = C rho^-alpha, rho in cycles/pixel, without the mean; sum of S = rms^2; "
        "scaled: y (1 + field), rms as a share"
    )
    references: ClassVar[tuple[str, ...]] = (
        "Rauscher, Teledyne H1RG, H2RG and H4RG noise generator (picture frame), PASP 127, 1144 "
        "(2015)",
    )
    fingerprint: ClassVar[tuple[str, ...]] = (
        *named("pattern_psd", BANDS[:5]), "shading_mid", "pattern_u_0_0.03", "pattern_v_0_0.03",
    )  # fmt: skip
    confused_with: ClassVar[dict[str, str]] = {
        "column_fpn": "all of its power lies on the v = 0 axis and vanishes under the mask",
        "dark_gradient": "a few orders of shading only, and grows with exposure and temperature",
        "dark_shading": "shading of the dark current grows with exposure and temperature",
        "offset_gradient": "a plane and a bowl only: no power above order 2",
        "amp_glow": "falls off from a corner or an edge, grows with exposure",
        "flicker_noise": "new in every frame, smooth along rows only",
        "crosstalk": "lowers high frequencies, leaves the lowest flat",
    }

    rms: float = parameter(0.5, "DN", 1e-4, 1e3, "standard deviation over a frame")
    alpha: float = parameter(1.0, "1", 0.3, 4.0, "exponent of the power spectrum", "linear")
    form: str = choice("added", "an offset, or a share of the dark signal", "added", "scaled")
    added: str = choice("before", ADDED, "before", "after")

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Add the field."""

        def make() -> np.ndarray:
            stream = site.fixed_stream.child("field")
            whole = Window.whole(site.shape)
            if site.window == whole:
                white = site.field(stream, "normal")
            else:
                white = stream.normal(whole, site.shape[1])
            return pink.field(white, self.value("alpha", site.point))

        rms = np.float32(self.value("rms", site.point))
        if self.form == "scaled":
            signal *= site.keep(
                "map",
                lambda: np.maximum(1.0 + rms * site.share("field", make)[site.window.slices], 0.0),
            )
            return signal
        rms *= np.float32(self.amplified(site))
        signal += site.keep("map", lambda: rms * site.share("field", make)[site.window.slices])
        return signal

    def variance(self, point: OperatingPoint) -> float | None:
        """rms^2, DN^2."""
        if self.form == "scaled":
            return None  # a share of a signal that is not known here
        return self.value("rms", point) ** 2
