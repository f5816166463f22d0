"""``--mask`` wherever frames are read."""

import json

import numpy as np
import pytest
from dnanalyze_cli.main import main

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


@pytest.mark.parametrize(
    "command",
    [
        ["benchmark", "FOLDER", "FOLDER"],
        ["channels", "FOLDER"],
        ["check", "FOLDER", "--init=t.yaml"],
    ],
)
def test_a_mask_of_another_shape_is_refused(command, folder, capsys):
    other = folder.parent / "other.npy"
    given = [str(folder) if a == "FOLDER" else a for a in command]
    assert main([*given, f"--mask={other}"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "has (64, 32) pixels, the frames have (64, 64)" in line
