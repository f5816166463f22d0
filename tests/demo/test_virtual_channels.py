"""One pixel array read through several channels."""

import numpy as np
import pytest

from dnanalyze.demo import Channel, VirtualSensor, generate_channels, write_folder
from dnanalyze.loaders import load

SENSOR = VirtualSensor(dark_e_s=2000.0, read_noise_e=1.0, pixel_offset_e=0.1)
CHANNELS = {"long": Channel(), "short": Channel(gain=0.5, exposure=0.125)}


def stacks(**more):
    made = generate_channels(
        SENSOR, CHANNELS, shape=(64, 64), temperatures=[45.0], frames=8, **more
    )
    return {s.point.channel: np.stack([f.read() for f in s.frames]) - 64.0 for s in made.settings}


def test_channels_share_the_dark_current_but_no_noise():
    made = stacks()
    means = {c: y.mean(axis=0) for c, y in made.items()}
    # .5 of the gain and .125 of the exposure; the offsets scale with the gain alone
    assert means["long"].mean() / means["short"].mean() == pytest.approx(16.0, rel=0.02)
    assert np.corrcoef(means["long"].ravel(), means["short"].ravel())[0, 1] > 0.9
    noise = [(y[0] - y[1]).ravel() for y in made.values()]
    assert abs(np.corrcoef(*noise)[0, 1]) < 5 / 64


def test_hot_pixels_are_the_same_pixels_in_proportion_to_the_exposure():
    hot = {"hot_pixels": {"fraction": 5e-3, "e": 4000.0, "activation_ev": 0.6}}
    before, after = stacks(), stacks(pixel=hot)
    extra = {c: (after[c] - before[c]).mean(axis=0) for c in CHANNELS}
    seen = extra["long"] > 200
    assert 5 < seen.sum() < 50
    assert extra["long"][seen].sum() / extra["short"][seen].sum() == pytest.approx(16.0, rel=0.05)


def test_what_is_hidden_in_one_channel_leaves_the_others_alone():
    plain, striped = stacks(), stacks(hidden={"short": {"row_fpn": {"e": 5.0}}})
    assert (plain["long"] == striped["long"]).all()
    rows = (striped["short"] - plain["short"]).mean(axis=(0, 2))
    assert rows.std() == pytest.approx(2.5, rel=0.4)  # .5 DN/e- of 5 e-; 4.5 sigma of 64 rows


def test_the_folder_names_the_channels(tmp_path):
    made = generate_channels(SENSOR, CHANNELS, shape=(16, 16), temperatures=[25.0], frames=2)
    found = load(write_folder(made, tmp_path / "hdr"))
    assert found.channels == ["long", "short"]
    assert [s.point for s in found.settings] == [s.point for s in made.settings]
