"""What hot pixels and hot clusters share: how far their signal reaches, and how that is guessed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect, Site
from dnanalyze.model.evidence import excess
from dnanalyze.model.laws import Law, scaled

THRESHOLDS = (5, 8, 16, 32, 64, 128)
HEAVY = 0.5  # exponent from which a heavy tail is tried


class HotTail(Effect):
    """An extra dark signal that is exponential over its pixels, or has a power-law tail."""

    scale: Law
    ea_ev: Law
    tail: Law

    def idle(self) -> tuple[str, ...]:
        """The exponent of a tail that is exponential."""
        return ("tail",) if self.tail == 0.0 else ()

    def relatives(self) -> list[Effect]:
        """The heavy tail that has as much at a tenth of the pixels."""
        if self.tail != 0.0:
            return []
        ten = np.array(10.0)
        factor = float(amplitude(ten, 0.0) / amplitude(ten, HEAVY))
        scale = scaled(self.scale, factor)
        return [replace(self, tail=HEAVY, scale=scale)]  # type: ignore[call-arg]

    def scale_at(self, site: Site) -> float:
        """Scale of the signal at a site, DN: Arrhenius, in proportion to exposure and gain."""
        scale = self.value("scale", site.point) * site.thermal(self.value("ea_ev", site.point))
        return scale * (site.exposure_ratio * site.gain_ratio)


def amplitude(share: np.ndarray, tail: float) -> np.ndarray:
    """Quantile of the hot signal over its scale where ``1 / share`` of the hot pixels lie above.

    ln(share), exponential; with a tail s > 0 (share^s - 1) / s, generalised Pareto.
    """
    log = np.log(share)
    return log if tail == 0.0 else np.expm1(log.dtype.type(tail) * log) / log.dtype.type(tail)


def tail_of_counts(clues: Clues) -> tuple[float, np.ndarray] | None:
    """Fraction and mean amplitude (DN, one a setting) of the unexplained hot pixels.

    N(> k s) = N p e^(-k s/nu), with s the robust sigma of the pattern.
    """
    sigma = np.asarray(clues.measured("pattern_noise_core"), float)
    sigma = np.where(np.isfinite(sigma), sigma, clues.measured("frame_noise_core"))
    extra = np.array([excess(clues, f"hot_count_{k}") for k in THRESHOLDS])
    pixels = float(np.prod(clues.shape))
    amplitude = np.full(sigma.size, np.nan)
    fractions = []
    for j in range(sigma.size):
        good = np.isfinite(extra[:, j]) & (extra[:, j] >= 2)
        if not good.any() or not np.isfinite(sigma[j]):
            continue
        level = np.array(THRESHOLDS)[good] * sigma[j]
        count = extra[good, j]
        if good.sum() == 1:
            amplitude[j] = level[0]
        else:
            # line through the logs, each weighed by its count (the variance of a Poisson log)
            slope = np.polyfit(level, np.log(count), 1, w=np.sqrt(count))[0]
            amplitude[j] = -1.0 / slope if slope < 0 else 4 * level[-1]
        fractions.append((count[0], count[0] / pixels * np.exp(min(20.0, level[0] / amplitude[j]))))
    if not fractions:
        return None
    return float(max(fractions)[1]), amplitude
