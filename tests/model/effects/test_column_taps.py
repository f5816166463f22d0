import dataclasses

import numpy as np
import pytest
from readout_bench import Given, added

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effects.column_taps import ColumnTaps


@pytest.mark.parametrize("taps", [2, 3, 4, 8, 16])
@pytest.mark.parametrize("kind", ["interleaved", "blocks"])
def test_offsets_of_the_taps_have_exactly_the_stated_rms(kind, taps):
    d = added(ColumnTaps(0.7, kind, taps), shape=(8, 240))
    np.testing.assert_allclose(d, np.broadcast_to(d[0, 0], d.shape), atol=1e-4)
    line = d[0, 0]
    per_tap = line.reshape(-1, taps) if kind == "interleaved" else line.reshape(taps, -1).T
    np.testing.assert_allclose(per_tap, np.broadcast_to(per_tap[0], per_tap.shape), atol=1e-4)
    assert per_tap[0].mean() == pytest.approx(0.0, abs=1e-4)
    assert per_tap[0].std() == pytest.approx(0.7, rel=1e-4)


def test_interleaved_taps_make_lines_at_multiples_of_one_pth():
    line = added(ColumnTaps(1.0, "interleaved", 4), shape=(4, 256))[0, 0]
    power = np.abs(np.fft.rfft(line)) ** 2
    assert set(np.flatnonzero(power > 1e-6 * power.max())) <= {64, 128}


def test_other_sensors_have_other_offsets_of_the_same_rms():
    lines = [added(ColumnTaps(1.0, "blocks", 8), 1, (4, 64), seed=s)[0, 0] for s in (1, 2)]
    assert not np.allclose(*lines, atol=0.01)


def test_follows_gain_but_not_temperature():
    plain = added(ColumnTaps(1.0))
    loud = added(ColumnTaps(1.0), point=OperatingPoint(85.0, 9.0, 2.0))
    np.testing.assert_allclose(loud, 2 * plain, atol=1e-4)


LEVELS = (1.0, -2.0, 0.5, 0.5)


def test_measured_levels_keep_their_proportion_and_order():
    line = added(ColumnTaps(2.0, "interleaved", 4, LEVELS), shape=(4, 64))[0, 0]
    wanted = np.array(LEVELS) * 2.0 / np.std(LEVELS)
    np.testing.assert_allclose(line, np.tile(wanted, 16), atol=1e-4)


@pytest.mark.parametrize("levels", [(1.0, 2.0), (1.0, 1.0, 1.0, 1.0), (1.0, np.nan, 0.0, 0.0)])
def test_levels_that_make_no_pattern_are_refused(levels):
    with pytest.raises(InputError, match=r"column_taps\.levels"):
        ColumnTaps(2.0, "interleaved", 4, levels)


def test_guess_reads_interleaved_levels_off_the_columns_beside_a_gradient():
    rng = np.random.default_rng(5)
    column = np.arange(256)
    profile = 0.8 * np.array(LEVELS)[column % 4] / np.std(LEVELS) + 0.01 * column
    profile += 0.02 * rng.standard_normal(256)
    shares = {"column_periodic_2": 0.3, "column_periodic_4": 0.985, "column_periodic_8": 0.99}
    seen = Given(seen=shares, off=dict.fromkeys(shares, 9.0), profiles={"columns": [profile]})
    (effect,) = ColumnTaps.guess(seen)
    assert effect.taps == 4
    # each level is the mean of 64 columns: 5 of its standard deviations, .0125 DN
    np.testing.assert_allclose(effect.levels, np.array(LEVELS) / np.std(LEVELS), atol=0.02)
    assert effect.sigma == pytest.approx(0.8, abs=0.0125)


def test_guess_reads_the_levels_of_strips_off_the_blocks():
    blocks = np.repeat(np.array([[3.0, -1.0, -1.0, -1.0]]), 8, axis=1).repeat(6, axis=0)
    seen = Given(off={"shading_1_0": -5.0}, curves={"block_means": [blocks]})
    (effect,) = ColumnTaps.guess(seen)
    assert (effect.kind, effect.taps) == ("blocks", 4)
    np.testing.assert_allclose(effect.levels, np.array([3, -1, -1, -1]) / np.sqrt(3), atol=1e-3)
    assert ColumnTaps.guess(dataclasses.replace(seen, off={})) == []


def test_taps_that_slip_move_by_whole_columns_from_frame_to_frame():
    effect = ColumnTaps(2.0, "interleaved", 4, LEVELS, slip=1.0)
    lines = added(effect, count=5, shape=(4, 64))[:, 0]
    for n in range(1, 5):
        np.testing.assert_allclose(lines[n], np.roll(lines[0], -n), atol=1e-4)
    np.testing.assert_allclose(lines[4], lines[0], atol=1e-4)


def test_guess_sees_which_settings_slip_and_turns_the_others_to_agree():
    rng = np.random.default_rng(6)
    points = tuple(OperatingPoint(t, 1.0) for t in (0.0, 20.0, 40.0))
    frequency = np.arange(1, 121) / 240
    column = np.arange(240)
    noise = rng.exponential(1.0, (3, 120))
    noise[1, 79] = 400.0  # 1/3 cycle a pixel, in the differences of the second setting
    levels = np.array([2.0, -1.0, -1.0])
    profiles = [levels[(column + shift) % 3] for shift in (0, 1, 2)]
    shares = {f"column_periodic_{p}": 0.99 if p == 3 else 0.0 for p in (2, 3, 4, 8)}
    seen = Given(
        (240, 240), points, seen=shares, off=dict.fromkeys(shares, 99.0),
        profiles={"columns": profiles},
        curves={"temporal_column_spectrum": list(noise), "column_spectrum_f": [frequency] * 3},
    )  # fmt: skip
    (effect,) = ColumnTaps.guess(seen)
    assert [effect.value("slip", p) for p in points] == [0.0, 1.0, 0.0]
    assert effect.sigma == pytest.approx(np.std(levels), rel=1e-6)
    assert sorted(effect.levels) == pytest.approx([-0.7071, -0.7071, 1.4142], abs=1e-3)


def test_unequal_strips_have_the_stated_rms_over_the_columns():
    effect = ColumnTaps(10.0, "blocks", levels=(1.0, -3.0, 0.0), begins=(62.0, 200.0))
    line = added(effect, 1, (4, 350))[0, 0]
    widths = [62, 138, 150]
    level = np.array([1.0, -3.0, 0.0])
    level -= np.average(level, weights=widths)
    level *= 10.0 / np.sqrt(np.average(level**2, weights=widths))
    np.testing.assert_allclose(line, np.repeat(level, widths), atol=1e-4)


def test_strips_of_rows_are_those_of_columns_turned():
    named = {"levels": (1.0, -1.0), "begins": (30.0,)}
    rows = added(ColumnTaps(5.0, "blocks", axis="rows", **named), 1, (100, 40))[0]
    columns = added(ColumnTaps(5.0, "blocks", **named), 1, (40, 100))[0]
    np.testing.assert_allclose(rows, columns.T, atol=1e-4)


@pytest.mark.parametrize("side", ["after", "before", "both"])
def test_a_step_settles_exponentially_beside_its_edge(side):
    named = {"levels": (1.0, 0.0), "begins": (40.0,)}
    plain = added(ColumnTaps(5.0, "blocks", **named), 1, (4, 100))[0, 0]
    settled = added(ColumnTaps(5.0, "blocks", settle=0.4, length=6.0, side=side, **named), 1,
                    (4, 100))[0, 0]  # fmt: skip
    step = plain[99] - plain[0]
    wanted = np.zeros(100)
    if side != "before":
        wanted[40:] -= 0.4 * step * np.exp(-np.arange(60) / 6.0)
    if side != "after":
        wanted[39::-1] += 0.4 * step * np.exp(-np.arange(40) / 6.0)
    np.testing.assert_allclose(settled - plain, wanted, atol=1e-4)


@pytest.mark.parametrize(
    "wrong",
    [{"begins": (5.0, 5.0)}, {"begins": (0.0,)}, {"begins": (4.0,), "kind": "interleaved"}],
)
def test_edges_that_make_no_strips_are_refused(wrong):
    with pytest.raises(InputError, match=r"column_taps\.begins"):
        ColumnTaps(2.0, **({"kind": "blocks"} | wrong))


def bowl(n):
    x = np.linspace(-1, 1, n)
    return 6.0 * x**2 + 3.0 * x


def test_guess_finds_one_step_of_unequal_strips_beside_a_bowl():
    rng = np.random.default_rng(8)
    profile = 20.0 * (np.arange(350) < 62) + bowl(350) + rng.standard_normal(350)
    seen = Given((350, 350), off={"shading_1_0": 9.0}, profiles={"columns": [profile]})
    (effect,) = ColumnTaps.guess(seen)
    assert effect.begins == (62.0,)
    # rms over the columns of a step h at a share p: h sqrt(p (1 - p)); the cubic beside it takes
    # some of the step, whose standard error is then .4 DN
    assert effect.sigma == pytest.approx(20.0 * np.sqrt(62 * 288) / 350, abs=5 * 0.4 * 0.4)


def test_guess_finds_a_step_of_rows_at_the_seam_of_the_halves():
    rng = np.random.default_rng(9)
    level = np.repeat([0.0, 4.0], 128) + 0.3 * rng.standard_normal(256)
    halves = np.concatenate([part - part.mean() for part in np.split(level, 2)])
    blocks = np.repeat(level.reshape(16, 16).mean(axis=1)[:, None], 16, axis=1)
    seen = Given(
        off={"shading_0_1": 9.0}, profiles={"rows": [halves]}, curves={"block_means": [blocks]}
    )
    (effect,) = ColumnTaps.guess(seen)
    assert (effect.axis, effect.begins) == ("rows", (128.0,))


def test_guess_sees_no_strips_in_a_smooth_profile():
    rng = np.random.default_rng(10)
    line = bowl(256) + 4.0 * np.sin(np.arange(256) / 30.0) + 0.1 * rng.standard_normal(256)
    blocks = np.repeat(line.reshape(16, 16).mean(axis=1)[None, :], 16, axis=0)
    seen = Given(
        off={"shading_1_0": 9.0}, profiles={"columns": [line]}, curves={"block_means": [blocks]}
    )
    assert ColumnTaps.guess(seen) == []


@pytest.mark.parametrize("kind", ["interleaved", "blocks"])
def test_taps_of_rows_are_those_of_columns_turned(kind):
    named = {"kind": kind, "taps": 4, "levels": LEVELS}
    rows = added(ColumnTaps(5.0, axis="rows", slip=1.0, **named), 3, (96, 40))
    columns = added(ColumnTaps(5.0, slip=1.0, **named), 3, (40, 96))
    np.testing.assert_allclose(rows, columns.transpose(0, 2, 1), atol=1e-4)


def test_guess_reads_odd_and_even_rows_off_their_profile():
    rng = np.random.default_rng(8)
    row = np.arange(256)
    profile = np.where(row % 2, -0.1, 0.1) + 0.05 * rng.standard_normal(256)
    seen = Given(off={"row_periodic_2": 12.0}, profiles={"rows": [profile]})
    (effect,) = ColumnTaps.guess(seen)
    assert (effect.axis, effect.kind, effect.taps) == ("rows", "interleaved", 2)
    assert effect.levels == (1.0, -1.0)
    # half the difference of two means of 128 rows: 4 of its standard deviations
    assert effect.sigma == pytest.approx(0.1, abs=4 * 0.05 / np.sqrt(256))
    assert ColumnTaps.guess(dataclasses.replace(seen, off={})) == []
