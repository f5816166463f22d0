"""``--mask`` wherever frames are read."""

import json
import re

import numpy as np
import pytest
from dnanalyze_cli.main import main

import dnanalyze
from dnanalyze.loaders import load

SHAPE = (64, 64)


@pytest.fixture
def folder(tmp_path):
    """Frames of 100 DN whose last rows are another 900 DN higher, and the mask of these rows."""
    made = tmp_path / "captures"
    made.mkdir()
    rng = np.random.default_rng(0)
    for temperature in (25, 45):
        for number in range(3):
            frame = rng.normal(100.0, 5.0, SHAPE)
            frame[-8:] += 900.0
            name = f"T{temperature}C_exp_1s_{number}.npy"
            np.save(made / name, frame.round().astype(np.uint16))
    mask = np.zeros(SHAPE, np.uint8)
    mask[-8:] = 1
    np.save(tmp_path / "mask.npy", mask)
    np.save(tmp_path / "other.npy", mask[:, :32])
    return made


@pytest.mark.long
def test_a_benchmark_leaves_masked_pixels_out(folder):
    out, mask = folder.parent / "o.json", folder.parent / "mask.npy"
    nonuniformity = {}
    for option in ([f"--mask={mask}"], []):
        arguments = ["benchmark", str(folder), str(folder), "--quick", f"--json={out}", *option]
        assert main(arguments) == 0
        first = json.loads(out.read_text())["sensors"][0]["readings"]["dsnu"][0]
        nonuniformity[bool(option)] = first["value"]
        out.unlink()
    # of rows 900 DN higher, n of N: 900 sqrt(n (N - n)) / N
    assert nonuniformity[False] == pytest.approx(900.0 * np.sqrt(8 * 56) / 64, rel=0.01)
    assert nonuniformity[True] < 1.0


def model(folder):
    path = folder / "m.yaml"
    path.write_text(
        "schema: dnanalyze/model/1\npedestal: 100.0\n"
        "reference: {temperature_c: 25.0, exposure_s: 1.0, gain: 1.0}\nseed: 0\n"
        "effects:\n- read_noise: {sigma: 5.0}\n- quantization\n"
    )
    return path


def test_a_simulation_like_masked_captures_has_what_they_leave(folder, capsys):
    out, odd = folder.parent, folder / "T25C_exp_1s_9.npy"
    np.save(odd, np.random.default_rng(3).normal(100.0, 40.0, SHAPE).round().astype(np.uint16))
    base = ["simulate", "--model", str(model(folder.parent)), "--like", str(folder)]
    mask = f"--mask={folder.parent / 'mask.npy'}"
    assert main([*base, str(out / "m"), mask]) == 0
    said = capsys.readouterr().err
    assert "is unlike the" in said
    assert "hardly differs" not in said  # of the odd frame only
    captures = load(out / "m")
    assert captures.sensor.shape == (56, 64)
    assert [len(s.frames) for s in captures.settings] == [3, 3]
    assert main([*base, str(out / "n"), mask, "--keep-outliers"]) == 0
    assert [len(s.frames) for s in load(out / "n").settings] == [4, 3]
    assert main([*base[:3], str(out / "o"), mask]) == 2
    assert "--mask: leaves out pixels of --like" in capsys.readouterr().err


def test_simulated_pixels_are_their_own_where_measured_ones_are_filled(folder):
    dots = np.random.default_rng(1).random(SHAPE) < 0.01
    captures = load(folder, mask=dots)
    assert captures.sensor.filled > 0
    made = dnanalyze.simulate(dnanalyze.load_model(model(folder.parent)), like=captures)
    assert made.sensor.shape == SHAPE
    assert "temporal_corr_10" in dnanalyze.analyze(made).settings[0].values


@pytest.mark.parametrize(
    "command",
    [
        ["benchmark", "FOLDER", "FOLDER"],
        ["channels", "FOLDER"],
        ["check", "FOLDER", "--init=t.yaml"],
        ["simulate", "OUT", "--model=MODEL", "--like=FOLDER"],
    ],
)
def test_a_mask_of_another_shape_is_refused(command, folder, capsys):
    other = folder.parent / "other.npy"
    names = {"FOLDER": folder, "OUT": folder.parent / "made", "MODEL": model(folder.parent)}
    given = [re.sub("[A-Z]{3,}", lambda m: str(names[m[0]]), a) for a in command]
    assert main([*given, f"--mask={other}"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "has (64, 32) pixels, the frames have (64, 64)" in line
