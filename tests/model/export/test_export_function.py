"""`export` by suffix and by name."""

from __future__ import annotations

import pytest

from dnanalyze import InputError, NoiseModel, export, load_model
from dnanalyze.model.effects.column_fpn import ColumnFpn
from dnanalyze.model.effects.convolved_lognormal import ConvolvedLognormal
from dnanalyze.model.effects.dark_shot_noise import DarkShotNoise
from dnanalyze.model.effects.read_noise import ReadNoise

MODEL = NoiseModel((ConvolvedLognormal(), DarkShotNoise(0.5), ReadNoise(2.0), ColumnFpn(0.5)), 64.0)


@pytest.mark.parametrize(
    ("name", "format", "words"),
    [
        ("m.csv", None, "read_noise,sigma"),
        ("m.json", None, '"sigma"'),
        ("m.py", None, "def dark_frames"),
        ("m.py", "torch", "class DarkNoise"),
        ("m.toml", None, "resolution"),
        ("m.yml", "pyxel", "pipeline"),
        ("m.yaml", None, "dnanalyze/model/1"),
    ],
)
def test_a_file_of_each_form(tmp_path, name, format, words):
    target = tmp_path / name
    lost = export(MODEL, target, format=format)
    assert words in target.read_text()
    assert any("column_fpn" in what for what in lost) == (name in ("m.toml", "m.yml"))


def test_the_model_file_is_read_back(tmp_path):
    MODEL.save(tmp_path / "m.yaml")
    assert NoiseModel.load(tmp_path / "m.yaml") == load_model(tmp_path / "m.yaml") == MODEL
    assert "sigma: 0.5" in MODEL._repr_html_()


@pytest.mark.parametrize(
    ("name", "more", "words"),
    [
        ("m.txt", {}, "no format has this suffix"),
        ("m.csv", {"format": "tif"}, "frames come from simulate"),
        ("m.toml", {"temperatures": (5.0, 25.0)}, "one temperature"),
        ("m.toml", {"shape": (0, 5)}, "valid: 1 to"),
        ("none/m.csv", {}, "cannot be written"),
    ],
)
def test_what_cannot_be_written_is_refused_in_a_line(tmp_path, name, more, words):
    with pytest.raises(InputError, match=words):
        export(MODEL, tmp_path / name, **more)
    assert not list(tmp_path.rglob("*"))
