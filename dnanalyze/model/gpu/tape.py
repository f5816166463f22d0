"""A signal that writes down what is done to it, so that a kernel can do it to every pixel at once.

`Recorded` stands for the float32 signal of a whole frame in an effect's ``apply``. Arithmetic,
rounding, clipping and the functions of `dnanalyze.model.draws` become steps on its `Tape`; what
has no step here raises `Unrecordable`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

from dnanalyze.loaders.captures import Window
from dnanalyze.model.telegraph import Telegraph

Operand = Any  # Recorded, or a number or array to take as it is


class Unrecordable(Exception):
    """An effect did to the signal what has no step; its message names it."""


@dataclass(frozen=True)
class Result:
    """Stands in the table of numbers for the address of a step's values, made in an earlier pass.

    ``size`` is the number of values, one a pixel or one a pixel of a few.
    """

    step: int
    size: int


Number = int | np.ndarray | Result  # 64 bits, or what to take the address of


@dataclass
class Tape:
    """Steps that design one frame.

    Parameters
    ----------
    shape : tuple of int
        (rows, columns).
    keep : callable
        ``keep(name, make)`` returns ``make()`` and caches it for the frames of this operating
        point.
    steps : list of tuple
        (name, operand, ...): a name of `source.STEPS`; operands are numbers of earlier steps, or
        places in ``numbers``, as the name has it. Frames of like steps share a kernel.
    numbers : list
        Keys, scalars, and arrays of which the kernel wants the address.
    """

    shape: tuple[int, int]
    keep: Callable[[Any, Callable[[], Any]], Any]
    steps: list[tuple[Any, ...]] = field(default_factory=list)
    numbers: list[Number] = field(default_factory=list)

    def step(self, name: str, *operands: int) -> int:
        """Write a step down; its number."""
        self.steps.append((name, *operands))
        return len(self.steps) - 1

    def number(self, value: Number) -> int:
        """Write a number down; its place."""
        self.numbers.append(value)
        return len(self.numbers) - 1

    def array(self, values: np.ndarray) -> int:
        """Place of an array's address; the kernel reads it later, so it must stay as it is."""
        return self.number(np.ascontiguousarray(values))

    def made(self, step: int, size: int) -> int:
        """Place of the address of a step's values, which a pass of its own makes."""
        return self.number(Result(step, size))

    def scalar(self, value: float) -> int:
        """A step that gives one float32 for all pixels."""
        return self.step("scalar", self.number(int(np.float32(value).view(np.uint32))))

    def operand(self, value: Operand) -> int:
        """A step that gives the value, whatever it is, spread over the frame as NumPy does."""
        if isinstance(value, Recorded):
            return value.step
        if isinstance(value, int | float) and not isinstance(value, np.float64):
            return self.scalar(value)
        values = np.asarray(value)
        kind = "mask" if values.dtype == bool else "field"
        if kind == "field" and values.dtype != np.float32:
            raise Unrecordable(f"arithmetic with {values.dtype}")
        if values.ndim == 0:
            return self.scalar(float(values))
        rows, columns = (1,) * (2 - values.ndim) + values.shape
        if (rows, columns) == self.shape:
            return self.step(kind, self.array(values))
        if kind == "field" and (rows, columns) == (1, self.shape[1]):
            return self.step("columns", self.array(values))
        if kind == "field" and (rows, columns) == (self.shape[0], 1):
            return self.step("rows", self.array(values))
        raise Unrecordable(f"an array of shape {values.shape}")


_UFUNCS = {
    np.add: "add",
    np.subtract: "subtract",
    np.multiply: "multiply",
    np.true_divide: "divide",
    np.maximum: "maximum",
    np.minimum: "minimum",
    np.rint: "rint",
}


class Recorded(NDArrayOperatorsMixin):
    """The signal after the steps so far; changed in place it is the signal after more of them.

    Parameters
    ----------
    tape : Tape
    step : int
        That gives its values.
    values : callable, optional
        Makes them in NumPy, where they do not hang on other steps.
    """

    dtype = np.dtype(np.float32)
    ndim = 2

    def __init__(
        self, tape: Tape, step: int, values: Callable[[], np.ndarray] | None = None
    ) -> None:
        self.tape, self.step, self._values = tape, step, values

    @property
    def shape(self) -> tuple[int, int]:
        """(rows, columns)."""
        return self.tape.shape

    @property
    def size(self) -> int:
        """Number of pixels."""
        return self.tape.shape[0] * self.tape.shape[1]

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Operand, **kwargs: Any) -> Any:
        (out,) = kwargs.pop("out", None) or (None,)
        name = _UFUNCS.get(ufunc)
        if name is None and out is None and not kwargs and method == "__call__":
            return ufunc(*(np.asarray(x) if isinstance(x, Recorded) else x for x in inputs))
        if name is None or method != "__call__" or kwargs:
            raise Unrecordable(f"{ufunc.__name__} of the signal")
        return self._onto(out, self.tape.step(name, *map(self.tape.operand, inputs)))

    def __array_function__(self, function: Any, types: Any, args: Any, kwargs: Any) -> Any:
        if function is np.clip:
            return self._clipped(*args[1:], **kwargs)
        if function is np.where and len(args) == 3:
            return self._onto(None, self.tape.step("where", *map(self.tape.operand, args)))
        raise Unrecordable(f"{function.__name__} of the signal")

    def __array__(self, dtype: Any = None, copy: Any = None) -> np.ndarray:
        if self._values is None:
            raise Unrecordable("its values, pixel by pixel")
        return np.asarray(self._values(), dtype)

    def __getitem__(self, index: Any) -> Recorded:
        if index == Window.whole(self.shape).slices:
            return self
        raise Unrecordable("a part of the signal")

    def __setitem__(self, where: Any, value: Operand) -> None:
        tape = self.tape
        if isinstance(where, np.ndarray) and where.dtype.kind == "b" and not np.ndim(value):
            chosen, instead = tape.operand(where), tape.operand(value)
            self._onto(self, tape.step("where", chosen, instead, self.step))
        elif _are_pixels(where) and getattr(value, "dtype", None) == np.float32:
            rows, columns = where
            places = self._places(rows, lambda: rows * self.shape[1] + columns)
            values = tape.array(np.broadcast_to(value, rows.shape))
            self._onto(self, tape.step("replaced", values, places, self.step))
        else:
            raise Unrecordable("a part of the signal")

    def __bool__(self) -> bool:
        raise Unrecordable("a decision by the signal")

    def note(self, name: str, *arguments: Any, **named: Any) -> Recorded:
        """A function that is `dnanalyze.model.draws.recordable`, called with this signal.

        Of the window and the width, which come last, the steps need nothing: it is a whole frame.
        """
        return getattr(self, f"_{name}")(*arguments, **named)

    def _onto(self, out: Recorded | None, step: int) -> Recorded:
        if out is None:
            return Recorded(self.tape, step)
        out.step, out._values = step, None
        return out

    def _clipped(self, low: Operand, high: Operand, out: Recorded | None = None) -> Recorded:
        tape = self.tape
        step = tape.step("maximum", self.step, tape.operand(low))
        return self._onto(out, tape.step("minimum", step, tape.operand(high)))

    def _normal(self, key: int) -> Recorded:
        return Recorded(self.tape, self.tape.step("normal", self.tape.number(key)))

    def _plain(self, value: Operand) -> Recorded:
        return Recorded(self.tape, self.tape.operand(value))

    def _add_normal(self, scale: float, key: int, *place: Any) -> Recorded:
        return self + np.float32(scale) * self._normal(key)

    def _add_scaled_normal(
        self, offset: np.ndarray, scale: np.ndarray, factor: float, key: int, *place: Any
    ) -> Recorded:
        spread = np.float32(factor) * self._plain(scale)
        return self + (self._plain(offset) + spread * self._normal(key))

    def _counts(self, dn_per_e: float, key: int, *place: Any) -> Recorded:
        k = self.tape.scalar(dn_per_e)
        return self._onto(None, self.tape.step("counts", self.step, k, self.tape.number(key)))

    def _add_lognormal(self, *arguments: Any) -> Recorded:
        mu, delta, phi, sigma, keys, *_ = arguments
        tape = self.tape
        seed = np.float32(mu) + np.float32(delta) * self._normal(keys[0])
        light = tape.step("exponential", seed.step)
        field = tape.made(light, self.size)
        mean = Recorded(tape, tape.step("kernel_mean", field, tape.scalar(phi)))
        norm = Recorded(tape, tape.step("kernel_norm", field))
        return self + (mean + np.float32(sigma) * norm * self._normal(keys[1]))

    def _share_with_neighbours(self, edge: float, corner: float, uneven: float = 0.0) -> Recorded:
        tape = self.tape
        field = tape.made(self.step, self.size)
        weights = tape.scalar(edge), tape.scalar(corner), tape.scalar(uneven)
        return self._onto(None, tape.step("share", field, *weights))

    def _add_telegraph(
        self,
        at: np.ndarray,
        step: np.ndarray,
        states: Sequence[Telegraph],
        below: np.ndarray | None = None,
    ) -> Recorded:
        tape = self.tape
        if at.size == 0:
            return self
        level = self._state(states[0])
        for other in states[1:]:
            level = tape.step("subtract", level, self._state(other))
        if below is not None:
            level = tape.step("subtract", level, tape.step("field", tape.array(below)))
        value = tape.step("multiply", tape.step("field", tape.array(step)), level)
        added = tape.step("sparse", tape.made(value, at.size), self._places(at, lambda: at))
        return self + Recorded(tape, added)

    def _places(self, named: np.ndarray, at: Callable[[], np.ndarray]) -> int:
        """Where each pixel's place among those ``at`` lies; the identity of an array names them."""

        def make() -> tuple[np.ndarray, np.ndarray]:
            places = np.full(self.size, -1, np.int32)  # of a pixel that is not one of them
            places[at()] = np.arange(named.size)
            return named, places

        return self.tape.array(self.tape.keep(("places", id(named)), make)[1])

    def _state(self, signal: Telegraph) -> int:
        if signal.frame < 0:
            raise Unrecordable("a frame before the first")
        tape = self.tape
        first, stop = signal.span()
        keys = tape.keep(
            ("keys", signal.root.key, signal.name, first, stop), lambda: signal.keys(first, stop)
        )
        _, index = tape.keep(
            ("index", id(signal.index)), lambda: (signal.index, signal.index.astype(np.uint32))
        )
        renew = int(np.float64(signal.renew).view(np.uint64))
        return tape.step(
            "telegraph",
            tape.array(keys),
            tape.number(signal.frame - first),
            tape.number(renew),
            tape.array(signal.occupancy),
            tape.array(index),
        )


def _are_pixels(index: Any) -> bool:
    """Rows and columns of a few pixels."""
    return (
        isinstance(index, tuple)
        and len(index) == 2
        and all(isinstance(i, np.ndarray) and i.ndim == 1 and i.dtype.kind == "i" for i in index)
    )
