"""Deferred charge: where it goes, how much, and how it correlates the noise of the charge."""

import numpy as np
import pytest
from charge_bench import MadeUpClues, flat, frames, same_from_a_window
from readout_bench import frames as drawn

from dnanalyze.model.effects.dark_shot_noise import DarkShotNoise
from dnanalyze.model.effects.defect_lines import DefectLines
from dnanalyze.model.effects.hot_pixels import HotPixels
from dnanalyze.model.effects.scaled_lines import ScaledLines
from dnanalyze.model.effects.transfer_tails import TOWARDS, TransferTails, deferred


@pytest.mark.parametrize("side", TOWARDS)
def test_a_bright_line_has_an_exponential_tail_on_one_side(side):
    axis = "rows" if side in ("down", "up") else "columns"
    bright = ScaledLines(0.01, 99.0, axis, (30,), (1.0,))
    y = frames((flat(10.0), bright, TransferTails(0.1, 2.0, side)), (64, 64))[0]
    y = y if axis == "rows" else y.T
    y = y[:, 20] if side in ("down", "right") else y[::-1, 20]
    at = 30 if side in ("down", "right") else 33
    a = np.exp(-0.5)
    assert y[at] == pytest.approx(990 * 0.9 + 10, rel=1e-3)
    np.testing.assert_allclose(
        y[at + 1 : at + 5] - 10, 990 * 0.1 * (1 - a) * a ** np.arange(4), rtol=1e-2
    )
    assert y[at - 1] == pytest.approx(10.0, rel=1e-3)


@pytest.mark.parametrize("side", TOWARDS)
def test_the_share_grows_with_the_number_of_transfers(side):
    """In proportion, from nothing at the output to twice the mean."""
    axis = "rows" if side in ("down", "up") else "columns"
    lines = (4, 28, 52)
    bright = ScaledLines(0.05, 99.0, axis, lines, (1.0, 1.0, 1.0))
    y = frames((flat(10.0), bright, TransferTails(0.1, 1.0, side, "transfers")), (64, 64))[0]
    y = y if axis == "rows" else y.T
    y = y[:, 20] if side in ("down", "right") else y[::-1, 20]
    for line in lines:
        at = line if side in ("down", "right") else 63 - line
        share = 0.2 * (at + 0.5) / 64
        assert y[at] == pytest.approx(990 * (1.0 - share) + 10, rel=1e-3)
        assert y[at + 1] - 10 == pytest.approx(990 * share * (1 - np.exp(-1.0)), rel=0.03, abs=0.1)


def test_all_of_the_charge_is_deferred_at_most():
    bright = ScaledLines(0.02, 99.0, "rows", (62,), (1.0,))
    y = frames((flat(1.0), bright, TransferTails(0.6, 0.1, "down", "transfers")), (64, 64))[0]
    assert y.min() >= 0.0


def test_no_charge_is_lost_within_the_field():
    assert deferred(1.5, 8).sum() == pytest.approx(1.0)
    chain = (flat(1.0), HotPixels(0.01))
    before = frames(chain, (128, 128))[0]
    after = frames((*chain, TransferTails(0.3, 0.5, "up")), (128, 128))[0]
    assert after.sum() == pytest.approx(before.sum(), rel=0.01)  # a tail may leave the border


def test_noise_of_the_charge_is_correlated_along_the_tail_alone():
    loss, tau = 0.2, 0.7
    chain = (flat(400.0), DarkShotNoise(1.0), TransferTails(loss, tau, "right"))
    a, b = frames(chain, (256, 256), 2)
    noise = (a - b)[8:, 8:]
    weights = np.concatenate([[1 - loss], loss * deferred(tau, 4)])
    truth = weights[1:] @ weights[:-1] / (weights @ weights)
    lag = [np.mean(noise[:, 1:] * noise[:, :-1]), np.mean(noise[1:] * noise[:-1])]
    np.testing.assert_allclose(
        np.array(lag) / noise.var(), [truth, 0.0], atol=5 / np.sqrt(noise.size)
    )


@pytest.mark.parametrize("growth", ["none", "transfers"])
@pytest.mark.parametrize("side", TOWARDS)
def test_windows_hold_the_pixels_of_the_whole_frame(side, growth):
    same_from_a_window((flat(50.0), HotPixels(0.05), TransferTails(0.2, 3.0, side, growth)))


def test_offsets_of_the_readout_have_no_tail():
    lines = DefectLines(0.01, 40.0, "rows", (30,), (1.0,))
    with_it = drawn(lines, TransferTails(0.3, 2.0), shape=(64, 64))
    np.testing.assert_array_equal(with_it, drawn(lines, shape=(64, 64)))


@pytest.mark.parametrize(("across", "found"), [(0.0, "down"), (0.04, None)])
def test_it_is_guessed_from_correlation_along_one_axis(across, found):
    clues = MadeUpClues(
        seen={"temporal_corr_01": 0.05, "temporal_corr_10": across, "temporal_noise": 10.0},
        model={"temporal_corr_01": 0.0, "temporal_corr_10": 0.0},
        stands_out=("temporal_corr_01",),
    )
    assert TransferTails.guess(clues) == []  # one setting: what is charge is not told
    clues.points = clues.points * 2
    clues.seen["temporal_noise"] = [1.0, 10.0]
    guesses = TransferTails.guess(clues)
    assert {g.towards for g in guesses if g.growth == "none"} == ({found} if found else set())
    if found:  # the side of the output is told by a share that grows away from it
        assert {g.towards for g in guesses if g.growth == "transfers"} == {"down", "up"}
        assert guesses[0].loss == pytest.approx(0.05 / 0.99 / (1 - np.exp(-2.5)), rel=0.01)
