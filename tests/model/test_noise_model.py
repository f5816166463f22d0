"""The model and its file."""

import numpy as np
import pytest
import yaml

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.laws import ArrheniusLaw, TableLaw
from dnanalyze.model.noise_model import NoiseModel, dump_model, load_model, model_from_plain
from dnanalyze.model.registry import built_in
from dnanalyze.model.simulate import simulate


def ordinary() -> NoiseModel:
    known = built_in()
    table = TableLaw((OperatingPoint(25.0), OperatingPoint(65.0)), (0.5, 2.5))
    effects = (
        known["quantization"](),
        known["read_noise"](sigma=1.5),
        known["convolved_lognormal"](mu=table, delta=0.4),
        known["dark_shot_noise"](dn_per_e=0.5),
    )
    return NoiseModel(effects, 64.0, OperatingPoint(45.0, 0.1, 1.0), 7)


def test_model_survives_its_file(tmp_path):
    path = tmp_path / "m.yaml"
    path.write_text(dump_model(ordinary()))
    assert load_model(path) == ordinary()


def test_a_model_prints_its_effects_and_the_number_of_its_parameters():
    read = built_in()["read_noise"]
    own = NoiseModel((read(sigma=1.5),), ArrheniusLaw(64.0, 25.0, 0.6))
    count = 2 + sum(p.scale != "choice" for p in read.parameters().values())
    assert repr(own) == f"<NoiseModel: read_noise; {count} parameters>"
    assert repr(ordinary()).startswith("<NoiseModel: quantization, read_noise, convolved_lognormal")
    assert repr(NoiseModel(())) == "<NoiseModel: no effects; 1 parameter>"


def test_chain_follows_the_signal_not_the_file():
    assert [e.name for e in ordinary().chain] == [
        "convolved_lognormal",
        "dark_shot_noise",
        "read_noise",
        "quantization",
    ]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("effects: 3", "not a model file"),
        ("[]", "not a model file"),
        ("effects: [nonsense]", "valid names"),
        ("effects: [{read_noise: {sgima: 1}}]", "valid: sigma"),
        ("effects: [{read_noise: {sigma: -1}}]", r"sigma: -1 DN is outside 0.001 to 10000"),
        ("effects: [{row_noise: {tilt: 7}}]", "tilt: 7 is outside 0 to 2"),
        ("effects: [{read_noise: {sigma: .nan}}]", "no law"),
        ("effects: [read_noise, read_noise]", "twice"),
        ("effects: [read_noise]\ncolour: 1", "unknown key"),
        ("effects: [7]", "malformed"),
        ("effects: [", "not YAML"),
        ("effects: !!python/object/apply:os.getcwd []", "not YAML"),
    ],
)
def test_bad_model_files_give_one_line_that_names_the_file(tmp_path, text, says):
    path = tmp_path / "m.yaml"
    path.write_text(text)
    with pytest.raises(InputError, match=says) as caught:
        load_model(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_adding_replacing_and_removing_effects():
    model = ordinary()
    known = built_in()
    more = model.with_effect(known["pixel_fpn"](sigma=2.0))
    assert more.names == [*model.names, "pixel_fpn"]
    assert more.with_effect(known["pixel_fpn"](sigma=3.0)).get("pixel_fpn").sigma == 3.0
    assert more.without("pixel_fpn") == model


def test_missing_file_is_one_line(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        load_model(tmp_path / "none.yaml")


def test_plain_form_is_plain_yaml():
    assert (
        model_from_plain(yaml.safe_load(yaml.safe_dump(ordinary().to_plain())), "x") == ordinary()
    )


def test_the_unit_of_the_files_is_kept_where_it_is_not_one():
    model = NoiseModel((), 64.0, unit=16.0)
    assert yaml.safe_load(dump_model(model))["unit"] == 16.0
    assert model_from_plain(model.to_plain(), "m.yaml") == model
    assert "unit" not in NoiseModel((), 64.0).to_plain()
    for bad in (0, -1, "x", True, float("nan")):
        with pytest.raises(InputError, match="unit"):
            model_from_plain(model.to_plain() | {"unit": bad}, "m.yaml")


@pytest.mark.parametrize("one", [25, np.float64(25.0), np.int64(25)])
def test_equal_operating_points_draw_the_same_noise(one):
    points = OperatingPoint(one, one), OperatingPoint(25.0, 25.0)
    assert repr(points[0]) == repr(points[1])
    assert repr(OperatingPoint(-0.0)) == repr(OperatingPoint(0.0))
    model = NoiseModel((built_in()["read_noise"](2.0),), 64.0)
    first, second = (simulate(model, (8, 8), [(p, 2)]).to_numpy()[p] for p in points)
    np.testing.assert_array_equal(first, second)


@pytest.mark.parametrize(
    ("name", "numbers", "tolerance"),
    [
        (
            "column_taps",
            {"sigma": 6.0, "kind": "blocks", "levels": (2.0, -0.5), "begins": (40,)},
            0.0,
        ),
        ("column_taps", {"sigma": 6.0, "taps": 3, "levels": (3.0, 0.0, 1.0)}, 0.0),
        ("offset_gradient", {"x": 4.0, "y": -2.0, "xx": 5.0, "yy": 3.0, "xy": 1.0}, 0.1),
        ("column_fpn", {"settle": 30.0, "length": 60.0, "edge": 10.0, "edge_length": 30.0}, 0.3),
        ("storage_dark_current", {"amplitude": 9.0, "before": 0.5, "ea_ev": 0.6}, 0.8),
        ("dark_gradient", {"wait": -9.0, "ea_ev": 0.6}, 0.3),
        ("amp_glow", {"amplitude": 50.0}, 0.0),
    ],
)
def test_frames_without_exposure_have_the_black_level_that_a_model_states(name, numbers, tolerance):
    shape, warm = (160, 200), OperatingPoint(45.0, 0.0, 2.0)
    effects = [built_in()[name](**numbers)]
    model = NoiseModel(tuple(effects), 100.0, OperatingPoint(25.0, 1.0, 1.0))
    (frame,) = simulate(model, shape, [(warm, 1)]).to_numpy().values()
    shown = 100.0 + model.black_shift(warm, shape)
    assert float(np.median(frame)) == pytest.approx(shown, abs=tolerance + 1e-3)
