"""The commands of the README run, in its order, on a smaller sensor."""

import shlex

import docs_tree as tree
import numpy as np
import pytest


@pytest.fixture
def sensor_folder(tmp_path, monkeypatch):
    """A folder ``sensor`` as `dnanalyze demo sensor` leaves it, smaller."""
    from dnanalyze.demo import draw_sensor, generate, write_folder

    sensor = draw_sensor(np.random.default_rng(1))
    temperatures = sensor.temperatures_c[::2]
    made = generate(sensor, {"column_fpn": "strong"}, (128, 128), temperatures, frames=4, seed=1)
    write_folder(made, tmp_path / "sensor")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.slow
def test_readme_commands_run(sensor_folder, capsys):
    from dnanalyze_cli.main import main

    lines = [x for x in tree.command_lines(tree.ROOT / "README.md") if " sensor" in x]
    assert len(lines) >= 5
    for line in lines:
        assert main(shlex.split(line)[1:]) == 0, line
    shown = capsys.readouterr().out
    assert "column_fpn" in shown


@pytest.mark.slow
def test_readme_python_runs(sensor_folder, capsys):
    (block,) = tree.blocks(tree.ROOT / "README.md", "python")
    namespace: dict[str, object] = {}
    exec(block.text, namespace)
    assert "column_fpn" in capsys.readouterr().out
    frames = namespace["frames"]
    assert frames.frame_count == 8
    assert frames.settings[0].frames[0].read().shape == (1080, 1920)
