"""Channels of one pixel array: what is hidden in one is named in that one only."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "model"))
import hdr_sensor

from dnanalyze.channels.refinement import belonging, by_channel, refine_channels
from dnanalyze.demo import Channel, VirtualSensor, generate_channels
from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import built_in


@pytest.mark.slow
def test_an_effect_hidden_in_one_channel_is_named_there_only():
    captures = hdr_sensor.captures(rows={"lcg_long": 1.5})
    result = refine_channels(captures)
    assert result.own == {
        "hcg_long": [],
        "hcg_short": [],
        "lcg_long": ["row_noise"],
        "lcg_short": [],
    }
    assert result.shared == []
    assert result.findings == ["row_noise: in lcg_long only, so of that readout"]
    model = result.model
    sigma = {
        c: model.get("row_noise").value("sigma", OperatingPoint(45.0, channel=c))
        for c in hdr_sensor.CHANNELS
    }
    assert sigma["lcg_long"] == pytest.approx(1.5, rel=0.15)
    assert max(v for c, v in sigma.items() if c != "lcg_long") <= 1e-3
    for channel, (gain, *_) in hdr_sensor.CHANNELS.items():
        found = model.get("dark_shot_noise").value(
            "dn_per_e", OperatingPoint(45.0, channel=channel)
        )
        assert found == pytest.approx(gain, rel=0.15)


# two conversion gains, two exposures, of one virtual pixel array
SENSOR = VirtualSensor(
    gain_dn_e=2.0, read_noise_e=1.5, pixel_offset_e=0.6, dark_e_s=85.0, dark_spread=0.4,
    activation_ev=0.63, exposure_s=0.1, temperatures_c=(25.0, 45.0, 65.0),
)  # fmt: skip
CHANNELS = {
    "hcg_long": Channel(),
    "hcg_short": Channel(exposure=0.125),
    "lcg_long": Channel(gain=0.25, read_noise=2.7),
    "lcg_short": Channel(gain=0.25, read_noise=2.7, exposure=0.125),
}


def virtual(hidden=None, pixel=None, shape=(128, 128), seed=2):
    return generate_channels(SENSOR, CHANNELS, hidden, pixel, shape, frames=4, seed=seed)


@pytest.mark.slow
def test_two_effects_in_two_channels_are_each_named_in_their_own():
    hidden = {"hcg_short": {"row_fpn": {"e": 1.5}}, "lcg_long": {"column_fpn": {"e": 3.0}}}
    result = refine_channels(virtual(hidden))
    assert result.own == {
        "hcg_long": [], "hcg_short": ["row_fpn"], "lcg_long": ["column_fpn"], "lcg_short": [],
    }  # fmt: skip
    assert result.shared == []
    assert result.verdict == "adequate"
    for channel, name, sigma in (("hcg_short", "row_fpn", 3.0), ("lcg_long", "column_fpn", 1.5)):
        at = OperatingPoint(45.0, channel=channel)
        found = result.model.get(name).value("sigma", at)
        assert found == pytest.approx(sigma, rel=0.35)  # of 128 lines: 4.5 sigma of the fit's half


@pytest.mark.slow
def test_hot_pixels_belong_to_the_pixel_and_so_to_all_channels():
    hot = {"hot_pixels": {"fraction": 4e-3, "e": 1200.0, "activation_ev": 0.5}}
    hidden = {"hcg_short": {"row_noise": {"e": 1.0}}}
    result = refine_channels(virtual(hidden, hot, (192, 192)))
    assert result.shared == ["hot_pixels"]
    assert [c for c, names in result.own.items() if names] == ["hcg_short"]
    assert result.own["hcg_short"] == ["row_noise"]
    fraction = result.model.get("hot_pixels").fraction  # one number for all channels
    assert fraction == pytest.approx(4e-3, rel=0.5)


def test_which_effect_belongs_where():
    known = built_in()

    def of(*names):
        return NoiseModel(tuple(known[n]() for n in ("convolved_lognormal", "read_noise", *names)))

    models = {"a": of("hot_pixels", "row_fpn", "row_noise"), "b": of("row_noise")}
    shared, own, findings = belonging(models, known)
    assert shared == ["hot_pixels", "row_noise"]
    assert own == {"a": ["row_fpn"], "b": []}
    assert findings == [
        "hot_pixels: an effect of the pixel, shared by all channels; identified in a",
        "identified in every channel, so shared by all readouts: row_noise",
        "row_fpn: identified in a only, so an effect of that readout",
    ]
    assert belonging({"a": of(), "b": of()}, known)[2] == [
        "no channel needs more than the baseline effects"
    ]


def test_captures_without_channels_are_refused_in_one_line():
    one = hdr_sensor.captures((16, 16), frames=2).select(lambda p: p.channel == "hcg_long")
    with pytest.raises(InputError, match=r"one channel; two or more .* column 'channel'"):
        by_channel(one)
