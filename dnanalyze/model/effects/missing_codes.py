"""Unequal steps of the converter."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import Window
from dnanalyze.model import draws
from dnanalyze.model.effect import Effect, Placing, Site, Stage, choice, parameter

PERIODS = 2, 4, 8, 16, 32, 64
_BLOCK = 64  # codes; also a multiple of every period
_ORIGIN = 1 << 20  # so that negative codes have a place in the random line
_FARTHEST = _ORIGIN - 2 * _BLOCK  # no converter has codes beyond


@dataclass(frozen=True)
class MissingCodes(Effect):
    """Code k is given over a width 1 + d_k; the transfer is straight over blocks of 64 codes."""

    name: ClassVar[str] = "missing_codes"
    stage: ClassVar[Stage] = Stage.CODE_WIDTHS
    varies: ClassVar[str] = "digital"
    placing: ClassVar[Placing] = Placing.EVERYWHERE
    summary: ClassVar[str] = (
        "Some codes occur too often, others too rarely (differential nonlinearity)."
    )
    physics: ClassVar[str] = (
        "A converter's decision levels are not evenly spaced. A code whose step is wider by d "
        "(differential non-linearity, DNL) occurs 1 + d times as often; at d = −1 it never "
        "occurs. Mismatched capacitors of a successive-approximation converter, or "
        "interpolation in a ramp converter, repeat with a period of a power of two; other "
        "errors are random. The pattern is tied to the codes: it is the same at every "
        "temperature, and does not move with the mean dark signal. Remedy: dither by noise of "
        "more than half a DN, or a table of corrected levels."
    )
    formula: ClassVar[str] = (
        "y = k for T_k <= x < T_(k+1),  T_(k+1) - T_k = max(0, 1 + d_k), rms d = sigma;  random: "
        "T_k = k - 1/2 at multiples of 64, periodic: on average"
    )
    references: ClassVar[tuple[str, ...]] = (
        "IEEE Std 1241, Terminology and test methods for analog-to-digital converters",
    )
    fingerprint: ClassVar[tuple[str, ...]] = ("code_roughness", "unused_codes", "code_comb")
    confused_with: ClassVar[dict[str, str]] = {
        "digital_gain": "codes are never reached or twice as frequent, with a period s/(s-1) that "
        "need not be a power of two",
        "quantization": "all codes have the same width",
    }

    sigma: float = parameter(0.2, "1", 1e-3, 1.5, "rms of the relative width errors d_k")
    kind: str = choice("random", "every code its own, or a period", "random", "periodic")
    period: int = choice(4, "codes (periodic)", *PERIODS)
    widths: tuple[float, ...] = choice(
        (), "d_k over a period in proportion, from a code that is a multiple of it, as measured; "
        "drawn at random where there are none"
    )  # fmt: skip

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.widths and (len(self.widths) != self.period or np.ptp(self.widths) == 0):
            raise InputError(
                f"missing_codes.widths: {len(self.widths)} numbers for a period of {self.period}; "
                "give one a code, not all alike, or none"
            )

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """The code of every pixel."""
        seen = np.clip(signal.reshape(-1), -_FARTHEST, _FARTHEST)
        first = math.floor(float(seen.min()) / _BLOCK) - 1
        last = math.floor(float(seen.max()) / _BLOCK) + 1
        codes = draws.rank(seen, self._levels(site, first, last), first * _BLOCK)
        codes += first * _BLOCK - 1
        return codes.reshape(signal.shape)

    def _levels(self, site: Site, first: int, last: int) -> np.ndarray:
        """Lower ends T_k of the codes of blocks ``first`` to ``last``, float32."""
        sigma = self.value("sigma", site.point)
        stream = site.fixed_stream.child("widths")
        if self.kind == "periodic":
            d = np.array(self.widths, float)
            if not self.widths:
                d = stream.normal(Window(0, 1, 0, self.period), self.period).astype(float)
            d -= d.mean()
            d /= np.sqrt(np.mean(d**2))
            d = np.tile(d, (last - first + 1, _BLOCK // self.period))
        else:
            line = Window(0, 1, _ORIGIN + first * _BLOCK, _ORIGIN + (last + 1) * _BLOCK)
            d = stream.normal(line, 2 * _ORIGIN).astype(float).reshape(-1, _BLOCK)
            d -= d.mean(axis=1, keepdims=True)
        widths = np.maximum(0.0, 1.0 + sigma * d)
        widths *= _BLOCK / widths.sum(axis=1, keepdims=True)
        starts = np.cumsum(widths, axis=1) - widths
        if self.kind == "periodic":  # in place on average, so that the pedestal has no part in it
            starts -= np.mean(starts - np.arange(_BLOCK))
        starts += _BLOCK * np.arange(first, last + 1)[:, None] - 0.5
        return starts.reshape(-1).astype(np.float32)
