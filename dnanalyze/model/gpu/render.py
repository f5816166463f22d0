"""Batches of frames on a device: recorded on the host, one launch a pass for all frames alike."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import groupby, islice
from threading import Lock
from typing import Any

import numpy as np

from dnanalyze.loaders.captures import OperatingPoint, Window
from dnanalyze.model.gpu.device import Device
from dnanalyze.model.gpu.record import Recorder
from dnanalyze.model.gpu.source import FRAMES, PIXELS, THREADS, passes, source
from dnanalyze.model.gpu.tape import Result, Tape
from dnanalyze.model.memo import Memo
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.simulator import room

BATCHED_BYTES = 1 << 16  # bytes; smaller arrays go to the device together, batch by batch
ALIGNED = 16


@dataclass(frozen=True)
class Take:
    """One frame as recorded."""

    tape: Tape
    last: int  # step that gives its values

    @property
    def kind(self) -> tuple[Any, ...]:
        """Frames of one kind differ in their numbers alone."""
        return (self.last, *self.tape.steps)


@dataclass
class Renderer:
    """Draws frames of one model on a device; fixed fields stay there from batch to batch.

    Parameters
    ----------
    model : NoiseModel
    shape : tuple of int
        (rows, columns).
    device : Device
    bits : int, optional
        Frames are rounded and cut to codes of so many bits, uint8 up to 8, else uint16; float32
        DN by default.
    """

    model: NoiseModel
    shape: tuple[int, int]
    device: Device
    bits: int | None = None
    _memos: tuple[Memo, Memo, Memo] = field(init=False)  # random fields, maps, arrays on device
    _programs: dict[Any, Any] = field(default_factory=dict, init=False)
    _on_host: set[int] = field(default_factory=set, init=False)
    _lock: Any = field(default_factory=Lock, init=False)

    def __post_init__(self) -> None:
        size = room(self.model, self.shape)
        self._memos = Memo(size), Memo(size), Memo(2 * size)

    def frames(self, point: OperatingPoint, numbers: Iterable[int]) -> Any:
        """Frames of those numbers, (frames, rows, columns), an array of the device.

        The kernels may still be at work when it returns; whoever reads the array on the device's
        current stream, or by DLPack, comes after them.
        """
        with self._lock:
            takes = [self.record(point, n) for n in numbers]
            kind = np.float32 if self.bits is None else np.uint8 if self.bits <= 8 else np.uint16
            out = self.device.empty((len(takes), *self.shape), kind)
            done = 0
            for _, alike in groupby(takes, lambda take: take.kind):
                group = list(alike)
                self._render(group, out[done : done + len(group)])
                done += len(group)
            return out

    def stream(self, point: OperatingPoint, numbers: Iterable[int], batch: int) -> Iterator[Any]:
        """Frames one after another, drawn by batches, one batch ahead of the one in use."""
        left = iter(numbers)
        ahead: Any = ()
        while chosen := list(islice(left, batch)):
            ready, ahead = ahead, self.frames(point, chosen)
            yield from ready
        yield from ahead

    def host(self, point: OperatingPoint, number: int) -> np.ndarray:
        """One frame, (rows, columns), in the host's memory."""
        return self.device.host(self.frames(point, [number]))[0]

    def record(self, point: OperatingPoint, number: int) -> Take:
        """One frame, as the steps that design it."""
        fields, maps, _ = self._memos
        tape = Tape(self.shape, lambda name, make: maps.get((point, name), make))
        recorder = Recorder(self.model, self.shape, fields, maps, tape=tape, on_host=self._on_host)
        signal: Any = recorder.frame(point, number, Window.whole(self.shape))
        return Take(tape, signal.step)

    def _render(self, takes: Sequence[Take], out: Any) -> None:
        """Launch the passes of frames of one kind."""
        tape, last, frames = takes[0].tape, takes[0].last, len(takes)
        needed = passes(tape, last)
        made = {p.step: self.device.empty((frames, p.size), np.float32) for p in needed[:-1]}
        table, held = self._table(takes, made, out)
        program = self._program(takes[0])
        for k, one in enumerate(needed):
            grid = -(-one.size // (THREADS * PIXELS)), -(-frames // FRAMES)
            arguments = [table, len(tape.numbers) + 1, frames, one.size, *self.shape]
            self.device.launch(program, f"pass_{k}", grid, THREADS, arguments)
        del held  # until here: what the table points to

    def _program(self, take: Take) -> Any:
        if take.kind not in self._programs:
            code = source(take.tape, take.last, self.bits)
            self._programs[take.kind] = self.device.program(code)
        return self._programs[take.kind]

    def _table(
        self, takes: Sequence[Take], made: dict[int, Any], out: Any
    ) -> tuple[Any, list[Any]]:
        """The numbers of each frame, on the device; with what must stay there beside them."""
        table = np.empty((len(takes), len(takes[0].tape.numbers) + 1), np.uint64)
        where: dict[int, int] = {}
        small, patches, held = bytearray(), [], []
        for row, take in enumerate(takes):
            for column, number in enumerate(take.tape.numbers):
                if isinstance(number, int):
                    table[row, column] = number
                elif isinstance(number, Result):
                    table[row, column] = self.device.address(made[number.step][row])
                elif number.nbytes < BATCHED_BYTES:
                    if id(number) not in where:
                        where[id(number)] = len(small)
                        small += number.tobytes() + bytes(-number.nbytes % ALIGNED)
                    patches.append((row, column, where[id(number)]))
                else:
                    held.append(self._held(number))
                    table[row, column] = self.device.address(held[-1])
            table[row, -1] = self.device.address(out[row])
        if patches:
            held.append(self.device.upload(np.frombuffer(small, np.uint8)))
            base = self.device.address(held[-1])
            for row, column, offset in patches:
                table[row, column] = base + offset
        held.append(table)
        return self.device.upload(table), held

    def _held(self, values: np.ndarray) -> Any:
        """The array on the device; its identity names it as long as it is held."""
        return self._memos[2].get(id(values), lambda: (values, self.device.upload(values)))[1]
