"""First guesses of row_noise: its strength, and the rows that are converted at a time.

Rows of a group share an offset, so that the correlation of two rows falls linearly with their
distance, to 0 at the size of the group; the spectrum of the row means is a Fejér kernel. It is
compared with those of other row noise by Whittle's likelihood (Whittle, Ark. Mat. 2, 423 (1953)).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import median_filter

from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.row_noise import TOGETHER, RowNoise
from dnanalyze.model.guesses import white_lines
from dnanalyze.model.guesses.evidence import curve
from dnanalyze.model.serial import sizes
from dnanalyze.significance import EVIDENCE_NULL

FEWEST_MODES = 32  # 8 to the narrowest feature of a kernel, 1/8 cycle/row
# Of two frames a white mode has an exponential power: one of 2^6 lies beyond 6 medians by chance
NEAR, LINE = 9, 6.0  # modes, and times their median: what is stronger is a line of a pattern
# Other rows that are alike, with the row before or the one before that: autoregressive, or a moving
# average of two, as `serial` and `serial2` have it; and 1/f noise
SHARES = (-0.8, -0.5, -0.2, 0.2, 0.5, 0.8, 0.95)
CORRELATIONS = (-0.45, -0.3, -0.15, 0.15, 0.3, 0.45)
SLOPES = (0.5, 1.0, 1.5)
# Share of the pixels, whose noise is white, in the power of the rows, in steps of 7.5 %
WHITE = np.geomspace(1e-4, 1.0, 128)
# Of the noise of the pixels, that of other frequencies is known to this: with a correlation of .1
# along the row, it differs by 20 % at the lowest
KNOWN = 1.25


@dataclass(frozen=True)
class Spectrum:
    """Mean power of the row means, DN^2, of ``repeats`` independent spectra, at ``v``, cycles/row.

    ``pixels``: of which the noise of single pixels has so much at every frequency.
    """

    v: np.ndarray
    power: np.ndarray
    repeats: int
    pixels: float


def guess(effect: type[RowNoise], clues: Clues) -> list[Effect]:
    """Sigma from the unexplained power of the rows; groups where the spectrum is that of groups."""
    found = [each for each in white_lines.guess(effect, clues) if isinstance(each, RowNoise)]
    together = rows_together(clues) if found else TOGETHER[0]
    return [replace(each, together=together) for each in found]


def rows_together(clues: Clues) -> str:
    """Rows of a group x interleaved banks, as `row_noise` has it, by the measured spectra."""
    spectra = [s for n in range(len(clues.points)) if (s := _spectrum(clues, n)) is not None]
    if not spectra:
        return TOGETHER[0]
    misfits = np.sum([[deviance(s, shape) for shape in _shapes(s.v)] for s in spectra], axis=0)
    best, freedom = int(np.argmin(misfits)), sum(s.v.size - 2 for s in spectra)
    overdispersion = max(1.0, float(misfits[best]) / freedom)
    ahead = float(np.delete(misfits, best).min() - misfits[best])
    sure = best < len(TOGETHER) and ahead > EVIDENCE_NULL * overdispersion
    return TOGETHER[best] if sure else TOGETHER[0]


def kernel(v: np.ndarray, together: str) -> np.ndarray:
    """Spectrum of the offsets of groups, of variance 1, at frequencies ``v``, cycles/row."""
    rows, banks = sizes(together)
    lags = np.arange(1, rows)
    waves = np.cos(2.0 * np.pi * banks * lags[:, None] * v)
    return np.asarray(1.0 + 2.0 * (1.0 - lags / rows) @ waves)


def deviance(seen: Spectrum, shape: np.ndarray) -> float:
    """Gamma deviance of a spectrum from the nearest one of this shape beside that of the pixels."""
    white = WHITE[:, None]
    ratio = seen.power / (white + (1.0 - white) * shape / shape.mean())
    size = ratio.mean(axis=1)  # the most likely one of each mixture
    off = np.abs(np.log(WHITE * size / seen.pixels))
    near = off <= max(math.log(KNOWN), off.min())
    ratio = ratio[near] / size[near, None]
    return float(2.0 * seen.repeats * np.sum(ratio - 1.0 - np.log(ratio), axis=1).min())


def _spectrum(clues: Clues, setting: int) -> Spectrum | None:
    """Of one operating point, without narrow lines; None where it tells nothing of groups."""
    names = "temporal_row_spectrum", "row_spectrum_f", "frame_means"
    power, v, means = (curve(clues, name, setting) for name in names)
    rows, columns = clues.shape
    pixels = columns * float(clues.measured("temporal_row_mean_explained")[setting]) ** 2
    if power is None or v is None or means is None or means.size < 2 or not pixels > 0:
        return None
    if v.size < rows // 3:  # a colour has every other row: of which group is not told
        return None
    good = (power > 0) & (power < LINE * median_filter(power, NEAR, mode="nearest")) & (v > 0)
    if good.sum() < FEWEST_MODES:
        return None
    return Spectrum(v[good], power[good], means.size - 1, pixels)


def _shapes(v: np.ndarray) -> list[np.ndarray]:
    """Spectra of groups, in the order of `TOGETHER`, and of rows that are alike without groups."""
    waves = [np.cos(2.0 * np.pi * rows * v) for rows in (1, 2)]
    return [
        *(kernel(v, t) for t in TOGETHER),
        *(1.0 / (1.0 + a * a - 2.0 * a * wave) for wave in waves for a in SHARES),
        *(1.0 + 2.0 * r * wave for wave in waves for r in CORRELATIONS),
        *(v**-slope for slope in SLOPES),
    ]
