"""Frames of a model by dnanalyze and by the programs that it is exported to: what agrees?

third-party-env/bin/python benchmarks/third_party/round_trip.py [M.yaml]

The model's operating point, 16 frames of 256 x 256. A statistic agrees where it differs from the
mean of six sensors of dnanalyze by less than three standard deviations of a sensor, or by 1 %.
"""

from __future__ import annotations

import sys
import tempfile
import tomllib
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

import dnanalyze
from dnanalyze.model.export.electrons import in_electrons
from dnanalyze.model.export.getframes_camera import getframes_preset
from dnanalyze.model.export.pyxel_pipeline import pyxel_pipeline
from dnanalyze.model.noise_model import NoiseModel, load_model
from dnanalyze.model.registry import built_in

SHAPE, FRAMES, SEED = (256, 256), 16, 1
SENSORS, SIGMAS, SHARE = 6, 3.0, 0.01
COMPARED = (
    "mean", "temporal_noise", "pattern_noise_core", "pattern_q0.99", "noise_at_50", "noise_at_99",
    "hot_count_8", "hot_count_32", "temporal_kurtosis", "temporal_corr_10", "column_noise",
)  # fmt: skip


def example() -> NoiseModel:
    """An ordinary sensor with hot pixels and crosstalk."""
    make = built_in()
    effects = (
        make["convolved_lognormal"](mu=2.5, delta=0.25, phi=1e-4, sigma=1e-5),
        make["hot_pixels"](fraction=2e-3, scale=120.0, law="narrow", width=0.1),
        make["crosstalk"](alpha=0.01, diagonal=0.0),
        make["dark_shot_noise"](dn_per_e=0.5),
        make["read_noise"](sigma=1.5),
        make["pixel_fpn"](sigma=0.6),
        make["quantization"](),
    )
    return NoiseModel(effects, pedestal=200.0, seed=SEED)


def by_getframes(model: NoiseModel) -> np.ndarray:
    """Codes, (frames, rows, columns)."""
    from getframes import Camera, CameraConfig

    plain = tomllib.loads(getframes_preset(model, SHAPE).text)
    here = in_electrons(model)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        camera = Camera(CameraConfig.from_dict(plain))
    series = camera.dark_series(here.exposure_s, FRAMES, here.point.temperature_c, seed=SEED)
    return np.stack([np.asarray(frame.data) for frame in series]).astype(np.uint16)


def by_pyxel(model: NoiseModel) -> np.ndarray:
    """Codes, (frames, rows, columns)."""
    import pyxel

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "pipeline.yaml"
        path.write_text(pyxel_pipeline(model, SHAPE).text, encoding="utf-8")
        frames = []
        for number in range(FRAMES):
            np.random.seed(SEED + number)  # noqa: NPY002  (its models draw from this one)
            made = pyxel.run_mode(pyxel.load(path))
            frames.append(np.asarray(made["/bucket/image"]).reshape(SHAPE))
    return np.stack(frames).astype(np.uint16)


def statistics(codes: np.ndarray) -> Any:
    """Of frames at one operating point."""
    import tifffile

    with tempfile.TemporaryDirectory() as folder:
        for number, frame in enumerate(codes):
            tifffile.imwrite(Path(folder) / f"dark_25C_1s_{number:03d}.tif", frame)
        return dnanalyze.analyze(dnanalyze.load(folder)).settings[0].values


def main(words: list[str]) -> int:
    """Print what agrees for either program."""
    model = load_model(Path(words[0])) if words else example()
    point = in_electrons(model).point
    plan = [(point, FRAMES)]
    mine = [
        dnanalyze.analyze(dnanalyze.simulate(replace(model, seed=SEED + n), SHAPE, plan))
        for n in range(SENSORS)
    ]
    for name, draw in (("getframes", by_getframes), ("pyxel", by_pyxel)):
        theirs = statistics(draw(model))
        print(f"\n{name}\n| statistic | dnanalyze | {name} | agrees |\n|---|---|---|---|")
        for key in COMPARED:
            own = [m.settings[0].values[key].value for m in mine]
            mean, sd, other = np.mean(own), np.std(own, ddof=1), theirs[key].value
            apart = SIGMAS * sd * np.sqrt(1.0 + 1.0 / SENSORS)  # of the mean and of one sensor
            same = "yes" if abs(other - mean) < max(apart, SHARE * abs(mean)) else "no"
            print(f"| {key} | {mean:.4g} ± {sd:.2g} | {other:.4g} | {same} |")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
