"""Selection of effects, from gains alone."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given as drawn
from hypothesis import strategies as st

from dnanalyze.diagnosis.candidates import by_standing
from dnanalyze.diagnosis.selection import (
    EVIDENCE_NULL,
    OUTSIDE,
    Trial,
    apart,
    beyond_doubt,
    competitors,
    confidence_of,
    confidences,
    contenders,
    falls,
    overdispersion,
    significant,
)
from dnanalyze.fitting.state import State, deviance
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.dark_current_steps import DarkCurrentSteps
from dnanalyze.model.effects.dpc import Dpc
from dnanalyze.model.effects.hot_clusters import HotClusters
from dnanalyze.model.effects.hot_pixels import HotPixels
from dnanalyze.model.effects.rts import Rts
from dnanalyze.model.noise_model import NoiseModel

NAMES = np.array(["lines"] * 3 + ["shading"] * 7)


def halves(lines: float, shading: float) -> np.ndarray:
    return np.array([lines] * 3 + [shading] * 7)


def one(z: float) -> float:
    return float(deviance(np.array([z]))[0])


def test_a_statistic_falls_by_what_it_does_at_all_operating_points():
    names = np.array(["lines", "shading", "lines"])
    fell = falls(names, np.array([9.0, 1.0, 2.0]), np.array([1.0, 4.0, 2.5]))
    np.testing.assert_allclose(fell, [one(9) + one(2) - one(1) - one(2.5), one(1) - one(4)])


def test_statistics_that_a_candidate_does_not_change_are_no_overdispersion():
    assert overdispersion(NAMES, halves(9.0, 5.0), halves(1.0, 5.0)) == 1.0


def test_overdispersion_is_weighted_by_the_change():
    found = overdispersion(NAMES, halves(9.0, 0.0), halves(2.0, 3.0))
    moved = np.array([3 * (one(9) - one(2)), 7 * one(3)])
    assert found == pytest.approx(moved @ [one(2), one(3)] / moved.sum())


def test_overdispersion_is_at_most_that_of_all_statistics():
    found = overdispersion(NAMES, halves(20.0, 0.0), halves(6.0, 0.0))
    assert found == pytest.approx(0.3 * one(6))


@pytest.mark.parametrize("left", [0.5, 0.99, 1.05, 1.3, 1.5])
def test_overdispersion_grows_from_one_without_a_step(left):
    found = overdispersion(NAMES, halves(9.0, 9.0), halves(left, left))
    assert found == pytest.approx(max(1.0, one(left)))


def test_a_candidate_that_changes_nothing_has_that_of_all_statistics():
    still = halves(3.0, 3.0)
    assert overdispersion(NAMES, still, still) == pytest.approx(one(3))
    assert overdispersion(np.empty(0, str), np.empty(0), np.empty(0)) == 1.0


def made(effect: str, gain: float, overdispersion: float = 1.0, error_fall: float = 0.5) -> Trial:
    state = State(NoiseModel(()), [], np.ones(4), lambda: np.ones(4), np.zeros((4, 0)))
    return Trial(effect, state, gain, gain, 1.0, error_fall, overdispersion)


def test_they_sum_to_one_with_nothing_in_the_last_place():
    chances = confidences([made("a", 300.0), made("b", 80.0)])
    assert chances.sum() == pytest.approx(1.0)
    assert chances.argmax() == 0
    assert chances[2] < chances[1] < chances[0]


def test_a_small_gain_is_nothing_and_so_is_one_that_raises_the_error():
    assert confidences([made("a", EVIDENCE_NULL / 5)])[1] > 0.5
    worse = made("a", 500.0, error_fall=-0.1)
    assert confidences([worse])[0] < 0.5
    assert not significant(worse)
    assert significant(made("a", 500.0))


def test_what_is_still_wrong_makes_gains_count_for_less():
    sure = confidences([made("a", 300.0), made("b", 200.0)])[0]
    unsure = confidences([made("a", 300.0, 4.0), made("b", 200.0, 4.0)])[0]
    assert sure > 0.99
    assert unsure < 0.9


def test_confidence_ranks_as_the_trials_are_ranked():
    """One overdispersion for all: that of the candidate with most evidence."""
    most, other = made("a", 300.0, 4.0), made("b", 200.0)
    assert [t.effect for t in by_standing([other, most])] == ["a", "b"]
    chances = confidences([most, other])
    assert chances[0] / chances[1] == pytest.approx(np.exp((300.0 - 200.0) / 4.0 / 16.0))


def of(effect: Effect, gain: float, overdispersion: float = 1.0) -> Trial:
    found = made(effect.name, gain, overdispersion)
    return dataclasses.replace(
        found, state=dataclasses.replace(found.state, model=NoiseModel((effect,)))
    )


@pytest.mark.parametrize("overdispersion", [1.0, 3.0])
@pytest.mark.parametrize(("rare", "odds"), [(DarkCurrentSteps(), 10.0), (HotClusters(), 1 / 0.3)])
def test_what_few_sensors_have_needs_its_odds_in_evidence(rare, odds, overdispersion):
    """Of a dozen hot pixels either law does: an equal share of both, ten hot pixels to one."""
    few, hot = (of(e, 200.0 * overdispersion, overdispersion) for e in (rare, HotPixels()))
    chances = confidences([few, hot])
    assert chances[1] / chances[0] == pytest.approx(odds)
    assert [t.effect for t in by_standing([few, hot])] == ["hot_pixels", rare.name]
    sure = of(rare, 400.0 * overdispersion, overdispersion)
    assert confidences([sure, hot])[0] > 0.99  # spacings that are seen speak for themselves


def test_beside_a_correction_hot_pixels_are_what_it_is_for():
    def beside(effect: Effect) -> Trial:
        found = of(effect, 100.0)
        model = NoiseModel((effect, Dpc()))
        return dataclasses.replace(found, state=dataclasses.replace(found.state, model=model))

    alone = confidences([of(HotPixels(), 100.0), of(Rts(), 100.0)])
    assert alone[0] == pytest.approx(alone[1])
    both = confidences([beside(HotPixels()), beside(Rts())])
    assert both[0] / both[1] == pytest.approx(10.0)


def test_a_near_rival_is_named():
    best, near, far = made("a", 300.0), made("b", 280.0), made("c", 90.0)
    assert competitors(best, [best, near, far]) == ["b"]


@pytest.mark.parametrize(("behind", "near"), [(5.9e3, ["b"]), (6.1e3, [])])
def test_what_is_behind_by_more_than_sensors_vary_is_no_competitor(behind, near):
    """300 in units of the overdispersion, however large the share of the evidence."""
    best, other = made("a", 40e3, overdispersion=20.0), made("b", 40e3 - behind)
    assert competitors(best, [best, other]) == near


def with_falls(found: Trial, *falls: float) -> Trial:
    return dataclasses.replace(found, falls=np.array(falls))


@pytest.mark.parametrize(
    ("other", "expected"),
    [
        ((0.0, 0.0, 90.0), True),
        ((22.0, -500.0, 68.0), True),  # what it harms is none of what both have
        ((23.0, 0.0, 67.0), False),
        ((90.0, 0.0, 0.0), False),
        ((30.0, 30.0, 5000.0), False),  # a quarter of the lesser's
        ((10.0, 10.0, 5000.0), True),
        ((), False),  # nothing is known of it
    ],
)
def test_candidates_that_explain_different_statistics_are_apart(other, expected):
    one, another = made("a", 50.0), made("b", 45.0)
    if other:
        one, another = with_falls(one, 60.0, 40.0, -9.0), with_falls(another, *other)
    assert apart(one, another) is apart(another, one) is expected


def test_contenders_gained_or_promised_nearly_as_much_of_the_same_statistics():
    best = with_falls(made("best", 1000.0), 900.0, 100.0)
    slow = with_falls(made("slow", 100.0), 90.0, 0.0)
    other = with_falls(made("other", 990.0), 0.0, 950.0)
    far = with_falls(made("far", 500.0), 450.0, 50.0)
    tried = [best, slow, other, far]
    promises = {"best": 1000.0, "slow": 800.0, "other": 990.0, "far": 500.0}
    assert contenders(best, tried, promises) == {"best", "slow"}
    assert contenders(best, tried, promises | {"slow": 690.0}) == {"best"}


@pytest.mark.parametrize(
    ("gain", "rival", "plain"),
    [(400.0, 250.0, True), (400.0, 350.0, False), (250.0, 10.0, False)],
)
def test_a_step_is_plain_with_much_evidence_and_no_rival_near(gain, rival, plain):
    best = dataclasses.replace(made("row_fpn", gain), falls=np.array([gain, 0.0]))
    other = dataclasses.replace(made("row_noise", rival), falls=np.array([rival, 0.0]))
    elsewhere = dataclasses.replace(made("column_fpn", gain), falls=np.array([0.0, gain]))
    assert beyond_doubt(best, [best, other, elsewhere]) == plain
    assert not beyond_doubt(dataclasses.replace(best, overdispersion=2.0), [best, other, elsewhere])


def test_what_explains_other_statistics_is_no_rival():
    """Row noise and column offsets, each missing: both are sure, and neither stands for both."""
    rows = with_falls(made("a", 4400.0, overdispersion=2.3), 8e3, 100.0, 0.0)
    columns = with_falls(made("b", 3900.0), 90.0, 0.0, 7e3)
    like_rows = with_falls(made("c", 4100.0, overdispersion=2.3), 7e3, 100.0, 50.0)
    tried = [rows, like_rows, columns]
    assert competitors(rows, tried) == ["c"]
    known = 1.0 - OUTSIDE
    assert confidence_of(columns, tried) > 0.999 * known
    assert confidence_of(rows, tried) == known * confidences([rows, like_rows])[0] > 0.99 * known
    assert confidence_of(like_rows, tried) == known * confidences([like_rows, rows])[0] < 0.01


@pytest.mark.parametrize("overdispersion", [1.0, 8.0])
def test_nothing_is_credited_in_proportion_to_what_is_left(overdispersion):
    even = [made("a", EVIDENCE_NULL * overdispersion, overdispersion)]
    np.testing.assert_allclose(confidences(even), [0.5, 0.5])


@pytest.mark.parametrize(
    ("gain", "fitted", "enough"),
    [(61.0, 63.0, True), (61.0, 62.0, False), (7.0, 200.0, True), (6.0, 200.0, False)],
)
def test_the_mean_gain_decides_and_either_half_gives_its_part(gain, fitted, enough):
    found = dataclasses.replace(made("a", gain), fitted_gain=fitted)
    assert found.evidence == (gain + fitted) / 2
    assert significant(found) is enough


@drawn(st.floats(1.0, 50.0), st.floats(-100.0, 1e4), st.floats(-100.0, 1e4))
def test_significance_is_in_units_of_the_overdispersion(overdispersion, gain, fitted):
    found = dataclasses.replace(made("a", gain), fitted_gain=fitted)
    scaled = dataclasses.replace(
        made("a", overdispersion * gain, overdispersion), fitted_gain=overdispersion * fitted
    )
    assert significant(found, 59.9999) >= significant(scaled, 60.0)
    assert significant(scaled, 59.9999) >= significant(found, 60.0)
    assert not significant(dataclasses.replace(found, error_fall=0.0), 60.0)
