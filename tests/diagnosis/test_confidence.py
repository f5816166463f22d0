"""Confidences from gains on data that no fit saw."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

from dnanalyze.diagnosis import diagnose
from dnanalyze.diagnosis.adequacy import REPLICATES
from dnanalyze.diagnosis.confidence import (
    CERTAIN,
    NOTHING,
    STANDS_IN,
    apart,
    confidence_of,
    confidences,
    lowers,
    rivals,
    significant,
)
from dnanalyze.diagnosis.diagnose import UNDONE
from dnanalyze.diagnosis.trial import Trial, by_standing
from dnanalyze.fitting.least_squares import State, given
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.dark_current_steps import DarkCurrentSteps
from dnanalyze.model.effects.dpc import Dpc
from dnanalyze.model.effects.hot_clusters import HotClusters
from dnanalyze.model.effects.hot_pixels import HotPixels
from dnanalyze.model.effects.periodic_pattern import PeriodicPattern
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.effects.rts import Rts
from dnanalyze.model.noise_model import NoiseModel


def made(effect: str, gain: float, error: float, spread: float = 1.0) -> Trial:
    state = State(NoiseModel(()), [], np.ones(4), given(np.ones(4)), np.zeros((4, 0)))
    return Trial(effect, state, gain, gain, error, spread)


def test_they_sum_to_one_with_nothing_in_the_last_place():
    chances = confidences([made("a", 300.0, 1.0), made("b", 80.0, 1.5)], 3.0)
    assert chances.sum() == pytest.approx(1.0)
    assert chances.argmax() == 0
    assert chances[2] < chances[1] < chances[0]


def test_a_small_gain_is_nothing_and_so_is_one_that_raises_the_error():
    assert confidences([made("a", NOTHING / 5, 1.0)], 1.1)[1] > 0.5
    worse = made("a", 500.0, 1.6)
    assert confidences([worse], 1.5)[0] < 0.5
    assert not significant(worse, 1.5)
    assert significant(made("a", 500.0, 1.4), 1.5)


def test_what_is_still_wrong_makes_gains_count_for_less():
    sure = confidences([made("a", 300.0, 1.0), made("b", 200.0, 1.2)], 3.0)[0]
    unsure = confidences([made("a", 300.0, 1.0, 4.0), made("b", 200.0, 1.2, 4.0)], 3.0)[0]
    assert sure > 0.99
    assert unsure < 0.9


def test_confidence_ranks_as_the_trials_are_ranked():
    """One overdispersion for all: that of the candidate with most evidence."""
    most, other = made("a", 300.0, 1.0, 4.0), made("b", 200.0, 1.2)
    assert [t.effect for t in by_standing([other, most])] == ["a", "b"]
    chances = confidences([most, other], 3.0)
    assert chances[0] / chances[1] == pytest.approx(np.exp((300.0 - 200.0) / 4.0 / 16.0))


@pytest.mark.parametrize(
    ("error", "spread", "sure"),
    [(8.9, 10.0, False), (7.5, 10.0, False), (7.3, 10.0, True), (8.9, 1.0, True)],
)
def test_a_first_name_that_hardly_explains_the_error_is_even_odds_at_best(error, spread, sure):
    """A fifth of what is beyond 1, by which chance leaves it, unless what it moves is right."""
    tried = [made("a", 5000.0, error, spread), made("b", 900.0, 8.9, spread)]
    alone = float(confidences(tried, 9.0)[0])
    assert alone > 0.99
    assert confidence_of(tried[0], tried, 9.0) == (alone if sure else STANDS_IN)


def of(effect: Effect, gain: float, spread: float = 1.0) -> Trial:
    found = made(effect.name, gain, 1.0, spread)
    return dataclasses.replace(
        found, state=dataclasses.replace(found.state, model=NoiseModel((effect,)))
    )


@pytest.mark.parametrize("spread", [1.0, 3.0])
@pytest.mark.parametrize(("rare", "odds"), [(DarkCurrentSteps(), 10.0), (HotClusters(), 1 / 0.3)])
def test_what_few_sensors_have_needs_its_odds_in_evidence(rare, odds, spread):
    """Of a dozen hot pixels either law does: an equal share of both, ten hot pixels to one."""
    few, hot = (of(e, 200.0 * spread, spread) for e in (rare, HotPixels()))
    chances = confidences([few, hot], 3.0)
    assert chances[1] / chances[0] == pytest.approx(odds)
    assert [t.effect for t in by_standing([few, hot])] == ["hot_pixels", rare.name]
    sure = of(rare, 400.0 * spread, spread)
    assert confidences([sure, hot], 3.0)[0] > 0.99  # spacings that are seen speak for themselves


def test_beside_a_correction_hot_pixels_are_what_it_is_for():
    def beside(effect: Effect) -> Trial:
        found = of(effect, 100.0)
        model = NoiseModel((effect, Dpc()))
        return dataclasses.replace(found, state=dataclasses.replace(found.state, model=model))

    alone = confidences([of(HotPixels(), 100.0), of(Rts(), 100.0)], 3.0)
    assert alone[0] == pytest.approx(alone[1])
    both = confidences([beside(HotPixels()), beside(Rts())], 3.0)
    assert both[0] / both[1] == pytest.approx(10.0)


def test_a_near_rival_is_named():
    best, near, far = made("a", 300.0, 1.0), made("b", 280.0, 1.0), made("c", 90.0, 1.4)
    assert rivals(best, [best, near, far]) == ["b"]


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
    one, another = made("a", 50.0, 1.0), made("b", 45.0, 1.0)
    if other:
        one, another = with_falls(one, 60.0, 40.0, -9.0), with_falls(another, *other)
    assert apart(one, another) is apart(another, one) is expected


def test_what_explains_other_statistics_is_no_rival():
    """Row noise and column offsets, each missing: both are sure, and neither stands for both."""
    rows = with_falls(made("a", 4400.0, 2.1, spread=2.3), 8e3, 100.0, 0.0)
    columns = with_falls(made("b", 3900.0, 2.5), 90.0, 0.0, 7e3)
    like_rows = with_falls(made("c", 4100.0, 2.4, spread=2.3), 7e3, 100.0, 50.0)
    tried = [rows, like_rows, columns]
    assert rivals(rows, tried) == ["c"]
    assert confidence_of(columns, tried, 3.3) > 0.999
    assert confidence_of(rows, tried, 3.3) == confidences([rows, like_rows], 3.3)[0] > 0.99
    assert confidence_of(like_rows, tried, 3.3) == confidences([like_rows, rows], 3.3)[0] < 0.01


@pytest.mark.parametrize(
    ("gain", "fitted", "enough"),
    [
        (40.0, 90.0, True),
        (19.0, 67.0, False),  # one chance in four that nothing is missing
        (21.0, 65.0, True),  # as little, by two witnesses
        (65.0, 21.0, True),
        (24.0, 24.0, False),  # nothing is likelier
        (55.0, 0.0, False),
        (2.0, 300.0, False),
        (14.0, 14.0, False),
        (6.0, 90.0, False),
    ],
)
def test_the_mean_gain_decides_and_either_half_gives_its_part(gain, fitted, enough):
    found = dataclasses.replace(made("a", gain, 1.0), fitted_gain=fitted)
    assert found.evidence == (gain + fitted) / 2
    assert significant(found, 1.1) is enough


def test_much_evidence_outweighs_a_little_luck_of_the_unseen_half():
    assert significant(made("a", 150.0, 1.05), 1.0)
    assert not significant(made("a", 150.0, 1.07), 1.0)
    assert not significant(made("a", 40.0, 1.01), 1.0)
    assert lowers(made("a", 150.0, 1.05, spread=2.0), 1.0)
    assert not lowers(made("a", 150.0, 1.05, spread=3.0), 1.0)


def test_while_much_is_wrong_chance_reaches_farther():
    assert significant(made("a", 70.0, 1.0), 3.0)
    assert not significant(made("a", 70.0, 1.0, spread=2.0), 3.0)
    assert significant(made("a", 50.0, 1.0), 3.0)  # two witnesses, of chance alone
    assert not significant(made("a", 100.0, 1.0, spread=2.0), 3.0)
    uneven = dataclasses.replace(made("a", 400.0, 1.0), fitted_gain=10.0)
    assert significant(uneven, 3.0)
    assert not significant(dataclasses.replace(uneven, spread=2.0), 3.0)


@pytest.mark.parametrize("spread", [1.0, 8.0])
def test_nothing_is_credited_in_proportion_to_what_is_left(spread):
    even = [made("a", NOTHING * spread, 1.0, spread)]
    np.testing.assert_allclose(confidences(even, 2.0), [0.5, 0.5])


@pytest.fixture
def asked(monkeypatch):
    """What decides, without a bench: nothing is left, and no fit goes on."""
    for name, stands_for in {
        "error_of": lambda *_: 1.0,
        "adequacy": lambda *_: SimpleNamespace(left=[]),
        "sobered": lambda _held, _state, trial: trial,
        "mends": lambda *_: False,
        "derive": lambda _, state, anew: state,
        "minimise": lambda _, state, *more: state,
        "start": lambda _, model, knobs, like: like,
        "on_average": lambda held, state: (held, state),
    }.items():
        monkeypatch.setattr(diagnose, name, stands_for)
    return monkeypatch


def test_where_the_halves_disagree_about_the_leader_nothing_is_added(asked):
    split = dataclasses.replace(made("a", -60.0, 1.05), fitted_gain=260.0)
    second = made("b", 90.0, 0.97)
    asked.setattr(diagnose, "judged", lambda *_: split)
    assert diagnose.missing(None, second.state, [second, split]) is second
    assert diagnose.missing(None, second.state, [split, second]) is None
    assert diagnose.missing(None, second.state, []) is None


def test_less_evidence_is_enough_where_nothing_is_missing_is_refuted_already(asked):
    some = dataclasses.replace(made("a", 0.9 * CERTAIN, 0.9), fitted_gain=0.3 * CERTAIN)
    chance = made("a", 0.9 * NOTHING, 0.9)
    asked.setattr(diagnose, "judged", lambda *_: some)  # the average sensor says the same
    assert diagnose.missing(None, some.state, [some]) is None
    asked.setattr(diagnose, "adequacy", lambda *_: SimpleNamespace(left=["drift"]))
    assert diagnose.missing(None, some.state, [some]) is None
    asked.setattr(diagnose, "mends", lambda _held, names, *_: "drift" in names)
    assert diagnose.missing(None, some.state, [some]).evidence == some.evidence
    asked.setattr(diagnose, "adequacy", lambda *_: SimpleNamespace(left=[*"abc", "drift"]))
    assert diagnose.missing(None, some.state, [some]) is None  # not of the worst
    assert diagnose.missing(None, chance.state, [chance]) is None


@pytest.mark.parametrize(
    ("left", "mended", "others", "spread", "first"),
    [
        (["hot_pairs"], ["hot_pairs"], [], 1.0, "b"),
        ([], ["hot_pairs"], [], 1.0, "a"),
        (["hot_pairs"], [], [], 1.0, "a"),
        (["drift", "hot_pairs"], ["hot_pairs"], [], 1.0, "a"),  # not the worst
        (["hot_pairs"], ["hot_pairs"], [], 3.0, "a"),  # more is missing
        (["hot_pairs"], ["hot_pairs"], ["drift"], 1.0, "a"),  # refuted itself
    ],
)
def test_a_leader_that_its_own_sensors_refute_gives_way(asked, left, mended, others, spread, first):
    """To a rival that explains nearly as much, puts that right, and is not refuted too."""
    tried = [made("a", 900.0, 1.0, spread), made("b", 850.0, 1.0), made("c", 90.0, 1.0)]
    asked.setattr(diagnose, "trials", lambda *_, **_more: tried)
    of_each = {id(t.state): others for t in tried} | {id(tried[0].state): left}
    asked.setattr(
        diagnose, "adequacy", lambda _, state, __: SimpleNamespace(left=of_each[id(state)])
    )
    asked.setattr(diagnose, "leaves", lambda _, state: bool(of_each[id(state)]))
    asked.setattr(diagnose, "mends", lambda _held, names, *_: bool({*names} & {*mended}))
    found = diagnose.ranked(None, None, {})
    assert found[0].effect == first
    assert {t.effect for t in found} == {*"abc"}
    if first == "b":
        assert confidences(found, 3.0)[0] > 0.95
    asked.setattr(diagnose, "trials", lambda *_, **_more: tried[:1])
    assert diagnose.ranked(None, None, {}) == tried[:1]


@pytest.mark.parametrize(
    ("gain", "spread", "added"), [(100.0, 1.0, False), (400.0, 1.0, True), (400.0, 2.0, False)]
)
def test_what_is_one_sensors_luck_is_not_added(asked, gain, spread, added):
    found = made("a", gain, 0.9, spread)
    luck = dataclasses.replace(found, gain=1.0, fitted_gain=1.0)
    asked.setattr(diagnose, "sobered", lambda *_: luck)
    assert (diagnose.missing(None, found.state, [found]) is found) == added


@pytest.mark.parametrize(
    ("gain", "fell", "again", "told"),
    [
        (100.0, 1.0, 80.0, 80.0),  # what is told is what it gains beside the better fit
        (100.0, 1.0, 20.0, None),
        (100.0, 0.0, 20.0, 100.0),  # the fit without it was at its best
        (121.0, 1.0, 20.0, 121.0),  # no last steps make that
        (119.0, 1.0, 20.0, None),
    ],
)
def test_the_model_without_it_is_fitted_as_well_as_with_it(asked, gain, fell, again, told):
    found = dataclasses.replace(made("a", gain, 0.9), others=("kept",))
    begun = SimpleNamespace(loss=5.0, model=NoiseModel(()))
    asked.setattr(diagnose, "minimise", lambda *_: SimpleNamespace(loss=5.0 - fell))
    asked.setattr(diagnose, "judged", lambda *_: made("a", again, 0.9))
    best = diagnose.missing(None, begun, [found])
    assert (best and best.evidence) == told
    assert best is None or best.others == ("kept",)


@pytest.mark.parametrize(
    ("gain", "fitted", "spread", "average", "added"),
    [
        (2.0, 300.0, 1.0, 150.0, True),
        (300.0, 2.0, 1.0, 150.0, True),
        (2.0, 300.0, 1.0, 2.0, False),
        (2.0, 300.0, 3.0, 150.0, False),  # beyond chance, but not beyond what is left
        (2.0, 0.9 * CERTAIN, 1.0, 150.0, False),
        (2.0, 300.0, 2.0, 40.0, False),  # certain, though it puts right what is left
    ],
)
def test_where_the_halves_disagree_the_average_sensor_decides(
    asked, gain, fitted, spread, average, added
):
    found = dataclasses.replace(made("a", gain, 0.9, spread), fitted_gain=fitted)
    asked.setattr(diagnose, "judged", lambda *_: made("a", average, 0.9))
    asked.setattr(diagnose, "adequacy", lambda *_: SimpleNamespace(left=["drift"]))
    asked.setattr(diagnose, "mends", lambda *_: True)
    best = diagnose.missing(None, found.state, [found])
    assert (best is not None) == added
    if best is not None:  # it is told by what the average sensor gains
        told = diagnose.retold([found], best)
        assert told == [best]
        assert (best.gain, best.fitted_gain, best.state) == (average, average, found.state)
        assert confidences(told, 1.0)[0] > 0.9


@pytest.mark.parametrize(
    ("gains", "average", "told"),
    [
        ((120.0, 14.0), 20.0, None),  # the luck of one sensor's clouds
        ((14.0, 120.0), 90.0, 90.0),
        ((60.0, 74.0), 20.0, 67.0),  # both say so
        ((46.0, 70.0), 20.0, None),  # both do, but not more than noise drawn anew may
        ((46.0, 70.0), 90.0, 90.0),
        ((300.0, 14.0), 20.0, 157.0),  # no luck makes that
    ],
)
def test_what_one_half_hardly_speaks_for_is_asked_of_averages_too(asked, gains, average, told):
    found = dataclasses.replace(made("a", gains[0], 0.9), fitted_gain=gains[1])
    answers = iter([found] if found.evidence < UNDONE else [])  # beside the better fit
    asked.setattr(diagnose, "minimise", lambda *_: SimpleNamespace(loss=1.0, model=None, knobs=[]))
    asked.setattr(diagnose, "judged", lambda *_: next(answers, made("a", average, 0.9)))
    begun = SimpleNamespace(loss=2.0, model=NoiseModel(()))
    best = diagnose.missing(None, begun, [found])
    assert (best and best.evidence) == told


def test_how_little_evidence_is_goes_by_what_is_left(asked):
    fits = []
    asked.setattr(diagnose, "minimise", lambda _, state, steps: fits.append(steps) or state)
    asked.setattr(diagnose, "judged", lambda _, state, effect, after: made(effect, 150.0, 0.9, 2.0))
    found = made("a", 150.0, 0.9, 2.0)  # 75 times the misfit left
    assert diagnose.missing(None, found.state, [found]).evidence == 150.0
    assert len(fits) == 1


def test_the_model_with_it_goes_on_where_that_without_did(asked):
    found, fits = made("a", 100.0, 0.9), []
    begun, lower, on = (SimpleNamespace(loss=x, model=NoiseModel(())) for x in (5.0, 4.0, 3.0))
    asked.setattr(diagnose, "derive", lambda _, state, anew: state)
    asked.setattr(
        diagnose, "minimise", lambda _, s, steps: fits.append(s) or (lower if s is begun else on)
    )
    asked.setattr(
        diagnose, "judged",
        lambda _, before, __, after: made("a", 90.0 * (before is lower and after is on), 0.9),
    )  # fmt: skip
    assert diagnose.missing(None, begun, [found]).evidence == 90.0
    assert fits == [begun, found.state]


def test_what_is_judged_on_average_is_fitted_on_average_first(asked):
    found = dataclasses.replace(made("a", -60.0, 0.9), fitted_gain=260.0)
    calls = []

    def fitted(held, state, steps):
        calls.append(held)
        return SimpleNamespace(model=f"{state} fitted", knobs=[])

    asked.setattr(diagnose, "on_average", lambda held, state: (f"fair {held}", "average"))
    asked.setattr(diagnose, "minimise", fitted)
    asked.setattr(diagnose, "start", lambda held, model, knobs, like: (held, model))
    asked.setattr(diagnose, "judged", lambda *_: made("a", 150.0, 0.9))
    best = diagnose.missing("bench", found.state, [found])
    assert calls == ["fair bench", "fair bench"]
    assert best.state == ("bench", "average fitted")  # from there the search goes on
    calls.clear()
    asked.setattr(diagnose, "judged", lambda *_: made("a", -1.0, 0.9))
    assert diagnose.missing("bench", found.state, [found]) is None
    assert calls == []


@pytest.mark.parametrize(
    ("gain", "left", "mended", "added"),
    [
        (100.0, [], False, True),
        (100.0, ["drift"], False, False),
        (100.0, ["drift"], True, True),
        (400.0, ["drift"], False, True),
    ],
)
def test_little_evidence_counts_only_where_it_puts_right_what_is_left(
    asked, gain, left, mended, added
):
    found = made("a", gain, 0.9)
    asked.setattr(diagnose, "adequacy", lambda *_: SimpleNamespace(left=left))
    asked.setattr(diagnose, "mends", lambda *_: mended)
    asked.setattr(diagnose, "sobered", lambda *_: found)
    assert (diagnose.missing(None, found.state, [found]) is found) == added


@pytest.mark.parametrize(
    ("mended", "error", "added"),
    [("worst", 1.49, True), ("second", 1.49, False), ("second", 1.47, True), ("none", 1.2, False)],
)
def test_what_leaves_the_worst_must_lower_the_error_clearly(asked, mended, error, added):
    found = made("a", 200.0, error)
    left = ["worst", "second"]
    asked.setattr(diagnose, "error_of", lambda *_: 1.5)
    asked.setattr(diagnose, "adequacy", lambda *_: SimpleNamespace(left=left))
    asked.setattr(diagnose, "mends", lambda _held, names, *_: mended in names)
    assert (diagnose.missing(None, found.state, [found]) is found) == added


def test_what_the_verdict_calls_unexplained_is_what_little_evidence_may_put_right(asked):
    """Fewer simulated sensors would leave both the name and "adequate" out."""
    found = made("a", 0.6 * CERTAIN, 0.9)

    def seen(_held, _state, replicates=REPLICATES):
        return SimpleNamespace(left=["drift"] if replicates == REPLICATES else [])

    asked.setattr(diagnose, "adequacy", seen)
    asked.setattr(diagnose, "mends", lambda _held, left, *_: bool(left))
    asked.setattr(diagnose, "sobered", lambda *_: found)
    asked.setattr(diagnose, "judged", lambda *_: found)
    assert diagnose.missing(None, found.state, [found]).evidence == found.evidence


def test_what_the_fit_with_it_found_for_others_is_open_to_the_model_without(asked):
    """A pattern's place, say; not what every sensor has, which may have made room for it."""
    pattern, noise = PeriodicPattern(0.5, 0.2, 0.1), ReadNoise(2.0)
    moved, less = dataclasses.replace(pattern, u=0.3), ReadNoise(0.5)
    before = dataclasses.replace(made("a", 0.0, 1.0).state, model=NoiseModel((noise, pattern)))
    after = dataclasses.replace(before, model=NoiseModel((less, moved, HotPixels())))
    found = Trial("hot_pixels", after, 100.0, 100.0, 0.9)
    begun = []
    asked.setattr(diagnose, "start", lambda _, model, knobs, like: begun.append(model) or like)
    asked.setattr(diagnose, "sobered", lambda *_: found)
    assert diagnose.missing(None, before, [found]) is found
    assert begun == [NoiseModel((noise, moved))]
