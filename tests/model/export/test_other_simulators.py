"""A model in the words of other simulators, against closed forms."""

from __future__ import annotations

import math
import tomllib

import pytest
import yaml

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.export.electrons import in_electrons
from dnanalyze.model.export.getframes_camera import getframes_preset
from dnanalyze.model.export.pyxel_pipeline import VOLT_PER_E, pyxel_pipeline
from dnanalyze.model.laws import TableLaw
from dnanalyze.model.noise_model import NoiseModel, dump_model
from dnanalyze.model.registry import built_in

MAKE = built_in()
K = 0.5  # DN/e-
KELVIN, EV_PER_K, EA_EV = 318.15, 8.617333e-5, 0.6


def log_dark(celsius):
    """ln DN: an Arrhenius law whose value at 45 C is 3."""
    return 3.0 - EA_EV / EV_PER_K * (1 / (celsius + 273.15) - 1 / KELVIN)


MU = TableLaw(
    tuple(OperatingPoint(c, 0.1, 1.0) for c in (15.0, 75.0)), (log_dark(15.0), log_dark(75.0))
)
MODEL = NoiseModel(
    (
        MAKE["convolved_lognormal"](mu=MU, delta=0.4, phi=0.001),
        MAKE["hot_pixels"](fraction=1e-3, scale=50.0, law="narrow"),
        MAKE["crosstalk"](alpha=0.01, diagonal=0.25, anisotropy=0.3),
        MAKE["dark_shot_noise"](dn_per_e=K),
        MAKE["read_noise"](sigma=1.5, spread=0.3),
        MAKE["noisy_pixels"](fraction=0.02, sigma=4.0),
        MAKE["pixel_fpn"](sigma=0.6),
        MAKE["row_noise"](sigma=0.2),
        MAKE["quantization"](bits=12),
    ),
    200.0,
    OperatingPoint(45.0, 0.1, 1.0),
)
MEAN_E = math.exp(3.0 + 0.4**2 / 2) / K  # of a log-normal law


def test_the_dark_current_in_electrons():
    here = in_electrons(MODEL)
    assert here.dark_e_s == pytest.approx(MEAN_E / 0.1)
    assert here.dark_e == pytest.approx(MEAN_E)
    # d ln I / dT = E / (k T^2), to second order of the 5 C on either side
    assert here.doubling_c == pytest.approx(math.log(2) * EV_PER_K * KELVIN**2 / EA_EV, rel=1e-2)
    cold = in_electrons(MODEL, 25.0)
    factor = math.exp(-EA_EV / EV_PER_K * (1 / 298.15 - 1 / KELVIN))
    assert cold.dark_e_s == pytest.approx(factor * here.dark_e_s, rel=1e-6)


def test_a_camera_of_getframes():
    made = getframes_preset(MODEL, (48, 64))
    camera = tomllib.loads(made.text)
    assert camera["resolution"] == [48, 64]
    assert camera["gain_e_per_adu"] == pytest.approx(1 / K)
    assert camera["bias_offset_adu"] == 200.0
    assert camera["bit_depth"] == 12
    assert camera["full_well_e"] == pytest.approx((4095 - 200) / K)
    # mean of a log-normal read noise whose root mean square is 1.5 DN
    assert camera["read_noise_e"] == pytest.approx(1.5 / K * math.exp(-(0.3**2) / 2), rel=1e-5)
    assert camera["hot_pixel_factor"] == pytest.approx(1 + 50.0 / K / MEAN_E, rel=1e-5)
    assert camera["read_noise_rts_factor"] == pytest.approx(math.hypot(1.5, 4.0) / 1.5, rel=1e-5)
    assert camera["ipc_coupling"] == 0.01
    lost = " ".join(made.lost)
    assert "row_noise" in lost
    assert "diagonal" in lost
    assert "along rows and columns" in lost
    assert "convolved_lognormal.phi" in lost
    assert all(f"# Not expressed: {what}" in made.text for what in made.lost)


def test_dead_pixels_have_a_field_of_getframes():
    made = getframes_preset(MODEL.with_effect(MAKE["dead_pixels"](fraction=0.003)), (48, 64))
    assert tomllib.loads(made.text)["dead_pixel_fraction"] == 0.003
    assert not any("dead_pixels" in what for what in made.lost)


@pytest.mark.parametrize(
    ("taps", "fields"),
    [
        ({"taps": 4}, {"readout_channel_count": 4, "bias_channel_spread_adu": 2.0}),
        ({"taps": 2, "axis": "rows"}, {}),
        ({"kind": "blocks", "taps": 4}, {"amplifier_layout": [1, 4], "amp_offset_spread_adu": 2.0}),
        ({"kind": "blocks", "taps": 4, "axis": "rows"}, {"amplifier_layout": [4, 1]}),
    ],
)
def test_taps_have_channels_or_amplifiers_of_getframes(taps, fields):
    made = getframes_preset(MODEL.with_effect(MAKE["column_taps"](sigma=2.0, **taps)), (48, 64))
    camera = tomllib.loads(made.text)
    assert fields.items() <= camera.items()
    spreads = {"bias_channel_spread_adu", "amp_offset_spread_adu"} & camera.keys()
    assert len(spreads) == bool(fields)
    assert any("column_taps" in what for what in made.lost)


def test_a_pipeline_of_pyxel():
    made = pyxel_pipeline(MODEL, (48, 64), 25.0)
    plain = yaml.safe_load(made.text)
    detector = plain["cmos_detector"]
    assert (detector["geometry"]["row"], detector["geometry"]["col"]) == (48, 64)
    assert detector["environment"]["temperature"] == pytest.approx(298.15)
    low, high = detector["characteristics"]["adc_voltage_range"]
    dn = (high - low) / 4095
    assert dn == pytest.approx(VOLT_PER_E / K)
    steps = {m["name"]: m.get("arguments") for g in plain["pipeline"].values() for m in g}
    dark = in_electrons(MODEL, 25.0).dark_e_s
    assert steps["simple_dark_current"]["dark_rate"] == pytest.approx(dark)
    assert steps["output_node_noise"]["std_deviation"] == pytest.approx(1.5 / K * VOLT_PER_E)
    assert steps["dc_offset"]["offset"] / dn == pytest.approx(200.5)  # it truncates
    assert steps["simple_ipc"]["diagonal_coupling"] == pytest.approx(0.0025)
    assert steps["simple_ipc"]["anisotropic_coupling"] == pytest.approx(0.003)
    assert any("hot_pixels" in what for what in made.lost)


@pytest.mark.parametrize("absent", ["dark_shot_noise", "convolved_lognormal"])
@pytest.mark.parametrize("translate", [getframes_preset, pyxel_pipeline])
def test_without_a_gain_or_a_dark_current_it_is_refused(absent, translate):
    with pytest.raises(InputError, match=f"no {absent}"):
        translate(MODEL.without(absent))


def test_the_command_says_what_is_lost(tmp_path, capsys):
    from dnanalyze_cli.main import main

    (tmp_path / "M.yaml").write_text(dump_model(MODEL))
    begin = ["export", str(tmp_path / "M.yaml"), "--to"]
    for name, file in (("getframes", "camera.toml"), ("pyxel", "pipeline.yaml")):
        assert main([*begin, name, "-o", str(tmp_path / file), "--shape", "64x96"]) == 0
        assert f"{name} does not express row_noise" in capsys.readouterr().err
    assert main([*begin, "pyxel", "-o", str(tmp_path / "p"), "--temperatures", "20,30"]) == 2
    assert "takes one temperature" in capsys.readouterr().err
    assert main([*begin, "pyxel", "-o", str(tmp_path / "p"), "--shape", "0x30"]) == 2
    assert "--shape 0x30" in capsys.readouterr().err
