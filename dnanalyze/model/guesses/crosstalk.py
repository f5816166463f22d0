"""First guesses of crosstalk: its parameters as the statistics suggest them."""

from __future__ import annotations

from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.crosstalk import Crosstalk
from dnanalyze.model.guesses.evidence import excess, known, shows


def guess(effect: type[Crosstalk], clues: Clues) -> list[Effect]:
    """Half the unexplained correlation of neighbours in the setting where it is largest.

    The same along rows and columns, and as the correlations along them differ there.
    """
    if not shows(clues, effect.fingerprint):
        return []
    shares = [(float(v), 0.0) for v in known(excess(clues, "hot_halo"))]
    for family in ("temporal", "pattern"):
        along, across = (excess(clues, f"{family}_corr_{lag}") / 2 for lag in ("10", "01"))
        mean, differ = (along + across) / 2, (along - across) / 2
        shares += [(float(m), float(d)) for m, d in zip(mean, differ, strict=True) if m > 0]
    alpha, differs = max(shares, default=(0.0, 0.0))
    if alpha <= 0:
        return []
    forms = ((0.25, 0.0), (1.0, 0.0), (0.25, differs / alpha))
    return [effect.within(alpha=alpha, diagonal=d, anisotropy=a) for d, a in forms]
