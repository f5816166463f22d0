"""Base of what the readout adds to lines or to the field: before the analog gain, or after it."""

from __future__ import annotations

from dataclasses import dataclass, replace

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect, Site

ADDED = "where it is added: before the analog gain, or after it"


@dataclass(frozen=True)
class ReadoutEffect(Effect):
    """An offset or noise of the readout, with the choice ``added`` of "before" or "after".

    A pixel's source follower is before the analog gain, which amplifies what it adds; converters
    and line drivers are after it, and add the same in DN at every gain. Captures of one gain do not
    tell the two apart.
    """

    @classmethod
    def guess(cls, clues: Clues) -> list[Effect]:
        """Those of the effect; where there are several gains, each added after them too."""
        found = super().guess(clues)
        if len({point.gain for point in clues.points}) > 1:
            found = [*found, *(replace(e, added="after") for e in found)]  # type: ignore[call-arg]
        return found

    def amplification(self, point: OperatingPoint, reference: OperatingPoint) -> float:
        """Gain of a point over that of the reference, or 1."""
        if vars(self).get("added") == "after":
            return 1.0
        return super().amplification(point, reference)

    def amplified(self, site: Site) -> float:
        """`amplification` at a site."""
        return self.amplification(site.point, site.reference)
