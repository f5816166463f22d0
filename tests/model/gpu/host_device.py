"""A stand-in for the CUDA device: the same source, compiled for the CPU, over NumPy arrays."""

import ctypes
import shutil
import subprocess
import tempfile
from functools import cache
from pathlib import Path

import numpy as np

COMPILER = shutil.which("g++") or shutil.which("clang++")

SHIM = """
#include <math.h>
#include <stddef.h>
#include <string.h>
#define __device__
#define __global__
#define __constant__ static const
#define __restrict__
#define __launch_bounds__(threads)
struct Index { unsigned x, y, z; };
static Index blockIdx, threadIdx;
template <class To, class From> To same_bits(From from) {
    static_assert(sizeof(To) == sizeof(From), "");
    To to;
    memcpy(&to, &from, sizeof to);
    return to;
}
inline int __float_as_int(float x) { return same_bits<int>(x); }
inline float __int_as_float(int x) { return same_bits<float>(x); }
inline double __longlong_as_double(long long x) { return same_bits<double>(x); }
template <class T> T __ldg(const T* at) { return *at; }
template <class T> T min(T a, T b) { return a < b ? a : b; }
"""

LAUNCH = """
typedef void (*Pass)(const u64*, u32, u32, u32, u32, u32);
extern "C" void launch(Pass pass, u32 across, u32 down, u32 threads,
                       const u64* numbers, u32 slots, u32 frames, u32 size, u32 rows, u32 columns) {
    for (blockIdx.y = 0; blockIdx.y < down; ++blockIdx.y)
        for (blockIdx.x = 0; blockIdx.x < across; ++blockIdx.x)
            for (threadIdx.x = 0; threadIdx.x < threads; ++threadIdx.x)
                pass(numbers, slots, frames, size, rows, columns);
}
"""


@cache
def compiled(source: str) -> ctypes.CDLL:
    """A library of CUDA C++ that asks for no more than the shim gives."""
    with tempfile.TemporaryDirectory() as folder:
        code, library = Path(folder, "pass.cpp"), Path(folder, "pass.so")
        code.write_text(SHIM + source)
        flags = ["-std=c++17", "-O0", "-ffp-contract=off", "-shared", "-fPIC"]
        quiet = ["-Wall", "-Werror", "-Wno-unknown-pragmas", "-Wno-unused"]
        done = subprocess.run(
            [COMPILER, *flags, *quiet, str(code), "-o", str(library)],
            capture_output=True, text=True,
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
        return ctypes.CDLL(str(library))


class HostDevice:
    """As `dnanalyze.model.gpu.device.Cuda`; remembers what it compiled."""

    def __init__(self):
        self.programs = []

    def upload(self, values):
        return values.copy()

    def empty(self, shape, dtype):
        return np.full(shape, 77, dtype)

    def address(self, array):
        return array.ctypes.data

    def host(self, array):
        return array.copy()

    def program(self, source):
        self.programs.append(source)
        return compiled(source + LAUNCH)

    def launch(self, program, kernel, grid, threads, arguments):
        numbers, *counts = arguments
        program.launch(
            ctypes.cast(getattr(program, kernel), ctypes.c_void_p),
            *map(ctypes.c_uint32, (*grid, threads)),
            ctypes.c_void_p(numbers.ctypes.data),
            *map(ctypes.c_uint32, counts),
        )
