from __future__ import annotations

from pathlib import Path

import pytest
from small_sensor import write_sensor

import dnanalyze
from dnanalyze.model.noise_model import NoiseModel


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small virtual sensor with column FPN, as a folder of frames."""
    return write_sensor(tmp_path_factory.mktemp("workbench") / "sensor")


@pytest.fixture(scope="session")
def fitted(folder: Path) -> NoiseModel:
    """The Wang 2025 model, fitted to that sensor."""
    return dnanalyze.fit(dnanalyze.load(str(folder)), replicates=0).model
