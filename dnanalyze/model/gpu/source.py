"""From steps on a tape to CUDA C++: one function a pass, and the loop over frames and pixels."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

from dnanalyze.model.gpu.tape import Result, Tape

# Steps by name. v{k}: the value of an earlier step; N[{k}]: a number of this frame.
STEPS = {
    "scalar": "scalar(N[{0}])",
    "field": "__ldg((const float*)N[{0}] + p)",
    "mask": "float(__ldg((const u8*)N[{0}] + p))",
    "columns": "__ldg((const float*)N[{0}] + column)",
    "rows": "__ldg((const float*)N[{0}] + row)",
    "add": "v{0} + v{1}",
    "subtract": "v{0} - v{1}",
    "multiply": "v{0} * v{1}",
    "divide": "v{0} / v{1}",
    "maximum": "v{0} > v{1} ? v{0} : v{1}",
    "minimum": "v{0} < v{1} ? v{0} : v{1}",
    "where": "v{0} != 0.0f ? v{1} : v{2}",
    "rint": "rintf(v{0})",
    "exponential": "exponential(v{0})",
    "normal": "normal(word(N[{0}], p))",
    "uniform": "uniform(word(N[{0}], p))",
    "counts": "counts(v{0}, v{1}, word(N[{2}], p))",
    "share": "share(around((const float*)N[{0}], row, column, rows, columns), v{1}, v{2}, v{3})",
    "kernel_mean": "kernel_mean(around((const float*)N[{0}], row, column, rows, columns), v{1})",
    "kernel_norm": "kernel_norm(around((const float*)N[{0}], row, column, rows, columns))",
    "telegraph": (
        "telegraph((const u64*)N[{0}], u32(N[{1}]), __longlong_as_double((long long)N[{2}]), "
        "__ldg((const float*)N[{3}] + p), __ldg((const u32*)N[{4}] + p))"
    ),
    "sparse": "sparse((const float*)N[{0}], __ldg((const int*)N[{1}] + p), 0.0f)",
    "replaced": "sparse((const float*)N[{0}], __ldg((const int*)N[{1}] + p), v{2})",
}

THREADS = 256  # of a block
PIXELS = 2  # of a thread: what they share is loaded once
FRAMES = 8  # of a thread: fixed fields come from the cache after the first

_PASS = """
__device__ inline float value_{number}(const u64* __restrict__ N, u32 p, u32 row, u32 column,
                                     u32 rows, u32 columns) {{
{lines}
    return v{step};
}}

extern "C" __global__ void __launch_bounds__({threads}) pass_{number}(
        const u64* __restrict__ numbers, u32 slots, u32 frames, u32 size, u32 rows, u32 columns) {{
    u32 p[{pixels}], row[{pixels}], column[{pixels}];
#pragma unroll
    for (u32 i = 0; i < {pixels}; ++i) {{
        // beyond the end the last pixel is made again, alike
        p[i] = min((blockIdx.x * {pixels} + i) * {threads} + threadIdx.x, size - 1);
        row[i] = p[i] / columns;
        column[i] = p[i] % columns;
    }}
    const u32 begin = blockIdx.y * {frames}, end = min(begin + {frames}, frames);
    for (u32 f = begin; f < end; ++f) {{
        const u64* __restrict__ N = numbers + f * slots;
        {kind} made[{pixels}];
#pragma unroll
        for (u32 i = 0; i < {pixels}; ++i)
            made[i] = {kind}({value});
#pragma unroll
        for (u32 i = 0; i < {pixels}; ++i)
            (({kind}*)N[{out}])[p[i]] = made[i];
    }}
}}
"""


@dataclass(frozen=True)
class Pass:
    """A kernel ``pass_0``, ``pass_1``, ... that writes a step's values.

    Parameters
    ----------
    step : int
        Which step.
    out : int
        Place in the table of numbers of the address to write to; the frame's comes last.
    size : int
        Number of values.
    """

    step: int
    out: int
    size: int


def passes(tape: Tape, last: int) -> list[Pass]:
    """What has to be made, in order, for the values of step ``last`` of all pixels.

    A step that others read around a pixel, or by place, is made for all pixels before them.
    """
    made: dict[int, Pass] = {}
    for place, number in enumerate(tape.numbers):
        if isinstance(number, Result):
            made.setdefault(number.step, Pass(number.step, place, number.size))
    frame = Pass(last, len(tape.numbers), tape.shape[0] * tape.shape[1])
    return [*sorted(made.values(), key=lambda p: p.step), frame]


def source(tape: Tape, last: int, bits: int | None) -> str:
    """CUDA C++ of all passes.

    Parameters
    ----------
    tape : Tape
    last : int
        Step that gives the frame.
    bits : int, optional
        Frames are rounded and cut to so many bits: uint8 up to 8, else uint16; left as float32
        by default.
    """
    needed = passes(tape, last)
    text = [prelude()]
    for number, one in enumerate(needed):
        kind, value = "float", f"value_{number}(N, p[i], row[i], column[i], rows, columns)"
        if number == len(needed) - 1 and bits is not None:
            kind, value = "u8" if bits <= 8 else "u16", f"code({value}, {2**bits - 1}.0f)"
        text.append(
            _PASS.format(
                number=number,
                lines=_lines(tape.steps, one.step),
                step=one.step,
                threads=THREADS,
                pixels=PIXELS,
                frames=FRAMES,
                out=one.out,
                kind=kind,
                value=value,
            )
        )
    return "".join(text)


def _lines(steps: Sequence[tuple[Any, ...]], last: int) -> str:
    """The steps that give ``last``, as statements."""
    wanted = {last}
    for number in range(last, -1, -1):
        if number in wanted:
            name, *operands = steps[number]
            wanted |= {operands[int(k)] for k in re.findall(r"v\{(\d)\}", STEPS[name])}
    lines = []
    for number in sorted(wanted):
        name, *operands = steps[number]
        lines.append(f"    const float v{number} = {STEPS[name].format(*operands)};")
    return "\n".join(lines)


@cache
def prelude() -> str:
    """What the passes call: `pixel.cuh`, after the numbers that it shares with the CPU's loops."""
    return _constants() + files(__package__).joinpath("pixel.cuh").read_text(encoding="utf-8")


def _constants() -> str:
    from dnanalyze.model import kernels

    floats = {f"L{k}": getattr(kernels, f"_L{k}") for k in range(8)}
    floats |= {f"Z{k}": getattr(kernels, f"_Z{k}") for k in range(13)}
    floats |= {
        "A": kernels._A,
        "B": kernels._B,
        "C": kernels._C,
        "INVERTED_BELOW": kernels.INVERTED_BELOW,
    }
    floats |= {"LN2": kernels._LN2, "LN2_HIGH": kernels._LN2_HIGH, "LN2_LOW": kernels._LN2_LOW}
    floats |= {"LOG2E": kernels._LOG2E, "UNIT": kernels._UNIT, "TINY": kernels._TINY}
    floats |= {"BELOW_ONE": kernels._BELOW_ONE}
    words = {"SQRT_HALF_BITS": kernels._SQRT_HALF_BITS, "MANTISSA": kernels._MANTISSA}
    longs = {"GOLDEN": kernels._GOLDEN, "MIX1": kernels._MIX1, "MIX2": kernels._MIX2}
    inverse = ", ".join(["0.0", *(f"1.0 / {k}" for k in range(1, 64))])
    return "\n".join(
        [
            *(f"#define {name} {float(x).hex()}f" for name, x in floats.items()),
            *(f"#define {name} {int(x)}" for name, x in words.items()),
            *(f"#define {name} {int(x)}ull" for name, x in longs.items()),
            f"__constant__ double INVERSE[64] = {{{inverse}}};\n\n",
        ]
    )
