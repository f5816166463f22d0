import numpy as np
import pytest
from readout_bench import POINT, Given, Ramp, added, frames

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effects.offset_drift import OffsetDrift


def levels(effect, count=400, point=POINT):
    d = added(effect, count=count, shape=(4, 4), point=point)
    np.testing.assert_allclose(d, np.broadcast_to(d[:, :1, :1], d.shape), atol=1e-4)
    return d[:, 0, 0]


def test_a_random_walk_from_the_first_frame():
    steps = np.diff(levels(OffsetDrift(0.5)))
    assert steps.var() == pytest.approx(0.25, rel=5 * np.sqrt(2 / steps.size))
    assert abs(np.corrcoef(steps[1:], steps[:-1])[0, 1]) < 5 / np.sqrt(steps.size)


def test_a_start_transient_decays():
    b = levels(OffsetDrift(1e-5, transient=8.0, settling=2.0), count=8)
    np.testing.assert_allclose(b, 8.0 * np.exp(-np.arange(8) / 2.0), atol=1e-3)


def test_settings_wander_apart_and_follow_gain():
    here, there = (
        levels(OffsetDrift(1.0), 6),
        levels(OffsetDrift(1.0), 6, OperatingPoint(45.0, 1.0)),
    )
    assert np.abs(here - there).max() > 0.1
    start = levels(OffsetDrift(1e-5, 3.0), 1, OperatingPoint(25.0, 1.0, 2.0))
    assert start[0] == pytest.approx(6.0, abs=1e-3)


def test_guess_of_the_step_and_of_a_transient():
    rng = np.random.default_rng(2)
    walks = np.cumsum(rng.normal(0, 0.4, (500, 6)), axis=1)
    drift = np.sqrt(np.mean(walks.var(axis=1, ddof=1)))
    clues = Given(
        seen={"drift": drift}, model={"drift": 0.0}, off={"drift": 9.0},
        curves={"frame_means": [64 + walks[0]]},
    )  # fmt: skip
    assert OffsetDrift.guess(clues)[-1].step == pytest.approx(0.4, rel=0.25)
    clues.curves["frame_means"] = [np.array([70.0, 64.1, 64.0, 63.9, 64.0, 64.1])]
    first = OffsetDrift.guess(clues)[0]
    assert first.transient == pytest.approx(6.0, abs=0.1)
    assert first.inactive_parameters() == ("white",)
    assert OffsetDrift(0.1).inactive_parameters() == ("transient", "settling", "white")


def test_white_offsets_have_the_stated_variance_and_no_memory():
    b = levels(OffsetDrift(1e-5, white=0.5))
    assert b.var() == pytest.approx(0.25, rel=5 * np.sqrt(2 / b.size))
    assert abs(np.corrcoef(b[1:], b[:-1])[0, 1]) < 5 / np.sqrt(b.size)
    share = frames(Ramp(), OffsetDrift(1e-5, white=0.1, form="scaled"), count=2)
    shift = np.mean(share[1] - share[0]) / np.mean(frames(Ramp(), count=1) - 64.0)
    assert 1e-3 < abs(shift) < 0.1 * 5 * np.sqrt(2)


@pytest.mark.parametrize("white", [True, False])
def test_guess_tells_white_offsets_from_a_walk_by_successive_frames(white):
    rng = np.random.default_rng(7)
    points = tuple(OperatingPoint(t, 1.0) for t in range(0, 80, 10))
    steps = rng.normal(0, 0.4, (8, 8))
    means = steps if white else np.cumsum(steps, axis=1)
    clues = Given(
        points=points, seen={"drift": means.std(axis=1, ddof=1)}, model={"drift": 0.0},
        off={"drift": 9.0}, curves={"frame_means": list(64 + means)},
    )  # fmt: skip
    found = OffsetDrift.guess(clues)[0]
    assert bool(found.white) == white
    # a median of 8 standard deviations of 8 frames: 1.25 / sqrt(2 x 7 x 8) of 12 %
    if white:
        assert found.white == pytest.approx(0.4, rel=5 * 0.12)


@pytest.mark.parametrize("white", [True, False])
def test_offsets_that_grow_with_the_dark_signal_are_guessed_as_a_share(white):
    rng = np.random.default_rng(8)
    points = tuple(OperatingPoint(t, 1.0) for t in range(0, 80, 10))
    dark = 2.0 ** np.arange(8)
    steps = rng.normal(0, 0.04, (8, 8))
    share = steps if white else np.cumsum(steps, axis=1)
    means = 64 + dark[:, None] * (1 + share)
    clues = Given(
        points=points, seen={"drift": means.std(axis=1, ddof=1), "mean": 64 + dark},
        model={"drift": 0.0}, off={"drift": 9.0}, curves={"frame_means": list(means)},
    )  # fmt: skip
    found = next(g for g in OffsetDrift.guess(clues) if g.form == "scaled")
    assert bool(found.white) == white
    # the two hottest settings tell most: 14 degrees of freedom, fewer of a walk
    assert (found.white or found.step) == pytest.approx(0.04, rel=0.7)
    level = np.full(8, 100.0)
    clues.seen["mean"] = level
    assert all(g.form == "added" for g in OffsetDrift.guess(clues))


def test_a_cooling_chip_moves_the_dark_signal_by_a_share():
    cooling = OffsetDrift(1e-5, transient=0.1, settling=1.0, form="scaled")
    plain = frames(Ramp(), count=4, pedestal=64.0)
    made = frames(Ramp(), cooling, count=4, pedestal=64.0)
    share = 1 + 0.1 * np.exp(-np.arange(4.0))
    wanted = 64 + (plain - 64) * share[:, None, None]
    np.testing.assert_allclose(made, wanted, rtol=2e-4)


def test_a_share_is_guessed_from_the_slope_over_the_level():
    levels = np.array([100.0, 101.0, 110.0, 400.0])
    points = tuple(OperatingPoint(t, 1.0) for t in (-40.0, -20.0, 0.0, 20.0))
    lost = 0.08 * (levels - 100.0) + np.array([0.1, -0.1, 0.05, 0.1])
    clues = Given(
        points=points, seen={"drift": 1.0, "mean": levels}, model={"drift": 0.0},
        off={"drift": 9.0}, curves={"frame_means": [np.array([d, 0.0]) for d in lost]},
    )  # fmt: skip
    found = OffsetDrift.guess(clues)[-1]
    assert found.form == "scaled"
    difference = found.transient * (1 - np.exp(-1 / found.settling))
    assert difference == pytest.approx(0.08, rel=0.02)
