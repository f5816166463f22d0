from dataclasses import replace

import numpy as np
import pytest
from readout_bench import Given, added, line_clues

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effects.column_fpn import ColumnFpn


def offsets(effect, **more):
    """Offsets of 8192 columns; that they are equal over rows and frames is checked on the way."""
    d = added(effect, shape=(6, 8192), **more)
    np.testing.assert_allclose(d, np.broadcast_to(d[0, 0], d.shape), atol=1e-4)
    return d[0, 0]


def settling_clues(profile, column, **more):
    """Clues with these means of the columns, and more power of columns than the model has."""
    profiles = {"columns": [profile], "places": [column]}
    shape = 256, column.size
    return line_clues("pattern_columns", 50.0, 3.0, shape, 9.0, profiles=profiles, **more)


def test_columns_scatter_by_sigma_and_stay():
    c = offsets(ColumnFpn(2.0))
    assert c.var() == pytest.approx(4.0, rel=5 * np.sqrt(2 / c.size))
    assert abs(np.corrcoef(c[1:], c[:-1])[0, 1]) < 5 / np.sqrt(c.size)


@pytest.mark.parametrize("rho", [-0.5, 0.8])
def test_neighbours_correlate_by_rho_at_the_same_variance(rho):
    c = offsets(ColumnFpn(2.0, rho))
    independent = c.size * (1 - rho**2) / (1 + rho**2)
    assert c.var() == pytest.approx(4.0, rel=5 * np.sqrt(2 / independent))
    assert np.corrcoef(c[1:], c[:-1])[0, 1] == pytest.approx(
        rho, abs=5 * np.sqrt((1 - rho**2) / c.size)
    )


def test_follows_gain_but_not_temperature_nor_exposure():
    cold = offsets(ColumnFpn(1.0))
    hot = offsets(ColumnFpn(1.0), point=OperatingPoint(85.0, 10.0, 1.0))
    loud = offsets(ColumnFpn(1.0), point=OperatingPoint(25.0, 1.0, 4.0))
    np.testing.assert_allclose(hot, cold, atol=1e-4)
    np.testing.assert_allclose(loud, 4 * cold, atol=2e-4)


def test_guess_from_power_on_the_axis():
    (effect,) = ColumnFpn.guess(line_clues("pattern_columns", 3.0 + 256 * 0.25, 3.0))
    assert effect.sigma == pytest.approx(0.5, rel=1e-6)
    assert effect.rho == 0.0


def test_guess_of_correlated_columns():
    f = np.sqrt([0.004 * 0.02, 0.02 * 0.1, 0.1 * 0.3, 0.3 * 0.5])
    power = 256 * 0.25 * (1 - 0.6**2) / np.abs(1 - 0.6 * np.exp(2j * np.pi * f)) ** 2
    (effect,) = ColumnFpn.guess(line_clues("pattern_columns", 3.0 + power, 3.0))
    assert effect.rho == pytest.approx(0.6, abs=0.02)
    assert effect.sigma == pytest.approx(0.5, rel=0.15)


def test_no_guess_without_a_sign():
    assert ColumnFpn.guess(line_clues("pattern_columns", 9.0, 3.0, z=2.0)) == []
    assert ColumnFpn.guess(Given()) == []


@pytest.mark.parametrize("first", ["left", "right"])
def test_a_settling_level_fades_exponentially_from_the_column_read_first(first):
    c = offsets(ColumnFpn(1e-4, settle=-20.0, length=40.0, first=first))
    wanted = -20.0 * np.exp(-np.arange(c.size) / 40.0)
    np.testing.assert_allclose(c if first == "left" else c[::-1], wanted, atol=1e-3)


def test_a_settling_level_follows_gain_alone_and_is_idle_where_it_is_none():
    effect = ColumnFpn(1e-4, settle=20.0, length=40.0)
    loud = offsets(effect, point=OperatingPoint(85.0, 10.0, 4.0))
    np.testing.assert_allclose(loud, 4 * offsets(effect), atol=2e-3)
    assert effect.inactive_parameters() == ("edge", "edge_length")
    assert ColumnFpn(1.0).inactive_parameters() == ("settle", "length", "edge", "edge_length")
    assert ColumnFpn(1.0, settle=1.0, edge=1.0).inactive_parameters() == ()


@pytest.mark.parametrize("first", ["left", "right"])
def test_the_other_edge_has_a_transient_of_its_own(first):
    settled = {"settle": -20.0, "length": 40.0, "first": first}
    c = offsets(ColumnFpn(1e-4, **settled, edge=9.0, edge_length=7.0))
    c = c if first == "left" else c[::-1]
    order = np.arange(c.size)
    wanted = -20.0 * np.exp(-order / 40.0) + 9.0 * np.exp(-(c.size - 1 - order) / 7.0)
    np.testing.assert_allclose(c, wanted, atol=1e-3)


@pytest.mark.parametrize(("first", "margin"), [("left", 0), ("left", 60), ("right", 0)])
def test_guess_reads_a_settling_level_off_the_columns(first, margin):
    """The transient of the whole field from the columns of its left half, noise beside it."""
    column = np.arange(margin, 512 + margin)
    away = column if first == "left" else 1023 - column
    profile = 30.0 * np.exp(-away / 90.0) + 0.3 * np.random.default_rng(4).standard_normal(512)
    clues = settling_clues(profile, column, whole=(256, 1024))
    (effect,) = ColumnFpn.guess(clues)
    if first == "right":  # 512 columns off it is e^(-5.7) of its start, below the noise
        assert effect.settle == 0.0
        return
    assert effect.first == first
    assert effect.length == pytest.approx(90.0, rel=0.12)  # the grid's step
    assert effect.settle == pytest.approx(30.0, rel=0.12)


def test_a_transient_that_begins_far_outside_the_window_is_within_its_bounds():
    column = np.arange(300, 812)
    profile = -3000.0 * np.exp(-(column - 300) / 60.0)  # e^5 times that at column 0
    profile += np.random.default_rng(5).standard_normal(512)
    clues = settling_clues(profile, column, whole=(256, 1024))
    (effect,) = ColumnFpn.guess(clues)
    assert effect.settle == -10_000.0


def test_where_a_transient_leaves_much_both_forms_are_guessed():
    column = np.arange(512)
    rng = np.random.default_rng(3)
    profile = 7.0 * np.exp(-column / 60.0) + np.repeat(rng.standard_normal(64), 8)
    clues = settling_clues(profile, column)
    scattered, settling = ColumnFpn.guess(clues)
    assert scattered.settle == 0.0 < settling.settle


@pytest.mark.parametrize("edge", [0.0, 20.0])
def test_a_second_edge_is_guessed_where_there_is_one(edge):
    column = np.arange(768)
    profile = 30.0 * np.exp(-column / 20.0) + edge * np.exp(-(767 - column) / 50.0)
    profile += 0.5 * np.random.default_rng(5).standard_normal(768)
    clues = settling_clues(profile, column)
    (effect,) = ColumnFpn.guess(clues)
    found = {"left": (effect.settle, effect.length), "right": (effect.edge, effect.edge_length)}
    if effect.first == "right":
        found = {"left": found["right"], "right": found["left"]}
    # blocks of 4 columns and steps of the grid
    assert found["left"] == pytest.approx((30.0, 20.0), rel=0.2)
    assert found["right"] == (pytest.approx((edge, 50.0), rel=0.2) if edge else (0.0, 50.0))


def test_it_adds_the_variance_of_its_columns_and_no_charge():
    effect = ColumnFpn(3.0, settle=-20.0, length=40.0, edge=9.0, edge_length=7.0)
    point, here = OperatingPoint(85.0, 10.0, 2.0), OperatingPoint(25.0, 1.0, 1.0)
    c = offsets(effect)
    level, variance = effect.adds(point, here, (64, c.size))
    assert level == 0.0
    # beside the transients, 3 DN of a normal law scatter the variance of so many columns
    error = np.sqrt(2 * 9.0**2 + 4 * 9.0 * np.var(offsets(replace(effect, sigma=1e-4)))) / np.sqrt(
        c.size
    )
    assert variance == pytest.approx(4.0 * c.var(), abs=5 * 4.0 * error)


def test_transients_are_guessed_beside_a_bowl_that_the_model_has():
    column = np.arange(768)
    profile = 30.0 * np.exp(-column / 20.0) + 40.0 * np.linspace(-1.0, 1.0, 768) ** 2
    profile += 0.5 * np.random.default_rng(6).standard_normal(768)
    clues = settling_clues(profile, column)
    for of in (clues.seen, clues.model):
        of["shading_2_0"] = 12.0
    effect = ColumnFpn.guess(clues)[-1]
    assert (effect.settle, effect.length) == pytest.approx((30.0, 20.0), rel=0.25)
    assert effect.first == "left"
