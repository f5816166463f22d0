"""Simulate: a model, a seed and operating points to a CaptureSet, frame by frame, by window."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import CaptureSet, Frame, OperatingPoint, Sensor, Setting, Window
from dnanalyze.model import bands
from dnanalyze.model.memo import Memo
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.row_bands import band_rows
from dnanalyze.model.simulator import Simulator, room
from dnanalyze.processors import cpu_count

_Draw = Callable[[OperatingPoint, int, Window | None], np.ndarray]


def simulate(
    model: NoiseModel,
    shape: tuple[int, int] | None = None,
    settings: Sequence[tuple[OperatingPoint, int]] | None = None,
    name: str = "simulation",
    sensor: Sensor | None = None,
    threads: int = 1,
    device: str = "cpu",
    like: CaptureSet | None = None,
) -> CaptureSet:
    """Simulate the frames of a model; each is drawn when it is read.

    Parameters
    ----------
    model : NoiseModel
        What to simulate; its seed selects the virtual sensor.
    shape : tuple of int, optional
        (rows, columns); those of ``like`` by default.
    settings : sequence of (OperatingPoint, int), optional
        Operating points with their number of frames; those of ``like`` by default.
    name : str
        Name of the capture set.
    sensor : Sensor, optional
        What to record of the sensor (bits, colour filter, ...).
    threads : int
        That share a frame; the pixels do not depend on it.
    device : str
        "cpu", or "cuda" for a GPU; the pixels do not depend on it beyond rounding.
    like : CaptureSet, optional
        Captures whose frame size, operating points, numbers of frames and sensor are taken where
        they are not given; rows, columns and frames that they leave out are not simulated.

    Returns
    -------
    CaptureSet
        The frames, which are drawn when they are read.

    Raises
    ------
    InputError
        Neither shape and settings nor captures to be like; the device is unknown or not to be had.

    Examples
    --------
    >>> import dnanalyze
    >>> from dnanalyze import NoiseModel, OperatingPoint
    >>> model = NoiseModel((dnanalyze.catalogue()["read_noise"](sigma=2.0),), pedestal=64.0)
    >>> captures = dnanalyze.simulate(model, (64, 64), [(OperatingPoint(25.0), 4)])
    >>> frame = captures.settings[0].frames[0].read()
    >>> frame.shape
    (64, 64)
    >>> bool(abs(frame.std() - 2.0) < 0.1)
    True
    """
    if like is not None:
        shape = shape or like.sensor.shape
        settings = settings or [(s.point, len(s.frames)) for s in like.settings]
        # every simulated pixel is its own, masked ones included
        sensor = sensor or replace(like.sensor, shape=shape, filled=0.0)
    if shape is None or settings is None:
        raise InputError("simulate: give shape and settings, or captures to be like")
    draw = (
        _drawn_by_threads(model, shape, threads)
        if device == "cpu"
        else _drawn_on(device, model, shape)
    )
    return _captures(draw, model, settings, name, sensor or Sensor(shape))


def simulated_by(
    simulator: Simulator,
    settings: Sequence[tuple[OperatingPoint, int]],
    name: str = "simulation",
    sensor: Sensor | None = None,
) -> CaptureSet:
    """`simulate` by a simulator, which keeps random fields between calls in its memo."""
    sensor = sensor or Sensor(simulator.shape)
    return _captures(simulator.frame, simulator.model, settings, name, sensor)


def _captures(
    draw: _Draw,
    model: NoiseModel,
    settings: Sequence[tuple[OperatingPoint, int]],
    name: str,
    sensor: Sensor,
) -> CaptureSet:
    def setting(point: OperatingPoint, count: int) -> Setting:
        label = point.label()
        frames = (Frame(f"{label} #{n}", point, partial(draw, point, n)) for n in range(count))
        return Setting(point, tuple(frames))

    made = tuple(setting(point, count) for point, count in settings)
    captures = CaptureSet(name, sensor, made)
    return captures if model.unit == 1.0 else _in_files(captures, model.unit)


def _in_files(made: CaptureSet, unit: float) -> CaptureSet:
    """Frames in the unit of the files."""

    def scaled(frame: Frame) -> Frame:
        def load(window: Window | None) -> np.ndarray:
            return frame.read(window) * np.float32(unit)

        return replace(frame, load=load)

    settings = tuple(replace(s, frames=tuple(map(scaled, s.frames))) for s in made.settings)
    return replace(made, settings=settings)


def _drawn_by_threads(model: NoiseModel, shape: tuple[int, int], threads: int) -> _Draw:
    simulator = Simulator(model, shape)
    if threads == 1:
        return simulator.frame
    simulator = replace(simulator, _maps=Memo(room(model, shape)))

    def draw(point: OperatingPoint, number: int, window: Window | None) -> np.ndarray:
        return bands.drawn(simulator, point, number, window or Window.whole(shape), threads)

    return draw


def _drawn_on(device: str, model: NoiseModel, shape: tuple[int, int]) -> _Draw:
    """Whole frames on a device, the latest kept for the windows that follow."""
    from dnanalyze.model.gpu.device import named
    from dnanalyze.model.gpu.render import Renderer

    renderer, latest = Renderer(model, shape, named(device)), Memo()

    def draw(point: OperatingPoint, number: int, window: Window | None) -> np.ndarray:
        frame = latest.get((point, number), lambda: renderer.host(point, number))
        return frame[(window or Window.whole(shape)).slices].copy()

    return draw


def simulate_frames(
    model: NoiseModel,
    shape: tuple[int, int],
    point: OperatingPoint,
    numbers: Iterable[int],
    *,
    threads: int | None = None,
    rows: int | None = None,
    bits: int = 16,
    device: str = "cpu",
    batch: int = 32,
) -> Iterator[Any]:
    """Frames as codes, one after another; the pixels depend neither on threads nor on bands.

    Parameters
    ----------
    model : NoiseModel
    shape : tuple of int
        (rows, columns).
    point : OperatingPoint
    numbers : iterable of int
        Of the frames in their setting.
    threads : int, optional
        The number of processors by default.
    rows : int, optional
        Rows of the bands in which a frame is drawn.
    bits : int
        Values are rounded and cut to 0 .. 2^bits - 1; 8 at most give uint8, else uint16.
    device : str
        "cpu", or "cuda" for a GPU: the frames are CuPy arrays and stay there.
    batch : int
        Frames that a GPU draws at a time; ``threads`` and ``rows`` are the CPU's.

    Yields
    ------
    ndarray of uint16 or uint8
        (rows, columns); each a new array.

    Raises
    ------
    InputError
        The device is unknown or not to be had.
    """
    if model.unit != 1.0:
        more = {"threads": threads, "rows": rows, "bits": bits, "device": device, "batch": batch}
        unit = int(model.unit) if model.unit.is_integer() else np.float32(model.unit)
        codes = simulate_frames(model.in_codes, shape, point, numbers, **more)  # type: ignore[arg-type]
        return (frame * unit for frame in codes)
    if device != "cpu":
        from dnanalyze.model.gpu.device import named
        from dnanalyze.model.gpu.render import Renderer

        return Renderer(model, shape, named(device), bits).stream(point, numbers, batch)
    size = room(model, shape)
    simulator = Simulator(model, shape, Memo(size), Memo(size))
    threads = threads or cpu_count()
    rows = rows or band_rows(model, shape[1])
    return bands.stream(simulator, point, numbers, threads, rows, bits)
