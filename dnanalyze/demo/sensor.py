"""An ordinary sensor in a handful of numbers, and how to draw one at random."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

BOLTZMANN_EV = 8.617e-5  # eV/K
REFERENCE_C = 25.0
WHITE_DN = 4095  # 12 bits


def arrhenius(temperature_c: float, ea_ev: float, reference_c: float = REFERENCE_C) -> float:
    """Growth of a thermally activated rate from the reference temperature to this one."""
    kelvin, reference = temperature_c + 273.15, reference_c + 273.15
    return math.exp(ea_ev / BOLTZMANN_EV * (1.0 / reference - 1.0 / kelvin))


@dataclass(frozen=True)
class VirtualSensor:
    """A sensor with nothing but what every sensor has.

    Parameters
    ----------
    gain_dn_e : float
        Conversion gain, DN/e-.
    read_noise_e : float
        Gaussian read noise, e-.
    pixel_offset_e : float
        Standard deviation of the fixed Gaussian offsets of the pixels, e-.
    dark_e_s : float
        Median dark current at 25 C, e-/s.
    dark_spread : float
        Standard deviation of the logarithm of a pixel's dark current.
    activation_ev : float
        Activation energy of the dark current, eV.
    pedestal_dn : float
        Black level, DN.
    exposure_s : float
        Integration time, s.
    temperatures_c : tuple of float
        Temperatures at which it is usually taken, C, rising.
    """

    gain_dn_e: float = 1.0
    read_noise_e: float = 2.0
    pixel_offset_e: float = 0.8
    dark_e_s: float = 10.0
    dark_spread: float = 0.4
    activation_ev: float = 0.62
    pedestal_dn: float = 64.0
    exposure_s: float = 0.05
    temperatures_c: tuple[float, ...] = (25.0, 45.0, 65.0, 85.0, 105.0)

    @property
    def noise_e(self) -> float:
        """Temporal noise of a pixel without dark current, rounding (1/12 DN^2) included, e-."""
        return math.hypot(self.read_noise_e, 1.0 / (self.gain_dn_e * math.sqrt(12.0)))

    @property
    def noise_dn(self) -> float:
        """The same in DN."""
        return self.gain_dn_e * self.noise_e

    @property
    def hottest_c(self) -> float:
        """The highest of its usual temperatures, C."""
        return self.temperatures_c[-1]

    def dark_e(self, temperature_c: float) -> float:
        """Mean dark charge of an exposure, e-: median exp(s^2/2) times Arrhenius."""
        median = self.dark_e_s * self.exposure_s * arrhenius(temperature_c, self.activation_ev)
        return median * math.exp(self.dark_spread**2 / 2.0)

    def dsnu_e(self, temperature_c: float) -> float:
        """Standard deviation over the pixels of their mean, e-: log-normal charge and offsets."""
        relative = math.sqrt(math.expm1(self.dark_spread**2))
        return math.hypot(self.dark_e(temperature_c) * relative, self.pixel_offset_e)

    def spread_e(self, temperature_c: float) -> float:
        """Standard deviation over the pixels of one frame, e-: pattern, shot and read noise."""
        temporal = math.sqrt(self.noise_e**2 + self.dark_e(temperature_c))
        return math.hypot(self.dsnu_e(temperature_c), temporal)


def draw_sensor(rng: np.random.Generator) -> VirtualSensor:
    """A sensor at random, over the ranges of today's image sensors.

    Five temperatures, the lowest between 5 and 30 C, 10 to 20 C apart; at the highest the dark
    charge has a shot noise clearly above the read noise and stays below a fifth of full scale.
    Noise of at least .4 DN, without which rounding rules, and a pedestal of at least 8 times it.
    """
    gain, read = 0.0, 0.0
    while gain * read < 0.4:
        gain, read = _log_uniform(rng, 0.1, 4.0), _log_uniform(rng, 0.8, 5.0)
    offset = float(rng.uniform(0.3, 1.5))
    spread, activation = float(rng.uniform(0.15, 0.8)), float(rng.uniform(0.55, 1.0))
    exposure = _log_uniform(rng, 0.01, 1.0)
    start, step = float(rng.choice([5, 15, 25, 30])), float(rng.choice([10, 15, 20]))
    temperatures = tuple(start + step * n for n in range(5))
    brightest = 0.2 * WHITE_DN / gain
    dark = min(max(20.0, read**2 * _log_uniform(rng, 3.0, 30.0)), brightest)
    rate = dark / (exposure * arrhenius(temperatures[-1], activation) * math.exp(spread**2 / 2))
    room = max(16.0, 8.0 * gain * math.hypot(read, offset))
    pedestal = float(round(_log_uniform(rng, room, 256.0)))
    return VirtualSensor(
        gain, read, offset, rate, spread, activation, pedestal, exposure, temperatures
    )


def _log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    return float(math.exp(rng.uniform(math.log(low), math.log(high))))
