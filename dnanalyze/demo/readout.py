"""Hidden effects of the readout: columns, rows, taps, clocks and the amplifier's tails."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.signal import lfilter

from dnanalyze.demo.hidden import HiddenEffect, Moment, Scene, Step, of_noise
from dnanalyze.demo.sensor import WHITE_DN, VirtualSensor

Generator = np.random.Generator
Plain = dict[str, Any]


def _added(pattern: np.ndarray) -> Step:
    """A pattern that is the same in every frame, e-."""
    return Step("line", lambda y, now: y + pattern)


def _column_fpn(scene: Scene, rng: Generator, e: float) -> Step:
    """y += c_j, fixed."""
    return _added(e * rng.standard_normal((1, scene.shape[1])))


def _row_fpn(scene: Scene, rng: Generator, e: float) -> Step:
    """y += r_i, fixed."""
    return _added(e * rng.standard_normal((scene.shape[0], 1)))


def _column_gain(scene: Scene, rng: Generator, relative: float) -> Step:
    """y (1 + g_j)."""
    factor = 1.0 + relative * rng.standard_normal((1, scene.shape[1]))
    return Step("line", lambda y, now: y * factor)


def _row_draw(sensor: VirtualSensor, amount: float, rng: Generator) -> Plain:
    return of_noise(sensor, amount, rng) | {"apart": 0.0, "slope": 0.0, "at_once": 1, "banks": 1}


def _row_noise(
    scene: Scene, rng: Generator, e: float, apart: float, slope: float, at_once: int, banks: int
) -> Step:
    """y += r_i, new in each frame; every second column is read by a converter of its own.

    Its rows are those of the others by ``apart`` 0, independent by 1. ``slope``: standard deviation
    of the change from one end of a row to the other, over ``e``. ``at_once``: rows of each of the
    interleaved ``banks`` that are read at the same time.
    """
    odd = scene.column % 2 == 1
    along = (scene.column + 0.5) / scene.shape[1] - 0.5
    reads = -(-scene.shape[0] // (at_once * banks))

    def drawn(now: Moment) -> np.ndarray:
        each = now.rng.standard_normal((reads, 1, banks))
        return np.repeat(each, at_once, axis=1).reshape(-1, 1)[: scene.shape[0]]

    def apply(y: np.ndarray, now: Moment) -> np.ndarray:
        rows = drawn(now)
        offsets = rows
        if apart:
            offsets = np.where(odd, np.sqrt(1 - apart**2) * rows + apart * drawn(now), rows)
        if slope:
            offsets = offsets + slope * along * drawn(now)
        return y + e * offsets

    return Step("line", apply)


def _column_noise(scene: Scene, rng: Generator, e: float) -> Step:
    """y += c_j, new in each frame."""
    size = (1, scene.shape[1])
    return Step("line", lambda y, now: y + e * now.rng.standard_normal(size))


def _flicker_draw(sensor: VirtualSensor, amount: float, rng: Generator) -> Plain:
    return of_noise(sensor, amount, rng) | {"alpha": float(rng.uniform(0.8, 1.3))}


def _flicker_fpn(scene: Scene, rng: Generator, e: float, alpha: float) -> Step:
    """Fixed isotropic field of power rho^-alpha, standard deviation ``e`` over twice the frame."""
    rows, columns = 2 * scene.shape[0], 2 * scene.shape[1]
    rho = np.hypot(np.fft.fftfreq(rows)[:, None], np.fft.rfftfreq(columns)[None, :])
    rho[0, 0] = np.inf
    amplitude = rho ** (-alpha / 2)
    full = np.hypot(np.fft.fftfreq(rows)[:, None], np.fft.fftfreq(columns)[None, :])
    full[0, 0] = np.inf
    white = np.fft.rfft2(rng.standard_normal((rows, columns)))
    field = np.fft.irfft2(white * amplitude, s=(rows, columns))
    field *= e / np.sqrt(np.mean(full**-alpha))
    return _added(field[: scene.shape[0], : scene.shape[1]])


def _flicker_noise(scene: Scene, rng: Generator, e: float, alpha: float) -> Step:
    """f^-alpha along the raster scan, new in each frame; deviation ``e`` over 4 frames' time."""
    pixels = scene.shape[0] * scene.shape[1]
    length = 4 * pixels
    f = np.fft.rfftfreq(length)
    amplitude = np.zeros(f.size)
    amplitude[1:] = f[1:] ** (-alpha / 2)
    amplitude *= e / np.sqrt(2.0 * np.sum(amplitude**2) / length)

    def apply(y: np.ndarray, now: Moment) -> np.ndarray:
        white = np.fft.rfft(now.rng.standard_normal(length))
        scan = np.fft.irfft(white * amplitude, n=length)
        return y + scan[:pixels].reshape(scene.shape)

    return Step("line", apply)


def _serial_draw(sensor: VirtualSensor, amount: float, rng: Generator) -> Plain:
    radius, turn = rng.uniform(0.6, 0.9), rng.uniform(0.0, 0.9)
    return of_noise(sensor, amount, rng) | {"radius": float(radius), "turn": float(turn)}


def _serial_noise(scene: Scene, rng: Generator, e: float, radius: float, turn: float) -> Step:
    """Each row an autoregressive process of second order, new in each frame.

    Its poles lie at ``radius`` e^(+-i pi ``turn``); variance ``e``^2 once it has settled.
    """
    settled = 128
    first, second = 2.0 * radius * np.cos(np.pi * turn), -(radius**2)
    rest = (1.0 + second) * (1.0 - second - first) * (1.0 - second + first) / (1.0 - second)

    def apply(y: np.ndarray, now: Moment) -> np.ndarray:
        white = now.rng.standard_normal((scene.shape[0], scene.shape[1] + settled))
        x = lfilter([1.0], [1.0, -first, -second], white, axis=1)
        return y + e * np.sqrt(rest) * x[:, settled:]

    return Step("line", apply)


def _heavy_draw(sensor: VirtualSensor, amount: float, rng: Generator) -> Plain:
    return {"excess_kurtosis": amount}


def _heavy_tailed_read_noise(scene: Scene, rng: Generator, excess_kurtosis: float) -> Step:
    """Student-t of the same variance: 4 + 6/kurtosis degrees of freedom."""
    nu = 4.0 + 6.0 / excess_kurtosis

    def apply(noise: np.ndarray, now: Moment) -> np.ndarray:
        return noise * np.sqrt((nu - 2.0) / now.rng.chisquare(nu, noise.shape))

    return Step("noise", apply)


def _periodic_draw(sensor: VirtualSensor, amount: float, rng: Generator) -> Plain:
    fy, fx = rng.uniform(0.03, 0.45, 2)
    fx *= rng.choice([-1, 1])
    return of_noise(sensor, amount, rng) | {"fy": float(fy), "fx": float(fx), "harmonic": 0.0}


def _periodic_pattern(
    scene: Scene, rng: Generator, e: float, fy: float, fx: float, harmonic: float = 0.0
) -> Step:
    """A sin(2 pi (fx x + fy y) + phase), the phase new in each frame: variance A^2/2.

    With a second harmonic of ``harmonic`` A and a phase of its own, where there is one.
    """
    angle = 2 * np.pi * (fy * scene.row + fx * scene.column)

    def apply(y: np.ndarray, now: Moment) -> np.ndarray:
        y = y + e * np.sin(angle + now.rng.uniform(0, 2 * np.pi))
        if harmonic:
            y = y + harmonic * e * np.sin(2 * angle + now.rng.uniform(0, 2 * np.pi))
        return y

    return Step("line", apply)


def _offset_drift(scene: Scene, rng: Generator, e: float) -> Step:
    """Random walk of the black level from frame to frame, ``e`` a step."""

    def apply(y: np.ndarray, now: Moment) -> np.ndarray:
        now.memory["level"] = now.memory.get("level", 0.0) + e * now.rng.standard_normal()
        return y + now.memory["level"]

    return Step("line", apply)


def _cfa_mismatch(scene: Scene, rng: Generator, e: float, gain: float) -> Step:
    """Offsets b_c of standard deviation ``e`` and gains K_c over the four places of a 2x2 cell."""
    lines = np.array([[1, 1, -1, -1], [1, -1, 1, -1], [1, -1, -1, 1]])
    weight = np.zeros(3)
    while weight.min() < 0.15:  # all three lines of the spectrum, or it would be rows or columns
        offsets = rng.standard_normal(4)
        offsets -= offsets.mean()
        weight = (lines @ offsets) ** 2 / (4 * np.sum(offsets**2))
    offsets *= e / np.sqrt(np.mean(offsets**2))
    gains = 1.0 + gain * rng.standard_normal(4)
    phase = 2 * (scene.row % 2) + scene.column % 2
    return Step("line", lambda y, now: y * gains[phase] + offsets[phase])


def _taps_draw(sensor: VirtualSensor, amount: float, rng: Generator) -> Plain:
    return of_noise(sensor, amount, rng) | {
        "taps": int(rng.choice([2, 4, 8])),
        "interleaved": bool(rng.random() < 0.7),
    }


def _column_taps(scene: Scene, rng: Generator, e: float, taps: int, interleaved: bool) -> Step:
    """Offset o_(j mod P), or one a block of columns: mean 0, standard deviation ``e``."""
    offsets = rng.standard_normal(taps)
    offsets -= offsets.mean()
    offsets *= e / np.sqrt(np.mean(offsets**2))
    columns = scene.shape[1]
    tap = scene.column % taps if interleaved else scene.column * taps // columns
    return _added(offsets[tap])


def _stuck_draw(sensor: VirtualSensor, amount: float, rng: Generator) -> Plain:
    return {"fraction": amount}


def _stuck_pixels(scene: Scene, rng: Generator, fraction: float) -> Step:
    """y = 0, full scale, or some code between, whatever happens."""
    sites = scene.random_pixels(rng, fraction)
    any_code = rng.integers(0, WHITE_DN + 1, sites.size)
    kind = rng.integers(0, 3, sites.size)
    codes = np.where(kind == 0, 0, np.where(kind == 1, WHITE_DN, any_code))

    def apply(codes_in: np.ndarray, now: Moment) -> np.ndarray:
        stuck = codes_in.copy()
        stuck.flat[sites] = codes
        return stuck

    return Step("codes", apply)


def _lines_draw(sensor: VirtualSensor, amount: float, rng: Generator) -> Plain:
    return of_noise(sensor, amount, rng) | {"lines": 3, "columns": bool(rng.random() < 0.5)}


def _defect_lines(scene: Scene, rng: Generator, e: float, lines: int, columns: bool) -> Step:
    """A few columns, or rows, off by ``e`` give or take a third of it, either sign."""
    count = scene.shape[1] if columns else scene.shape[0]
    offset = np.zeros(count)
    where = rng.choice(count, lines, replace=False)
    offset[where] = e * rng.choice([-1, 1], lines) * rng.uniform(0.67, 1.33, lines)
    return _added(offset[None, :] if columns else offset[:, None])


_OVER_NOISE = "standard deviation over the noise"
READOUT = (
    HiddenEffect("column_fpn", (0.1, 0.25, 0.6), _OVER_NOISE, of_noise, _column_fpn),
    HiddenEffect("column_gain", (0.01, 0.03, 0.08), "relative; a typical .001 drowns in the "
                 "scatter of the dark current", lambda s, a, r: {"relative": a}, _column_gain),
    HiddenEffect("row_fpn", (0.1, 0.25, 0.6), _OVER_NOISE, of_noise, _row_fpn),
    HiddenEffect("row_noise", (0.1, 0.25, 0.6), _OVER_NOISE, _row_draw, _row_noise),
    HiddenEffect("column_noise", (0.1, 0.25, 0.6), _OVER_NOISE, of_noise, _column_noise),
    HiddenEffect("flicker_fpn", (0.15, 0.4, 1.0), _OVER_NOISE, _flicker_draw, _flicker_fpn),
    HiddenEffect("flicker_noise", (0.15, 0.35, 0.8), _OVER_NOISE, _flicker_draw, _flicker_noise),
    HiddenEffect("serial_noise", (0.15, 0.35, 0.8), _OVER_NOISE, _serial_draw, _serial_noise),
    HiddenEffect("heavy_tailed_read_noise", (0.5, 1.5, 5.0), "excess kurtosis of the read noise",
                 _heavy_draw, _heavy_tailed_read_noise),
    HiddenEffect("periodic_pattern", (0.1, 0.3, 0.8), "amplitude over the noise",
                 _periodic_draw, _periodic_pattern),
    HiddenEffect("offset_drift", (0.03, 0.1, 0.3), "step over the noise", of_noise, _offset_drift),
    HiddenEffect("cfa_mismatch", (0.1, 0.25, 0.6), _OVER_NOISE + ", and 1 % of gain",
                 lambda s, a, r: of_noise(s, a, r) | {"gain": 0.01}, _cfa_mismatch),
    HiddenEffect("column_taps", (0.1, 0.25, 0.6), _OVER_NOISE, _taps_draw, _column_taps),
    HiddenEffect("stuck_pixels", (3e-5, 1.5e-4, 1e-3), "fraction of the pixels",
                 _stuck_draw, _stuck_pixels),
    HiddenEffect("defect_lines", (0.5, 1.5, 5.0), "offset over the noise, in 3 lines",
                 _lines_draw, _defect_lines),
)  # fmt: skip
