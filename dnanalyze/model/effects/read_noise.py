"""White Gaussian noise of the readout, new in every frame."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model import draws
from dnanalyze.model.effect import Effect, Placing, Site, Stage, choice, parameter
from dnanalyze.model.serial import averaged, moving_average, sizes


@dataclass(frozen=True)
class ReadNoise(Effect):
    """y += sigma_i N(0,1), new in every frame; sigma_i = sigma e^(s n_i - s^2)."""

    name: ClassVar[str] = "read_noise"
    stage: ClassVar[Stage] = Stage.PIXEL_READ
    varies: ClassVar[str] = "temporal"
    placing: ClassVar[Placing] = Placing.EVERYWHERE
    summary: ClassVar[str] = "white Gaussian noise of the readout, the same at every temperature"
    physics: ClassVar[str] = (
        "The pixel's amplifier and the converter add noise each time a pixel is read: thermal "
        "noise of the source follower, reset (kTC) noise that correlated double sampling left, "
        "converter noise. It is new in every frame, white over the field, and does not grow with "
        "exposure or temperature, so it is what remains in the coldest and shortest frames. In "
        "DN it grows with the analog gain. In CMOS sensors each pixel has its own transistor, "
        "so sigma may differ from pixel to pixel (`spread`). Small pixels share one (`shared`): "
        "sigma, and the noisy pixels and telegraph signals of the readout, are then common to "
        "1 x 2, 2 x 1 or 2 x 2 of them, while the noise of each is its own, since they are read "
        "one after the other. Where one amplifier reads pixel "
        "after pixel, as in a CCD, double sampling and a limited bandwidth carry some of it over "
        "to the next pixel of the row (`serial`, either sign) and to the one after it "
        "(`serial2`). What is added after the analog gain (`converter`), by the line driver and "
        "the converter, is the same in DN at every gain; captures of two gains tell it apart. "
        "Averaging K frames divides it by sqrt(K); a higher analog gain lowers it in electrons."
    )
    formula: ClassVar[str] = (
        "y_i += sqrt((G sigma)^2 e^(2 s n_i - 2 s^2) + c^2) N(0,1), G the analog gain over that of "
        "the reference, n_i ~ N(0,1) fixed, one an amplifier; "
        "pixels of a row that are read one after the other correlated by r_1, those two apart by "
        "r_2, those farther apart not"
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
            "shot variance grows in proportion to the dark signal; read noise does not"
        ),
        "heavy_tailed_read_noise": (
            "the temporal kurtosis of single pixels is 0 for Gaussian read noise"
        ),
        "transfer_tails": "deferred charge correlates the noise of the charge, not that of cold "
        "frames",
        "serial_noise": "correlated farther along the row than with the next two pixels",
        "noisy_pixels": "a second population of pixels, not a log-normal spread of all",
        "rts": "an RTS pixel returns to the same two levels; its squared differences repeat",
        "quantization": "rounding adds 1/12 DN² and leaves integer codes",
    }

    sigma: float = parameter(1.0, "DN", 1e-3, 1e4, "standard deviation at the reference gain")
    spread: float = parameter(
        0.0, "1", 0.0, 1.5, "standard deviation over the pixels of ln(sigma)", "linear"
    )

    serial: float = parameter(
        0.0, "1", -0.45, 0.45, "correlation with the pixel read before, in the same row", "linear"
    )
    serial2: float = parameter(
        0.0, "1", -0.45, 0.45, "correlation with the pixel read before that one", "linear"
    )
    converter: float = parameter(
        0.0, "DN", 0.0, 1e4, "standard deviation of what is added after the analog gain", "linear"
    )
    shared: str = choice(
        "1x1", "rows x columns of pixels that share an amplifier, from the corner of the frame",
        "1x1", "1x2", "2x1", "2x2",
    )  # fmt: skip

    @property
    def shared_pixels(self) -> tuple[int, int]:
        """Rows and columns of the pixels that share an amplifier."""
        return sizes(self.shared)

    def inactive_parameters(self) -> tuple[str, ...]:
        """Correlations where there are none; noise after the gain, which one gain does not tell."""
        return tuple(n for n in ("serial", "serial2", "converter") if getattr(self, n) == 0)

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Add the noise."""
        sigma = self.value("sigma", site.point) * site.gain_ratio
        converter = self.value("converter", site.point)
        spread = np.float32(self.value("spread", site.point))
        key = site.frame_stream.child("").key
        serial = self.value("serial", site.point), self.value("serial2", site.point)
        if spread == 0 and not any(serial):
            total = math.hypot(sigma, converter)
            return draws.add_normal(signal, total, key, site.window, site.shape[1])

        def of_pixels() -> np.ndarray:
            own = np.float32(sigma) * np.exp(spread * (site.amplifiers("normal") - spread))
            return np.hypot(own, np.float32(converter)) if converter else own

        each = site.keep("map", of_pixels)
        signal += each * (_one_after_another(serial, key, site) if any(serial) else site.normal())
        return signal

    def variance(self, point: OperatingPoint) -> float:
        """Of both sources, DN^2, at the reference gain; the spread keeps the mean square."""
        return self.value("sigma", point) ** 2 + self.value("converter", point) ** 2


def _one_after_another(correlations: tuple[float, float], key: int, site: Site) -> np.ndarray:
    """Standard normals, float32, correlated along a row at lags 1 and 2 (moving average).

    The first two of a row have none, or one, before them.
    """
    weights = moving_average(*correlations)
    window = site.window
    left = max(0, window.left - weights.size + 1)
    field = draws.normal(key, replace(window, left=left), site.shape[1])
    return averaged(field, weights, left == 0)[:, window.left - left :]
