"""Eight effects in dark frames of an image sensor, each with its true description."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

SHAPE = (256, 256)
ROW, COLUMN = np.indices(SHAPE).astype(float)
BOLTZMANN_EV = 8.617333e-5


@dataclass
class Case:
    """One effect: its words, numbers and choices, and how it enters the frame."""

    words: tuple[str, tuple[str, ...], str, str]  # what, when (all that are right), where, law
    numbers: dict[str, float] = field(default_factory=dict)
    choices: dict[str, Any] = field(default_factory=dict)
    add: Callable[[float, np.random.Generator], np.ndarray] | None = None  # electrons
    scale: np.ndarray | None = None  # multiplies the dark charge
    after: Callable[[np.ndarray], np.ndarray] | None = None  # changes the read frame


def _scaled(pattern: np.ndarray, rms: float) -> np.ndarray:
    """The pattern with mean zero and the given rms over the pixels."""
    pattern = pattern - pattern.mean()
    return pattern * (rms / pattern.std())


def _thermal(ea_ev: float, celsius: float) -> float:
    """Arrhenius growth relative to 25 C."""
    return math.exp(ea_ev / BOLTZMANN_EV * (1 / 298.15 - 1 / (celsius + 273.15)))


def _block_side(rng: np.random.Generator, low: int, high: int, other: int = 0) -> int:
    """A block side that is no power of two and differs from the other side by 3 or more."""
    while True:
        side = int(rng.integers(low, high + 1))
        if side & (side - 1) and abs(side - other) >= 3:
            return side


def _blocks(rng: np.random.Generator, low: int, high: int) -> tuple[np.ndarray, dict[str, Any]]:
    """Evenly spaced values dealt at random to blocks of any phase, and the blocks' geometry."""
    height = _block_side(rng, low, high)
    width = _block_side(rng, low, high, height)
    top, left = int(rng.integers(4, height - 3)), int(rng.integers(4, width - 3))
    down = ((ROW + top) // height).astype(int)
    across = ((COLUMN + left) // width).astype(int)
    shape = (int(down.max()) + 1, int(across.max()) + 1)
    values = rng.permutation(np.linspace(-1, 1, shape[0] * shape[1])).reshape(shape)
    return values[down, across], {"height": height, "width": width, "top": top, "left": left}


def diagonal_stripes(rng: np.random.Generator) -> Case:
    """Every diagonal has a fixed level with a skewed (gamma) distribution."""
    amplitude = float(rng.uniform(0.9, 1.8))
    slant = str(rng.choice(["down", "up"]))
    index = ROW - COLUMN + 255 if slant == "down" else ROW + COLUMN
    level = _scaled(rng.gamma(4.0, size=511)[index.astype(int)], amplitude)
    return Case(
        ("level", ("fixed",), "diagonal", "constant"),
        {"amplitude": amplitude},
        {"slant": slant},
        add=lambda celsius, frame: level,
    )


def stitched_blocks(rng: np.random.Generator) -> Case:
    """Exposure fields of the stitching mask, each with a fixed level of its own."""
    amplitude = float(rng.uniform(0.9, 1.8))
    pattern, choices = _blocks(rng, 35, 61)
    level = _scaled(pattern, amplitude)
    return Case(
        ("level", ("fixed",), "block", "constant"),
        {"amplitude": amplitude},
        choices,
        add=lambda celsius, frame: level,
    )


def row_lag(rng: np.random.Generator) -> Case:
    """The column lines settle incompletely: each row keeps a share of the row read before."""
    share = float(rng.uniform(0.06, 0.12))

    def after(read: np.ndarray) -> np.ndarray:
        """Settle from the value left on the line towards each row in turn."""
        kept = np.array(read, dtype=float)
        for row in range(1, len(kept)):
            kept[row] = (1 - share) * kept[row] + share * kept[row - 1]
        return kept

    return Case(("gain", ("fixed",), "row_before", "constant"), {"gain": share}, after=after)


def tiled_gain(rng: np.random.Generator) -> Case:
    """Tiles with a gain of their own on the dark charge."""
    gain = float(rng.uniform(0.07, 0.12))
    pattern, choices = _blocks(rng, 21, 47)
    return Case(
        ("gain", ("fixed",), "block", "constant"),
        {"gain": gain},
        choices,
        scale=1 + _scaled(pattern, gain),
    )


def noisy_bands(rng: np.random.Generator) -> Case:
    """Bands of rows with more temporal noise, the bands differing a little in strength."""
    amplitude = float(rng.uniform(1.6, 2.8))
    sigma = np.zeros(SHAPE[0])
    bands = int(rng.integers(4, 7))
    slot = SHAPE[0] // bands
    for band in range(bands):
        rows = int(rng.integers(7, 19))
        start = band * slot + int(rng.integers(2, slot - rows - 1))
        sigma[start : start + rows] = rng.uniform(0.85, 1.15)
    has = sigma > 0
    sigma *= amplitude / math.sqrt(np.mean(sigma[has] ** 2))
    return Case(
        ("noise", ("fixed",), "row", "constant"),
        {"amplitude": amplitude, "share": float(has.mean())},
        add=lambda celsius, frame: sigma[:, None] * frame.standard_normal(SHAPE),
    )


def blinking_spot(rng: np.random.Generator) -> Case:
    """A round Gaussian spot at one place, present in about half of the frames."""
    amplitude = float(rng.uniform(2.0, 3.2))
    radius = float(rng.uniform(9, 20))
    y, x = (float(v) for v in rng.uniform(50, 205, 2))
    present = float(rng.uniform(0.4, 0.6))
    spot = amplitude * np.exp(-((ROW - y) ** 2 + (COLUMN - x) ** 2) / (2 * radius**2))
    return Case(
        ("level", ("switching",), "blob", "constant"),
        {"amplitude": amplitude, "centre_y": y, "centre_x": x, "radius": radius},
        add=lambda celsius, frame: spot * float(frame.random() < present),
    )


def thermal_rings(rng: np.random.Generator) -> Case:
    """Wafer striations: rings about a centre outside the frame, with sharpened crests."""
    amplitude, ea_ev = float(rng.uniform(0.2, 0.32)), float(rng.uniform(0.3, 0.4))
    period, phase = float(rng.uniform(17, 36)), float(rng.uniform(0, 2 * math.pi))
    outside = float(rng.uniform(25, 90))
    along = float(rng.uniform(30, 225))
    across = -outside if rng.random() < 0.5 else 255 + outside
    y, x = (along, across) if rng.random() < 0.5 else (across, along)
    angle = 2 * math.pi * np.hypot(ROW - y, COLUMN - x) / period + phase
    level = _scaled(np.cos(angle) + 0.25 * np.cos(2 * angle), amplitude)
    return Case(
        ("level", ("fixed",), "rings", "thermal"),
        {"amplitude": amplitude, "ea_ev": ea_ev, "period": period, "centre_y": y, "centre_x": x},
        add=lambda celsius, frame: level * _thermal(ea_ev, celsius),
    )


def column_pieces(rng: np.random.Generator) -> Case:
    """Column lines cut in three unequal pieces; each piece gets a new level in every frame."""
    amplitude = float(rng.uniform(0.9, 1.6))
    first = int(rng.integers(50, 81))
    second = first + int(rng.integers(95, 116))
    piece = np.digitize(np.arange(SHAPE[0]), [first, second])
    return Case(
        ("level", ("frame",), "column_segments", "constant"),
        {"amplitude": amplitude},
        add=lambda celsius, frame: amplitude * frame.standard_normal((3, SHAPE[1]))[piece],
    )


EFFECTS: dict[str, Callable[[np.random.Generator], Case]] = {
    "diagonal_stripes": diagonal_stripes,
    "stitched_blocks": stitched_blocks,
    "row_lag": row_lag,
    "tiled_gain": tiled_gain,
    "noisy_bands": noisy_bands,
    "blinking_spot": blinking_spot,
    "thermal_rings": thermal_rings,
    "column_pieces": column_pieces,
}
