"""The sample files and the commands of docs/ci.md, run as they are written."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
import yaml

from dnanalyze.checking.check import check
from dnanalyze.checking.targets import dump_targets, load_targets
from dnanalyze.loaders import load, write_captures
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.hdr import simulate_combined
from dnanalyze.model.hdr_file import load_combination
from dnanalyze.model.noise_model import dump_model, load_model
from dnanalyze.model.simulate import simulate

ROOT = Path(__file__).parents[2]
SAMPLES = ROOT / "sample_configs"
TEMPERATURES = (25.0, 45.0, 65.0)


@pytest.fixture(scope="module")
def noise(tmp_path_factory):
    """A repository with noise/dark, noise/model.yaml and noise/targets.yaml."""
    root = tmp_path_factory.mktemp("repository")
    folder = root / "noise"
    folder.mkdir()
    shutil.copy(SAMPLES / "model.yaml", folder)
    shutil.copy(SAMPLES / "targets.yaml", folder)
    model = load_model(folder / "model.yaml")
    settings = [(OperatingPoint(t, 0.05, 1.0), 4) for t in TEMPERATURES]
    write_captures(simulate(model, (96, 96), settings, "dark"), folder / "dark", "npy")
    return root


def run(command, folder, **environment):
    """By bash, with this Python and its dnanalyze first on the path."""
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    return subprocess.run(
        ["bash", "-e", "-c", command],
        cwd=folder,
        env=os.environ | {"PATH": path, "NO_COLOR": "1"} | environment,
        capture_output=True,
        text=True,
    )


def test_the_sample_targets_are_read_and_held(noise):
    targets = load_targets(SAMPLES / "targets.yaml")
    again = noise / "again.yaml"
    again.write_text(dump_targets(targets))
    assert load_targets(again) == targets
    model = load_model(SAMPLES / "model.yaml")
    captures = load(noise / "noise" / "dark")
    for seed in (5, 6):
        from dataclasses import replace

        result = check(captures, targets, replace(model, seed=seed))
        assert result.passed, [(c.name, c.value, c.lower, c.upper) for c in result.failures]
    assert [c.subject for c in result.known_misses] != ["temporal_noise"]
    louder = check(captures, targets, model.with_effect(ReadNoise(sigma=2.6)))
    assert {"temporal_noise", "read_noise.sigma"} <= {c.subject for c in louder.failures}


def steps():
    return yaml.safe_load((SAMPLES / "dark-noise.yml").read_text())["jobs"]["check"]["steps"]


def workflow(folder):
    """Run the workflow's steps as a runner does; the exit codes of those that ran."""
    summary = folder / "summary.md"
    summary.write_text("")
    codes: list[int] = []
    for step in steps():
        if "run" not in step:
            assert step["uses"].startswith("actions/")
            continue
        if any(codes) and step.get("if") != "always()":
            continue
        done = run(step["run"], folder, GITHUB_STEP_SUMMARY=str(summary), GITHUB_RUN_NUMBER="12")
        assert done.returncode in (0, 1), done.stderr
        codes.append(done.returncode)
    return codes, summary.read_text()


@pytest.mark.slow  # .ci/run runs it
def test_the_github_workflow_passes_and_fails_as_it_should(noise):
    codes, summary = workflow(noise)
    assert codes == [0, 0, 0]
    assert "Passed" in summary
    model = noise / "noise" / "model.yaml"
    good = model.read_text()
    try:
        model.write_text(dump_model(load_model(model).with_effect(ReadNoise(sigma=2.6))))
        codes, summary = workflow(noise)
    finally:
        model.write_text(good)
    assert codes == [0, 1, 0]
    assert "Failed" in summary
    assert "temporal_noise at 25 °C" in summary
    assert ET.parse(noise / "dark-noise.xml").getroot().find(".//failure") is not None


def test_the_pre_commit_hook_runs(noise):
    (hook,) = yaml.safe_load((SAMPLES / "pre-commit-config.yaml").read_text())["repos"][0]["hooks"]
    done = run(hook["entry"], noise)
    assert done.returncode == 0, done.stdout + done.stderr
    assert re.search(hook["files"], "noise/model.yaml")
    assert not re.search(hook["files"], "noise/dark/T+025C/dark_000.npy")


@pytest.mark.slow  # .ci/run runs it
def test_the_commands_of_the_ci_page_run_as_written(noise, tmp_path):
    shutil.copytree(noise / "noise" / "dark", tmp_path / "noise" / "dark")
    blocks = re.findall(r"```bash\n(.*?)```", (ROOT / "docs" / "ci.md").read_text(), re.DOTALL)
    assert len(blocks) == 3
    for block in blocks:
        for command in block.strip().splitlines():
            done = run(command, tmp_path)
            assert done.returncode == 0, (command, done.stdout, done.stderr)
    assert (tmp_path / "dark-noise.xml").is_file()


def test_the_sample_combination_is_read():
    how = load_combination(SAMPLES / "hdr.yaml")
    assert how.names == ["hcg_long", "lcg_long", "lcg_short"]
    assert [t[2] for t in how.transitions] == [3000.0, 12000.0]


def test_the_sample_model_of_channels_is_simulated_and_combined(tmp_path):
    """The sample manifest finds its frames, the combination its channels."""
    from dnanalyze_cli.main import main

    model, out = SAMPLES / "hdr-model.yaml", tmp_path / "hdr"
    grid = ["--shape", "32x32", "--temperatures", "25,45,65", "--frames", "2", "--format", "npy"]
    assert main(["simulate", str(out), "--model", str(model), *grid, "-q"]) == 0
    drawn = load(out)
    how = load_combination(SAMPLES / "hdr.yaml")
    assert drawn.channels == sorted(how.names)
    combined = simulate_combined(load_model(model), how, (32, 32), [(OperatingPoint(45.0, 0.1), 2)])
    codes = combined.settings[0].frames[0].read()
    # dark charge of 400 e-/s median at 45 °C: 80 DN of the first channel, 1 code per 2 DN from 64
    assert abs(float(np.median(how.decode(codes))) - 80.0) < 4.0
    named = tmp_path / "named"
    for setting in drawn.settings:
        for number, frame in enumerate(setting.frames):
            point = setting.point
            file = named / point.channel / f"T{point.temperature_c:+04.0f}C" / f"{number}.npy"
            file.parent.mkdir(parents=True, exist_ok=True)
            np.save(file, np.rint(frame.read()).astype(np.uint16))
    shutil.copy(SAMPLES / "hdr-manifest.csv", named / "manifest.csv")
    assert [s.point for s in load(named).settings] == [s.point for s in drawn.settings]


def test_every_sample_is_run_by_a_test():
    tests = "".join(p.read_text() for p in (ROOT / "tests").rglob("test_*.py"))
    assert [p.name for p in SAMPLES.iterdir() if p.is_file() and p.name not in tests] == []
