"""First guesses of serial_noise: the unexplained spectrum along the rows."""

from __future__ import annotations

import math

import numpy as np

from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.serial_noise import SerialNoise
from dnanalyze.model.guesses.evidence import curve, shows

BANDS = 32  # of 1/64 c/px: correlations of up to 32 pixels
# Quantile of the bands that is taken for white: of the least band another effect of the model may
# have too much. On a real camera with interference sigma would be 36 DN by the least band,
# and is 6.7 DN by this one.
FLOOR = 0.1
FEWEST_MODES = 4 * BANDS  # of a row


def guess(effect: type[SerialNoise], clues: Clues) -> list[Effect]:
    """Measured less modelled power along the rows, above its floor.

    The mean over the operating points, by their errors. What lies below the floor is white, and
    the white read noise has it.
    """
    if not shows(clues, effect.fingerprint, 0):
        return []
    every = range(len(clues.points))
    for part in ("temporal", "frame"):
        found = [s for n in every if (s := _excess(clues, part, n)) is not None]
        if found:
            break
    else:
        return []
    excess, weight = (np.array(each) for each in zip(*found, strict=True))
    mean = np.average(excess, axis=0, weights=weight)
    power = np.maximum(mean - np.quantile(mean, FLOOR), 0.0)
    size = float(power.mean())
    if size <= 0.0:
        return []
    bands = tuple(float(f"{p:.4g}") for p in power / size)
    return [effect.within(sigma=math.sqrt(size), bands=bands)]


def _excess(clues: Clues, part: str, setting: int) -> tuple[np.ndarray, float] | None:
    """Unexplained power of each band, DN^2 at the reference gain, and its weight.

    None where the operating point has no such spectrum. ``part``: "temporal", or "frame" where no
    operating point has several frames.
    """
    name = f"{part}_horizontal_spectrum"
    seen = curve(clues, name, setting)
    if seen is None or seen.size < FEWEST_MODES:
        return None
    model = clues.modelled_curve(name, setting)
    gain = clues.points[setting].gain_over(clues.reference) ** 2
    where = np.linspace(0, seen.size, BANDS + 1).astype(int)[:-1]
    count = np.diff(np.append(where, seen.size))
    power = np.add.reduceat(seen - model, where) / count / gain
    return power, (gain / float(np.mean(seen))) ** 2
