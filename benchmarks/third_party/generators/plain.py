"""A sensor in plain formulas, NumPy alone: nothing of dnanalyze and of no simulator.

Codes = round(gain (electrons + offset + read noise) + pedestal), electrons Poisson about a
log-normal dark current with D(T) = D0 (T/T0)^1.5 exp(-Eg/2k (1/T - 1/T0)). An effect is a few
lines that change an array at one stage of this chain.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from third_party.case import FRAMES, SHAPE, Claim, Drawn, Point, Recipe, near
from third_party.dark_current import dark_growth

Generator = np.random.Generator
WHITE = 16383
ROWS, COLUMNS = SHAPE
ROW, COLUMN = np.arange(ROWS)[:, None], np.arange(COLUMNS)[None, :]


@dataclass(frozen=True)
class Sensor:
    """Gain (DN/e-), noises (e-), dark current at the hottest temperature (e-) and its spread."""

    gain: float
    read_e: float
    offset_e: float
    dark_e: float
    spread: float
    gap_ev: float
    pedestal: float
    exposure_s: float
    temperatures_c: tuple[float, ...]

    def growth(self, celsius: float) -> float:
        """Dark current at a temperature over that at the hottest."""
        return dark_growth(celsius, self.temperatures_c[-1], self.gap_ev)

    @property
    def noise_dn(self) -> float:
        """Temporal noise without dark current, DN."""
        return float(np.hypot(self.gain * self.read_e, 12**-0.5))

    @property
    def cold_noise_dn(self) -> float:
        """Temporal noise at the coldest temperature, DN."""
        charge = self.dark_e * self.growth(self.temperatures_c[0])
        return float(np.hypot(self.noise_dn, self.gain * np.sqrt(charge)))

    def pattern_dn(self, celsius: float) -> float:
        """Standard deviation over the pixels of the mean of the frames of a point, DN."""
        charge = self.dark_e * self.growth(celsius)
        fixed = np.hypot(charge * np.sqrt(np.expm1(self.spread**2)), self.offset_e)
        noise = np.hypot(self.noise_dn, self.gain * np.sqrt(charge)) / np.sqrt(FRAMES)
        return float(np.hypot(self.gain * fixed, noise))

    @property
    def hot_noise_dn(self) -> float:
        """Temporal noise at the hottest temperature, DN."""
        return float(np.hypot(self.noise_dn, self.gain * np.sqrt(self.dark_e)))


def draw_sensor(rng: Generator) -> Sensor:
    """Ordinary values: noise above 0.7 DN, pedestal above ten times it."""
    gain = float(np.exp(rng.uniform(np.log(0.3), np.log(2.0))))
    read = max(float(rng.uniform(1.5, 5.0)), 0.7 / gain)
    start, step = float(rng.choice([5, 10, 20])), float(rng.choice([10, 12, 15]))
    return Sensor(
        gain=gain,
        read_e=read,
        offset_e=float(rng.uniform(0.3, 1.2)),
        dark_e=float(np.exp(rng.uniform(np.log(60), np.log(400)))),
        spread=float(rng.uniform(0.15, 0.5)),
        gap_ev=float(rng.uniform(1.12, 1.5)),
        pedestal=float(rng.integers(100, 300)),
        exposure_s=float(rng.choice([0.05, 0.2, 1.0])),
        temperatures_c=tuple(start + step * n for n in range(5)),
    )


@dataclass
class Moment:
    """When a step acts: the point, the number of the frame, random numbers, what came before."""

    sensor: Sensor
    celsius: float
    frame: int
    rng: Generator
    memory: dict[str, Any] = field(default_factory=dict)

    @property
    def growth(self) -> float:
        """Of the dark current, 1 at the hottest point."""
        return self.sensor.growth(self.celsius)


Step = Callable[[np.ndarray, Moment], np.ndarray]


@dataclass(frozen=True)
class Effect:
    """Steps by stage, and what the frames must show.

    Stages: "rate" (mean charge of every pixel at a point, e-), "charge" (of a frame, e-),
    "electrons" (after the Poisson draw), "noise" (read noise, e-), "volts" (all of it, e-),
    "dn" (before rounding), "codes".
    """

    steps: Mapping[str, Step]
    claims: tuple[Claim, ...] = ()


Build = Callable[[Sensor, Generator, float], Effect]


def expose(sensor: Sensor, effects: tuple[Effect, ...], seed: int) -> dict[Point, np.ndarray]:
    """The stacks; fixed maps from one generator, every frame from its own."""
    silicon = np.random.default_rng([seed, 1])
    pixel = np.exp(sensor.spread * silicon.standard_normal(SHAPE) - sensor.spread**2 / 2)
    offset = sensor.offset_e * silicon.standard_normal(SHAPE)
    stacks = {}
    for number, celsius in enumerate(sensor.temperatures_c):
        memory: list[dict[str, Any]] = [{} for _ in effects]
        codes = []
        for frame in range(-2, FRAMES):  # the first two prepare what has a memory
            rng = np.random.default_rng([seed, 2, number, frame + 2])
            moments = [Moment(sensor, celsius, frame, rng, m) for m in memory]

            def stage(name: str, array: np.ndarray, moments: list[Moment] = moments) -> np.ndarray:
                for effect, now in zip(effects, moments, strict=True):
                    if name in effect.steps:
                        array = effect.steps[name](array, now)
                return array

            mean = stage("rate", pixel * sensor.dark_e * sensor.growth(celsius))
            charge = rng.poisson(np.maximum(stage("charge", mean), 0.0)).astype(float)
            noise = stage("noise", sensor.read_e * rng.standard_normal(SHAPE))
            volts = stage("volts", stage("electrons", charge) + offset + noise)
            dn = np.rint(stage("dn", sensor.gain * volts + sensor.pedestal))
            if frame >= 0:
                codes.append(np.clip(stage("codes", np.clip(dn, 0, WHITE)), 0, WHITE))
        stacks[Point(celsius, sensor.exposure_s)] = np.array(codes, np.uint16)
    return stacks


def drawn(builds: tuple[Build, ...], amounts: tuple[float, ...], seed: int) -> Drawn:
    """A sensor at random with these effects."""
    sensor = draw_sensor(np.random.default_rng([seed, 0]))
    effects = tuple(
        build(sensor, np.random.default_rng([seed, 3, n]), amount)
        for n, (build, amount) in enumerate(zip(builds, amounts, strict=True))
    )
    claims = tuple(c for e in effects for c in e.claims) or ordinary_claims(sensor)
    return Drawn(expose(sensor, effects, seed), claims, asdict(sensor) | {"amounts": amounts})


def ordinary_claims(sensor: Sensor) -> tuple[Claim, ...]:
    """Nothing but Poisson charge, Gaussian noise and pixels that differ."""
    pattern = sensor.pattern_dn(sensor.temperatures_c[0])
    return (
        near("charge_slope", sensor.gain, 0.1),
        Claim("temporal_kurtosis", -0.1, 0.5, 0),  # shot noise differs between the pixels
        Claim("row_noise_sd", 0.0, 0.03 * sensor.cold_noise_dn, 0),
        Claim("column_fpn_sd", 0.0, 0.08 * pattern, 0),
        Claim("row_fpn_sd", 0.0, 0.08 * pattern, 0),
        Claim("smooth_rms", 0.0, 0.15 * pattern, 0),
    )


def sheet(rng: Generator, power: float, shape: tuple[int, int] = SHAPE) -> np.ndarray:
    """A random field of unit deviation whose power falls as f^-power."""
    fy, fx = np.fft.fftfreq(2 * shape[0])[:, None], np.fft.rfftfreq(2 * shape[1])[None, :]
    f = np.hypot(fy, fx)
    f[0, 0] = np.inf
    spectrum = np.fft.rfft2(rng.standard_normal((2 * shape[0], 2 * shape[1])))
    field_ = np.fft.irfft2(spectrum * f ** (-power / 2))[: shape[0], : shape[1]]
    return (field_ - field_.mean()) / field_.std()


def chain(rng: Generator, count: int, power: float = 1.0, cutoff: float = 0.0) -> np.ndarray:
    """1/f^power noise along a scan, white below the cutoff (cycles a sample), deviation 1."""
    length = 2 * count
    f = np.maximum(np.fft.rfftfreq(length), max(cutoff, 1.0 / length))
    noise = np.fft.irfft(np.fft.rfft(rng.standard_normal(length)) * f ** (-power / 2), length)
    expected = np.sqrt(np.mean(np.concatenate([f[1:], f[1:]]) ** -power))
    return noise[:count] / expected


def _read_out(make: Callable[[Generator], np.ndarray]) -> Step:
    return lambda y, now: y + make(now.rng)


# ---- lines -------------------------------------------------------------------------------------


def row_noise(s: Sensor, rng: Generator, amount: float) -> Effect:
    e = amount * s.noise_dn / s.gain
    return Effect(
        {"volts": lambda y, now: y + e * now.rng.standard_normal((ROWS, 1))},
        (near("row_noise_sd", e * s.gain, 0.15, point=0),),
    )


def column_noise(s: Sensor, rng: Generator, amount: float) -> Effect:
    e = amount * s.noise_dn / s.gain
    return Effect(
        {"volts": lambda y, now: y + e * now.rng.standard_normal((1, COLUMNS))},
        (near("column_noise_sd", e * s.gain, 0.15, point=0),),
    )


def row_fpn(s: Sensor, rng: Generator, amount: float) -> Effect:
    lines = amount * s.noise_dn * rng.standard_normal((ROWS, 1))
    return Effect(
        {"dn": lambda y, now: y + lines}, (near("row_fpn_sd", lines.std(), 0.15, point=0),)
    )


def column_fpn(s: Sensor, rng: Generator, amount: float) -> Effect:
    lines = amount * s.noise_dn * rng.standard_normal((1, COLUMNS))
    return Effect(
        {"dn": lambda y, now: y + lines}, (near("column_fpn_sd", lines.std(), 0.15, point=0),)
    )


def column_gain(s: Sensor, rng: Generator, amount: float) -> Effect:
    lines = 1.0 + amount * rng.standard_normal((1, COLUMNS))
    size = s.gain * s.dark_e * lines.std()
    return Effect(
        {"electrons": lambda y, now: y * lines},
        (near("column_fpn_sd", size, 0.5), Claim("column_fpn_sd", 0, 0.1 * size, 0)),
    )


def defect_lines(s: Sensor, rng: Generator, amount: float) -> Effect:
    lines = np.zeros((1, COLUMNS))
    where = rng.choice(COLUMNS, 6, replace=False)
    lines[0, where] = amount * s.noise_dn * rng.uniform(0.7, 1.4, 6) * rng.choice([-1, 1], 6)
    return Effect(
        {"dn": lambda y, now: y + lines}, (near("column_fpn_sd", lines.std(), 0.2, point=0),)
    )


def dead_columns(s: Sensor, rng: Generator, amount: float) -> Effect:
    alive = np.ones((1, COLUMNS))
    alive[0, rng.choice(COLUMNS, int(amount), replace=False)] = 0.0
    return Effect(
        {"rate": lambda d, now: d * alive},
        (near("dark_columns", float(amount) / COLUMNS, 0.01),),
    )


def column_taps(s: Sensor, rng: Generator, amount: float) -> Effect:
    levels = amount * s.noise_dn * np.array([-1.0, 1.0, 0.6, -0.6])
    taps = np.repeat(levels, COLUMNS // 4)[None, :]
    edges = [COLUMNS // 4 * n for n in (1, 2, 3)]
    claim = near("segment_sd", levels.std(), 0.15, point=0, options={"columns": edges})
    return Effect({"dn": lambda y, now: y + taps}, (claim,))


def unequal_segments(s: Sensor, rng: Generator, amount: float) -> Effect:
    edges = sorted(int(v) for v in rng.choice(np.arange(30, 226, 14), 3, replace=False))
    levels = amount * s.noise_dn * np.array([0.0, 1.3, -0.8, 0.5])
    widths = np.diff([0, *edges, COLUMNS])
    taps = np.repeat(levels, widths)[None, :]
    claim = near("segment_sd", levels.std(), 0.15, point=0, options={"columns": edges})
    return Effect({"dn": lambda y, now: y + taps}, (claim,))


def odd_even(s: Sensor, rng: Generator, amount: float) -> Effect:
    step = amount * s.noise_dn * (COLUMN % 2 - 0.5)
    claim = near("interleaved_sd", amount * s.noise_dn / 2, 0.15, point=0)
    return Effect({"dn": lambda y, now: y + step}, (claim,))


def mosaic(s: Sensor, rng: Generator, amount: float) -> Effect:
    levels = amount * s.noise_dn * np.array([[1.0, -0.2], [-1.1, 0.3]])
    tiles = np.tile(levels, (ROWS // 2, COLUMNS // 2))
    claim = near("mosaic_sd", levels.std(), 0.15, point=0)
    return Effect({"dn": lambda y, now: y + tiles}, (claim,))


# ---- noise of the chain ------------------------------------------------------------------------


def _correlated(
    s: Sensor, rng: Generator, amount: float, make: Callable[[Generator], np.ndarray], lag: int
) -> Effect:
    """Noise of a deviation ``amount`` of the read noise; the claim from its own draws."""
    e = amount * s.read_e
    found = [_covariance(make(rng), lag) for _ in range(20)]
    wide = 4 * np.std(found) / np.sqrt(FRAMES - 1) + 0.1 * np.mean(found)
    low, high = (s.gain * e) ** 2 * (np.mean(found) + np.array([-wide, wide]))
    return Effect(
        {"volts": _read_out(lambda g: e * make(g))},
        (Claim("raster_covariance", float(low), float(high), 0, {"lag": lag}),),
    )


def _covariance(image: np.ndarray, lag: int) -> float:
    image = image - np.median(image)
    return float(np.mean(image[:, lag:] * image[:, :-lag]))


def flicker_noise(s: Sensor, rng: Generator, amount: float) -> Effect:
    return _correlated(s, rng, amount, lambda g: chain(g, ROWS * COLUMNS).reshape(SHAPE), lag=1)


def flicker_cutoff(s: Sensor, rng: Generator, amount: float) -> Effect:
    return _correlated(
        s, rng, amount, lambda g: chain(g, ROWS * COLUMNS, cutoff=0.004).reshape(SHAPE), lag=1
    )


def alternating_flicker(s: Sensor, rng: Generator, amount: float) -> Effect:
    def make(g: Generator) -> np.ndarray:
        image = np.empty(SHAPE)
        for side in (0, 1):
            image[:, side::2] = chain(g, ROWS * COLUMNS // 2).reshape(ROWS, COLUMNS // 2)
        return image

    return _correlated(s, rng, amount, make, lag=2)


def periodic_pattern(s: Sensor, rng: Generator, amount: float) -> Effect:
    u, v = rng.uniform(0.05, 0.4, 2)
    e = amount * s.noise_dn

    def apply(y: np.ndarray, now: Moment) -> np.ndarray:
        phase = now.rng.uniform(0, 2 * np.pi)
        return y + e * np.sqrt(2) * np.cos(2 * np.pi * (u * ROW + v * COLUMN) + phase)

    return Effect({"dn": apply}, (Claim("spectral_peak", 50.0, np.inf, 0),))


def offset_walk(s: Sensor, rng: Generator, amount: float) -> Effect:
    def apply(y: np.ndarray, now: Moment) -> np.ndarray:
        level = now.memory.get("level", 0.0) + amount * s.noise_dn * now.rng.standard_normal()
        now.memory["level"] = level
        return y + level

    low, high = 0.4 * amount * s.noise_dn, 4.0 * amount * s.noise_dn
    return Effect({"dn": apply}, (Claim("frame_offset_sd", low, high, 0),))


def offset_jumps(s: Sensor, rng: Generator, amount: float) -> Effect:
    e = amount * s.noise_dn
    return Effect(
        {"dn": lambda y, now: y + e * now.rng.standard_normal()},
        (Claim("frame_offset_sd", 0.25 * e, 2.0 * e, 0),),
    )


# ---- noise of pixels ---------------------------------------------------------------------------


def student_noise(s: Sensor, rng: Generator, amount: float) -> Effect:
    """Student's t with so many degrees of freedom, scaled to the same variance."""
    scale = s.read_e * np.sqrt((amount - 2) / amount)
    return Effect(
        {"noise": lambda n, now: scale * now.rng.standard_t(amount, SHAPE)},
        (Claim("temporal_kurtosis", 0.15, np.inf, 0), Claim("noisy_share", 1e-4, 0.5, 0)),
    )


def noise_spread(s: Sensor, rng: Generator, amount: float) -> Effect:
    factor = np.exp(amount * rng.standard_normal(SHAPE) - amount**2 / 2)
    kurtosis = 3 * float(np.mean(factor**4) / np.mean(factor**2) ** 2 - 1)
    share = (s.gain * s.read_e / s.cold_noise_dn) ** 4  # shot noise and rounding dilute
    return Effect(
        {"noise": lambda n, now: n * factor},
        (near("temporal_kurtosis", share * kurtosis, 0.5, point=0),),
    )


def noise_populations(s: Sensor, rng: Generator, amount: float) -> Effect:
    """Three per cent of the pixels with so many times the read noise."""
    factor = np.where(rng.random(SHAPE) < 0.03, amount, 1.0)
    variance = np.mean(factor**2)
    kurtosis = 3 * float(np.mean(factor**4) / variance**2 - 1)
    kurtosis *= (s.gain * s.read_e / s.cold_noise_dn) ** 4
    return Effect(
        {"noise": lambda n, now: n * factor},
        (Claim("temporal_kurtosis", 0.5 * kurtosis, 1.3 * kurtosis, 0),),
    )


def telegraph(s: Sensor, rng: Generator, amount: float) -> Effect:
    """One pixel in fifty jumps between two dark levels with a dwell of some frames."""
    sites = np.flatnonzero(rng.random(SHAPE) < 0.02)
    size = amount * s.hot_noise_dn / s.gain * rng.uniform(0.5, 1.5, sites.size)

    def apply(charge: np.ndarray, now: Moment) -> np.ndarray:
        state = now.memory.get("state")
        if state is None:
            state = now.rng.random(sites.size) < 0.5
        state = state ^ (now.rng.random(sites.size) < 0.35)
        now.memory["state"] = state
        out = charge.copy()
        out.flat[sites] += now.growth * size * state
        return out

    return Effect({"charge": apply}, (Claim("wandering_share", 0.004, 0.03, -1, {"sigmas": 6.0}),))


# ---- charge ------------------------------------------------------------------------------------


def _hot(s: Sensor, rng: Generator, heights: np.ndarray, claims: tuple[Claim, ...]) -> Effect:
    return Effect({"rate": lambda d, now: d + heights * now.growth}, claims)


def hot_pixels(s: Sensor, rng: Generator, amount: float) -> Effect:
    """A share of the pixels with an exponential extra rate of eight times the mean."""
    sites = rng.random(SHAPE) < amount
    heights = sites * rng.exponential(8.0 * s.dark_e, SHAPE)
    share = float(np.mean(s.gain * heights > 10 * s.pattern_dn(s.temperatures_c[-1])))
    claim = Claim("hot_share", 0.6 * share, 1.7 * amount + 5e-4, -1, {"sigmas": 10.0})
    return _hot(s, rng, heights, (claim,))


def power_law_hot(s: Sensor, rng: Generator, amount: float) -> Effect:
    sites = rng.random(SHAPE) < amount
    heights = sites * np.minimum(3.0 * s.dark_e * rng.random(SHAPE) ** (-1 / 1.3), 5e3)
    return _hot(s, rng, heights, (Claim("hot_share", 0.2 * amount, 1.5 * amount),))


def narrow_hot(s: Sensor, rng: Generator, amount: float) -> Effect:
    sites = rng.random(SHAPE) < amount
    high = 10.0 * s.dark_e
    half = {"sigmas": 0.5 * s.gain * high / s.pattern_dn(s.temperatures_c[-1])}
    claims = (
        near("hot_share", float(sites.mean()), 0.25, options=half),
        near("hot_height", s.gain * high, 0.15, options=half),
        Claim("hot_spread", 0.0, 0.15, -1, half),
    )
    return _hot(s, rng, sites * high, claims)


def hot_clusters(s: Sensor, rng: Generator, amount: float) -> Effect:
    """Groups of four to nine hot pixels within two pixels of a centre."""
    heights = np.zeros(SHAPE)
    for _ in range(rng.poisson(amount * ROWS * COLUMNS / 6)):
        centre = rng.uniform((0, 0), SHAPE)
        for _ in range(rng.integers(4, 10)):
            y, x = np.rint(centre + rng.normal(0, 1.2, 2)).astype(int)
            if 0 <= y < ROWS and 0 <= x < COLUMNS:
                heights[y, x] += rng.exponential(8.0 * s.dark_e)
    return _hot(s, rng, heights, (Claim("hot_share", 0.2 * amount, 2.0 * amount),))


def dark_steps(s: Sensor, rng: Generator, amount: float) -> Effect:
    """Traps of one kind: a Poisson number in each pixel, each the same rate."""
    quantum = 12.0 * np.hypot(s.hot_noise_dn / s.gain, s.dark_e * s.spread) / 2.5
    heights = quantum * rng.poisson(amount, SHAPE)
    return _hot(s, rng, heights, (Claim("hot_share", 0.0005, 1.0, -1, {"sigmas": 4.0}),))


def corner_glow(s: Sensor, rng: Generator, amount: float) -> Effect:
    high = amount * s.dark_e
    glow = high * np.exp(-np.hypot(ROW, COLUMNS - 1 - COLUMN) / 40.0)
    excess = s.gain * float(np.median(glow[:16, -16:]))
    return Effect(
        {"rate": lambda d, now: d + glow},
        (near("corner_excess", excess, 0.2), near("corner_excess", excess, 0.25, point=0)),
    )


def edge_glow(s: Sensor, rng: Generator, amount: float) -> Effect:
    away = np.minimum(np.minimum(ROW, ROWS - 1 - ROW), np.minimum(COLUMN, COLUMNS - 1 - COLUMN))
    glow = amount * s.dark_e * np.exp(-away / 15.0)
    excess = s.gain * amount * s.dark_e * float(np.exp(-1.5 / 15.0))
    return Effect({"rate": lambda d, now: d + glow}, (near("edge_excess", excess, 0.25, point=0),))


def dark_gradient(s: Sensor, rng: Generator, amount: float) -> Effect:
    """A tilt of the die's temperature: the dark current of every pixel times 1 + plane."""
    a, b = rng.uniform(0.5, 1.0, 2) * rng.choice([-1, 1], 2)
    plane = a * (2 * ROW / (ROWS - 1) - 1) + b * (2 * COLUMN / (COLUMNS - 1) - 1)
    plane = amount * plane / plane.std()
    return Effect(
        {"rate": lambda d, now: d * np.maximum(1 + plane, 0)},
        (near("plane_rms", s.gain * amount * s.dark_e, 0.2),),
    )


def dark_shading(s: Sensor, rng: Generator, amount: float) -> Effect:
    field_ = amount * sheet(rng, 3.0)
    return Effect(
        {"rate": lambda d, now: d * np.maximum(1 + field_, 0)},
        (near("smooth_rms", s.gain * amount * s.dark_e, 0.25),),
    )


def flicker_fpn(s: Sensor, rng: Generator, amount: float) -> Effect:
    field_ = amount * s.noise_dn * sheet(rng, 2.0)
    tiles = field_.reshape(16, 16, 16, 16).mean(axis=(1, 3)).std()
    return Effect({"dn": lambda y, now: y + field_}, (near("smooth_rms", tiles, 0.2, point=0),))


def offset_plane(s: Sensor, rng: Generator, amount: float) -> Effect:
    a, b = rng.uniform(0.5, 1.0, 2) * rng.choice([-1, 1], 2)
    plane = a * (2 * ROW / (ROWS - 1) - 1) + b * (2 * COLUMN / (COLUMNS - 1) - 1)
    plane = amount * s.noise_dn * plane / plane.std()
    size = amount * s.noise_dn
    limit = 1.4 * size + 0.05 * s.pattern_dn(s.temperatures_c[-1])  # it does not grow
    return Effect(
        {"dn": lambda y, now: y + plane},
        (near("plane_rms", size, 0.15, point=0), Claim("plane_rms", 0.3 * size, limit)),
    )


def tracks(s: Sensor, rng: Generator, amount: float) -> Effect:
    """Muons: straight tracks of 3 to 60 pixels, Landau-like charge in each pixel."""

    def apply(charge: np.ndarray, now: Moment) -> np.ndarray:
        out = charge.copy()
        for _ in range(now.rng.poisson(amount)):
            length = int(min(3 + now.rng.exponential(15.0), 60))
            y, x = now.rng.uniform((0, 0), SHAPE)
            angle = now.rng.uniform(0, 2 * np.pi)
            for n in range(length):
                i, j = round(y + n * np.sin(angle)), round(x + n * np.cos(angle))
                if 0 <= i < ROWS and 0 <= j < COLUMNS:
                    out[i, j] += 25 * s.hot_noise_dn / s.gain * now.rng.gumbel(1.0, 0.25)
        return out

    share = amount * 15 / (ROWS * COLUMNS)
    return Effect({"electrons": apply}, (Claim("transient_share", 0.3 * share, 2.5 * share),))


def single_hits(s: Sensor, rng: Generator, amount: float) -> Effect:
    def apply(charge: np.ndarray, now: Moment) -> np.ndarray:
        out = charge.copy()
        count = now.rng.poisson(amount)
        sites = now.rng.integers(0, out.size, count)
        out.flat[sites] += 20 * s.hot_noise_dn / s.gain * now.rng.gamma(3.0, 1.0, count)
        return out

    share = amount / (ROWS * COLUMNS)
    return Effect({"electrons": apply}, (near("transient_share", share, 0.4),))


def crosstalk(s: Sensor, rng: Generator, amount: float) -> Effect:
    def apply(charge: np.ndarray, now: Moment) -> np.ndarray:
        p = np.pad(charge, 1, mode="edge")
        side = p[:-2, 1:-1] + p[2:, 1:-1] + p[1:-1, :-2] + p[1:-1, 2:]
        return (1 - 4 * amount) * charge + amount * side

    shot = 1 - (s.noise_dn / s.hot_noise_dn) ** 2
    return Effect({"electrons": apply}, (near("neighbour_correlation", 2 * amount * shot, 0.35),))


def persistence(s: Sensor, rng: Generator, amount: float) -> Effect:
    """So much of the last frame's charge comes back; hot pixels make it seen."""
    hot = 20 * s.dark_e * (rng.random(SHAPE) < 0.01)

    def flash(charge: np.ndarray, now: Moment) -> np.ndarray:
        return charge + hot * now.growth

    def apply(electrons: np.ndarray, now: Moment) -> np.ndarray:
        last = now.memory.get("last", np.zeros(SHAPE))
        total = electrons + amount * last
        now.memory["last"] = total
        return total

    shot = 1 - (s.noise_dn / s.hot_noise_dn) ** 2
    return Effect(
        {"charge": flash, "electrons": apply}, (near("frame_correlation", amount * shot, 0.5),)
    )


def multiplication(s: Sensor, rng: Generator, amount: float) -> Effect:
    """A register that multiplies each electron by an exponential number of mean ``amount``."""
    return Effect(
        {
            "electrons": lambda n, now: now.rng.gamma(np.maximum(n, 1e-12), 1.0) * amount,
            "noise": lambda noise, now: noise * amount,
        },
        (near("charge_slope", 2 * s.gain * amount, 0.15),),
    )


def transfer_tails(s: Sensor, rng: Generator, amount: float) -> Effect:
    """Hot pixels, and a share of every pixel's charge left to the next row of each transfer."""
    heights = (rng.random(SHAPE) < 0.004) * rng.exponential(30.0 * s.dark_e, SHAPE)
    lost = np.minimum(amount * (ROW + 1) / ROWS, 0.9)

    def apply(electrons: np.ndarray, now: Moment) -> np.ndarray:
        left = np.rint(electrons * lost)
        out = electrons - left
        out[1:] += left[:-1]
        return out

    return Effect(
        {"rate": lambda d, now: d + heights * now.growth, "electrons": apply},
        (Claim("trailing_share", 0.25 * amount, 1.0 * amount),),
    )


def dark_jitter(s: Sensor, rng: Generator, amount: float) -> Effect:
    size = amount * s.gain * s.dark_e
    return Effect(
        {"charge": lambda d, now: d * (1 + amount * now.rng.standard_normal())},
        (Claim("frame_offset_sd", 0.25 * size, 2.0 * size),),
    )


def rings(s: Sensor, rng: Generator, amount: float) -> Effect:
    y, x = rng.uniform(-0.3, 1.3, 2) * SHAPE
    ring = np.sqrt(2) * amount * s.noise_dn * np.cos(2 * np.pi / 11 * np.hypot(ROW - y, COLUMN - x))
    return Effect({"dn": lambda v, now: v + ring}, (near("ring_rms", ring.std(), 0.3, point=0),))


# ---- digital -----------------------------------------------------------------------------------


def stuck_pixels(s: Sensor, rng: Generator, amount: float) -> Effect:
    dead = rng.random(SHAPE) < amount
    return Effect(
        {"codes": lambda y, now: np.where(dead, 0.0, y)},
        (near("low_share", float(dead.mean()), 0.3, point=0),),
    )


def dead_pixels(s: Sensor, rng: Generator, amount: float) -> Effect:
    dead = rng.random(SHAPE) < amount
    return Effect(
        {"rate": lambda d, now: np.where(dead, 0.0, d)},
        (Claim("low_share", 0.0, 1.3 * amount + 1e-4),),
    )


def digital_gain(s: Sensor, rng: Generator, amount: float) -> Effect:
    """Codes times ``amount`` about the pedestal after rounding: some codes never come."""
    base = round(s.pedestal)
    return Effect(
        {"codes": lambda y, now: np.rint((y - base) * amount + base)},
        (near("empty_codes", 1 - 1 / amount, 0.35),),
    )


def missing_codes(s: Sensor, rng: Generator, amount: float) -> Effect:
    """Code widths 1 + amount N(0, 1), never below 0."""
    widths = np.maximum(1 + amount * rng.standard_normal(WHITE + 2), 0.0)
    edges = np.cumsum(widths)
    edges *= (WHITE + 1) / edges[-1]
    return Effect(
        {"dn": lambda y, now: np.searchsorted(edges, y + 0.5).astype(float)},
        (Claim("code_roughness", 0.25 * amount, 2.5 * amount),),
    )


def black_clipping(s: Sensor, rng: Generator, amount: float) -> Effect:
    """The black level is moved to ``amount`` deviations of the noise above code 0."""
    shift = s.pedestal - amount * s.noise_dn
    return Effect({"dn": lambda y, now: y - shift}, (Claim("lowest_code_share", 0.005, 0.5, 0),))


def temporal_denoise(s: Sensor, rng: Generator, amount: float) -> Effect:
    """A recursive mean over frames: y_n = (1 - amount) x_n + amount y_(n-1)."""

    def apply(y: np.ndarray, now: Moment) -> np.ndarray:
        last = now.memory.get("last", y)
        now.memory["last"] = (1 - amount) * y + amount * last
        return np.rint(now.memory["last"])

    return Effect({"dn": apply}, (Claim("frame_correlation", 0.4 * amount, 1.6 * amount, 0),))


# name: (kinds, build, moderate, strong); amounts in the units of each function
EFFECTS: dict[str, tuple[tuple[str, ...], Build, float, float]] = {
    "row_noise": (("row_noise",), row_noise, 0.25, 0.8),
    "column_noise": (("column_noise",), column_noise, 0.25, 0.8),
    "row_fpn": (("row_fpn",), row_fpn, 0.25, 0.8),
    "column_fpn": (("column_fpn",), column_fpn, 0.25, 0.8),
    "column_gain": (("column_gain",), column_gain, 0.015, 0.04),
    "defect_lines": (("defect_lines",), defect_lines, 2.0, 8.0),
    "dead_columns": (("dead_columns",), dead_columns, 2, 8),
    "column_taps": (("column_taps",), column_taps, 0.3, 1.0),
    "unequal_segments": (("amplifier_segments",), unequal_segments, 0.4, 2.0),
    "odd_even": (("interleaved_channels",), odd_even, 0.4, 1.2),
    "mosaic": (("cfa_mismatch",), mosaic, 0.3, 1.0),
    "flicker_noise": (("flicker_noise",), flicker_noise, 0.4, 1.0),
    "flicker_cutoff": (("flicker_cutoff",), flicker_cutoff, 0.5, 1.2),
    "alternating_flicker": (("alternating_flicker",), alternating_flicker, 0.5, 1.2),
    "periodic_pattern": (("periodic_pattern",), periodic_pattern, 0.2, 0.6),
    "offset_walk": (("offset_drift",), offset_walk, 0.3, 1.0),
    "offset_jumps": (("offset_jumps",), offset_jumps, 0.3, 1.0),
    "student_noise": (("student_t_noise",), student_noise, 6.0, 3.5),
    "noise_spread": (("read_noise_spread",), noise_spread, 0.3, 0.6),
    "noise_populations": (("read_noise_populations",), noise_populations, 2.2, 4.0),
    "telegraph": (("rts",), telegraph, 8.0, 16.0),
    "hot_pixels": (("hot_pixels",), hot_pixels, 0.001, 0.006),
    "power_law_hot": (("power_law_hot_pixels",), power_law_hot, 0.002, 0.01),
    "narrow_hot": (("narrow_hot_pixels",), narrow_hot, 0.002, 0.01),
    "hot_clusters": (("hot_clusters",), hot_clusters, 0.002, 0.01),
    "dark_steps": (("dark_current_steps",), dark_steps, 0.03, 0.3),
    "corner_glow": (("amp_glow",), corner_glow, 0.15, 0.8),
    "edge_glow": (("edge_glow",), edge_glow, 0.15, 0.6),
    "dark_gradient": (("dark_gradient",), dark_gradient, 0.04, 0.12),
    "dark_shading": (("dark_shading",), dark_shading, 0.06, 0.18),
    "flicker_fpn": (("flicker_fpn",), flicker_fpn, 0.3, 1.0),
    "offset_plane": (("offset_plane",), offset_plane, 0.3, 1.2),
    "tracks": (("tracks",), tracks, 4.0, 20.0),
    "single_hits": (("single_hits",), single_hits, 20.0, 120.0),
    "crosstalk": (("crosstalk",), crosstalk, 0.012, 0.03),
    "persistence": (("persistence", "narrow_hot_pixels"), persistence, 0.05, 0.15),
    "multiplication": (("multiplication",), multiplication, 3.0, 10.0),
    "transfer_tails": (("transfer_tails", "hot_pixels"), transfer_tails, 0.05, 0.2),
    "dark_jitter": (("dark_jitter",), dark_jitter, 0.01, 0.04),
    "rings": (("concentric_rings",), rings, 0.3, 0.8),
    "stuck_pixels": (("stuck_pixels",), stuck_pixels, 0.0005, 0.004),
    "dead_pixels": (("dead_pixels",), dead_pixels, 0.001, 0.006),
    "digital_gain": (("digital_gain",), digital_gain, 1.13, 1.5),
    "missing_codes": (("missing_codes",), missing_codes, 0.2, 0.5),
    "black_clipping": (("clipping_at_zero",), black_clipping, 1.8, 0.5),
    "temporal_denoise": (("temporal_denoise",), temporal_denoise, 0.2, 0.5),
}

PAIRS = (
    ("row_noise", "hot_pixels"),
    ("column_fpn", "flicker_noise"),
    ("single_hits", "row_fpn"),
    ("crosstalk", "column_noise"),
    ("offset_jumps", "noise_spread"),
)
ORDINARY = 5


def _single(name: str) -> Recipe:
    hides, build, *amounts = EFFECTS[name]
    return Recipe(hides, lambda a, seed: drawn((build,), (a,), seed), tuple(amounts))


def _pair(names: tuple[str, str]) -> Recipe:
    hides = tuple(kind for n in names for kind in EFFECTS[n][0])
    builds, strong = zip(*((EFFECTS[n][1], EFFECTS[n][3]) for n in names), strict=True)
    return Recipe(hides, lambda a, seed: drawn(builds, strong, seed))


RECIPES: dict[str, Recipe] = {
    **{name: _single(name) for name in EFFECTS},
    **{"+".join(names): _pair(names) for names in PAIRS},
    **{
        f"ordinary_{n}": Recipe((), lambda a, seed: drawn((), (), seed))
        for n in range(1, ORDINARY + 1)
    },
}
