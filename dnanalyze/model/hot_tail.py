"""What hot pixels and hot clusters share: how far their signal reaches."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from dnanalyze.model.effect import Effect, Site
from dnanalyze.model.laws import Law, scaled

HEAVY = 0.5  # exponent from which a heavy tail is tried


class HotTail(Effect):
    """An extra dark signal that is exponential over its pixels, or has a power-law tail."""

    scale: Law
    ea_ev: Law
    tail: Law

    def inactive_parameters(self) -> tuple[str, ...]:
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
