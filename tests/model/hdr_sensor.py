"""Four channels of one virtual pixel array, drawn without any code of the model.

Two conversion gains and two exposures; the dark current of each pixel is one map for all.
"""

from __future__ import annotations

import numpy as np

from dnanalyze.loaders.captures import CaptureSet, Frame, OperatingPoint, Sensor, Setting

BOLTZMANN_EV = 8.617e-5
# channel: (DN/e-, exposure s, read noise e-, black DN)
CHANNELS = {
    "hcg_long": (2.0, 0.1, 1.5, 64.0),
    "hcg_short": (2.0, 0.0125, 1.5, 64.0),
    "lcg_long": (0.5, 0.1, 4.0, 64.0),
    "lcg_short": (0.5, 0.0125, 4.0, 64.0),
}


def rate_map(shape, rng, median=400.0, spread=0.4):
    """Dark current at 45 C, e-/s."""
    return median * np.exp(spread * rng.standard_normal(shape))


def growth(celsius, ea=0.63):
    return np.exp(ea / BOLTZMANN_EV * (1 / 318.15 - 1 / (celsius + 273.15)))


def expose(channel, rate, offset, celsius, rng, light_e=0.0, rows=0.0):
    """One frame of a channel, DN codes; ``rows`` is temporal row noise, DN."""
    gain, seconds, read, black = CHANNELS[channel]
    charge = rate * growth(celsius) * seconds + light_e * seconds / 0.1
    electrons = rng.poisson(charge) + offset + read * rng.standard_normal(rate.shape)
    dn = gain * electrons + black + rows * rng.standard_normal((rate.shape[0], 1))
    return np.clip(np.rint(dn), 0, 4095).astype(np.uint16)


def captures(
    shape=(128, 128), temperatures=(25.0, 45.0, 65.0), frames=4, seed=1, rows=None, hot=0.0
):
    """All channels; ``rows``: channel to temporal row noise, DN; ``hot``: share of pixels."""
    rng = np.random.default_rng(seed)
    rate = rate_map(shape, rng)
    rate = rate + (rng.random(shape) < hot) * rng.exponential(20.0 * 400.0, shape)
    offset = 0.6 * rng.standard_normal(shape)
    settings = []
    for channel, (_, seconds, _, _) in CHANNELS.items():
        for celsius in temperatures:
            point = OperatingPoint(celsius, seconds, 1.0, channel)
            hidden = (rows or {}).get(channel, 0.0)
            made = [expose(channel, rate, offset, celsius, rng, rows=hidden) for _ in range(frames)]
            settings.append(Setting(point, tuple(frame(point, y, n) for n, y in enumerate(made))))
    settings.sort(key=lambda s: s.point.sort_key())
    return CaptureSet("hdr", Sensor(shape, bits=12, black_level=64.0), tuple(settings))


def frame(point, codes, number):
    def load(window):
        return codes.copy() if window is None else np.ascontiguousarray(codes[window.slices])

    return Frame(f"{point.label()} #{number}", point, load)
