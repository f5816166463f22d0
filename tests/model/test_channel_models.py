"""One model of several readout channels, and the model of each back out of it."""

from __future__ import annotations

import importlib
import math
from dataclasses import replace

import numpy as np
import pytest

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.channel_models import channel_model, channels_of, merged, require
from dnanalyze.model.export.table import read_table, to_csv
from dnanalyze.model.laws import ArrheniusLaw, TableLaw
from dnanalyze.model.noise_model import NoiseModel, dump_model, model_from_plain
from dnanalyze.model.registry import built_in
from dnanalyze.model.simulate import simulate

P = OperatingPoint
E = built_in()
LONG, SHORT = P(45.0, 0.1, 1.0), P(45.0, 0.0125, 1.0)


def models():
    """A long exposure at a high gain, an eighth of it at a quarter of the gain."""

    def of(gain, seconds, read, reference, *more):
        signal = math.log(200.0 * gain * seconds)
        mu = TableLaw((P(25.0), P(45.0)), (signal - 2.0, signal))
        effects = (
            E["convolved_lognormal"](mu=mu, delta=0.4, phi=0.0, sigma=1e-6),
            E["dark_shot_noise"](dn_per_e=gain),
            E["read_noise"](sigma=read),
            *more,
        )
        return NoiseModel(effects, 64.0 + read, reference, 3)

    hot = E["hot_pixels"](fraction=2e-3, scale=80.0, ea_ev=0.5)
    return {
        "long": of(2.0, 0.1, 2.0, LONG, hot),
        "short": of(0.5, 0.0125, 1.5, SHORT, E["row_noise"](sigma=0.7)),
    }


def test_frames_of_each_channel_are_those_of_its_own_model():
    own = models()
    own["short"] = own["short"].with_effect(
        E["hot_pixels"](fraction=2e-3, scale=80.0 / 32.0, ea_ev=0.5)
    )
    one = merged(own, [25.0, 45.0])
    for channel, model in own.items():
        for celsius in (25.0, 45.0):
            at = replace(model.reference, channel=channel, temperature_c=celsius)
            expected, drawn = (
                simulate(m, (48, 48), [(at, 1)]).settings[0].frames[0].read() for m in (model, one)
            )
            weakest = 0.01 if channel == "long" else 0.0  # row noise at its weakest, DN
            assert np.abs(drawn - expected).max() <= weakest + 1e-3


def test_what_the_short_exposure_is_too_weak_to_show_is_scaled_from_the_bright_channel():
    one = merged(models(), [25.0, 45.0])
    hot = one.get("hot_pixels")
    assert hot.fraction == 2e-3
    assert hot.ea_ev == 0.5
    assert hot.value("scale", replace(LONG, channel="long")) == 80.0
    # a quarter of the gain, an eighth of the exposure
    assert hot.value("scale", replace(SHORT, channel="short")) == pytest.approx(80.0 / 32.0)


def test_the_models_of_the_channels_come_back_out():
    own = models()
    one = merged(own, [25.0, 45.0])
    assert channels_of(one) == ["long", "short"]
    assert channel_model(one, "long") == own["long"]
    back = channel_model(one, "short")
    assert back.without("hot_pixels") == replace(
        own["short"], effects=tuple(back.get(e.name) for e in own["short"].effects)
    )
    assert [back.get(e.name) for e in own["short"].effects] == list(own["short"].effects)


def test_an_arrhenius_law_is_stated_at_the_temperatures():
    own = models()
    law = ArrheniusLaw(5.0, 45.0, 0.6)
    own["long"] = own["long"].with_effect(E["read_noise"](sigma=law))
    one = merged(own, [25.0, 45.0, 65.0])
    for celsius in (25.0, 65.0):
        at = P(celsius, channel="long")
        assert one.get("read_noise").value("sigma", at) == pytest.approx(law.at(at))


def test_kinds_that_differ_give_way_to_the_commonest():
    choices = E["column_taps"].parameters()["kind"].choices
    kinds = (choices[0], choices[1], choices[1])
    own = {
        c: models()["short"].with_effect(E["column_taps"](sigma=1.0, kind=k))
        for c, k in zip("abc", kinds, strict=True)
    }
    assert merged(own).get("column_taps").kind == choices[1]


def test_files_keep_the_references(tmp_path):
    import yaml

    one = merged(models(), [25.0, 45.0])
    assert len(one.channel_references) == 2
    assert model_from_plain(yaml.safe_load(dump_model(one)), "M.yaml") == one
    (tmp_path / "M.csv").write_text(to_csv(one))
    assert read_table(tmp_path / "M.csv") == one


def test_a_channel_that_the_model_does_not_know_is_one_line():
    one = merged(models(), [25.0, 45.0])
    require(one, ["short"])
    require(models()["long"], ["anything"])
    with pytest.raises(InputError, match="no channel 'lofic'; valid: long, short"):
        require(one, ["short", "lofic"])


def test_the_exported_function_draws_the_channels(tmp_path, monkeypatch):
    from dnanalyze.model.export.numpy_code import numpy_source

    one = merged(models(), [25.0, 45.0])
    (tmp_path / "exported_channels.py").write_text(numpy_source(one))
    monkeypatch.syspath_prepend(tmp_path)
    exported = importlib.import_module("exported_channels")
    for channel in ("long", "short"):
        at = replace(one.reference_of(channel), channel=channel)
        drawn = exported.dark_frames(45.0, at.exposure_s, 1.0, channel, shape=(32, 32))[0]
        expected = simulate(one, (32, 32), [(at, 1)]).settings[0].frames[0].read()
        assert np.abs(drawn - expected).max() < 0.01
    assert exported.dark_frames(shape=(8, 8)).shape == (1, 8, 8)  # the first channel
