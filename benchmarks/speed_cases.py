"""The cases of `speed.py`, each run in a process of its own, by whatever Python has the package.

    python speed_cases.py CASE '{"key": value}'      prints one line of JSON

Only the standard library and NumPy are imported above; the rest by the cases.
"""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

UHD = (2160, 3840)
ANALYSED = (2048, 2048)
TEN = (
    "convolved_lognormal", "dark_shot_noise", "hot_pixels", "pixel_fpn", "crosstalk",
    "read_noise", "row_noise", "column_fpn", "rts", "quantization",
)  # fmt: skip


def repeated(step: Callable[[], Any], count: int, warm: int = 1) -> dict[str, float]:
    """Wall and CPU seconds of one step."""
    for _ in range(warm):
        step()
    wall, cpu = time.perf_counter(), time.process_time()
    for _ in range(count):
        step()
    return {
        "seconds": (time.perf_counter() - wall) / count,
        "cpu": (time.process_time() - cpu) / count,
    }


def quickest(step: Callable[[], Any], runs: int = 3) -> dict[str, float]:
    """Least wall and CPU seconds of some runs, which other work on the machine disturbs least."""
    each = [repeated(step, 1, warm=0) for _ in range(runs)]
    return {name: min(one[name] for one in each) for name in each[0]}


def dark_stack(frames: int, shape: tuple[int, int], seed: int = 1) -> Iterator[np.ndarray]:
    """uint16 frames with a fixed pattern; four distinct ones in turn."""
    rng = np.random.default_rng(seed)
    pattern = 100 + rng.standard_gamma(2.0, shape, np.float32) * np.float32(3)
    pattern += rng.standard_normal((1, shape[1]), np.float32)
    held = [
        np.rint(pattern + 4 * rng.standard_normal(shape, np.float32)).astype(np.uint16)
        for _ in range(min(4, frames))
    ]
    for number in range(frames):
        yield held[number % len(held)]


# Simulation of one dark frame


def simulate_ours(effects: list[str], threads: int, frames: int) -> dict[str, float]:
    from dnanalyze.loaders.captures import OperatingPoint
    from dnanalyze.model.noise_model import NoiseModel
    from dnanalyze.model.registry import built_in
    from dnanalyze.model.simulate import simulate_frames

    known = built_in()
    model = NoiseModel(tuple(known[n]() for n in effects), 64.0, seed=1)
    point = OperatingPoint(45.0, 0.1, 1.0)
    drawn = simulate_frames(model, UHD, point, range(frames + 3), threads=threads)
    return repeated(lambda: next(drawn), frames - 2, warm=4)


def simulate_numpy() -> dict[str, float]:
    """The paper's formula as it is written: a normal deviate a pixel and tap."""
    rng = np.random.default_rng(1)
    mu, delta, phi, sigma = 1.0, 0.5, 0.05, 0.02

    def frame() -> np.ndarray:
        light = np.pad(np.exp(rng.normal(mu, delta, UHD)), 1, mode="edge")
        out = np.zeros(UHD)
        for dy in range(3):
            for dx in range(3):
                weight = 1 - 8 * phi if dy == dx == 1 else phi
                kernel = rng.normal(weight, sigma, UHD)
                out += kernel * light[dy : dy + UHD[0], dx : dx + UHD[1]]
        return np.clip(np.rint(out + 64), 0, 65535).astype(np.uint16)

    return repeated(frame, 2, warm=0)


def simulate_getframes() -> dict[str, float]:
    import getframes as gf

    camera = gf.Camera.from_preset("andor_ikon_m934").with_config(resolution=(UHD[1], UHD[0]))
    seeds = iter(range(100))
    return repeated(lambda: camera.dark_frame(exposure=0.1, seed=next(seeds)).data, 3)


def simulate_pyxel() -> dict[str, float]:
    from pyxel.detectors import CMOS, CMOSCharacteristics, CMOSGeometry, Environment
    from pyxel.detectors.characteristics import ChargeToVoltSettings
    from pyxel.models.charge_collection import simple_collection
    from pyxel.models.charge_generation import simple_dark_current
    from pyxel.models.charge_measurement import simple_measurement
    from pyxel.models.readout_electronics import simple_adc

    detector = CMOS(
        geometry=CMOSGeometry(
            row=UHD[0], col=UHD[1], total_thickness=40.0, pixel_vert_size=3.0, pixel_horz_size=3.0
        ),
        environment=Environment(temperature=318.0),
        characteristics=CMOSCharacteristics(
            quantum_efficiency=0.9,
            charge_to_volt=ChargeToVoltSettings(value=1e-5),
            pre_amplification=10.0,
            full_well_capacity=50_000,
            adc_bit_resolution=16,
            adc_voltage_range=(0.0, 5.0),
        ),
    )
    detector.set_readout(times=[0.1])

    def frame() -> None:
        detector.empty()
        simple_dark_current(detector, dark_rate=100.0)
        simple_collection(detector)
        simple_measurement(detector)
        simple_adc(detector)

    return repeated(frame, 3)


def simulate_emva1288() -> dict[str, float]:
    from emva1288.camera.camera import Camera

    camera = Camera(width=UHD[1], height=UHD[0], bit_depth=12, dark_current_ref=30)
    return repeated(lambda: camera.grab(0), 2)


# Analysis of a stack


def analyse_ours(
    frames: int, shape: list[int], threads: int, families: Sequence[str] = ()
) -> dict[str, float]:
    from dnanalyze.analyzers.analyze import analyze
    from dnanalyze.loaders.captures import CaptureSet, Frame, OperatingPoint, Sensor, Setting

    point = OperatingPoint(45.0, 0.1)
    size = (shape[0], shape[1])
    stack = tuple(
        Frame(str(n), point, lambda window, pixels=pixels: pixels)
        for n, pixels in enumerate(dark_stack(frames, size))
    )
    captures = CaptureSet("stack", Sensor(size), (Setting(point, stack),))
    short = CaptureSet("stack", Sensor(size), (Setting(point, stack[:3]),))
    analyze(short, workers=threads)  # compiled, or read from Numba's cache
    runs = 3 if frames <= 20 else 1
    return quickest(lambda: analyze(captures, workers=threads, families=families), runs)


def analyse_numpy(frames: int) -> dict[str, float]:
    """What one would write first: a few of our statistics, on the whole stack in memory."""
    stack = np.array(list(dark_stack(frames, ANALYSED)))

    def run() -> None:
        y = stack.astype(np.float32)
        pattern, noise = y.mean(axis=0), y.var(axis=0, ddof=1)
        for image in (pattern, y[1] - y[0]):
            np.abs(np.fft.rfft2(image - image.mean())) ** 2
            np.quantile(image, [0.001, 0.01, 0.1, 0.25, 0.5, 0.75, 0.9, 0.99, 0.999])
        np.bincount(stack.ravel())
        np.quantile(noise, [0.5, 0.9, 0.99, 0.999])

    return quickest(run)


def analyse_emva1288(frames: int) -> dict[str, float]:
    from emva1288.process import routines

    stack = list(dark_stack(frames, ANALYSED))

    def run() -> None:
        sums = routines.get_int_imgs(stack)
        routines.FFT1288(sums["sum"], n=frames)
        routines.FFT1288(sums["sum"], rotate=True, n=frames)
        routines.Histogram1288(sums["sum"], 256)
        routines.Histogram1288(sums["pvar"], 256)

    return quickest(run)


def stream_bare(frames: int) -> dict[str, float]:
    """The floor: read every pixel once, add it and its square in single precision."""
    stack = list(dark_stack(frames, ANALYSED))

    def run() -> None:
        total, square = np.zeros(ANALYSED, np.float32), np.zeros(ANALYSED, np.float32)
        room = np.empty(ANALYSED, np.float32)
        for frame in stack:
            np.copyto(room, frame)
            total += room
            np.multiply(room, room, out=room)
            square += room

    return repeated(run, 2)


# What limits


def limits() -> dict[str, float]:
    import tempfile

    import scipy.fft

    from dnanalyze.model import kernels

    a = np.ones(1 << 25, np.float32)
    b = np.empty_like(a)
    words = np.empty(UHD, np.int32)
    normals = np.empty(UHD, np.float32)
    image = np.ones(ANALYSED, np.float32)
    key = np.uint64(1)
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "frame.npy")
        np.save(path, image.astype(np.uint16))
        decode = repeated(lambda: np.load(path), 5)["cpu"]
    copy = repeated(lambda: np.copyto(b, a), 5)["cpu"]
    return {
        "copy, GB/s read and written": 2 * a.nbytes / copy / 1e9,
        "random words, 1e9/s": words.size
        / repeated(lambda: kernels.fill_bits(key, 0, 0, UHD[1], words), 5)["cpu"]
        / 1e9,
        "normal deviates, 1e9/s": words.size
        / repeated(lambda: kernels.fill_normal(key, 0, 0, UHD[1], normals), 5)["cpu"]
        / 1e9,
        "2-D FFT of 2048x2048 float32, ms": 1e3
        * repeated(lambda: scipy.fft.rfft2(image), 5)["cpu"],
        "decode of a 2048x2048 .npy, ms": 1e3 * decode,
    }


def first_use() -> dict[str, float]:
    """A short simulation and analysis with an empty cache of compiled code."""
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        os.environ["NUMBA_CACHE_DIR"] = folder
        wall, cpu = time.perf_counter(), time.process_time()
        simulate_ours(list(TEN), 1, 3)
        analyse_ours(4, [64, 64], 1)
        return {"seconds": time.perf_counter() - wall, "cpu": time.process_time() - cpu}


def peak_mib() -> float:
    """Largest resident size of this process so far, MiB."""
    import resource

    largest = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return largest / (1 << 20 if sys.platform == "darwin" else 1 << 10)


if __name__ == "__main__":
    result = globals()[sys.argv[1]](**json.loads(sys.argv[2]))
    print(json.dumps(result | {"peak_mib": peak_mib()}))
