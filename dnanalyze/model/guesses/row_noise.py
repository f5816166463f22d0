"""First guesses of row_noise: its strength, and the rows that are converted at a time.

Rows of a group share an offset, so that the correlation of two rows falls linearly with their
distance, to 0 at the size of the group; the spectrum of the row means is a Fejér kernel. It is
compared with those of other row noise by Whittle's likelihood (Whittle, Ark. Mat. 2, 423 (1953)).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.ndimage import median_filter

from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.row_noise import TOGETHER, RowNoise
from dnanalyze.model.guesses import white_lines
from dnanalyze.model.guesses.evidence import curve
from dnanalyze.significance import EVIDENCE_NULL

FEWEST_MODES = 32  # of the spectrum: two of its lowest bands of 16 rows
NEAR, LINE = 9, 6.0  # modes, and times their median: what is stronger is a line of a pattern
# Other spectra of rows that are alike: none, neighbours (autoregressive, 1/f), two rows apart
ALIKE = (-0.8, -0.5, -0.2, 0.2, 0.5, 0.8, 0.95)
SLOPES = (0.5, 1.0, 1.5)
# Share of the pixels, whose noise is white, in steps of a factor of 1.3
WHITE = np.geomspace(1e-4, 1.0, 36)


def guess(effect: type[RowNoise], clues: Clues) -> list[Effect]:
    """Sigma from the unexplained power of the rows; groups where the spectrum is that of groups."""
    found = [each for each in white_lines.guess(effect, clues) if isinstance(each, RowNoise)]
    together = rows_together(clues) if found else TOGETHER[0]
    return [replace(each, together=together) for each in found]


def rows_together(clues: Clues) -> str:
    """Rows of a group x interleaved banks, as `row_noise` has it, by the measured spectra."""
    misfits = np.zeros(len(TOGETHER) + len(_others(np.ones(1))))
    freedom = 0
    for setting in range(len(clues.points)):
        names = "temporal_row_spectrum", "row_spectrum_f", "frame_means"
        power, v, means = (curve(clues, name, setting) for name in names)
        if power is None or v is None or means is None or means.size < 2:
            continue
        near = median_filter(power, NEAR, mode="nearest")
        good = (power > 0) & (power < LINE * near) & (v > 0)
        if good.sum() < FEWEST_MODES:
            continue
        power, v = power[good], v[good]
        shapes = [*(kernel(v, *sizes(t)) for t in TOGETHER), *_others(v)]
        misfits += [deviance(power, shape, means.size - 1) for shape in shapes]
        freedom += power.size - 2
    if not freedom:
        return TOGETHER[0]
    best = int(np.argmin(misfits))
    overdispersion = max(1.0, float(misfits[best]) / freedom)
    rest = np.delete(misfits, best).min() - misfits[best]
    sure = best < len(TOGETHER) and rest > EVIDENCE_NULL * overdispersion
    return TOGETHER[best] if sure else TOGETHER[0]


def sizes(together: str) -> tuple[int, int]:
    """Rows of a group, and banks."""
    rows, banks = together.split("x")
    return int(rows), int(banks)


def kernel(v: np.ndarray, rows: int, banks: int) -> np.ndarray:
    """Spectrum of the offsets of groups, of variance 1, at frequencies ``v``, cycles/row."""
    lags = np.arange(1, rows)
    waves = np.cos(2.0 * np.pi * banks * lags[:, None] * v)
    return np.asarray(1.0 + 2.0 * (1.0 - lags / rows) @ waves)


def deviance(power: np.ndarray, shape: np.ndarray, repeats: int) -> float:
    """Gamma deviance of a mean of ``repeats`` spectra from the nearest a + b shape; a, b >= 0."""
    white = WHITE[:, None]
    ratio = power / (white + (1.0 - white) * np.maximum(shape, 0.0) / shape.mean())
    ratio /= ratio.mean(axis=1, keepdims=True)  # the most likely size of either mixture
    return float(2.0 * repeats * np.sum(ratio - 1.0 - np.log(ratio), axis=1).min())


def _others(v: np.ndarray) -> list[np.ndarray]:
    """Spectra of rows that are alike without groups."""
    waves = [np.cos(2.0 * np.pi * rows * v) for rows in (1, 2)]
    near = [1.0 / (1.0 + r * r - 2.0 * r * wave) for wave in waves for r in ALIKE]
    return near + [v**-slope for slope in SLOPES]
