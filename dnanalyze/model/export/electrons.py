"""A model in electrons: the few numbers that other simulators of image sensors take."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.laws import value_at
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import BASE

STEP_C = 5.0  # either side of the reference, over which the doubling temperature is taken
BITS = 16  # where the model has no converter


@dataclass(frozen=True)
class Electrons:
    """A sensor at one operating point, in electrons.

    Parameters
    ----------
    point : OperatingPoint
    dn_per_e : float
        Conversion gain K, DN/e-.
    dark_e_s : float
        Mean dark current, e-/s.
    dark_spread : float
        Standard deviation over the pixels of the logarithm of the dark current.
    doubling_c : float
        Rise of temperature that doubles the mean dark current, C; infinite where it stays.
    read_e : float
        Read noise, rms over the pixels, e-.
    read_spread : float
        Standard deviation over the pixels of the logarithm of the read noise.
    offset_dn : float
        Black level, DN.
    pixel_offset_dn : float
        Standard deviation of the pixels' fixed offsets, DN.
    bits : int
        Of the converter.
    """

    point: OperatingPoint
    dn_per_e: float
    dark_e_s: float
    dark_spread: float
    doubling_c: float
    read_e: float
    read_spread: float
    offset_dn: float
    pixel_offset_dn: float
    bits: int

    @property
    def dark_e(self) -> float:
        """Mean dark signal of an exposure, e-."""
        return self.dark_e_s * self.exposure_s

    @property
    def exposure_s(self) -> float:
        """Exposure, s; one second where the model knows none."""
        return self.point.exposure_s or 1.0


@dataclass(frozen=True)
class Translation:
    """A model in another program's words.

    Parameters
    ----------
    text : str
        Content of the file.
    lost : list of str
        What the other program cannot express, one line each.
    """

    text: str
    lost: list[str]


def in_electrons(model: NoiseModel, temperature_c: float | None = None) -> Electrons:
    """The model at its reference exposure and gain.

    The mean of a log-normal law is exp(mu + delta^2 / 2).

    Parameters
    ----------
    model : NoiseModel
    temperature_c : float, optional
        C; the reference temperature by default.

    Raises
    ------
    InputError
        The model has no dark current or no conversion gain.
    """
    point = model.reference
    if temperature_c is not None:
        point = replace(point, temperature_c=temperature_c)
    base, shot = model.get(BASE), model.get("dark_shot_noise")
    if base is None or shot is None:
        absent = BASE if base is None else "dark_shot_noise"
        raise InputError(
            f"export: the model has no {absent}, which states the signal in electrons; "
            "refit it with that effect (dnanalyze add)"
        )
    read, offsets, converter = map(model.get, ("read_noise", "pixel_fpn", "quantization"))

    def log_mean(celsius: float) -> float:
        there = replace(point, temperature_c=celsius)
        return base.value("mu", there) + base.value("delta", there) ** 2 / 2.0

    gain = shot.value("dn_per_e", point)
    at = point.temperature_c if point.temperature_c is not None else 25.0
    slope = (log_mean(at + STEP_C) - log_mean(at - STEP_C)) / (2.0 * STEP_C)
    spread = 0.0 if read is None else read.value("spread", point)
    sigma = 0.0 if read is None else math.sqrt(read.variance(point) or 0.0)
    return Electrons(
        point=replace(point, temperature_c=at),
        dn_per_e=gain,
        dark_e_s=math.exp(log_mean(at)) / gain / (point.exposure_s or 1.0),
        dark_spread=base.value("delta", point),
        doubling_c=math.log(2.0) / slope if slope > 0.0 else math.inf,
        read_e=sigma / gain,
        read_spread=spread,
        offset_dn=value_at(model.pedestal, point),
        pixel_offset_dn=0.0 if offsets is None else math.sqrt(offsets.variance(point) or 0.0),
        bits=BITS if converter is None else int(getattr(converter, "bits")),  # noqa: B009
    )
