"""The combination of HDR channels: against closed forms and an independent generator."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent))
import hdr_sensor

from dnanalyze.comparator.combined import compare_combined
from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import CaptureSet, OperatingPoint, Sensor, Setting
from dnanalyze.model.channel_models import merged
from dnanalyze.model.hdr import ChannelUse, Combination, noise_steps, simulate_combined
from dnanalyze.model.hdr_file import load_combination
from dnanalyze.model.laws import TableLaw
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import built_in
from dnanalyze.model.simulate import simulate

P = OperatingPoint
E = built_in()
# DN per light that gives hcg_long 1 DN: gains 2, .5 and exposures .1, .0125
HOW = Combination(
    (
        ChannelUse("hcg_long", 64.0, 1.0, knee=3000.0),
        ChannelUse("lcg_long", 64.0, 0.25, knee=3000.0),
        ChannelUse("hcg_short", 64.0, 0.125, knee=3000.0, exposure=0.125),
        ChannelUse("lcg_short", 64.0, 0.03125, knee=4000.0, exposure=0.125),
    ),
    companding=((0.0, 64.0), (2000.0, 1064.0), (16000.0, 2464.0), (130000.0, 4000.0)),
)


def channel_model(seed=3):
    """The virtual sensor of hdr_sensor in terms of the model."""
    channels = hdr_sensor.CHANNELS
    points = tuple(P(channel=c) for c in channels)
    gains = tuple(g for g, *_ in channels.values())
    temperatures = (25.0, 45.0, 65.0)
    mu = TableLaw(
        tuple(P(t, channel=c) for c in channels for t in temperatures),
        tuple(
            float(np.log(400.0 * hdr_sensor.growth(t) * 0.1 * g))
            for g, *_ in channels.values()
            for t in temperatures
        ),
    )
    effects = (
        E["convolved_lognormal"](mu=mu, delta=0.4, phi=0.0, sigma=1e-6),
        E["dark_shot_noise"](dn_per_e=TableLaw(points, gains)),
        E["read_noise"](sigma=TableLaw(points, tuple(g * r for g, _, r, _ in channels.values()))),
        E["pixel_fpn"](sigma=TableLaw(points, tuple(0.6 * g for g in gains))),
        E["quantization"](),
    )
    return NoiseModel(effects, 64.0, P(45.0, 0.1, 1.0), seed)


def measured_combined(light=0.0, shape=(128, 128), frames=4, seed=1):
    """Combined frames of the independent generator."""
    rng = np.random.default_rng(seed)
    rate = hdr_sensor.rate_map(shape, rng)
    offset = 0.6 * rng.standard_normal(shape)
    point = P(45.0, 0.1, 1.0)
    made = []
    for number in range(frames):
        parts = {
            c: hdr_sensor.expose(c, rate, offset, 45.0, rng, light_e=light / 2.0)
            for c in hdr_sensor.CHANNELS
        }
        made.append(hdr_sensor.frame(point, HOW.combine(parts).astype(np.uint16), number))
    return CaptureSet("combined", Sensor(shape, bits=12), (Setting(point, tuple(made)),))


def test_each_range_of_light_comes_from_its_channel():
    light = np.array([[100.0, 2999.0, 3001.0, 11000.0, 13000.0, 23000.0, 30000.0, 90000.0]])
    frames = {u.channel: np.minimum(light * u.sensitivity + 64, 4095) for u in HOW.channels}
    assert HOW.linear(frames) == pytest.approx(light, rel=1e-5)
    spoiled = frames | {"lcg_long": np.zeros_like(light)}
    changed = HOW.linear(spoiled)[0] != pytest.approx(light[0], rel=1e-5)
    wrong = [abs(a - b) > 1 for a, b in zip(HOW.linear(spoiled)[0], light[0], strict=True)]
    assert changed
    assert wrong == [False, False, True, True, True, True, True, True]


def test_companding_goes_there_and_back_within_a_code():
    light = np.linspace(0, 125000, 500)
    codes = HOW.encode(light)
    x, y = np.array(HOW.companding).T
    slope = (np.diff(y) / np.diff(x))[np.clip(np.searchsorted(x, light, side="right") - 1, 0, 2)]
    assert np.all(np.abs(HOW.decode(codes) - light) <= 0.5 / slope * 1.01 + 1e-3)
    assert np.all(np.diff(codes) >= 0)


def test_a_blend_is_continuous():
    how = Combination(
        (ChannelUse("a", 0, 1.0, 1000.0, blend=200.0), ChannelUse("b", 0, 0.1, 1000.0)), black=0.0
    )
    # channel b reads 10 % too much: the blend goes from one to the other without a jump
    light = np.linspace(700, 1100, 401)[None, :]
    out = how.linear({"a": light, "b": 0.11 * light})
    assert np.diff(out[0]).min() > 0
    assert np.diff(out[0]).max() < 2.5
    assert out[0, 0] == pytest.approx(700)
    assert out[0, -1] == pytest.approx(1210)


def test_the_silicon_is_shared_between_channels_and_the_readout_is_not():
    model = channel_model()
    points = [(P(65.0, s, 1.0, c), 6) for c, (_, s, _, _) in hdr_sensor.CHANNELS.items()]
    made = simulate(model, (96, 96), points, "hdr")
    stacks = {s.point.channel: np.stack([f.read() for f in s.frames]) for s in made.settings}
    means = {c: s.mean(axis=0) - s.mean() for c, s in stacks.items()}
    shared = np.corrcoef(means["hcg_long"].ravel(), means["lcg_long"].ravel())[0, 1]
    assert shared > 0.9
    noise = {c: (s[0] - s[1]).ravel() for c, s in stacks.items()}
    # independent: |r| sd 1/96
    assert abs(np.corrcoef(noise["hcg_long"], noise["lcg_long"])[0, 1]) < 5 / 96


def test_combined_frames_of_an_independent_generator_are_reached():
    for light in (0.0, 6000.0):
        found = compare_combined(measured_combined(light), channel_model(), HOW, light)
        assert found.error < 1.8, found.failures
    wrong = compare_combined(measured_combined(6000.0), channel_model(), HOW, 5000.0)
    assert wrong.error > 5


def test_noise_steps_at_the_transitions():
    point = [(P(45.0, 0.1, 1.0), 2)]
    ours = noise_steps(
        lambda light: simulate_combined(channel_model(), HOW, (96, 96), point, light=light), HOW
    )
    theirs = noise_steps(lambda light: measured_combined(light, (96, 96), 2, 5), HOW)
    assert [(s.before, s.after) for s in ours] == [
        ("hcg_long", "lcg_long"), ("lcg_long", "hcg_short"), ("hcg_short", "lcg_short"),
    ]  # fmt: skip
    for a, b in zip(ours, theirs, strict=True):
        # sd of a noise from 9216 differences .74 %; of a ratio of ratios 1.5 % = .13 dB
        assert a.step_db == pytest.approx(b.step_db, abs=5 * 0.13)
    # lcg_long to hcg_short: variance (L/2 + 4^2) (.5/.25)^2 at .85 of the transition's light of
    # 12000 DN, (L/16 + 1.5^2) (2/.125)^2 at 1.15 of it
    below, above = (5100 + 16) * 2.0**2, (862.5 + 2.25) * 16.0**2
    assert ours[1].step_db == pytest.approx(10 * np.log10(above / below), abs=4 * 0.13)


def test_models_of_channels_merge_into_one():
    read = {"hcg": 2.0, "lcg": 5.0}
    models = {
        c: NoiseModel((E["read_noise"](sigma=s),), 60.0 + s, P(45.0, 0.1, 1.0), 4)
        for c, s in read.items()
    }
    models["lcg"] = models["lcg"].with_effect(E["row_noise"](sigma=0.7))
    one = merged(models, [25.0, 45.0])
    for c, s in read.items():
        at = P(45.0, 0.1, 1.0, c)
        assert one.get("read_noise").value("sigma", at) == s
        assert one.pedestal.at(at) == 60.0 + s
    assert one.get("row_noise").value("sigma", P(45.0, channel="lcg")) == 0.7
    assert one.get("row_noise").value("sigma", P(45.0, channel="hcg")) <= 1e-3


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("channels: [{channel: a, blak: 1}]", "unknown key 'blak'; valid: channel, black"),
        ("channels: [{channel: a}]", "each channel needs channel, black, sensitivity, knee"),
        ("channels: 3", "needs 'channels', a list"),
        (
            "channels: [{channel: a, black: 0, sensitivity: 1, knee: 9},"
            " {channel: b, black: 0, sensitivity: 2, knee: 9}]",
            "most sensitive channel first",
        ),
    ],
)
def test_bad_combinations_are_one_line(text, words, tmp_path):
    (tmp_path / "hdr.yaml").write_text(text)
    with pytest.raises(InputError, match=words):
        load_combination(tmp_path / "hdr.yaml")
    with pytest.raises(InputError, match="no frames of channel 'lcg_long'; there are hcg_long"):
        HOW.linear({"hcg_long": np.zeros((2, 2))})


def test_the_command_compares_and_writes_combined_frames(tmp_path):
    import yaml
    from dnanalyze_cli.main import main

    from dnanalyze.loaders import load, write_captures
    from dnanalyze.model.noise_model import dump_model

    write_captures(measured_combined(), tmp_path / "combined", "npy")
    (tmp_path / "M.yaml").write_text(dump_model(channel_model()))
    plain = {
        "channels": [vars(u) for u in HOW.channels],
        "companding": [list(k) for k in HOW.companding],
    }
    (tmp_path / "hdr.yaml").write_text(yaml.safe_dump(plain))
    assert load_combination(tmp_path / "hdr.yaml") == HOW
    options = [
        "--model",
        "M.yaml",
        "--combine",
        "hdr.yaml",
        "--simulate",
        "out",
        "--json",
        "H.json",
    ]
    placed = [o if o.startswith("--") else str(tmp_path / o) for o in options]
    found = {}
    for name in ("compare", "hdr"):  # the second is the earlier name of compare --combine
        call = [name, str(tmp_path / "combined"), *placed, "-q"]
        assert main([*call, "--force"] if found else call) == 0
        found[name] = json.loads((tmp_path / "H.json").read_text())
        assert found[name].pop("schema") == f"dnanalyze/{name}/1"
    assert found["compare"] == found["hdr"]
    written = found["compare"]
    assert written["error"] < 1.8
    assert main(call) == 2  # its frames exist
    assert len(written["noise_steps"]) == 3
    assert load(tmp_path / "out").frame_count == 4
