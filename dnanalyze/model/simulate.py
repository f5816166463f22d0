"""Simulate: a model, a seed and operating points to a CaptureSet, frame by frame, by window."""

from __future__ import annotations

import os
from collections import OrderedDict
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from threading import Lock
from typing import Any

import numpy as np

from dnanalyze.loaders.captures import CaptureSet, Frame, OperatingPoint, Sensor, Setting, Window
from dnanalyze.model import bands
from dnanalyze.model.effect import Effect, Site, Stage
from dnanalyze.model.laws import value_at
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.streams import Stream

MAPS = 4  # fixed fields that an effect may keep


@dataclass
class Memo:
    """Least recently used arrays, bounded in bytes: fields are pure, forgetting costs only time.

    ``charge``, if any, keeps frames as they are counted in electrons: models that differ only in
    what is read out share them.
    """

    limit_bytes: int = 256 << 20
    charge: Memo | None = None
    _held: OrderedDict[object, Any] = field(default_factory=OrderedDict)
    _bytes: int = 0
    _lock: Any = field(default_factory=Lock)
    _making: dict[object, Any] = field(default_factory=dict)

    def __reduce__(self) -> tuple[type[Memo], tuple[int]]:
        """Another process begins with an empty one."""
        return Memo, (self.limit_bytes,)

    def once(self, key: object, make: Callable[[], Any]) -> Any:
        """As `get`; a second thread waits for the first one's, for what is dear to make."""
        with self._lock:
            turn = self._making.setdefault(key, Lock())
        with turn:
            value = self.get(key, make)
        with self._lock:
            self._making.pop(key, None)
        return value

    def get(self, key: object, make: Callable[[], Any]) -> Any:
        """``make()``, or what it gave last time; threads may at worst make a thing twice."""
        with self._lock:
            if key in self._held:
                self._held.move_to_end(key)
                return self._held[key]
        value = make()
        with self._lock:
            if key not in self._held:
                self._held[key] = value
                self._bytes += _size(value)
            while self._bytes > self.limit_bytes and len(self._held) > 1:
                self._bytes -= _size(self._held.popitem(last=False)[1])
        return value


def _size(value: Any) -> int:
    if isinstance(value, tuple):
        return sum(map(_size, value))
    return int(getattr(value, "nbytes", 64))


def _ends_charge(count: int, chain: Sequence[Effect]) -> bool:
    """Whether what follows ``count`` effects is read out, from charge that others may share."""
    if count == len(chain):
        return False
    return chain[count - 1].stage <= Stage.ARRIVAL < chain[count].stage <= Stage.PEDESTAL


@dataclass(frozen=True)
class Simulator:
    """Draws frames of one model.

    Parameters
    ----------
    model : NoiseModel
    shape : tuple of int
        Full frame, (rows, columns).
    memo : Memo
        Fields kept between calls; may be shared by simulators of like models (common random
        numbers make their differences smooth in the parameters).
    """

    model: NoiseModel
    shape: tuple[int, int]
    memo: Memo = field(default_factory=Memo)
    _maps: Memo = field(default_factory=Memo)

    def frame(self, point: OperatingPoint, number: int, window: Window | None = None) -> np.ndarray:
        """Pixels of a frame, DN, float32; a pure function of its arguments and the model."""
        window = window or Window.whole(self.shape)
        chain = self.model.chain
        return self._after(len(chain), chain, point, number, window)

    def _after(
        self, count: int, chain: list[Effect], point: OperatingPoint, number: int, window: Window
    ) -> np.ndarray:
        """Signal of ``window`` after the first ``count`` effects."""
        if count == 0:
            level = (
                np.float32(self._pedestal(point))
                if not chain or chain[0].stage > Stage.PEDESTAL
                else 0
            )
            return self._level(window, float(level))
        memo = self.memo.charge
        if memo is None or not _ends_charge(count, chain):
            return self._applied(count, chain, point, number, window)
        at = self.shape, self.model.seed, self.model.reference_of(point.channel), point, number
        key = (*at, window, *chain[:count])
        made = memo.get(key, lambda: self._applied(count, chain, point, number, window))
        return np.array(made)  # what follows may write into it

    def _applied(
        self, count: int, chain: list[Effect], point: OperatingPoint, number: int, window: Window
    ) -> np.ndarray:
        """The last of ``count`` effects, put on the signal of those before it."""
        effect = chain[count - 1]
        grown = window.grown(effect.margin(), self.shape)
        if effect.memory:
            first = -effect.warm_up(point)
            signal = np.stack(
                [
                    self._remembered(count - 1, chain, point, max(first, n), grown)
                    for n in range(number - effect.memory, number + 1)
                ]
            )
        else:
            signal = self._after(count - 1, chain, point, number, grown)

        def calibration(n: int, warmer: float = 0.0) -> np.ndarray:
            there = self.model.reference_of(point.channel).warmer(warmer)
            return self._after(count - 1, chain, there, n, Window.whole(self.shape))

        signal = effect.apply(signal, self._site(effect, point, number, grown, calibration))
        if grown != window:
            signal = signal[window.within(grown)]
        last_before = count == len(chain) or chain[count].stage > Stage.PEDESTAL
        if effect.stage < Stage.PEDESTAL and last_before:
            signal = signal + np.float32(self._pedestal(point))
        return signal

    def _level(self, window: Window, level: float) -> np.ndarray:
        """The signal before the first effect."""
        return np.full(window.shape, level, np.float32)

    def _remembered(
        self, count: int, chain: list[Effect], point: OperatingPoint, number: int, window: Window
    ) -> np.ndarray:
        """`_after`, kept for the frames that follow: they look back at it."""
        return self._maps.get(
            ("past", count, point, number, window),
            lambda: self._after(count, chain, point, number, window),
        )

    def _pedestal(self, point: OperatingPoint) -> float:
        return value_at(self.model.pedestal, point)

    def _site(
        self,
        effect: Effect,
        point: OperatingPoint,
        number: int,
        window: Window,
        calibration: Callable[[int, float], np.ndarray],
    ) -> Site:
        root = Stream.from_seed(self.model.seed).child(effect.name)
        moment = root.child("moment", repr(point), number)

        def draw(stream: Stream, kind: str) -> np.ndarray:
            make = getattr(stream, kind)
            return self.memo.get((stream.key, kind, window), lambda: make(window, self.shape[1]))

        def keep(name: str, make: Callable[[], Any]) -> Any:
            return self._maps.get((effect.name, point, window, name), make)

        def share(name: str, make: Callable[[], Any]) -> Any:
            return self._maps.once((effect.name, point, name), make)

        return Site(
            self.shape, window, point, self.model.reference_of(point.channel), number,
            root.child("silicon"), moment, keep, draw, calibration, share,
        )  # fmt: skip


def simulate(
    model: NoiseModel,
    shape: tuple[int, int],
    settings: Sequence[tuple[OperatingPoint, int]],
    name: str = "simulation",
    sensor: Sensor | None = None,
    memo: Memo | None = None,
    threads: int = 1,
    device: str = "cpu",
) -> CaptureSet:
    """Simulate the frames of a model; each is drawn when it is read.

    Parameters
    ----------
    model : NoiseModel
        What to simulate; its seed selects the virtual sensor.
    shape : tuple of int
        (rows, columns).
    settings : sequence of (OperatingPoint, int)
        Operating points with their number of frames.
    name : str
        Name of the capture set.
    sensor : Sensor, optional
        What to record of the sensor (bits, colour filter, ...).
    memo : Memo, optional
        Where random fields are kept between calls.
    threads : int
        That share a frame; the pixels do not depend on it.
    device : str
        "cpu", or "cuda" for a GPU; the pixels do not depend on it beyond rounding.

    Returns
    -------
    CaptureSet
        The frames, which are drawn when they are read.

    Raises
    ------
    InputError
        The device is unknown or not to be had.

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
    draw = (
        _drawn_by_threads(model, shape, memo or Memo(), threads)
        if device == "cpu"
        else _drawn_on(device, model, shape)
    )

    def frame(point: OperatingPoint, number: int) -> Frame:
        return Frame(
            f"{point.label()} #{number}",
            point,
            lambda window: draw(point, number, window),
        )

    made = tuple(
        Setting(point, tuple(frame(point, n) for n in range(count))) for point, count in settings
    )
    return CaptureSet(name, sensor or Sensor(shape), made)


_Draw = Callable[[OperatingPoint, int, Window | None], np.ndarray]


def _drawn_by_threads(model: NoiseModel, shape: tuple[int, int], memo: Memo, threads: int) -> _Draw:
    simulator = Simulator(model, shape, memo)
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
    if device != "cpu":
        from dnanalyze.model.gpu.device import named
        from dnanalyze.model.gpu.render import Renderer

        return Renderer(model, shape, named(device), bits).stream(point, numbers, batch)
    size = room(model, shape)
    simulator = Simulator(model, shape, Memo(size), Memo(size))
    threads = threads or len(os.sched_getaffinity(0))
    rows = rows or bands.band_rows(model, shape[1])
    return bands.stream(simulator, point, numbers, threads, rows, bits)


def room(model: NoiseModel, shape: tuple[int, int]) -> int:
    """Bytes for the fixed fields of a setting: to forget one would mean to make it every frame."""
    return MAPS * 4 * shape[0] * shape[1] * max(1, len(model.effects))
