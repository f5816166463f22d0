"""What `dnanalyze workbench` refuses, in one line and with exit code 2."""

import importlib.util
import socket
import sys

import numpy as np
import pytest
from dnanalyze_cli.main import main


@pytest.fixture
def folder(tmp_path):
    """Two frames."""
    made = tmp_path / "captures"
    made.mkdir()
    rng = np.random.default_rng(1)
    for number in range(2):
        pixels = rng.normal(100, 3, (64, 64)).round().astype(np.uint16)
        np.save(made / f"dark_25C_0.1s_{number}.npy", pixels)
    return made


def told(capsys, *arguments: str) -> str:
    """The line on stderr of a run that is refused."""
    assert main(["workbench", *arguments, "--no-browser"]) == 2
    return [x for x in capsys.readouterr().err.splitlines() if x.startswith("dnanalyze:")][-1]


def test_a_folder_or_the_demo_is_needed_and_not_both(capsys, folder):
    for arguments in ((), (str(folder), "--demo")):
        assert "give a folder of dark frames, or --demo" in told(capsys, *arguments)


def test_an_empty_folder_is_told(capsys, tmp_path):
    assert str(tmp_path) in told(capsys, str(tmp_path))


def test_a_model_that_does_not_parse_is_told(capsys, folder, tmp_path):
    model = tmp_path / "broken.yaml"
    model.write_text("schema: [")
    assert "broken.yaml" in told(capsys, str(folder), "--model", str(model))


def test_without_the_extra_it_is_said_how_to_get_it(monkeypatch, capsys, folder):
    monkeypatch.setitem(sys.modules, "panel", None)
    assert "pip install 'panel>=1.9,<2'" in told(capsys, str(folder))


@pytest.mark.skipif(importlib.util.find_spec("panel") is None, reason="without the extra workbench")
def test_a_port_in_use_is_told(capsys, folder):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        said = told(capsys, str(folder), "--port", str(port))
    assert f"--port {port}: cannot listen on 127.0.0.1" in said
