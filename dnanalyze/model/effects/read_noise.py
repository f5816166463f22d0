"""White Gaussian noise of the readout, new in every frame."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model import draws, hints
from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect, Site, Stage, parameter
from dnanalyze.model.evidence import shows


@dataclass(frozen=True)
class ReadNoise(Effect):
    """y += sigma_i N(0,1), new in every frame; sigma_i = sigma e^(s n_i - s^2)."""

    name: ClassVar[str] = "read_noise"
    stage: ClassVar[Stage] = Stage.PIXEL_READ
    varies: ClassVar[str] = "temporal"
    summary: ClassVar[str] = "white Gaussian noise of the readout, the same at every temperature"
    physics: ClassVar[str] = (
        "The pixel's amplifier and the converter add noise each time a pixel is read: thermal "
        "noise of the source follower, reset (kTC) noise that correlated double sampling left, "
        "converter noise. It is new in every frame, white over the field, and does not grow with "
        "exposure or temperature, so it is what remains in the coldest and shortest frames. In "
        "DN it grows with the analogue gain. In CMOS sensors each pixel has its own transistor, "
        "so the sigma itself may spread over pixels (`spread`). Where one amplifier reads pixel "
        "after pixel, as in a CCD, double sampling and a limited bandwidth carry some of it over "
        "to the next pixel of the row (`serial`, either sign). Averaging K frames divides it by "
        "sqrt(K); a higher analogue gain lowers it in electrons."
    )
    formula: ClassVar[str] = (
        "y_i += sigma e^(s n_i - s^2) N(0,1), n_i ~ N(0,1) fixed; rms over pixels = sigma; "
        "next pixels of a row correlated by r, those farther apart not"
    )
    references: ClassVar[tuple[str, ...]] = (
        "EMVA Standard 1288, release 4.0",
        "Wei et al., ELD: extreme low-light denoising (read-noise priors)",
    )
    fingerprint: ClassVar[tuple[str, ...]] = (
        "temporal_noise_core",
        "temporal_noise",
        "noise_at_50",
        "temporal_psd_0.25_0.35",
    )
    confused_with: ClassVar[dict[str, str]] = {
        "dark_shot_noise": (
            "shot variance grows in proportion to the dark signal; read noise does not move"
        ),
        "heavy_tailed_read_noise": (
            "the temporal kurtosis of single pixels is 0 for Gaussian read noise"
        ),
        "rts": "an RTS pixel returns to the same two levels; its squared differences repeat",
        "quantization": "rounding adds 1/12 DN^2 and leaves integer codes",
    }

    sigma: float = parameter(1.0, "DN", 1e-3, 1e4, "standard deviation at the reference gain")
    spread: float = parameter(
        0.0, "1", 0.0, 1.5, "spread over pixels of the log of the standard deviation", "linear"
    )

    serial: float = parameter(
        0.0, "1", -0.45, 0.45, "correlation with the pixel read before, in the same row", "linear"
    )

    def idle(self) -> tuple[str, ...]:
        """The correlation where there is none: pixels that are read side by side have none."""
        return ("serial",) if self.serial == 0 else ()

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Add the noise."""
        sigma = self.value("sigma", site.point) * site.gain_ratio
        spread = np.float32(self.value("spread", site.point))
        key = site.moment.child("").key
        serial = self.value("serial", site.point)
        if spread == 0 and serial == 0:
            return draws.add_normal(signal, sigma, key, site.window, site.shape[1])
        each = site.keep(
            "map", lambda: np.float32(sigma) * np.exp(spread * (site.fixed_normal() - spread))
        )
        signal += each * (site.normal() if serial == 0 else _one_after_another(serial, key, site))
        return signal

    def variance(self, point: OperatingPoint) -> float:
        """sigma^2, DN^2, at the reference gain; the spread keeps the mean square."""
        return self.value("sigma", point) ** 2

    @classmethod
    def guess(cls, clues: Clues) -> list[Effect]:
        """From the unexplained temporal variance of the least noisy settings."""
        if not shows(clues, cls.fingerprint):
            return []
        gain = hints.gains(clues)
        lost = hints.unexplained_variance(clues, "temporal_noise_core") / gain**2
        total = np.asarray(clues.measured("temporal_noise_core"), float) / gain
        good = lost[np.isfinite(lost) & (lost > 0)]
        if good.size:
            sigma = float(np.sqrt(np.median(good)))
        elif np.isfinite(total).any():
            sigma = 0.7 * float(np.nanmin(total))
        else:
            return []
        return [cls(**hints.clip(cls, sigma=sigma))]


def _one_after_another(correlation: float, key: int, site: Site) -> np.ndarray:
    """Standard normals, float32, of which next ones in a row are correlated (moving average).

    (z_c + s z_(c-1)) / sqrt(1 + s^2) has the correlation s / (1 + s^2); the first of a row has
    none before it.
    """
    share = (1.0 - np.sqrt(1.0 - 4.0 * correlation**2)) / (2.0 * correlation)
    window = site.window
    left = max(0, window.left - 1)
    field = draws.normal(key, replace(window, left=left), site.shape[1])
    mixed = field * np.float32(1.0 / np.sqrt(1.0 + share**2))
    mixed[:, 1:] += np.float32(share / np.sqrt(1.0 + share**2)) * field[:, :-1]
    if left == 0:
        mixed[:, 0] = field[:, 0]
    return mixed[:, window.left - left :]
