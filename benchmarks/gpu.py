"""Frames a second on a CUDA device, and how far its kernels are from what bounds them.

    python benchmarks/gpu.py                 3840x2160, uint16
    python benchmarks/gpu.py --json gpu.json
    python benchmarks/gpu.py --profile "ten effects"     a few batches only, for a profiler

Needs CuPy and a GPU. Kernel time is read between CUDA events around every launch. The bounds are
measured in the same run: the bytes of the codes at the speed of a copy, and the random numbers of
a frame at the speed of kernels that draw them and do nothing else. getframes on CuPy and PyTorch
by DLPack run beside it where they are installed. Memory is read before and after 10,000 frames.
The statistics are those that CuPy gives in a few lines (mean and variance of each pixel, means of
rows and columns, power spectrum, histogram), to show what a device could save `analyze`.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from speed_cases import TEN, UHD, dark_stack

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.gpu.device import Cuda, cuda
from dnanalyze.model.gpu.render import Renderer
from dnanalyze.model.gpu.source import prelude
from dnanalyze.model.gpu.tape import Result
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import built_in
from dnanalyze.model.simulate import simulate_frames

MODELS = {"Wang 2025 model": ("convolved_lognormal",), "ten effects": TEN}
POINT = OperatingPoint(45.0, 0.1, 1.0)
PIXELS = UHD[0] * UHD[1]
COUNTED = 0.25  # electrons: about what a pixel of the ten effects holds
EACH = 256  # numbers that a thread of the bare kernels draws

BARE = """
extern "C" __global__ void bare_{name}(u64 key, float* out) {{
    const u32 first = blockIdx.x * blockDim.x + threadIdx.x;
    const u32 stride = gridDim.x * blockDim.x;
    {type} sum = 0;
    for (u32 i = 0; i < {each}; ++i)
        sum += {draw};
    if (sum == ({type})0.123)  // never: but the compiler cannot know
        *out = sum;
}}
"""
DRAWS = {
    "word": ("u32", "word(key, first + i * stride)"),
    "normal": ("float", "normal(word(key, first + i * stride))"),
    "counts": ("float", f"counts({COUNTED}f, 1.0f, word(key, first + i * stride))"),
}


@dataclass(frozen=True)
class Timed(Cuda):
    """The device, with an event before and after every kernel."""

    events: list[tuple[Any, Any]] = field(default_factory=list)

    def launch(self, *arguments: Any) -> None:
        before, after = self.cupy.cuda.Event(), self.cupy.cuda.Event()
        before.record()
        super().launch(*arguments)
        after.record()
        self.events.append((before, after))

    def kernel_seconds(self) -> float:
        """Of all kernels since the last call."""
        self.cupy.cuda.runtime.deviceSynchronize()
        times = [self.cupy.cuda.get_elapsed_time(a, b) for a, b in self.events]
        self.events.clear()
        return sum(times) * 1e-3


def seconds(device: Cuda, step: Callable[[], Any], count: int) -> float:
    """Of one step, between events, after one to warm up."""
    before, after = device.cupy.cuda.Event(), device.cupy.cuda.Event()
    step()
    before.record()
    for _ in range(count):
        step()
    after.record()
    after.synchronize()
    return float(device.cupy.cuda.get_elapsed_time(before, after)) * 1e-3 / count


def bounds(device: Cuda, bytes_: int = 1 << 31, blocks: int = 1 << 15) -> dict[str, float]:
    """Bytes a second of a copy, read and written; random numbers a second."""
    a = device.empty((bytes_,), np.uint8)
    b = device.empty((bytes_,), np.uint8)
    a.fill(1)
    copy = seconds(device, lambda: b.data.copy_from_device_async(a.data, bytes_), 10)
    rates = {"copy": 2 * bytes_ / copy}
    kernels = (
        BARE.format(name=name, type=kind, draw=draw, each=EACH)
        for name, (kind, draw) in DRAWS.items()
    )
    program = device.program(prelude() + "".join(kernels))
    out = device.empty((1,), np.float32)
    for name in DRAWS:
        kernel = program.get_function(f"bare_{name}")
        taken = seconds(device, lambda k=kernel: k((blocks,), (256,), (np.uint64(1), out)), 5)
        rates[name] = blocks * 256 * EACH / taken
    return rates


def model(names: tuple[str, ...]) -> NoiseModel:
    known = built_in()
    return NoiseModel(tuple(known[n]() for n in names), 64.0, seed=1)


def needed(renderer: Renderer) -> dict[str, float]:
    """Random numbers that a frame cannot do without, by kind."""
    tape = renderer.record(POINT, 1).tape
    kinds = [step[0] for step in tape.steps]
    few = {n.step: n.size for n in tape.numbers if isinstance(n, Result) and n.size != PIXELS}
    normals = PIXELS * kinds.count("normal")
    counts = PIXELS * kinds.count("counts")
    # a blinking pixel: whether its state is drawn anew, and the state
    telegraph = 2 * sum(few.values())
    return {"normal": normals, "counts": counts, "word": normals + counts + telegraph}


def simulated(names: tuple[str, ...], limit: dict[str, float], batch: int, batches: int) -> Any:
    """Frames a second, kernel time, bounds, and what differs from the CPU."""
    device = Timed(cuda().cupy)
    renderer = Renderer(model(names), UHD, device, 16)
    renderer.frames(POINT, range(batch))
    device.kernel_seconds()
    begun = time.perf_counter()
    for k in range(batches):
        renderer.frames(POINT, range(batch * k, batch * (k + 1)))
    kernel = device.kernel_seconds() / (batch * batches)
    wall = (time.perf_counter() - begun) / (batch * batches)
    begun = time.perf_counter()
    for n in range(batch):
        renderer.record(POINT, n)
    recorded = (time.perf_counter() - begun) / batch
    numbers = needed(renderer)
    drawn = numbers["normal"] / limit["normal"] + numbers["counts"] / limit["counts"]
    floor = {
        "write": 2 * PIXELS / limit["copy"],
        "words": numbers["word"] / limit["word"],
        "deviates": drawn,
    }
    off = [
        np.abs(device.host(ours).astype(int) - theirs)
        for ours, theirs in zip(
            renderer.frames(POINT, range(2)),
            simulate_frames(model(names), UHD, POINT, range(2)),
            strict=True,
        )
    ]
    return {
        "frames_per_s": 1 / wall,
        "kernel_s": kernel,
        "recording_s": recorded,
        "floor_s": floor,
        "words_per_frame": numbers["word"],
        "ratio_to_words_and_bytes": max(floor["write"], floor["words"]) / kernel,
        "ratio_to_deviates_and_bytes": max(floor["write"], floor["deviates"]) / kernel,
        "pixels_off": int(sum((o > 0).sum() for o in off)),
        "largest_difference": int(max(o.max() for o in off)),
        "pixels_compared": 2 * PIXELS,
    }


def handed_over(batch: int) -> Any:
    """Simulate, hand to PyTorch by DLPack, use there: frames a second, and whether it copied."""
    try:
        import torch
    except ImportError:
        return {"failed": "PyTorch is not installed"}
    if not hasattr(torch, "uint16"):
        return {"failed": "this PyTorch has no uint16; 2.3 has"}
    device = cuda()
    renderer = Renderer(model(MODELS["Wang 2025 model"]), UHD, device, 16)
    frames = renderer.frames(POINT, range(batch))
    same = torch.from_dlpack(frames).data_ptr() == frames.data.ptr
    torch.cuda.synchronize()
    begun = time.perf_counter()
    for k in range(4):
        tensor = torch.from_dlpack(renderer.frames(POINT, range(batch * k, batch * (k + 1))))
        tensor.float().mean()
    torch.cuda.synchronize()
    return {"frames_per_s": 4 * batch / (time.perf_counter() - begun), "same_memory": same}


def getframes(count: int = 50) -> Any:
    """The peer on CuPy."""
    try:
        import getframes as gf
    except ImportError:
        return {"failed": "getframes is not installed"}
    cupy = cuda().cupy
    camera = gf.Camera.from_preset("andor_ikon_m934", device="gpu", precision="single")
    camera = camera.with_config(resolution=(UHD[1], UHD[0]))
    camera.dark_frame(exposure=0.1, seed=0)
    cupy.cuda.runtime.deviceSynchronize()
    begun = time.perf_counter()
    for seed in range(1, count + 1):
        camera.dark_frame(exposure=0.1, seed=seed)
    cupy.cuda.runtime.deviceSynchronize()
    return {"frames_per_s": count / (time.perf_counter() - begun)}


def memory(frames: int, batch: int) -> Any:
    """MiB on the device and on the host after a tenth of so many frames, and after all."""
    device = cuda()
    renderer = Renderer(model(TEN), UHD, device, 16)
    done, held = 0, []
    for stop in (frames // 10, frames):
        while done < stop:
            renderer.frames(POINT, range(done, done + batch))
            done += batch
        device.cupy.cuda.runtime.deviceSynchronize()
        free, total = device.cupy.cuda.runtime.memGetInfo()
        host = int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
        held.append(
            {"frames": done, "device_mib": (total - free) / 2**20, "host_mib": host / 2**20}
        )
    return held


def statistics(frames: int = 20, shape: tuple[int, int] = (2048, 2048)) -> Any:
    """Milliseconds of the first and second moments, lines, spectrum and histogram of a stack."""
    device = cuda()
    cp = device.cupy
    stack = np.stack(list(dark_stack(frames, shape)))

    def evaluated(codes: Any) -> Any:
        values = codes.astype(cp.float32)
        mean, variance = values.mean(0), values.var(0, ddof=1)
        lines = values.mean(1), values.mean(2)
        spectrum = sum(cp.abs(cp.fft.rfft2(v - mean)) ** 2 for v in values)
        return mean, variance, lines, spectrum, cp.bincount(codes.ravel(), minlength=65536)

    on_device = device.upload(stack)
    counted = seconds(device, lambda: evaluated(on_device), 5)
    copied = seconds(device, lambda: device.upload(stack), 5)
    return {"device_ms": 1e3 * counted, "copy_ms": 1e3 * copied}


def profile(name: str, batch: int) -> None:
    """Two batches, for a profiler that watches the process."""
    renderer = Renderer(model(MODELS[name]), UHD, cuda(), 16)
    for k in range(2):
        renderer.frames(POINT, range(batch * k, batch * (k + 1)))
    cuda().cupy.cuda.runtime.deviceSynchronize()


def printed(results: dict[str, Any]) -> str:
    """Markdown."""
    lines = [
        f"{results['device']}, CuPy {results['cupy']}, 3840 x 2160, "
        f"batches of {results['batch']}\n",
        "| 3840x2160, uint16 | frames/s | kernel time, µs | time to write, µs "
        "| time to draw the words, µs | time to draw the deviates, µs | ratio to words "
        "| ratio to deviates | time to record, µs | differing pixels |",
        "|" + " --- |" * 10,
    ]
    for name, run in results["models"].items():
        floor = run["floor_s"]
        micro = [1e6 * x for x in (run["kernel_s"], *floor.values())]
        ratios = run["ratio_to_words_and_bytes"], run["ratio_to_deviates_and_bytes"]
        lines.append(
            f"| {name} | {run['frames_per_s']:.0f} | "
            + " | ".join(f"{x:.1f}" for x in micro)
            + f" | {ratios[0]:.2f} | {ratios[1]:.2f} | {1e6 * run['recording_s']:.0f} "
            f"| {run['pixels_off']} of {run['pixels_compared']} |"
        )
    for name in ("getframes", "dlpack", "statistics"):
        run = results[name]
        lines.append(f"\n{name}: " + ", ".join(f"{k} {v}" for k, v in run.items()))
    for held in results["memory"]:
        lines.append("\nmemory: " + ", ".join(f"{k} {v:.0f}" for k, v in held.items()))
    rates = ", ".join(f"{k} {v:.3g}/s" for k, v in results["bounds"].items())
    return "\n".join([*lines, f"\nmeasured bounds: {rates}"])


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--batch", type=int, default=64)
    parser.add_argument("--batches", type=int, default=8)
    parser.add_argument("--memory-frames", type=int, default=10_000)
    parser.add_argument("--profile", choices=list(MODELS))
    parser.add_argument("--json", type=Path)
    asked = parser.parse_args()
    try:
        device = cuda()
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    if asked.profile:
        profile(asked.profile, asked.batch)
        return 0
    name = device.cupy.cuda.runtime.getDeviceProperties(0)["name"]
    limit = bounds(device)
    results = {
        "device": name.decode() if isinstance(name, bytes) else name,
        "cupy": device.cupy.__version__,
        "batch": asked.batch,
        "bounds": limit,
        "models": {
            label: simulated(names, limit, asked.batch, asked.batches)
            for label, names in MODELS.items()
        },
        "getframes": getframes(),
        "dlpack": handed_over(asked.batch),
        "statistics": statistics(),
        "memory": memory(asked.memory_frames, asked.batch),
    }
    print(printed(results))
    if asked.json:
        asked.json.write_text(json.dumps(results, indent=1))
    return 0


if __name__ == "__main__":
    sys.exit(main())
