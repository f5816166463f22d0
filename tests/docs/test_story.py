"""The commands of the README and of the first hour run, in their order, on a smaller sensor."""

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


def run_commands(page, least):
    """Every command of the page that works on the folder ``sensor``, in its order."""
    from dnanalyze_cli.main import main

    lines = list(tree.command_lines(page))
    assert len(lines) >= least
    for line in lines:
        assert main(shlex.split(line)[1:]) == 0, line


@pytest.mark.slow  # .ci/run runs it
def test_readme_commands_run(sensor_folder, capsys):
    run_commands(tree.ROOT / "README.md", 1)
    assert "column_fpn" in capsys.readouterr().out


@pytest.mark.slow
def test_first_hour_commands_run(sensor_folder, capsys):
    run_commands(tree.DOCS / "first-hour.md", 5)
    shown = capsys.readouterr().out
    assert "column_fpn" in shown
    assert (sensor_folder / "analyze.html").stat().st_size > 100_000
    assert (sensor_folder / "targets.yaml").exists()


@pytest.mark.slow
def test_readme_python_runs(sensor_folder, capsys):
    (block,) = tree.blocks(tree.ROOT / "README.md", "python")
    namespace: dict[str, object] = {}
    exec(block.text, namespace)
    assert "column_fpn" in capsys.readouterr().out
    assert (sensor_folder / "model.yaml").exists()
    frames = namespace["frames"]
    assert frames.frame_count == 8
    assert frames.settings[0].frames[0].read().shape == (1080, 1920)
