"""First guesses of quantization: its parameters as the statistics suggest them."""

from __future__ import annotations

import numpy as np

from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.quantization import Quantization
from dnanalyze.model.guesses.evidence import histogram, shows


def guess(effect: type[Quantization], clues: Clues) -> list[Effect]:
    """Integer frames where the model's are not; range and step from the codes that occur."""
    if not shows(clues, ("lattice",)):
        return []
    top, step = 0, 0
    for setting in range(len(clues.points)):
        found = histogram(clues, "histogram", setting)
        seen = np.empty(0) if found is None else found[0][found[1] > 0]
        if not seen.size or not np.all(seen == np.rint(seen)):
            continue
        top = max(top, int(seen.max()))
        step = int(np.gcd.reduce(np.r_[step, seen.astype(np.int64)]))
    # a top code of all ones is the converter's end; any other says nothing of the range
    bits = top.bit_length() if top >= 255 and top & (top + 1) == 0 else 16
    while 2**bits <= top:
        bits += 1
    power = step & -step if step else 1
    return [effect(bits=bits, step=power if power in effect.parameters()["step"].choices else 1)]
