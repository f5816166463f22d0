"""The better of an effect's guesses, by both halves."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from dnanalyze.diagnosis import trial
from dnanalyze.diagnosis.screening import Prospect
from dnanalyze.diagnosis.trial import Trial, best_guess, trials
from dnanalyze.fitting.least_squares import State, given
from dnanalyze.model.noise_model import NoiseModel

MODEL = NoiseModel(())


def state(train, test):
    fitted, unseen = (np.full(100, level) for level in (train, test))
    return State(MODEL, [], fitted, given(unseen), np.zeros((100, 0)))


@pytest.mark.parametrize(
    ("train", "test", "taken"),
    [
        (1.0, 1.0, True),
        (2.1, 1.0, True),  # a little worse where it was fitted, much better where it was not
        (1.9, 2.9, False),
        (2.0, 2.0, False),  # no better
    ],
)
def test_another_guess_is_taken_where_both_halves_together_gain(monkeypatch, train, test, taken):
    first, other = state(2.0, 2.0), state(train, test)
    monkeypatch.setattr(trial, "refitted", lambda *_: other)
    found = Trial("a", first, 10.0, 10.0, 1.0, others=(Prospect("a", MODEL, 9.0),))
    assert best_guess(None, first, found) is (other if taken else first)


def test_without_other_guesses_the_trial_stands():
    first = state(2.0, 2.0)
    assert best_guess(None, first, Trial("a", first, 10.0, 10.0, 1.0)) is first


@pytest.mark.parametrize(
    ("left", "promise", "again"), [(0.5, 700.0, False), (2.0, 700.0, True), (2.0, 500.0, False)]
)
def test_a_rival_is_tried_from_its_other_guess_where_the_leader_leaves_much(
    monkeypatch, left, promise, again
):
    """The second guess of b would put all right; a bends around what b is."""
    names = np.array(["codes"] * 100)
    half = SimpleNamespace(names=names, families=names)
    bench = SimpleNamespace(train=half, test=half)
    begun, after = state(5.0, 5.0), {"a": state(left, left), "b": state(4.0, 4.0)}
    first, second = NoiseModel(()), NoiseModel(())
    guesses = [
        Prospect("a", first, 900.0),
        Prospect("b", first, 800.0),
        Prospect("b", second, promise),
    ]
    monkeypatch.setattr(trial, "prospects", lambda *_: guesses)
    monkeypatch.setattr(
        trial,
        "refitted",
        lambda _bench, p, *_: state(0.1, 0.1) if p.model is second else after[p.effect],
    )
    monkeypatch.setattr(trial, "derive", lambda _bench, ended, **_: ended)
    monkeypatch.setattr(trial, "minimise", lambda _bench, ended, *_, **__: ended)
    found = trials(bench, begun, {})
    assert [t.effect for t in found] == (["b", "a"] if again else ["a", "b"])
    kept = {t.effect: len(t.others) for t in found}
    assert kept == {"a": 0, "b": 0 if again else 1}  # what is left for `best_guess`


@pytest.mark.parametrize(("judged", "again"), [(5.1, True), (4.9, False)])
def test_another_guess_is_refitted_where_the_first_gains_and_yet_raises_the_error(
    monkeypatch, judged, again
):
    names = np.array(["spectrum"] * 100)
    half = SimpleNamespace(names=names, families=names)
    bench = SimpleNamespace(train=half, test=half)
    first, second = NoiseModel(()), NoiseModel(())
    guesses = [Prospect("a", first, 900.0), Prospect("a", second, 800.0)]
    ended = {id(first): state(1.0, judged), id(second): state(0.5, 0.5)}
    monkeypatch.setattr(trial, "prospects", lambda *_: guesses)
    monkeypatch.setattr(trial, "refitted", lambda _bench, p, *_: ended[id(p.model)])
    monkeypatch.setattr(trial, "derive", lambda _bench, found, **_: found)
    monkeypatch.setattr(trial, "minimise", lambda _bench, found, *_, **__: found)
    (found,) = trials(bench, state(5.0, 5.0), {})
    assert found.state.train is ended[id(second) if again else id(first)].train
    assert len(found.others) == (0 if again else 1)


@pytest.mark.parametrize(
    ("left", "levelled", "taken"),
    [
        (2.0, 0.5, True),
        (2.0, 3.0, False),  # it ends no better there
        (1.0, 0.5, False),  # little is left: the fit has not bent its level
    ],
)
def test_where_a_refit_leaves_much_it_begins_at_the_level_of_the_moments_too(
    monkeypatch, left, levelled, taken
):
    names = np.array(["codes"] * 100)
    half = SimpleNamespace(names=names, families=names)
    bench = SimpleNamespace(train=half, test=half)
    bent, level = NoiseModel(()), NoiseModel(())
    ended = {id(bent): state(left, left), id(level): state(levelled, levelled)}
    monkeypatch.setattr(trial, "prospects", lambda *_: [Prospect("a", bent, 900.0, level)])
    monkeypatch.setattr(trial, "refitted", lambda _bench, p, *_: ended[id(p.model)])
    monkeypatch.setattr(trial, "derive", lambda _bench, found, **_: found)
    monkeypatch.setattr(trial, "minimise", lambda _bench, found, *_, **__: found)
    (found,) = trials(bench, state(5.0, 5.0), {})
    assert found.state.train is ended[id(level if taken else bent)].train


@pytest.mark.parametrize(
    ("rival", "at_rest", "error", "who"),
    [
        (90.0, False, 1.0, "b"),  # from the leader's derivatives as they are
        (90.0, True, 1.0, ""),
        (99.9, False, 1.0, "ab"),  # a tie: anew, and both
        (99.9, True, 1.0, "ab"),
        (50.0, False, 1.0, ""),
        (50.0, False, 3.0, "a"),  # the leader raises the error for all it gains
    ],
)
def test_rivals_go_on_and_the_leader_where_that_may_decide(monkeypatch, rival, at_rest, error, who):
    """Close rivals share the derivatives of what both have."""

    def stands(own):
        knobs = [SimpleNamespace(name=name) for name in ("shared", own)]
        return State(MODEL, knobs, np.ones(9), given(np.ones(9)), np.zeros((9, 2)), at_rest)

    begun = []
    monkeypatch.setattr(
        trial, "derive", lambda _, s, anew: replace(s, jacobian=np.full_like(s.jacobian, 7.0))
    )
    reach = []
    monkeypatch.setattr(
        trial, "minimise", lambda _, s, __, below: reach.append(below) or begun.append(s) or s
    )
    monkeypatch.setattr(trial, "judged", lambda _bench, _before, name, _after: best[name])
    monkeypatch.setattr(trial, "error_of", lambda *_: 2.0)
    best = {n: Trial(n, stands(n), g, g, error) for n, g in (("b", rival), ("a", 100.0))}
    trial._polish(None, state(2.0, 2.0), best)
    assert "".join(s.knobs[1].name for s in begun) == who
    leader_met = False
    for s in begun:
        leader_met = leader_met or s.knobs[1].name == "a"
        shared, own = s.jacobian[0]
        assert shared == (7.0 if leader_met else 0.0)
        assert np.isnan(own) == (leader_met and s.knobs[1].name == "b")
    # a rival behind is given up where it can no longer catch up: 9 is its loss and the leader's
    behind = 100.0 - rival - trial.TIE * stands("a").loss
    assert reach == [pytest.approx(stands("b").loss - behind) if who == "b" else np.inf] * len(who)


@pytest.mark.parametrize(
    ("share", "tried"), [(0.25, [("b", True)]), (0.15, [("b", False)]), (0.09, [])]
)
def test_who_could_not_come_near_the_leader_is_not_refitted_or_not_twice(monkeypatch, share, tried):
    names = np.array(["spectrum"] * 100)
    half = SimpleNamespace(names=names, families=names)
    bench = SimpleNamespace(train=half, test=half)
    begun, right, made = state(5.0, 5.0), state(0.0, 0.0), []
    gained = trial.judged(bench, begun, "a", right).fitted_gain
    guesses = [Prospect("a", MODEL, 0.3 * gained), Prospect("b", MODEL, share * gained)]

    def refit(_bench, p, *more):
        made.append((p.effect, more[-1]))
        return right if p.effect == "a" else begun

    monkeypatch.setattr(trial, "prospects", lambda *_: guesses)
    monkeypatch.setattr(trial, "refitted", refit)
    trials(bench, begun, {})
    assert made == [("a", True), *tried]


def test_another_kind_is_kept_for_the_one_to_add(monkeypatch):
    names = np.array(["spectrum"] * 100)
    half = SimpleNamespace(names=names, families=names)
    bench = SimpleNamespace(train=half, test=half)
    refits = []
    spare, faint = (Prospect("a", MODEL, promise, spare=True) for promise in (850.0, 10.0))
    lone = Prospect("b", MODEL, 840.0, spare=True)
    guesses = [Prospect("a", MODEL, 900.0), spare, lone, faint]
    monkeypatch.setattr(trial, "prospects", lambda *_: guesses)
    monkeypatch.setattr(trial, "refitted", lambda _, p, *__: refits.append(p) or state(1.0, 1.0))
    (found,) = trials(bench, state(5.0, 5.0), {})
    assert refits == guesses[:1]
    assert found.others == (spare,)


def test_what_the_best_took_off_the_loss_counts_though_its_evidence_is_less(monkeypatch):
    """Far off the evidence is a logarithm; promises are of the loss, as is the fall of the best."""
    names = np.array(["spectrum"] * 100)
    half = SimpleNamespace(names=names, families=names)
    bench = SimpleNamespace(train=half, test=half)
    begun, after, made = state(50.0, 50.0), {"a": 0.0, "b": 40.0}, []
    fall = begun.loss - state(0.0, 0.0).loss
    gained = trial.judged(bench, begun, "a", state(0.0, 0.0)).fitted_gain
    out_of_reach = 0.9 * trial.CLOSE * fall / trial.REACH
    assert out_of_reach > 2.0 * trial.CLOSE * gained / trial.REACH
    guesses = [
        Prospect("a", MODEL, 0.3 * fall), Prospect("b", MODEL, 0.2 * fall),
        Prospect("c", MODEL, out_of_reach),
    ]  # fmt: skip

    def refit(_bench, p, *_):
        made.append(p.effect)
        return state(after[p.effect], after[p.effect])

    monkeypatch.setattr(trial, "prospects", lambda *_: guesses)
    monkeypatch.setattr(trial, "refitted", refit)
    trials(bench, begun, {})
    assert made == ["a", "b"]


@pytest.mark.parametrize(
    ("evidence", "spread", "goes_on"),
    [(5.9, 1.0, False), (6.1, 1.0, True), (59.0, 1.0, True), (61.0, 1.0, False),
     (59.0, 10.0, False), (61.0, 10.0, True), (599.0, 10.0, True), (601.0, 10.0, False)],
)  # fmt: skip
def test_a_leader_of_doubtful_evidence_goes_on_alone(monkeypatch, evidence, spread, goes_on):
    """In units of the misfit left: what the fit left undone may decide whether it is named."""
    begun = []
    monkeypatch.setattr(trial, "error_of", lambda *_: 2.0)
    monkeypatch.setattr(trial, "derive", lambda _, s, anew: s)
    monkeypatch.setattr(trial, "minimise", lambda _, s, __, **___: begun.append(s) or s)
    monkeypatch.setattr(trial, "judged", lambda _bench, _before, name, _after: best[name])
    found = Trial("a", state(1.0, 1.0), evidence, evidence, 1.0, spread)
    best = {"a": found, "b": Trial("b", state(1.0, 1.0), -1.0, -1.0, 1.5)}
    trial._polish(None, state(2.0, 2.0), best)
    assert len(begun) == int(goes_on)


@pytest.mark.parametrize(
    ("begins", "after_one", "taken"),
    [(2.0, 2.0, True), (4.0, 1.5, True), (4.0, 3.5, False)],
)
def test_another_kind_may_begin_far_off_if_one_step_brings_it_near(
    monkeypatch, begins, after_one, taken
):
    """The numbers of the wrong kind made up for what was wrong with it; all halves alike.

    Refitted while its steps may still bring it to where the other stands.
    """
    steps, before = [], state(1.0, 1.0)
    kind = SimpleNamespace(name="a")

    def stepped(_bench, begun, iterations, below=math.inf):
        steps.append((iterations, below))
        first = iterations == 1
        return state(*(2 * [after_one**0.5 if first else 0.1]))

    monkeypatch.setattr(trial, "start", lambda *_, like: state(*(2 * [begins**0.5])))
    monkeypatch.setattr(trial, "minimise", stepped)
    monkeypatch.setattr(trial, "knobs_of", lambda _: [])
    like = replace(before, model=SimpleNamespace(with_effect=lambda _: MODEL))
    ended = trial._better(None, like, kind, 3)
    assert (ended is not like) == taken
    assert steps == [(1, math.inf)] * (begins > 3.0) + [(3, before.loss)] * taken
