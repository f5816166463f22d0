"""Mosaics of 4 x 4 and 6 x 6 pixels: read, told, analysed as phases, written and read again."""

import numpy as np
import pytest
import yaml

import dnanalyze
from dnanalyze.errors import InputError
from dnanalyze.loaders import load, planes
from dnanalyze.loaders.config import checked_config
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import built_in

SHAPE = (96, 96)
QUAD = "RRGGRRGGGGBBGGBB"
X_TRANS = "GGRGGBGGBGGRBRGRBGGGBGGRGGRGGBRBGBRG"


def folder(root, cfa, blue=0.0):
    period = round(len(cfa) ** 0.5)
    letters = np.array(list(cfa)).reshape(period, period)
    offset = blue * np.tile(letters == "B", [n // period for n in SHAPE])
    rng = np.random.default_rng(0)
    for k in range(4):
        frame = rng.normal(100.0, 4.0, SHAPE) + offset
        np.save(root / f"dark_20C_1s_{k}.npy", frame.round().astype(np.uint16))
    (root / "dnanalyze.yaml").write_text(f"cfa: {cfa}\nbits: 12\n")
    return root


@pytest.mark.parametrize("cfa", [QUAD, X_TRANS])
def test_a_large_mosaic_is_told_and_colours_that_differ_are(tmp_path, cfa):
    period = round(len(cfa) ** 0.5)
    (note,) = load(folder(tmp_path, cfa)).notes
    assert note.startswith(f"The mosaic of {period} x {period} pixels is analysed as its four")
    assert "differ in level" not in note
    captures = load(folder(tmp_path, cfa, blue=30.0))
    (note,) = captures.notes
    assert "Its colours differ in level (" in note
    assert "B 130" in note
    for name, plane in planes(captures):
        level = next(plane.frames()).read().mean()
        assert level == pytest.approx(130.0 if name.startswith("B") else 100.0, abs=2.0)


@pytest.mark.parametrize("cfa", [QUAD, X_TRANS])
def test_a_simulation_like_a_large_mosaic_keeps_it(tmp_path, cfa):
    (tmp_path / "in").mkdir()
    captures = load(folder(tmp_path / "in", cfa))
    model = NoiseModel((built_in()["read_noise"](sigma=4.0),), 100.0)
    made = dnanalyze.simulate(model, like=captures).save(tmp_path / "out")
    again = load(made)
    assert again.sensor.cfa == captures.sensor.cfa
    found = dnanalyze.analyze(again).settings
    assert [s.plane for s in found] == ["00", "01", "10", "11"]
    for setting in found:
        assert setting.values["temporal_noise"].value == pytest.approx(4.0, rel=0.05)


@pytest.mark.parametrize("cfa", ["[RG, GB]", "[[R, G], [G, B]]", "rggb"])
def test_a_colour_filter_is_a_word_or_rows(cfa):
    config = checked_config({"cfa": yaml.safe_load(cfa)}, "sidecar")
    assert config.colour_filter() == (("R", "G"), ("G", "B"))


@pytest.mark.parametrize("cfa", ["[R, G]", "[[1, 2], [3, 4]]", "5"])
def test_what_is_no_colour_filter_is_refused(cfa):
    with pytest.raises(InputError, match="sidecar: cfa: "):
        checked_config({"cfa": yaml.safe_load(cfa)}, "sidecar")
