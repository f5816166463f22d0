from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import dnanalyze
from dnanalyze.demo import draw_sensor, generate, write_folder
from dnanalyze.model.noise_model import NoiseModel


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small virtual sensor with column FPN, as a folder of frames."""
    sensor = draw_sensor(np.random.default_rng(3))
    made = generate(sensor, {"column_fpn": "strong"}, (96, 144), frames=3, seed=3)
    return write_folder(made, tmp_path_factory.mktemp("workbench") / "sensor")


@pytest.fixture(scope="session")
def fitted(folder: Path) -> NoiseModel:
    """The Wang 2025 model, fitted to that sensor."""
    return dnanalyze.fit(dnanalyze.load(str(folder)), replicates=0).model
