"""Channels of one pixel array: what is hidden in one is named in that one only."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "model"))
import hdr_sensor

from dnanalyze.diagnosis.channels import by_channel, refine_channels
from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import OperatingPoint


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


@pytest.mark.slow
def test_what_belongs_to_the_pixel_is_shared():
    result = refine_channels(hdr_sensor.captures((192, 192), rows={"hcg_short": 1.5}, hot=4e-3))
    assert "hot_pixels" in result.shared
    assert [c for c, names in result.own.items() if "row_noise" in names] == ["hcg_short"]


def test_captures_without_channels_are_refused_in_one_line():
    one = hdr_sensor.captures((16, 16), frames=2).select(lambda p: p.channel == "hcg_long")
    with pytest.raises(InputError, match=r"one channel; two or more .* column 'channel'"):
        by_channel(one)
