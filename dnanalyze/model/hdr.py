"""High dynamic range: the channels of one pixel combined into one linear, companded output.

The most sensitive channel is used as long as it does not near its full scale; above, the next one
takes over, scaled to the same light. At each transition the noise steps, since the next channel's
own noise is multiplied by the ratio of the sensitivities. Solhusvik et al., IISW 2019 (LOFIC, DCG).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import ClassVar

import numpy as np

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import CaptureSet, Frame, OperatingPoint, Sensor, Setting, Window
from dnanalyze.model.effect import Effect, Site, Stage, parameter
from dnanalyze.model.laws import TableLaw
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.simulator import Simulator

# Smallest and largest, DN, DN a DN, times: as for codes, what single precision holds exactly.
_DN = (-float(1 << 24), float(1 << 24))
_USE = {
    "black": _DN, "sensitivity": (1e-6, 1e6), "knee": (0.0, _DN[1]), "blend": (0.0, _DN[1]),
    "exposure": (1e-9, 1e9),
}  # fmt: skip
_MOST_LINEAR = 1e12  # DN of the first channel: 2^24 codes of one 2^16 times less sensitive
_OUTPUT = {"black": _DN, "bits": (1, 24)}


def _check_numbers(where: str, held: object, limits: dict[str, tuple[float, float]]) -> None:
    for name, (least, most) in limits.items():
        value = getattr(held, name)
        number = isinstance(value, (int, float)) and not isinstance(value, bool)
        if not (number and least <= value <= most):
            raise InputError(
                f"{where}: {name} {str(value)[:40]!r}; valid: a number of {least:g} to {most:g}"
            )


@dataclass(frozen=True)
class ChannelUse:
    """How a channel enters the combination.

    Parameters
    ----------
    channel : str
    black : float
        Its black level, DN.
    sensitivity : float
        DN that it gives for light that gives the first channel 1 DN.
    knee : float
        DN above black from which the next channel takes over; no matter in the last one.
    blend : float
        DN below the knee over which the two are mixed; 0 switches.
    exposure : float
        Its exposure over that of the combined frame.
    """

    channel: str
    black: float
    sensitivity: float
    knee: float
    blend: float = 0.0
    exposure: float = 1.0

    def __post_init__(self) -> None:
        _check_numbers(f"channel {str(self.channel)[:40]}", self, _USE)
        if not isinstance(self.channel, str):
            raise InputError(f"channel {str(self.channel)[:40]!r} is no text; quote it")


@dataclass(frozen=True)
class Combination:
    """A linear combination of channels with piecewise-linear companding.

    Parameters
    ----------
    channels : tuple of ChannelUse
        Most sensitive first.
    companding : tuple of (float, float)
        Knees (linear DN of the first channel, output code), rising; none leaves the output linear.
    black : float
        Output code of no light where there is no companding.
    bits : int
        Of the output.
    """

    channels: tuple[ChannelUse, ...]
    companding: tuple[tuple[float, float], ...] = ()
    black: float = 64.0
    bits: int = 12

    def __post_init__(self) -> None:
        _check_numbers("combination", self, _OUTPUT)
        if type(self.bits) is not int:
            raise InputError(f"combination: bits {self.bits} is no whole number")
        if len(self.channels) < 2:
            raise InputError("combination: needs two channels or more")
        steps = [c.sensitivity for c in self.channels]
        if any(a <= b for a, b in pairwise(steps)):
            raise InputError(
                "combination: give the most sensitive channel first, sensitivity falling"
            )
        knees = np.array(self.companding, float).reshape(-1, 2)
        if not np.all(np.abs(knees) < _MOST_LINEAR):  # NaN neither
            raise InputError(f"combination: companding knees must be below {_MOST_LINEAR:g} DN")
        if len(knees) and (len(knees) < 2 or np.any(np.diff(knees, axis=0) <= 0)):
            raise InputError("combination: companding needs two knees or more, rising in both")

    @property
    def names(self) -> list[str]:
        """The channels."""
        return [c.channel for c in self.channels]

    def linear(self, frames: Mapping[str, np.ndarray]) -> np.ndarray:
        """Light of each pixel in DN of the first channel, from the frames of all channels.

        Parameters
        ----------
        frames : mapping
            Channel to pixels, DN as recorded.
        """
        missing = [c.channel for c in self.channels if c.channel not in frames]
        if missing:
            raise InputError(
                f"combination: no frames of channel {missing[0]!r}; there are {', '.join(frames)}"
            )
        last = self.channels[-1]
        out = (frames[last.channel].astype(np.float32) - last.black) / last.sensitivity
        for use in self.channels[-2::-1]:
            own = frames[use.channel].astype(np.float32) - np.float32(use.black)
            if use.blend > 0:
                share = np.clip((own - (use.knee - use.blend)) / use.blend, 0.0, 1.0)
            else:
                share = (own >= use.knee).astype(np.float32)
            out = (1.0 - share) * own / np.float32(use.sensitivity) + share * out
        return out.astype(np.float32)

    def encode(self, linear: np.ndarray) -> np.ndarray:
        """Output codes of linear light: companded, rounded, clipped."""
        if self.companding:
            x, y = np.array(self.companding, float).T
            code = np.interp(linear, x, y)
            low, high = (y[1] - y[0]) / (x[1] - x[0]), (y[-1] - y[-2]) / (x[-1] - x[-2])
            code = np.where(linear < x[0], y[0] + (linear - x[0]) * low, code)
            code = np.where(linear > x[-1], y[-1] + (linear - x[-1]) * high, code)
        else:
            code = linear + self.black
        return np.clip(np.rint(code), 0, 2**self.bits - 1).astype(np.float32)

    def decode(self, codes: np.ndarray) -> np.ndarray:
        """Linear light of output codes."""
        if not self.companding:
            return codes - np.float32(self.black)
        x, y = np.array(self.companding, float).T
        return np.interp(codes, y, x).astype(np.float32)

    def combine(self, frames: Mapping[str, np.ndarray]) -> np.ndarray:
        """Output codes of the frames of all channels."""
        return self.encode(self.linear(frames))

    @property
    def transitions(self) -> list[tuple[str, str, float]]:
        """(from, to, linear light in DN of the first channel) of each change of channel."""
        pairs = pairwise(self.channels)
        return [(a.channel, b.channel, a.knee / a.sensitivity) for a, b in pairs]


@dataclass(frozen=True)
class Light(Effect):
    """Uniform light on top of the dark charge, so that a model reaches the transitions."""

    name: ClassVar[str] = "light"
    stage: ClassVar[Stage] = Stage.CHARGE
    summary: ClassVar[str] = "uniform light, for the noise at the transitions of an HDR combination"

    level: float = parameter(0.0, "DN", 0.0, 1e7, "signal that it adds")

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Add it."""
        signal += np.float32(self.value("level", site.point))
        return signal


def lit(model: NoiseModel, how: Combination, light: float) -> NoiseModel:
    """The model under uniform light of so many DN of the first channel."""
    points = tuple(OperatingPoint(channel=c.channel) for c in how.channels)
    levels = TableLaw(points, tuple(light * c.sensitivity for c in how.channels))
    return model.with_effect(Light(levels)) if light > 0 else model  # type: ignore[arg-type]


def simulate_combined(
    model: NoiseModel,
    how: Combination,
    shape: tuple[int, int],
    settings: Sequence[tuple[OperatingPoint, int]],
    name: str = "combined simulation",
    light: float = 0.0,
) -> CaptureSet:
    """Combined frames of a model whose parameters are tables over channels.

    The silicon (dark-current map, hot pixels, pixel offsets) is one for all channels; each channel
    has its own readout noise and its own shot noise, as separate exposures have.

    Parameters
    ----------
    model : NoiseModel
    how : Combination
    shape : tuple of int
        (rows, columns).
    settings : sequence of (OperatingPoint, int)
        Of the combined frames, without a channel.
    name : str
    light : float
        Uniform light, DN of the first channel.
    """
    simulator = Simulator(lit(model, how, light), shape)

    def load(point: OperatingPoint, number: int) -> Callable[[Window | None], np.ndarray]:
        def read(window: Window | None) -> np.ndarray:
            frames = {
                use.channel: simulator.frame(channel_point(point, use), number, window)
                for use in how.channels
            }
            return how.combine(frames)

        return read

    made = tuple(
        Setting(
            point,
            tuple(Frame(f"{point.label()} #{n}", point, load(point, n)) for n in range(count)),
        )
        for point, count in settings
    )
    return CaptureSet(name, Sensor(shape, bits=how.bits), made)


def channel_point(point: OperatingPoint, use: ChannelUse) -> OperatingPoint:
    """Where a channel is when the combined frame is at ``point``."""
    seconds = None if point.exposure_s is None else point.exposure_s * use.exposure
    return replace(point, channel=use.channel, exposure_s=seconds)


@dataclass(frozen=True)
class NoiseStep:
    """Noise around a change of channel.

    Parameters
    ----------
    before, after : str
        Channels.
    light : float
        Where, linear DN of the first channel.
    below, above : float
        Temporal noise just below and above, linear DN.
    """

    before: str
    after: str
    light: float
    below: float
    above: float

    @property
    def step_db(self) -> float:
        """20 log10 of the ratio."""
        return float(20 * np.log10(self.above / self.below))


def noise_steps(
    frames: Callable[[float], CaptureSet], how: Combination, distance: float = 0.15
) -> list[NoiseStep]:
    """Temporal noise on both sides of each transition.

    Parameters
    ----------
    frames : callable
        Combined frames under uniform light of so many linear DN, two or more.
    how : Combination
    distance : float
        How far from a transition, as a share of its light; beyond the blend.
    """
    made = []
    for before, after, light in how.transitions:
        use = how.channels[how.names.index(before)]
        low = light * (1 - distance) - use.blend / use.sensitivity
        below, above = (_temporal(frames(x), how) for x in (low, light * (1 + distance)))
        made.append(NoiseStep(before, after, light, below, above))
    return made


def _temporal(captures: CaptureSet, how: Combination) -> float:
    """Temporal noise of the first setting's first two frames, linear DN."""
    a, b = (how.decode(f.read().astype(np.float32)) for f in captures.settings[0].frames[:2])
    return float(np.std(a - b) / np.sqrt(2.0))
