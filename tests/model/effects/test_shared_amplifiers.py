"""Pixels that share an amplifier: what they have in common, and what each has of its own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from dnanalyze.fitting.simulated import room
from dnanalyze.loaders.captures import OperatingPoint, Window
from dnanalyze.model.effects.noisy_pixels import NoisyPixels
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.effects.rts import Rts
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.simulator import Simulator

HERE = OperatingPoint(25.0, 1.0, 1.0)
ODD = (65, 99)  # rows and columns: the last groups are not whole
GROUPS = ("1x1", "1x2", "2x1", "2x2")
TRAP = Rts(0.05, 40.0, 0.5, 0.05, 0.0, exposure="none", amplitudes="fixed")


def simulator(*effects, shape=ODD):
    return Simulator(NoiseModel(effects, 0.0, HERE), shape)


def stack(*effects, count=16, shape=ODD):
    made = simulator(*effects, shape=shape)
    return np.stack([made.frame(HERE, n) for n in range(count)]).astype(float)


def alike_in_groups(seen, groups):
    """Whether all pixels of a group are in a set, or none is."""
    rows, columns = map(int, groups.split("x"))
    number = (np.arange(ODD[0]) // rows)[:, None] * ODD[1] + np.arange(ODD[1])[None] // columns
    _, group = np.unique(number, return_inverse=True)
    count = np.bincount(group.ravel(), seen.ravel())
    return bool(np.isin(count / np.bincount(group.ravel()), (0.0, 1.0)).all())


@pytest.mark.parametrize("groups", GROUPS)
def test_a_noisy_amplifier_makes_all_its_pixels_noisy(groups):
    y = stack(NoisyPixels(0.2, 3.0), ReadNoise(1e-3, shared=groups))
    noisy = y.std(axis=0) > 0.1
    assert alike_in_groups(noisy, groups)
    assert not alike_in_groups(noisy, "4x4")
    assert noisy.mean() == pytest.approx(0.2, abs=5 * 0.4 / np.sqrt(noisy.size / 4))


@pytest.mark.parametrize("groups", GROUPS)
def test_a_trap_of_an_amplifier_switches_all_its_pixels_each_in_its_own_time(groups):
    y = stack(TRAP, ReadNoise(1e-3, shared=groups))
    switching = np.ptp(y, axis=0) > 20.0  # of 16 states one in 30,000 is never another
    assert alike_in_groups(switching, groups)
    assert not alike_in_groups(switching, "4x4")
    two = switching[:, 1:] & switching[:, :-1] & (np.arange(ODD[1] - 1) % 2 == 0)
    state = y > 20.0
    joint = np.mean([np.corrcoef(state[:, r, c], state[:, r, c + 1])[0, 1]
                     for r, c in np.argwhere(two)])  # fmt: skip
    assert abs(joint) < 5 / np.sqrt(15 * two.sum())


def test_step_sign_and_occupancy_are_those_of_the_trap():
    trap = replace(TRAP, amplitudes="exponential", polarity="both", occupancies="spread")
    y = stack(trap, ReadNoise(1e-3, shared="2x2"), count=300, shape=(64, 96))
    step = np.where(y.max(axis=0) > -y.min(axis=0), y.max(axis=0), y.min(axis=0))
    occupancy = (np.abs(y) > np.abs(step) / 2).mean(axis=0)
    first = step[::2, ::2]
    seen = (np.abs(step) > 1.0) & (occupancy < 1.0)  # up in every frame: a trap of full occupancy
    both = (seen[::2, ::2] & seen[1::2, 1::2]).nonzero()
    assert both[0].size > 40
    np.testing.assert_allclose(step[1::2, 1::2][both], first[both], atol=0.05)
    assert (first[both] > 0).mean() == pytest.approx(0.5, abs=5 * 0.5 / np.sqrt(both[0].size))
    apart = occupancy[::2, ::2][both] - occupancy[1::2, 1::2][both]
    # each of 300 frames: sqrt(2 o (1 - o) / 300), of occupancies from 0 to 1
    assert apart.std() < 2 * np.sqrt(2 / 6 / 300)


def test_a_defect_of_the_photodiode_is_shared_by_none():
    traps = replace(TRAP, exposure="proportional")
    assert np.array_equal(
        stack(traps, ReadNoise(1.0, shared="2x2")), stack(traps, ReadNoise(1.0, shared="1x1"))
    )


def test_sigma_is_that_of_the_amplifier_and_the_noise_of_the_pixel():
    shape, count = (128, 128), 24
    y = stack(ReadNoise(2.0, spread=0.5, shared="2x2"), count=count, shape=shape)
    log = np.log(y.var(axis=0))
    log -= log.mean()
    # ln of a variance of 23 degrees of freedom scatters by 2/23, beside (2 spread)^2
    shared = 1.0 / (1.0 + 2.0 / (count - 1))
    five = 5 / np.sqrt(shape[0] * shape[1] / 4)
    within, between = (np.mean(log[:, k:-1:2] * log[:, k + 1 :: 2]) / log.var() for k in (0, 1))
    assert within == pytest.approx(shared, abs=five)
    assert between == pytest.approx(0.0, abs=five)
    assert np.mean(y[:, :, ::2] * y[:, :, 1::2]) == pytest.approx(0.0, abs=5 * 4 / np.sqrt(y.size))
    # mean square of log-normal factors, of one in four pixels
    assert np.mean(y**2) == pytest.approx(4.0, rel=5 * np.sqrt((np.exp(1.0) - 1) / 4096))


@pytest.mark.parametrize("groups", GROUPS)
@pytest.mark.parametrize("window", [Window(1, 34, 3, 60), Window(64, 65, 0, 99)])
def test_a_window_is_a_part_of_the_frame(groups, window):
    made = simulator(TRAP, NoisyPixels(0.1), ReadNoise(1.0, spread=0.3, shared=groups), shape=ODD)
    rows, columns = slice(window.top, window.bottom), slice(window.left, window.right)
    assert np.array_equal(made.frame(HERE, 1, window), made.frame(HERE, 1)[rows, columns])


def test_charge_kept_for_one_grouping_is_not_that_of_another():
    memo = room()
    for groups in GROUPS:
        model = NoiseModel((TRAP, ReadNoise(1.0, shared=groups)), 0.0, HERE)
        kept, anew = Simulator(model, ODD, memo), Simulator(model, ODD)
        assert np.array_equal(kept.frame(HERE, 0), anew.frame(HERE, 0))
