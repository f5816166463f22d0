"""Noise of the readout that is coloured along the rows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy import fft

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import OperatingPoint, Window
from dnanalyze.model.effect import Placing, Site, Stage, choice, parameter
from dnanalyze.model.readout_effect import ADDED, ReadoutEffect

CORNER = 0.05  # c/px, of the low pass that stands for bands that are not given
MOST_BANDS = 256
SETTLED = 4  # pixel periods a band of the spectrum from one row to the next: rows are independent


@dataclass(frozen=True)
class SerialNoise(ReadoutEffect):
    """y += sigma x; x a stationary process along each row, new in every row and frame."""

    name: ClassVar[str] = "serial_noise"
    stage: ClassVar[Stage] = Stage.LINE_READ
    varies: ClassVar[str] = "temporal"
    placing: ClassVar[Placing] = Placing.EVERYWHERE
    summary: ClassVar[str] = "Read noise that is coloured along the rows, rows independent."
    physics: ClassVar[str] = (
        "The pixels of a row pass one amplifier after the other. Its bandwidth, the filter before "
        "the converter and double sampling shape the spectrum of its noise: some is carried over "
        "to the pixels that follow, farther than to the next one or two. Interference whose phase "
        "is new in every row, since the clock of the rows is not locked to its source, is a raised "
        "band or a group of lines along the rows and is white across them. It is new in every "
        "frame, follows the analog gain and depends on neither temperature nor exposure. It shows "
        "as fine horizontal streaks. Averaging K frames divides its power by K. Remedies: a "
        "slower readout, shielding, supplies locked to the pixel clock, subtraction of reference "
        "pixels that are read at the same time."
    )
    formula: ClassVar[str] = (
        "y_ij += sigma x_ij, x_i a stationary Gaussian process along row i of power P(u), "
        "mean of P over u = 1: P is linear between the centers of equal bands from 0 to 1/2 "
        "cycles/pixel; rows are independent"
    )
    references: ClassVar[tuple[str, ...]] = (
        "EMVA Standard 1288, release 4.0 (horizontal spectrogram)",
        "Janesick, Photon Transfer, SPIE Press (2007) (bandwidth of the signal chain)",
    )
    fingerprint: ClassVar[tuple[str, ...]] = (
        "temporal_u_0.03_0.1", "temporal_u_0.1_0.3", "temporal_u_0.3_0.5", "temporal_u_0_0.03",
        "temporal_corr_10", "temporal_corr_20",
    )  # fmt: skip
    confused_with: ClassVar[dict[str, str]] = {
        "flicker_noise": "1/f noise goes on from one row to the next, as soft horizontal bands",
        "row_noise": "the offset of a row is the same in all of its pixels",
        "periodic_pattern": "the phase of a line is the same in all rows, or walks evenly",
        "read_noise": "white, or correlated with the next two pixels alone (`serial`)",
        "transfer_tails": "deferred charge correlates the noise of the charge, not that of the "
        "readout",
        "denoise": "a spatial filter acts along the columns too",
    }

    sigma: float = parameter(0.5, "DN", 1e-4, 1e4, "standard deviation")
    bands: tuple[float, ...] = choice(
        (),
        "relative power P in equal bands from 0 to 1/2 c/px, as measured; a low pass with a "
        f"corner at {CORNER:g} c/px where there are none",
    )
    added: str = choice("before", ADDED, "before", "after")

    def __post_init__(self) -> None:
        super().__post_init__()
        power = self._power()
        if power.size > MOST_BANDS or (power < 0).any() or not power.any():
            raise InputError(
                f"serial_noise.bands: {len(self.bands)} numbers; valid: up to {MOST_BANDS}, none "
                "below 0, one above 0"
            )

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Add the noise of this frame."""
        sigma = np.float32(self.value("sigma", site.point) * self.amplified(site))
        signal += sigma * self._rows(site)
        return signal

    def variance(self, point: OperatingPoint) -> float:
        """sigma^2, DN^2."""
        return self.value("sigma", point) ** 2

    def nuisance_bias(self, name: str, unit: str, noise: float = np.inf) -> tuple[float, float]:
        """A fit without it has its variance in the white read noise."""
        if name != "read_noise.sigma" or not np.isfinite(noise):
            return 1.0, 0.0
        share = self.variance(OperatingPoint()) / noise**2
        return float(np.sqrt(max(1.0 - share, 0.01))), 0.0

    def _power(self) -> np.ndarray:
        """P in its bands."""
        if self.bands:
            return np.array(self.bands)
        u = (np.arange(64) + 0.5) / 128
        return np.asarray(1.0 / (1.0 + (u / CORNER) ** 2))

    def _amplitudes(self, period: int) -> np.ndarray:
        """Of the modes k / period of a row, for `_rows`: unit variance, float32."""
        power = self._power()
        centre = (np.arange(power.size) + 0.5) / (2 * power.size)
        each = np.interp(np.arange(1, period // 2 + 1) / period, centre, power)
        level = np.interp(0.0, centre, power)
        total = level + 2.0 * each[:-1].sum() + each[-1]  # the last one is its own mirror image
        weights = np.sqrt(np.append(level, each) / (2.0 * total))
        weights[[0, -1]] *= np.sqrt(2.0)
        return weights.astype(np.float32)

    def _rows(self, site: Site) -> np.ndarray:
        """Rows of unit variance over the window, drawn in the frequency domain, float32."""
        window = site.window
        period = _fast_length(site.shape[1] + SETTLED * self._power().size)
        weights = site.share("amplitudes", lambda: self._amplitudes(period))
        whole = Window(window.top, window.bottom, 0, period)
        white = np.ascontiguousarray(site.frame_stream.child("rows").normal(whole, period))
        pairs = white.view(np.complex64)
        modes = np.empty((white.shape[0], weights.size), np.complex64)
        np.multiply(pairs, weights[1:], out=modes[:, 1:])
        modes[:, 0] = pairs[:, -1].imag * weights[0]  # that mode is real and leaves it over
        rows = fft.irfft(modes, n=period, axis=1, norm="forward")
        return np.asarray(rows[:, window.left : window.right])


def _fast_length(shortest: int) -> int:
    """The smallest of 2^n and 3 2^n, n > 0, that is no less: even, with a fast FFT."""
    power = max(8, 1 << (shortest - 1).bit_length())
    return 3 * power // 4 if 3 * power // 4 >= shortest else power
