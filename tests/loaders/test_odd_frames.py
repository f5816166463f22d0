"""A frame unlike the rest of its operating point is told and left out; ordinary ones are not."""

import numpy as np
import pytest

from dnanalyze import analyze
from dnanalyze.loaders import load
from dnanalyze.loaders.moved import find_move
from dnanalyze.loaders.odd_frames import Peers, odd_frames

SHAPE = (128, 192)
NOISE = 4.0


def ordinary(count, seed=0):
    rng = np.random.default_rng(seed)
    pattern = rng.normal(200.0, 2.0, SHAPE)
    return [pattern + rng.normal(0.0, NOISE, SHAPE) for _ in range(count)]


def folder(root, frames):
    for k, frame in enumerate(frames):
        np.save(root / f"dark_20C_1s_{k:02d}.npy", np.rint(frame).astype(np.uint16))
    return root


def glow(frame):
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]]
    return frame + 60 * np.exp(-((x - 90) ** 2 + (y - 60) ** 2) / 2000)


def noisy(frame):
    return frame + np.random.default_rng(9).normal(0, np.sqrt(8) * NOISE, SHAPE)


def saturated(frame):
    out = np.full(SHAPE, 4095.0)
    out[3, :40] = 4000
    return out


ODD = {
    "shifted by 1 column": lambda f, before: np.roll(f, 1, 1),
    "shifted by -17 rows": lambda f, before: np.roll(f, -17, 0),
    "flipped top to bottom": lambda f, before: f[::-1],
    "flipped left to right": lambda f, before: f[:, ::-1],
    "turned by 180 degrees": lambda f, before: f[::-1, ::-1],
    "2.9 times their noise": lambda f, before: noisy(f),
    "a part of it is that of dark_20C_1s_03.npy": lambda f, before: np.vstack(
        [f[:64], before[64:]]
    ),
    "DN above them": lambda f, before: glow(f),
    "40 DN above them": lambda f, before: f + 40,
    "3.9e+03 DN above them": lambda f, before: saturated(f),
    "all pixels equal 4095": lambda f, before: np.full(SHAPE, 4095.0),
}


@pytest.mark.parametrize("said", ODD)
def test_an_odd_frame_is_named_and_left_out(tmp_path, said):
    frames = [np.rint(f) for f in ordinary(8)]
    frames[4] = ODD[said](frames[4], frames[3])
    captures = load(folder(tmp_path, frames))
    (note,) = captures.notes
    assert note.startswith("dark_20C_1s_04.npy ")
    assert said.replace("-", "") in note
    assert "left out; --keep-outliers keeps it" in note
    assert captures.frame_count == 7
    assert "dark_20C_1s_04.npy" not in [f.name for f in captures.frames()]
    values = analyze(captures, families=("level",)).settings[0].values
    assert values["temporal_noise"].value == pytest.approx(np.hypot(NOISE, 1 / 12**0.5), rel=0.02)


def test_an_odd_frame_is_kept_when_asked_for(tmp_path):
    frames = ordinary(8)
    frames[2] = np.roll(frames[2], 1, 1)
    captures = load(folder(tmp_path, frames), keep_outliers=True)
    assert captures.frame_count == 8
    (note,) = captures.notes
    assert "shifted by 1 column; kept as asked" in note


def test_two_kinds_of_frames_are_told_and_none_is_left_out(tmp_path):
    frames = ordinary(7)
    for k in (1, 3, 5):
        frames[k] = noisy(frames[k])
    captures = load(folder(tmp_path, frames))
    assert captures.frame_count == 7
    (note,) = captures.notes
    assert "3 of 7 frames at 20 °C, 1 s are unlike the rest" in note


def hits(rng, pattern, k):
    y = pattern + rng.normal(0, NOISE, SHAPE)
    struck = rng.random(SHAPE) < 0.002 * (1 + k % 3)
    y[struck] += rng.exponential(500, struck.sum())
    return y


def telegraph(rng, pattern, k):
    blinking = np.random.default_rng(1).exponential(30, SHAPE) * (pattern > 203)
    return pattern + rng.normal(0, NOISE, SHAPE) + blinking * (rng.random(SHAPE) < 0.5)


def drifting(rng, pattern, k):
    hot = 60 * (pattern > 204)
    return pattern + 3 * k + hot * (1 + 0.03 * k) + rng.normal(0, NOISE, SHAPE)


def flicker(rng, pattern, k):
    return pattern + 2 * (k % 2) + rng.normal(0, NOISE, SHAPE)


def rows(rng, pattern, k):
    return pattern + rng.normal(0, NOISE, SHAPE) + rng.normal(0, 2, (SHAPE[0], 1))


def ramp(rng, pattern, k):
    """A pedestal that wanders within the frame as it does from frame to frame."""
    slope = np.linspace(-1, 1, SHAPE[0])[:, None] * (4 if k == 0 else 0.3)
    return pattern + 3 * k + slope + rng.normal(0, NOISE, SHAPE)


def still(rng, pattern, k):
    return np.rint(pattern / 10) + (rng.random(SHAPE) < 1e-4)


@pytest.mark.parametrize("count", [3, 5, 40])
@pytest.mark.parametrize("kind", [hits, telegraph, drifting, flicker, rows, ramp, still])
def test_ordinary_frames_are_not_odd(kind, count):
    rng = np.random.default_rng(3)
    pattern = rng.normal(200.0, 2.0, SHAPE)
    peers = Peers(16)
    for k in range(count):
        peers.add(np.rint(kind(rng, pattern, k)).astype(np.uint16))
    assert odd_frames([peers.finish()]) == [{}]


def test_a_move_is_found_in_each_orientation_and_none_without_a_pattern():
    rng = np.random.default_rng(4)
    pattern = rng.normal(0, 1, (60, 90))
    found = find_move(np.roll(pattern[::-1], (3, -2), (0, 1)), pattern)
    assert found.words() == "flipped top to bottom and shifted by 3 rows and 2 columns"
    assert find_move(pattern, pattern) is None
    assert find_move(rng.normal(0, 1, (60, 90)), pattern) is None
