"""Multiplication of codes after the converter."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect, Site, Stage, parameter
from dnanalyze.model.evidence import bounded, curve, shows

_GAINS = np.concatenate([np.arange(0.5, 2.0, 5e-4), np.arange(2.0, 4.0005, 1e-3)])
_PHASES = np.arange(0.0, 1.0, 0.05)


@dataclass(frozen=True)
class DigitalGain(Effect):
    """y = round((y - b) s + b) on codes."""

    name: ClassVar[str] = "digital_gain"
    stage: ClassVar[Stage] = Stage.DIGITAL
    varies: ClassVar[str] = "digital"
    summary: ClassVar[str] = (
        "Codes multiplied after the converter: gaps or spikes in the histogram."
    )
    physics: ClassVar[str] = (
        "A gain applied to codes, in the sensor or in the camera, brings no information: with s > "
        "1 some codes are never reached (gaps, one in s/(s-1)), with s < 1 several codes fall "
        "together (spikes, one in s/(1-s)). Noise and dark signal grow by s alike, so only the "
        "histogram tells. It is exact, the same at every temperature, and changes with the gain "
        "setting where the camera makes up its upper gains this way. Cure: divide by s and round; "
        "use analogue gain instead."
    )
    formula: ClassVar[str] = "y = round((x - b) s + b), x and y whole numbers"
    references: ClassVar[tuple[str, ...]] = ()
    fingerprint: ClassVar[tuple[str, ...]] = ("code_comb", "unused_codes", "code_roughness")
    confused_with: ClassVar[dict[str, str]] = {
        "missing_codes": "irregular widths, or a period that is a power of two; the pattern is "
        "fixed to the codes, and widths take all values",
        "quantization": "a coarse step leaves all codes but every n-th empty: s a whole number",
    }

    gain: float = parameter(1.25, "1", 0.5, 4.0, "factor s", "linear")
    offset: float = parameter(
        0.0, "DN", -1e5, 1e5, "code b that maps to itself, commonly the black level", "linear"
    )

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Multiply and round."""
        s, b = self.value("gain", site.point), self.value("offset", site.point)
        return np.rint(signal * np.float32(s) + np.float32(b * (1.0 - s)))

    @classmethod
    def guess(cls, clues: Clues) -> list[Effect]:
        """The factor whose gaps and spikes fit the histogram best; b is the lowest mean level."""
        if not shows(clues, cls.fingerprint):
            return []
        found = []
        for setting in range(len(clues.points)):
            codes = curve(clues, "histogram_codes", setting)
            counts = curve(clues, "histogram_counts", setting)
            if codes is not None and counts is not None and np.sum(counts > 0) > 4:
                found.append(_ripple(codes, counts))
        gain = _best_gain(found)
        if gain is None:
            return []
        level = np.asarray(clues.measured("mean"), float)
        level = level[np.isfinite(level)]
        offset = round(float(level.min())) if level.size else 0.0
        return [cls(bounded(cls, "gain", gain), bounded(cls, "offset", offset))]


def _ripple(codes: np.ndarray, counts: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Codes of the histogram's body, its ratio to a smooth curve less 1, and weights."""
    first, last = int(codes.min()), int(codes.max())
    full = np.zeros(last - first + 1)
    full[np.asarray(codes, int) - first] = counts
    body = np.cumsum(full) / full.sum()
    a, b = np.searchsorted(body, [0.005, 0.995])
    half = max(3, (b - a) // 12)
    kernel = np.convolve(np.ones(half), np.ones(half)) / half**2
    smooth = np.convolve(np.pad(full, half - 1), kernel, "valid")
    full, smooth = full[a : b + 1], np.maximum(smooth[a : b + 1], 1e-9)
    return np.arange(first + a, first + b + 1), full / smooth - 1.0, smooth / smooth.sum()


def _best_gain(ripples: list[tuple[np.ndarray, np.ndarray, np.ndarray]]) -> float | None:
    """Factor whose expected ripple agrees best, after a scan of the coherence at 1/s.

    The coherence |sum w(c) ripple(c) exp(2 pi i c / s)| is the same for all s whose 1/s differ by a
    whole number or in sign, so the candidates are then held against the ripple that each makes.
    """
    if not ripples:
        return None
    coherence = np.zeros(_GAINS.size)
    for codes, ripple, weight in ripples:
        wave = np.exp(2j * np.pi * np.outer(1.0 / _GAINS, codes - codes[0]))
        coherence += np.abs(wave @ (weight * ripple)) ** 2
    order = np.argsort(-coherence)[:200]
    scores = [sum(_agreement(_GAINS[i], *r) for r in ripples) / len(ripples) for i in order]
    best = int(np.argmax(scores))
    return float(_GAINS[order[best]]) if scores[best] > 0.3 else None


def _agreement(gain: float, codes: np.ndarray, ripple: np.ndarray, weight: np.ndarray) -> float:
    """Correlation of the ripple with the one that a factor makes, at its best phase."""
    low = np.ceil((codes[None, :] - 0.5 - _PHASES[:, None]) / gain)
    high = np.ceil((codes[None, :] + 0.5 - _PHASES[:, None]) / gain)
    expected = (high - low) * gain - 1.0
    expected -= (expected @ weight)[:, None]
    seen = ripple - ripple @ weight
    scale = np.sqrt((expected**2 @ weight) * (seen**2 @ weight))
    good = scale > 1e-9
    fit = np.zeros(_PHASES.size)
    fit[good] = (expected @ (weight * seen))[good] / scale[good]
    return float(fit.max())
