"""First guesses of black_clipping: its parameters as the statistics suggest them."""

from __future__ import annotations

import numpy as np

from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.black_clipping import BlackClipping
from dnanalyze.model.guesses.evidence import histogram, shows, strongest


def guess(effect: type[BlackClipping], clues: Clues) -> list[Effect]:
    """The lowest code where it is a spike, or holds a larger share than the model's lowest."""
    share, model = (np.nan_to_num(of("clipped_low")) for of in (clues.measured, clues.simulated))
    if not (shows(clues, ["low_spike"]) or np.any(share > 3.0 * model + 1e-3)):
        return []
    setting = int(np.argmax(share)) if share.any() else strongest(clues, ["low_spike"]) or 0
    seen = histogram(clues, "histogram", setting)
    if seen is None:
        return [effect()]
    lowest = float(np.min(seen[0][seen[1] > 0]))
    return [effect.within(level=lowest)]
