"""Hot pixels read off how many pixels stand out of the pattern, and how far."""

from __future__ import annotations

import numpy as np

from dnanalyze.loaders.thermometer import tells_slope
from dnanalyze.model.clues import Clues
from dnanalyze.model.guesses import hints
from dnanalyze.model.guesses.evidence import excess
from dnanalyze.model.hot_signal import HotSignal

THRESHOLDS = (5, 8, 16, 32, 64, 128)  # robust sigmas, as the statistics count them
USUAL = 0.55  # eV
ENERGIES = np.array([USUAL, *np.linspace(0.0, 1.5, 31)])  # eV; the first where none is told
REACHES = 0.3, 500.0, 60  # robust sigmas that the mean signal may be of, where it shows most
UNLIKE = 0.1  # share of a count by which no smooth tail is exact
TYPICAL = 1e-3, 30.0  # fraction of the pixels; mean signal in robust sigmas, where these are most


def hot_signals(clues: Clues) -> list[HotSignal]:
    """The unexplained hot pixels.

    Read in two ways, of all settings together and of each by itself: together they tell more,
    unless a correction has taken the hot pixels of some. Where it has taken those of all, the few
    that are left (neighbours of each other) tell nothing of the rest: as many as are usual.
    """
    readings = _of_all(clues), _of_each(clues), _typical(clues)
    return [hot for hot in readings if hot is not None]


def _of_all(clues: Clues) -> HotSignal | None:
    """One population at all settings: N p (e^(-a/nu) - e^(-b/nu)) pixels from a to b robust sigmas.

    nu goes by Arrhenius. Where counts show no excess none may reach, so a cold setting tells of the
    energy too. Temperatures too near each other for a slope tell none.
    """
    energies = ENERGIES if tells_slope(p.temperature_c for p in clues.points) else ENERGIES[:1]
    sigma = _sigma(clues)
    growth = hints.thermal_growth(clues, energies) * hints.exposure_and_gain(clues)
    extra, variance = _between(clues)
    usable = np.isfinite(sigma) & (sigma > 0) & np.isfinite(growth).all(axis=0)
    usable &= np.isfinite(extra).any(axis=0)
    if not usable.any():
        return None
    extra, variance, sigma, growth = (
        extra[:, usable],
        variance[:, usable],
        sigma[usable],
        growth[:, usable],
    )
    variance, extra = np.where(np.isfinite(extra), variance, np.inf), np.nan_to_num(extra)
    plainest = int(np.argmax(np.sum(extra / np.sqrt(variance), axis=0)))
    scales = np.geomspace(*REACHES) * sigma[plainest] / growth[:, [plainest]]
    beyond = np.exp(-np.array([*THRESHOLDS, np.inf])[:, None] * sigma
                    / (scales[..., None, None] * growth[:, None, None, :]))  # fmt: skip
    share = beyond[..., :-1, :] - beyond[..., 1:, :]  # (energies, scales, thresholds, settings)
    along = np.sum(share * extra / variance, axis=(-2, -1))
    square = np.maximum(np.sum(share**2 / variance, axis=(-2, -1)), 1e-30)
    energy, scale = np.unravel_index(np.argmax(np.maximum(along, 0.0) ** 2 / square), along.shape)
    pixels = float(along[energy, scale] / square[energy, scale])
    if pixels <= 0:
        return None
    fraction = pixels / float(np.prod(clues.shape))
    return HotSignal(fraction, float(scales[energy, scale]), float(energies[energy]))


def _of_each(clues: Clues) -> HotSignal | None:
    """A slope of log N(> k s) = log(N p) - k s/nu for each setting, then Arrhenius through nu."""
    sigma = _sigma(clues)
    extra = np.array([excess(clues, f"hot_count_{k}") for k in THRESHOLDS])
    amplitude, fractions = np.full(sigma.size, np.nan), []
    for j in range(sigma.size):
        good = np.isfinite(extra[:, j]) & (extra[:, j] >= 2)
        if not good.any() or not np.isfinite(sigma[j]):
            continue
        level, count = np.array(THRESHOLDS)[good] * sigma[j], extra[good, j]
        if good.sum() == 1:
            amplitude[j] = level[0]
        else:
            # line through the logs, each weighed by its count (the variance of a Poisson log)
            slope = np.polyfit(level, np.log(count), 1, w=np.sqrt(count))[0]
            amplitude[j] = -1.0 / slope if slope < 0 else 4 * level[-1]
        fractions.append((count[0], count[0] * np.exp(min(20.0, level[0] / amplitude[j]))))
    fitted = hints.thermal_fit(clues, amplitude / hints.exposure_and_gain(clues), USUAL)
    if fitted is None:
        return None
    fraction = float(max(fractions)[1]) / float(np.prod(clues.shape))
    return HotSignal(fraction, *fitted)


def _typical(clues: Clues) -> HotSignal | None:
    """As many as many sensors have, and as hot."""
    sigma = _sigma(clues) / hints.exposure_and_gain(clues)
    growth = hints.thermal_growth(clues, np.array([USUAL]))[0]
    if not np.isfinite(sigma).any():
        return None
    most = int(np.nanargmax(sigma))
    fraction, sigmas = TYPICAL
    return HotSignal(fraction, float(sigmas * sigma[most] / growth[most]), USUAL)


def _sigma(clues: Clues) -> np.ndarray:
    """Robust sigma of the pattern, DN, one a setting; of a frame where there is but one."""
    sigma = clues.measured("pattern_noise_core")
    return np.where(np.isfinite(sigma), sigma, clues.measured("frame_noise_core"))


def _between(clues: Clues) -> tuple[np.ndarray, np.ndarray]:
    """Unexplained pixels from each threshold to the next, with their variance, Poisson and more."""
    there, here = (
        -np.diff([np.asarray(side(f"hot_count_{k}"), float) for k in THRESHOLDS], axis=0, append=0)
        for side in (clues.measured, clues.simulated)
    )
    extra = there - here
    return extra, 1.0 + there + here + (UNLIKE * extra) ** 2
