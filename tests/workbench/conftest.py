from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from page_driver import Workbench, served
from small_sensor import write_sensor

import dnanalyze
from dnanalyze.model.noise_model import NoiseModel

FLAGS = [
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--disable-background-networking",
    "--disable-component-update", "--disable-sync",
]  # fmt: skip


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    """A headless Chromium; tests that ask for it are skipped where there is none."""
    api = pytest.importorskip("playwright.sync_api", reason="Playwright is not installed")
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    if chromium is None:
        pytest.skip("no Chromium on this machine")
    with api.sync_playwright() as play:
        made = play.chromium.launch(executable_path=chromium, args=FLAGS)
        yield made
        made.close()


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small virtual sensor with column FPN, as a folder of frames."""
    return write_sensor(tmp_path_factory.mktemp("workbench") / "sensor")


@pytest.fixture(scope="session")
def fitted(folder: Path) -> NoiseModel:
    """The Wang 2025 model, fitted to that sensor."""
    return dnanalyze.fit(dnanalyze.load(str(folder)), replicates=0).model


@pytest.fixture(scope="session")
def series(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A sensor of five temperatures, so that parameters share a plot on the page."""
    return write_sensor(tmp_path_factory.mktemp("page") / "sensor", every=1)


@pytest.fixture(scope="module")
def address(series: Path) -> Iterator[str]:
    """Of a server that shows the series."""
    with served(series) as found:
        yield found


@pytest.fixture(scope="module")
def bench(browser: Any, address: str) -> Iterator[Workbench]:
    """An open page of it, on which no script fails in any test."""
    made = Workbench(browser, address)
    yield made
    assert made.errors == []
