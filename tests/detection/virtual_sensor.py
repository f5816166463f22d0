"""Random virtual sensors for tests of the detection, sharing no code with dnanalyze's model."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from scipy import fft, ndimage

from dnanalyze.loaders.captures import CaptureSet, Frame, OperatingPoint, Sensor, Setting

BOLTZMANN_EV_K = 8.617e-5
BAYER = (("R", "G"), ("G", "B"))
Stack = np.ndarray  # (frames, rows, columns), DN as recorded


@dataclass(frozen=True)
class Traits:
    """What a virtual sensor is made of; amplitudes in electrons unless said otherwise."""

    gain: float = 1.0  # DN/e-
    read: float = 3.0
    read_spread: float = 0.1  # log-normal sd of the read noise over pixels
    dark: float = 3.0  # mean dark charge at 25 C
    ea_ev: float = 0.63
    dsnu: float = 0.3
    offset: float = 1.0  # pixel offsets
    hot: float = 1e-3  # fraction
    hot_scale: float = 20.0  # mean dark charge of hot pixels over the mean
    hot_ea_ev: float = 0.52
    clusters: float = 0.0  # fraction of the hot pixels that come in clusters
    cluster_size: float = 4.0
    crosstalk: float = 0.0  # phi, share that each of 8 neighbours gets
    column_fpn: float = 0.0
    row_fpn: float = 0.0
    row_noise: float = 0.0
    column_noise: float = 0.0
    flicker: float = 0.0  # raster 1/f
    pink: float = 0.0  # two-dimensional 1/f, new each frame
    pink_fixed: float = 0.0
    pink_slope: float = 1.0
    hum: float = 0.0  # periodic pattern, random phase
    hum_at: tuple[float, float] = (0.17, 0.05)  # down the rows, along them, cycles/pixel
    rts: float = 0.0  # fraction of blinking pixels
    rts_e: float = 15.0
    heavy: float = 0.0  # share of read noise with tails three times as wide
    plane_offset: float = 0.0
    plane_gain: float = 0.0
    glow: float = 0.0
    drift: float = 0.0  # relative growth of the dark current per frame
    cosmic: float = 0.0  # hits a frame per 512x512
    comb: float = 1.0  # digital gain
    pedestal: float = 100.0
    white: float = 16383.0


def random_traits(rng: np.random.Generator) -> Traits:
    """An unfiltered sensor out of the range that the field makes, each nuisance in some of them."""

    def some(chance: float, low: float, high: float) -> float:
        return (
            float(np.exp(rng.uniform(np.log(low), np.log(high)))) if rng.random() < chance else 0.0
        )

    read = float(np.exp(rng.uniform(np.log(1.2), np.log(8.0))))
    kind = rng.choice(["ordinary", "coarse", "eight_bit"], p=[0.7, 0.2, 0.1])
    noise_dn = {"ordinary": (0.8, 12.0), "coarse": (0.25, 0.5), "eight_bit": (0.25, 1.0)}[kind]
    gain = float(np.exp(rng.uniform(*np.log(noise_dn)))) / read
    return Traits(
        gain=gain,
        read=read,
        read_spread=float(rng.uniform(0.02, 0.3)),
        dark=float(np.exp(rng.uniform(np.log(0.3), np.log(20.0)))),
        ea_ev=float(rng.uniform(0.55, 0.75)),
        dsnu=float(rng.uniform(0.1, 0.5)),
        offset=read * float(rng.uniform(0.1, 1.5)),
        hot=some(0.8, 1e-4, 5e-3),
        hot_scale=float(np.exp(rng.uniform(np.log(5.0), np.log(60.0)))),
        hot_ea_ev=float(rng.uniform(0.45, 0.62)),
        clusters=float(rng.uniform(0.2, 1.0)) if rng.random() < 0.3 else 0.0,
        cluster_size=float(rng.uniform(2.0, 6.0)),
        crosstalk=some(0.5, 1e-3, 0.02),
        column_fpn=read * some(0.5, 0.05, 1.5),
        row_fpn=read * some(0.4, 0.05, 1.0),
        row_noise=read * some(0.5, 0.05, 1.0),
        column_noise=read * some(0.3, 0.05, 0.5),
        flicker=read * some(0.3, 0.1, 1.5),
        pink=read * some(0.25, 0.1, 1.0),
        pink_fixed=read * some(0.25, 0.1, 1.5),
        pink_slope=float(rng.uniform(0.7, 1.6)),
        hum=read * some(0.2, 0.1, 1.0),
        rts=some(0.4, 1e-3, 3e-2),
        rts_e=read * float(rng.uniform(1.5, 8.0)),
        heavy=some(0.3, 0.01, 0.1),
        plane_offset=read * some(0.3, 0.1, 2.0),
        plane_gain=some(0.3, 0.01, 0.1),
        glow=some(0.3, 5.0, 300.0),
        drift=some(0.3, 1e-3, 2e-2),
        cosmic=some(0.3, 0.5, 20.0),
        comb=float(rng.uniform(1.05, 1.7)) if rng.random() < 0.1 else 1.0,
        pedestal=float(rng.choice([2.0, 64.0, 240.0], p=[0.15, 0.6, 0.25]))
        if kind != "eight_bit"
        else 8.0,
        white=255.0 if kind == "eight_bit" else float(2 ** rng.choice([10, 12, 14, 16]) - 1),
        hum_at=(float(rng.uniform(0.0, 0.5)), float(rng.uniform(-0.5, 0.5))),
    )


@dataclass
class VirtualSensor:
    """The silicon of one sensor; ``stack`` exposes it.

    The planes of a mosaic differ in offset and gain only: in the dark there is no colour.
    """

    traits: Traits
    shape: tuple[int, int]
    seed: int
    _dark: np.ndarray = field(init=False)
    _hot: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        t, rng = self.traits, np.random.default_rng([self.seed, 0])
        h, w = self.shape
        normal = lambda *s: rng.standard_normal(s or self.shape, dtype=np.float32)  # noqa: E731
        self._dark = np.exp(t.dsnu * normal() - t.dsnu**2 / 2) * t.dark
        self._hot = t.dark * t.hot_scale * _hot_pixels(t, self.shape, rng)
        self._read = t.read * np.exp(t.read_spread * normal())
        self._fixed = t.offset * normal() + t.column_fpn * normal(1, w) + t.row_fpn * normal(h, 1)
        self._gain = np.full(self.shape, np.float32(t.gain))
        for phase in range(4):
            block = (slice(phase // 2, None, 2), slice(phase % 2, None, 2))
            self._fixed[block] += t.plane_offset * rng.standard_normal()
            self._gain[block] *= 1 + t.plane_gain * rng.standard_normal()
        if t.pink_fixed:
            self._fixed += t.pink_fixed * _pink(self.shape, t.pink_slope, rng)
        yy, xx = np.ogrid[0:h, 0:w]
        self._glow = t.glow * np.exp(-(yy / (0.2 * h) + xx / (0.2 * w))).astype(np.float32)
        blink = rng.random(self.shape) < t.rts
        self._rts = np.where(blink, t.rts_e * rng.exponential(1.0, self.shape), 0).astype(
            np.float32
        )
        self._switch = rng.uniform(0.05, 0.5, self.shape).astype(np.float32)

    def charge(self, temperature_c: float) -> np.ndarray:
        """Mean dark charge of each pixel, electrons."""
        t = self.traits
        warm = _arrhenius(temperature_c, t.ea_ev)
        hot = self._hot * _arrhenius(temperature_c, t.hot_ea_ev)
        return self._dark * warm + hot + self._glow * warm

    def held(self, arrived: np.ndarray) -> np.ndarray:
        """Electrons that stay in the pixels; all, without a full well."""
        return arrived

    def stack(self, temperature_c: float, frames: int) -> Stack:
        """``frames`` dark frames at a temperature, DN as recorded, uint16."""
        t = self.traits
        rng = np.random.default_rng([self.seed, 1, round(10 * temperature_c) + 5000])
        charge = self.charge(temperature_c)
        state = rng.random(self.shape) < 0.5
        out = np.empty((frames, *self.shape), np.uint16)
        for n in range(frames):
            state ^= rng.random(self.shape, dtype=np.float32) < self._switch
            out[n] = self._frame(charge * np.float32(1 + t.drift * n), state, rng)
        return out

    def _frame(self, charge: np.ndarray, state: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        t = self.traits
        h, w = self.shape
        normal = lambda *s: rng.standard_normal(s or self.shape, dtype=np.float32)  # noqa: E731
        e = charge + state * self._rts
        arrived = rng.poisson(e).astype(np.float32)
        if t.cosmic:
            _hits(arrived, t.cosmic * h * w / 512**2, rng)
        if t.crosstalk:
            kernel = np.full((3, 3), t.crosstalk, np.float32)
            kernel[1, 1] = 1 - 8 * t.crosstalk
            arrived = ndimage.convolve(arrived, kernel, mode="nearest")
        arrived = self.held(arrived)
        read = self._read * normal()
        if t.heavy:
            read = np.where(rng.random(self.shape) < t.heavy, 3 * read, read)
        e = (
            arrived
            + read
            + self._fixed
            + t.row_noise * normal(h, 1)
            + t.column_noise * normal(1, w)
        )
        if t.flicker:
            e += t.flicker * _raster_flicker(self.shape, rng)
        if t.pink:
            e += t.pink * _pink(self.shape, t.pink_slope, rng)
        if t.hum:
            yy, xx = np.ogrid[0:h, 0:w]
            u, v = t.hum_at
            e += t.hum * 1.41 * np.sin(2 * np.pi * (u * yy + v * xx + rng.random()))
        dn = np.clip(np.round(self._gain * e + t.pedestal), 0, t.white)
        if t.comb != 1:
            dn = np.clip(np.round(dn * t.comb), 0, 65535)
        return dn.astype(np.uint16)


def captures(
    sensor: VirtualSensor,
    temperatures_c: tuple[float, ...] = (25.0, 45.0, 65.0, 85.0, 105.0),
    frames: int = 8,
    filtering: Callable[[Stack], Stack] | None = None,
    cfa: tuple[tuple[str, ...], ...] | None = None,
) -> CaptureSet:
    """A temperature series, drawn when first asked for."""
    held: dict[float, Stack] = {}

    def stack(temperature: float) -> Stack:
        if temperature not in held:
            made = sensor.stack(temperature, frames)
            held[temperature] = made if filtering is None else filtering(made)
        return held[temperature]

    return from_stacks({c: lambda c=c: stack(c) for c in temperatures_c}, sensor.shape, frames, cfa)


def from_stacks(
    stacks: dict[float | None, Callable[[], Stack]],
    shape: tuple[int, int],
    frames: int,
    cfa: tuple[tuple[str, ...], ...] | None = None,
) -> CaptureSet:
    """A capture set over functions that give the frames of a temperature."""
    settings = []
    for temperature, make in stacks.items():
        point = OperatingPoint(temperature, 0.1)

        def load(window, make=make, n=0):
            frame = make()[n]
            return np.ascontiguousarray(frame if window is None else frame[window.slices])

        settings.append(
            Setting(
                point,
                tuple(
                    Frame(f"{n}", point, lambda window, load=load, n=n: load(window, n=n))
                    for n in range(frames)
                ),
            )
        )
    return CaptureSet("virtual", Sensor(shape, cfa=cfa), tuple(settings))


def _arrhenius(temperature_c: float, ea_ev: float) -> float:
    k = 273.15
    return float(np.exp(-ea_ev / BOLTZMANN_EV_K * (1 / (temperature_c + k) - 1 / (25 + k))))


def _hot_pixels(t: Traits, shape: tuple[int, int], rng: np.random.Generator) -> np.ndarray:
    """Dark charge of hot pixels, in units of their mean; singles and Neyman-Scott clusters."""
    field = np.zeros(shape, np.float32)
    count = rng.poisson(t.hot * field.size)
    clustered = int(count * t.clusters)
    singles = count - clustered
    np.add.at(
        field,
        (rng.integers(0, shape[0], singles), rng.integers(0, shape[1], singles)),
        rng.exponential(1.0, singles).astype(np.float32),
    )
    parents = int(clustered / t.cluster_size)
    size = rng.poisson(t.cluster_size, parents)
    y = np.repeat(rng.integers(0, shape[0], parents), size) + np.round(
        rng.normal(0, 1.0, size.sum())
    )
    x = np.repeat(rng.integers(0, shape[1], parents), size) + np.round(
        rng.normal(0, 1.0, size.sum())
    )
    amplitude = np.repeat(rng.exponential(1.0, parents), size) * rng.exponential(1.0, size.sum())
    index = (y.astype(int) % shape[0], x.astype(int) % shape[1])
    np.add.at(field, index, amplitude.astype(np.float32))
    return field


def _hits(arrived: np.ndarray, mean: float, rng: np.random.Generator) -> None:
    """Charged-particle tracks: straight, a few pixels to tens of pixels long."""
    h, w = arrived.shape
    for _ in range(rng.poisson(mean)):
        y, x, angle = rng.uniform(0, h), rng.uniform(0, w), rng.uniform(0, np.pi)
        steps = np.arange(1 + rng.geometric(0.2))
        yy = np.clip(y + steps * np.sin(angle), 0, h - 1).astype(int)
        xx = np.clip(x + steps * np.cos(angle), 0, w - 1).astype(int)
        arrived[yy, xx] += rng.exponential(400.0, steps.size)


def _pink(shape: tuple[int, int], slope: float, rng: np.random.Generator) -> np.ndarray:
    """Two-dimensional field of power rho^-slope and unit variance."""
    h, w = shape
    rho = np.hypot(np.fft.fftfreq(h)[:, None], np.fft.rfftfreq(w)[None]).astype(np.float32)
    rho[0, 0] = 1
    amplitude = rho ** np.float32(-slope / 2)
    amplitude[0, 0] = 0
    spectrum = fft.rfft2(rng.standard_normal(shape, dtype=np.float32)) * amplitude
    field = fft.irfft2(spectrum, s=shape)
    return (field / field.std()).astype(np.float32)


def _raster_flicker(shape: tuple[int, int], rng: np.random.Generator) -> np.ndarray:
    """1/f over the scan, row after row, unit variance."""
    n = shape[0] * shape[1]
    f = np.fft.rfftfreq(n).astype(np.float32)
    f[0] = np.inf
    series = fft.irfft(fft.rfft(rng.standard_normal(n, dtype=np.float32)) / np.sqrt(f), n)
    return (series / series.std()).astype(np.float32).reshape(shape)
