"""Hidden effects of the charge: dark current, traps, light and particles."""

from __future__ import annotations

from typing import Any

import numpy as np

from dnanalyze.demo.hidden import HiddenEffect, Moment, Scene, Step
from dnanalyze.demo.sensor import VirtualSensor

Generator = np.random.Generator
Plain = dict[str, Any]


def _thermal_map(scene: Scene, excess_e: np.ndarray, activation_ev: float) -> Step:
    """Extra dark current, given as e- of an exposure at the sensor's highest temperature."""
    sensor = scene.sensor

    def apply(rate: np.ndarray, now: Moment) -> np.ndarray:
        growth = now.thermal(activation_ev, sensor.hottest_c)
        return rate + excess_e * (growth / sensor.exposure_s)

    return Step("rate", apply)


def _hot_draw(sensor: VirtualSensor, amount: float, rng: Generator) -> Plain:
    # Field-enhanced generation: an activation energy below that of the bulk.
    return {
        "fraction": amount,
        "e": 8.0 * sensor.spread_e(sensor.hottest_c),
        "activation_ev": float(sensor.activation_ev * rng.uniform(0.75, 0.95)),
    }


def _hot_pixels(
    scene: Scene, rng: Generator, fraction: float, e: float, activation_ev: float
) -> Step:
    """D += Exp(e) at a fraction of the pixels."""
    excess = np.zeros(scene.shape)
    sites = scene.random_pixels(rng, fraction)
    excess.flat[sites] = rng.exponential(e, sites.size)
    return _thermal_map(scene, excess, activation_ev)


def _cluster_draw(sensor: VirtualSensor, amount: float, rng: Generator) -> Plain:
    return _hot_draw(sensor, amount, rng) | {"offspring": 5.0, "radius": 1.5}


def _hot_clusters(
    scene: Scene,
    rng: Generator,
    fraction: float,
    e: float,
    activation_ev: float,
    offspring: float,
    radius: float,
) -> Step:
    """Neyman-Scott: Poisson parents, Poisson offspring uniform in a disc, each with Exp(e)."""
    rows, columns = scene.shape
    excess = np.zeros(scene.shape)
    parents = rng.uniform((0, 0), (rows, columns), (rng.poisson(fraction * rows * columns), 2))
    children = np.repeat(parents, rng.poisson(offspring, len(parents)), axis=0)
    far = radius * np.sqrt(rng.random(len(children)))
    angle = rng.uniform(0, 2 * np.pi, len(children))
    children += np.column_stack([far * np.sin(angle), far * np.cos(angle)])
    r, c = np.floor(children).astype(int).T
    inside = (r >= 0) & (r < rows) & (c >= 0) & (c < columns)
    np.add.at(excess, (r[inside], c[inside]), rng.exponential(e, int(inside.sum())))
    return _thermal_map(scene, excess, activation_ev)


def _steps_draw(sensor: VirtualSensor, amount: float, rng: Generator) -> Plain:
    return {
        "mean_atoms": amount,
        "e": 5.0 * sensor.spread_e(sensor.hottest_c),
        "activation_ev": float(rng.uniform(0.3, 0.55)),  # metals: W .37, Mo .3, Fe .4-.5 eV
    }


def _dark_current_steps(
    scene: Scene, rng: Generator, mean_atoms: float, e: float, activation_ev: float
) -> Step:
    """D += n q, n Poisson: metal atoms, each with the same current."""
    return _thermal_map(scene, e * rng.poisson(mean_atoms, scene.shape), activation_ev)


def _generation_draw(sensor: VirtualSensor, amount: float, rng: Generator) -> Plain:
    # Generation in depleted silicon: down to about half of the activation energy of diffusion.
    return {"share": amount, "less_ev": float(sensor.activation_ev * rng.uniform(0.1, 0.4))}


def _generation(scene: Scene, rng: Generator, share: float, less_ev: float) -> Step:
    """D (1 + s (e - 1)), e ~ Exp(1), ``s`` = ``share`` at the highest temperature: of a pixel with
    one defect of exponential strength, beside diffusion.
    """
    defect = rng.exponential(1.0, scene.shape)

    def apply(rate: np.ndarray, now: Moment) -> np.ndarray:
        part = min(1.0, share * now.thermal(-less_ev, scene.sensor.hottest_c))
        return rate * (1.0 + part * (defect - 1.0))

    return Step("rate", apply)


def _rts_draw(sensor: VirtualSensor, amount: float, rng: Generator) -> Plain:
    # Half of the sensors blink in the source follower, alike at every temperature.
    thermal = rng.random() < 0.5
    amplitude = 3.0 * sensor.spread_e(sensor.hottest_c) if thermal else 6.0 * sensor.noise_e
    return {
        "fraction": amount,
        "e": amplitude,
        "activation_ev": float(rng.uniform(0.4, 0.7)) if thermal else 0.0,
        "frames_high": float(rng.uniform(1.0, 6.0)),
        "frames_low": float(rng.uniform(1.0, 12.0)),
    }


def _rts(
    scene: Scene,
    rng: Generator,
    fraction: float,
    e: float,
    activation_ev: float,
    frames_high: float,
    frames_low: float,
) -> Step:
    """Two-state Markov charge, ``e`` at the highest temperature: variance A^2 p (1 - p)."""
    sites = scene.random_pixels(rng, fraction)
    leave_high, leave_low = -np.expm1(-1 / frames_high), -np.expm1(-1 / frames_low)
    occupied = leave_low / (leave_low + leave_high)

    def apply(charge: np.ndarray, now: Moment) -> np.ndarray:
        luck = now.rng.random(sites.size)
        high = now.memory.get("high")
        if high is None:
            high = luck < occupied
        else:
            high = np.where(high, luck >= leave_high, luck < leave_low)
        now.memory["high"] = high
        changed = charge.copy()
        changed.flat[sites[high]] += e * now.thermal(activation_ev, scene.sensor.hottest_c)
        return changed

    return Step("charge", apply)


def _glow_draw(sensor: VirtualSensor, amount: float, rng: Generator) -> Plain:
    return {
        "e_s": amount * sensor.noise_e / sensor.exposure_s,
        "length": float(rng.uniform(0.1, 0.4)),
        "corner": [int(rng.integers(2)), int(rng.integers(2))],
    }


def _amp_glow(scene: Scene, rng: Generator, e_s: float, length: float, corner: list[int]) -> Step:
    """D += a exp(-r/l) from a corner (row, column), l in widths of the frame; not thermal."""
    away = np.hypot(
        scene.row - corner[0] * (scene.shape[0] - 1),
        scene.column - corner[1] * (scene.shape[1] - 1),
    )
    glow = e_s * np.exp(-away / (length * scene.shape[1]))
    return Step("rate", lambda rate, now: rate + glow)


def _gradient_draw(sensor: VirtualSensor, amount: float, rng: Generator) -> Plain:
    angle, bow = rng.uniform(0, 2 * np.pi), rng.random()
    return {"relative": amount, "angle": float(angle), "bow": float(bow)}


def _dark_gradient(scene: Scene, rng: Generator, relative: float, angle: float, bow: float) -> Step:
    """D (1 + g), g a plane with ``bow`` of a bowl, mean 0, ``relative`` from end to end."""
    y = scene.row / (scene.shape[0] - 1) - 0.5
    x = scene.column / (scene.shape[1] - 1) - 0.5
    surface = x * np.cos(angle) + y * np.sin(angle) + bow * 2.0 * (x**2 + y**2)
    surface = (surface - surface.mean()) / np.ptp(surface)
    return Step("rate", lambda rate, now: rate * (1.0 + relative * surface))


def _storage_draw(sensor: VirtualSensor, amount: float, rng: Generator) -> Plain:
    return {
        "e": amount * sensor.spread_e(sensor.hottest_c),
        "variation": float(rng.uniform(0.5, 1.2)),
        "hold": float(rng.uniform(0.0, 2.0)),
        "activation_ev": float(rng.uniform(0.5, 0.7)),
        "upward": bool(rng.random() < 0.5),
    }


def _storage_dark_current(
    scene: Scene,
    rng: Generator,
    e: float,
    variation: float,
    hold: float,
    activation_ev: float,
    upward: bool,
) -> Step:
    """Charge of storage nodes while rows are read: Gamma over the pixels, ``e`` on average in the
    row read last at the highest temperature, whatever the exposure.
    """
    rows = scene.shape[0]
    wait = (hold + scene.row / (rows - 1)) / (hold + 1.0)
    nodes = (
        rng.gamma(variation**-2, variation**2, scene.shape) * e * (wait[::-1] if upward else wait)
    )

    def apply(charge: np.ndarray, now: Moment) -> np.ndarray:
        return charge + nodes * now.thermal(activation_ev, scene.sensor.hottest_c)

    return Step("charge", apply)


def _cosmic_draw(sensor: VirtualSensor, amount: float, rng: Generator) -> Plain:
    # 80 e-/um in a few um of silicon.
    return {"per_megapixel": amount, "e": 400.0, "length": 4.0}


def _cosmic_rays(
    scene: Scene, rng: Generator, per_megapixel: float, e: float, length: float
) -> Step:
    """Poisson tracks, each with Exp(length) pixels of path and Exp(e) electrons a pixel of path."""
    rows, columns = scene.shape
    expected = per_megapixel * 1e-6 * rows * columns

    def apply(charge: np.ndarray, now: Moment) -> np.ndarray:
        hit = charge.astype(float)
        for _ in range(now.rng.poisson(expected)):
            start, angle = now.rng.uniform((0, 0), (rows, columns)), now.rng.uniform(0, 2 * np.pi)
            path = 1.0 + now.rng.exponential(length)
            along = np.arange(0.0, path, 0.25)
            r = np.floor(start[0] + along * np.sin(angle)).astype(int)
            c = np.floor(start[1] + along * np.cos(angle)).astype(int)
            inside = (r >= 0) & (r < rows) & (c >= 0) & (c < columns)
            np.add.at(hit, (r[inside], c[inside]), 0.25 * now.rng.exponential(e))
        return hit

    return Step("arrived", apply)


def _lag_draw(sensor: VirtualSensor, amount: float, rng: Generator) -> Plain:
    return {"share": amount, "frames": float(rng.uniform(0.7, 2.0))}


def _persistence(scene: Scene, rng: Generator, share: float, frames: float) -> Step:
    """y_n = q_n + a sum over k of exp(-k/tau) q_(n-k): charge caught and given back later."""
    decay = np.exp(-1.0 / frames)

    def apply(charge: np.ndarray, now: Moment) -> np.ndarray:
        caught = now.memory.get("caught", 0.0)
        now.memory["caught"] = decay * (caught + charge)
        return charge + share * caught

    return Step("arrived", apply, warm_up=10)


def _crosstalk_draw(sensor: VirtualSensor, amount: float, rng: Generator) -> Plain:
    return {"share": amount, "diagonal": float(rng.uniform(0.1, 0.6))}


def _crosstalk(scene: Scene, rng: Generator, share: float, diagonal: float) -> Step:
    """Interpixel capacitance: ``share`` to 4 neighbours, ``diagonal`` of it to the corners."""
    kernel = share * np.array([[diagonal, 1, diagonal], [1, 0, 1], [diagonal, 1, diagonal]])
    kernel[1, 1] = 1.0 - kernel.sum()

    def apply(charge: np.ndarray, now: Moment) -> np.ndarray:
        from scipy.ndimage import convolve

        return convolve(charge.astype(float), kernel, mode="nearest")

    return Step("arrived", apply)


CHARGE = (
    HiddenEffect("hot_pixels", (3e-4, 1e-3, 5e-3), "fraction of the pixels, with 8 times "
                 "the spread of a hot frame", _hot_draw, _hot_pixels),
    HiddenEffect("hot_clusters", (1e-4, 3e-4, 1.5e-3), "clusters a pixel, with 5 hot pixels each",
                 _cluster_draw, _hot_clusters),
    HiddenEffect("dark_current_steps", (3e-3, 0.015, 0.3), "atoms a pixel, each with 5 times the "
                 "spread of a hot frame", _steps_draw, _dark_current_steps),
    HiddenEffect("dark_current_fpn", (0.2, 0.4, 0.8), "share of the dark current from one defect "
                 "in each pixel", _generation_draw, _generation),
    HiddenEffect("rts", (1e-3, 5e-3, 0.02), "fraction of the pixels, 6 times the noise or 3 times "
                 "the spread of a hot frame", _rts_draw, _rts),
    HiddenEffect("amp_glow", (0.5, 2.0, 8.0), "charge at the corner over the noise",
                 _glow_draw, _amp_glow),
    HiddenEffect("dark_gradient", (0.05, 0.15, 0.4), "of the dark current, end to end",
                 _gradient_draw, _dark_gradient),
    HiddenEffect("storage_dark_current", (0.3, 1.0, 3.0), "charge of the last row over the spread "
                 "of a hot frame", _storage_draw, _storage_dark_current),
    HiddenEffect("cosmic_rays", (5.0, 20.0, 100.0), "tracks a megapixel and frame",
                 _cosmic_draw, _cosmic_rays),
    HiddenEffect("persistence", (0.02, 0.06, 0.2), "of a frame's charge given back later",
                 _lag_draw, _persistence),
    HiddenEffect("crosstalk", (4e-3, 0.012, 0.04), "of the charge to each next neighbour",
                 _crosstalk_draw, _crosstalk),
)  # fmt: skip
