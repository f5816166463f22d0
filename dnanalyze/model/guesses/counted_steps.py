"""A spacing and a mean number of equal steps, read off a histogram."""

from __future__ import annotations

import numpy as np

# Power of the characteristic function, times the count, from which its log is told
POWER_COUNTS = 12.0
LEAST_RIPPLE = 10.0  # standard errors by which the ripple stands out
NUMBERS = 0.02, 20.0  # steps a pixel: fewer leave one peak, more leave none
SPACINGS = 160  # tried, 2 % or less apart: a ripple of 10 periods is out of step by a fifth
SMOOTH = np.arange(1, 5)  # powers: a log-normal core has tails that no parabola has


def counted_steps(centres: np.ndarray, counts: np.ndarray) -> tuple[float, float] | None:
    """Spacing q and mean number of steps, where pixels have n q more with n ~ Pois(lambda).

    The characteristic function of the sum is the product of the core's and exp(lambda (e^(2 pi i f
    q) - 1)): its log power is a smooth function of f, and 2 lambda (cos(2 pi f q) - 1), a ripple
    whose period tells q and whose height lambda, however few peaks can be counted (the cepstrum;
    Bogert, Healy, Tukey, 1963). Few steps in many pixels make none that stands out; of
    many in each, the power between the ripples is lost in chance. A core as steep at its lower end
    as a step, a log-normal wider than .5 with next to no noise, has a ripple too, of some .1.

    Of a histogram of equal bins in its core; the spacing in DN. None where no ripple stands out.
    """
    total = float(np.sum(counts))
    width = float(np.min(np.diff(centres))) if centres.size > 2 else 0.0
    if total <= 0 or width <= 0:
        return None
    mean = float(np.sum(centres * counts) / total)
    low, high = np.interp([0.16, 0.84], np.cumsum(counts) / total, centres)
    spread = max((high - low) / 2.0, width)
    f = np.linspace(0.0, 0.5 / width, 2049)[1:]
    f = f[f < 4.0 / spread]
    wave = np.exp(-2j * np.pi * f[:, None] * (centres - mean)) @ counts / total
    power = total * np.abs(wave) ** 2
    lost = np.flatnonzero(power < POWER_COUNTS)
    f, power = (a[: lost[0] if lost.size else None] for a in (f, power))
    if f.size < 12:
        return None
    alike = max(1.0, f.size / (f[-1] * 6.0 * spread))  # neighbouring frequencies
    weight = np.sqrt(power / alike) / 2.0  # the error of a log power is 2 / sqrt(power)
    y = np.log(power / total)
    smooth = (f[:, None] / f[-1]) ** SMOOTH
    basis = np.linalg.qr(smooth * weight[:, None])[0]
    rest = y * weight - basis @ (basis.T @ (y * weight))
    best, steps = 0.0, None  # nearly a period of the ripple must be seen
    for q in np.geomspace(max(0.9 / f[-1], spread), 20.0 * spread, SPACINGS):
        ripple = 2.0 * (np.cos(2 * np.pi * f * q) - 1.0) * weight
        ripple = ripple - basis @ (basis.T @ ripple)
        square = float(ripple @ ripple)
        number = float(ripple @ rest) / max(square, 1e-12)
        if NUMBERS[0] < number < NUMBERS[1] and number * np.sqrt(square) > max(best, LEAST_RIPPLE):
            best, steps = number * np.sqrt(square), (float(q), number)
    return steps
