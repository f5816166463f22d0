"""The field of a sensor as it is seen: one operating point and kind, measured and of models."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from dnanalyze.comparator.error import pooled
from dnanalyze.loaders.captures import CaptureSet, Frame, OperatingPoint
from dnanalyze.loaders.mosaic import planes
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.simulate import simulate

FRAME, MEAN, TEMPORAL = "single frame", "mean frame", "temporal noise"
MOST_FRAMES = 12  # that a mean or a standard deviation is taken over
PLAIN = 30.0  # standard deviations; what is off by more is not seen better for it
ROWS = 256  # of a frame, taken at a time
Rows = Sequence[Mapping[str, Any]]
PREFIXES = {
    "temporal": TEMPORAL, "noise": TEMPORAL, "blink": TEMPORAL, "local_variance": TEMPORAL,
    "frame": FRAME, "transient": FRAME, "drift": FRAME,
}  # fmt: skip


@dataclass(frozen=True)
class Place:
    """An operating point, a colour plane, and the kind of picture.

    Parameters
    ----------
    point : OperatingPoint
    plane : str
        Colour plane; "" for the whole frame.
    kind : str
        "single frame", "mean frame" or "temporal noise" (standard deviation over the frames).
    """

    point: OperatingPoint
    plane: str = ""
    kind: str = MEAN


@dataclass(frozen=True)
class Fields:
    """Images of one place by name, the measured first, DN.

    Parameters
    ----------
    place : Place
    frames : int
        That went into each.
    images : dict
        Name to image, all of one shape.
    """

    place: Place
    frames: int
    images: dict[str, np.ndarray]


def kind_of(name: str) -> str:
    """The kind of picture in which a statistic is seen."""
    return next((kind for start, kind in PREFIXES.items() if name.startswith(start)), MEAN)


def side_of(shape: tuple[int, ...], most: int) -> int:
    """Side of the blocks of an image with ``most`` cells a side at most: the least odd number.

    The means of blocks of an even side hide a pattern of two rows or columns.
    """
    return 2 * (math.ceil(max(shape) / most) // 2) + 1


def worst_place(rows: Rows, better: Rows = ()) -> Place | None:
    """Where a model fails most: by the model error of each operating point and kind.

    Parameters
    ----------
    rows : sequence of mapping
        Of a comparison.
    better : sequence of mapping
        Of another model: then where its error is lower by most.
    """
    was, now = _errors(rows), _errors(better)
    return max(was, key=lambda place: was[place] - now.get(place, 0.0), default=None)


def _errors(rows: Rows) -> dict[Place, float]:
    held: dict[Place, list[tuple[float, str]]] = defaultdict(list)
    for row in rows:
        point = OperatingPoint(
            row["temperature_c"], row["exposure_s"], row.get("gain"), row.get("channel")
        )
        place = Place(point, row.get("plane", ""), kind_of(row["name"]))
        held[place].append((min(abs(row["discrepancy"]), PLAIN), row["family"]))
    return {
        place: pooled(*(np.array(part) for part in zip(*found, strict=True)))
        for place, found in held.items()
    }


def fields(
    captures: CaptureSet, place: Place | None, models: Mapping[str, NoiseModel]
) -> Fields | None:
    """The measured image and that of each model; None where the captures lack the place."""
    settings = [s for s in captures.settings if place is None or s.point == place.point]
    if not settings:
        return None
    place = place or Place(settings[0].point)
    frames = settings[0].frames[: 1 if place.kind == FRAME else MOST_FRAMES]
    if len(frames) < 2:
        place = replace(place, kind=FRAME)
    own = replace(captures, settings=(replace(settings[0], frames=frames),))
    several = {"measured": own} | {
        name: simulate(model, like=own) for name, model in models.items()
    }
    images = {
        name: _image(_plane(found, place.plane), place.kind) for name, found in several.items()
    }
    return Fields(place, len(frames), images)


def _plane(captures: CaptureSet, plane: str) -> CaptureSet:
    return next((part for name, part in planes(captures) if name == plane), captures)


def _image(captures: CaptureSet, kind: str) -> np.ndarray:
    return over_frames(captures.settings[0].frames, kind == TEMPORAL)


def over_frames(frames: Sequence[Frame], deviation: bool = False) -> np.ndarray:
    """Mean of frames, or their standard deviation (ddof 1), by Welford's recurrence.

    Parameters
    ----------
    frames : sequence of Frame
        One of them is in memory at a time.
    deviation : bool
        Whether the standard deviation is wanted; it is NaN of a single frame.

    Returns
    -------
    ndarray of float32
        DN.
    """
    mean = frames[0].read().astype(np.float32)
    squares = np.zeros_like(mean) if deviation else None
    for number, frame in enumerate(frames[1:], 2):
        pixels = frame.read()
        for top in range(0, len(mean), ROWS):  # what is in between takes no room of a frame's size
            rows = slice(top, top + ROWS)
            x = pixels[rows].astype(np.float32)
            step = x - mean[rows]
            mean[rows] += step / number
            if squares is not None:
                squares[rows] += step * (x - mean[rows])
    if squares is None:
        return mean
    if len(frames) < 2:
        return np.full_like(mean, np.nan)
    squares /= len(frames) - 1
    return np.sqrt(squares, out=squares)
