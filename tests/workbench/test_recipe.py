"""The copied commands read the captures as the page did."""

import shlex

import numpy as np

import dnanalyze
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.workbench.history import History
from dnanalyze.workbench.recipe import commands, python
from dnanalyze.workbench.source import CaptureSource


def test_outliers_and_a_mask_are_those_of_the_page(tmp_path, monkeypatch):
    rng = np.random.default_rng(0)
    folder, mask = tmp_path / "captures", np.zeros((32, 32), np.uint8)
    folder.mkdir()
    for n in range(3):
        np.save(folder / f"T25C_exp_1s_{n}.npy", rng.normal(100, 5, (32, 32)).astype(np.uint16))
    mask[:8] = 1
    np.save(tmp_path / "mask.npy", mask)
    source = CaptureSource(folder, keep_outliers=True, mask=tmp_path / "mask.npy")
    assert source.captures().sensor.shape == (24, 32)

    path = History.begun(NoiseModel((), pedestal=100.0), "start").path()
    words = shlex.split(commands(source, path).splitlines()[-1])
    assert words[-3:] == ["--keep-outliers", "--mask", str(tmp_path / "mask.npy")]
    asked = {}
    monkeypatch.setattr(dnanalyze, "load", lambda folder, **more: asked.update(more))
    exec(python(source, path).split("model")[0].rsplit("\n", 1)[0], {})
    assert asked == {"keep_outliers": True, "mask": str(tmp_path / "mask.npy")}
