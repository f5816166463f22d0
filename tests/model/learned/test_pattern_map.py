"""The effect that adds a map: against closed forms, by window, in a model file beside its map."""

import numpy as np
import pytest

import dnanalyze
from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import OperatingPoint, Window
from dnanalyze.model.export.numpy_code import numpy_source
from dnanalyze.model.export.table import rows
from dnanalyze.model.learned.field_map import FieldMap, map_bytes
from dnanalyze.model.learned.pattern_map import PatternMap, named
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.simulate import simulate
from dnanalyze.thermal import arrhenius

MAP = FieldMap(np.random.default_rng(1).normal(0.0, 2.0, (8, 12)).astype(np.float32))
AT = OperatingPoint(25.0, 0.1, 1.0)


def frames(effect, point=AT, shape=(8, 12), window=None):
    made = simulate(NoiseModel((effect,), 64.0, reference=AT), shape, [(point, 2)])
    return [f.read(window) for f in made.frames()]


def test_a_constant_pattern_is_the_map_in_every_frame():
    for frame in frames(PatternMap(amplitude=0.5, map=MAP), OperatingPoint(85.0, 0.3, 1.0)):
        assert frame == pytest.approx(64.0 + 0.5 * MAP.array, rel=1e-6)


def test_a_thermal_pattern_grows_with_temperature_and_exposure():
    effect = PatternMap(law="thermal", ea_ev=0.55, map=MAP)
    (frame, _) = frames(effect, OperatingPoint(65.0, 0.3, 1.0))
    growth = 3.0 * arrhenius(65.0, 25.0, 0.55)
    assert frame == pytest.approx(64.0 + growth * MAP.array, rel=1e-5, abs=1e-4)


def test_a_window_is_cut_from_the_whole():
    effect, window = PatternMap(map=MAP), Window(2, 7, 3, 9)
    (part, _), (whole, _) = frames(effect, window=window), frames(effect)
    assert np.array_equal(part, whole[window.slices])


def test_another_shape_is_refused():
    with pytest.raises(InputError, match="map of 8 × 12 pixels; the frame has 16 × 16"):
        frames(PatternMap(map=MAP), shape=(16, 16))


def test_a_model_file_names_the_map_from_its_own_folder(tmp_path, monkeypatch):
    folder = tmp_path / "model"
    folder.mkdir()
    effect = named(PatternMap(map=MAP), folder / "map.npy", folder / "m.yaml")
    (folder / "map.npy").write_bytes(map_bytes(MAP))
    (folder / "m.yaml").write_text(dnanalyze.dump_model(NoiseModel((effect,), 64.0)))
    assert "file: map.npy" in (folder / "m.yaml").read_text()
    monkeypatch.chdir(tmp_path)
    found = dnanalyze.load_model(folder / "m.yaml").get("pattern_map")
    assert found.map == MAP


def test_a_model_without_its_map_is_refused(tmp_path):
    effect = named(PatternMap(map=MAP), tmp_path / "map.npy", tmp_path / "m.yaml")
    (tmp_path / "m.yaml").write_text(dnanalyze.dump_model(NoiseModel((effect,), 64.0)))
    with pytest.raises(InputError, match=r"m\.yaml: map .*map\.npy: No such file"):
        dnanalyze.load_model(tmp_path / "m.yaml")
    with pytest.raises(InputError, match="valid: a map of the frame"):
        PatternMap(map=3)


def test_its_variance_is_that_of_the_map():
    assert PatternMap(amplitude=2.0, map=MAP).variance(AT) == pytest.approx(4 * MAP.array.var())
    assert PatternMap(law="thermal", map=MAP).variance(AT) is None


def test_exports_say_what_they_cannot_hold():
    model = NoiseModel((PatternMap(map=MAP),), 64.0)
    with pytest.raises(InputError, match="pattern_map: an exported function holds no map"):
        numpy_source(model)
    (row,) = (r for r in rows(model) if r["parameter"] == "map")
    assert row["value"]["sha256"] == MAP.checksum
