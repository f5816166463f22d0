"""The CUDA device, by way of CuPy: memory, compiled kernels and their launch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from types import ModuleType
from typing import Any, Protocol

import numpy as np

from dnanalyze.errors import InputError

# Every operation rounded as IEEE 754 says: the bits are the CPU's.
OPTIONS = (
    "--std=c++17",
    "--fmad=false",
    "--prec-div=true",
    "--prec-sqrt=true",
    "--ftz=false",
)


class Device(Protocol):
    """What a batch of frames needs of a device; arrays are of its own kind."""

    def upload(self, values: np.ndarray) -> Any:
        """A copy on the device."""

    def empty(self, shape: tuple[int, ...], dtype: Any) -> Any:
        """Room on the device."""

    def address(self, array: Any) -> int:
        """Where an array on the device lies."""

    def host(self, array: Any) -> np.ndarray:
        """A copy in the host's memory."""

    def program(self, source: str) -> Any:
        """Compiled CUDA C++."""

    def launch(
        self, program: Any, kernel: str, grid: tuple[int, int], threads: int, arguments: Sequence
    ) -> None:
        """Begin a kernel; ``arguments`` are arrays of the device and uint32 numbers."""


@dataclass(frozen=True)
class Cuda:
    """The current CUDA device of CuPy.

    Parameters
    ----------
    cupy : module
    """

    cupy: ModuleType

    def upload(self, values: np.ndarray) -> Any:
        """A copy on the device."""
        return self.cupy.asarray(values)

    def empty(self, shape: tuple[int, ...], dtype: Any) -> Any:
        """Room on the device."""
        return self.cupy.empty(shape, dtype)

    def address(self, array: Any) -> int:
        """Where an array on the device lies."""
        return int(array.data.ptr)

    def host(self, array: Any) -> np.ndarray:
        """A copy in the host's memory."""
        return np.asarray(self.cupy.asnumpy(array))

    def program(self, source: str) -> Any:
        """Compiled CUDA C++; CuPy keeps it on disk for the next process."""
        return self.cupy.RawModule(code=source, options=OPTIONS)

    def launch(
        self, program: Any, kernel: str, grid: tuple[int, int], threads: int, arguments: Sequence
    ) -> None:
        """Begin a kernel on the current stream."""
        given = tuple(np.uint32(a) if isinstance(a, int) else a for a in arguments)
        program.get_function(kernel)(grid, (threads,), given)


def named(name: str) -> Device:
    """The device of that name.

    Raises
    ------
    InputError
        There is none of the name, or none to be had.
    """
    if name != "cuda":
        raise InputError(f"device {name!r}: unknown; valid: cpu, cuda")
    return cuda()


@cache
def cuda() -> Cuda:
    """The CUDA device.

    Raises
    ------
    InputError
        CuPy is not installed, or finds no device or no compiler.
    """
    try:
        import cupy
    except ModuleNotFoundError:
        raise InputError(
            "device cuda: CuPy is not installed; pip install cupy-cuda12x, or use device cpu"
        ) from None
    except ImportError:
        raise InputError(
            "device cuda: CuPy does not load; install the one for this CUDA version "
            "(cupy-cuda12x, cupy-cuda13x), or use device cpu"
        ) from None
    try:
        devices = cupy.cuda.runtime.getDeviceCount()
        cupy.cuda.nvrtc.getVersion()
    except Exception as error:  # of CUDA, or of what looks for its libraries
        reason = str(error).splitlines()[0]
        raise InputError(f"device cuda: {reason}; use device cpu") from None
    if not devices:
        raise InputError("device cuda: CuPy finds no CUDA device; use device cpu")
    return Cuda(cupy)
