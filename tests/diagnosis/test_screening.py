"""What is simulated of an effect before any refit."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from dnanalyze.diagnosis import screening
from dnanalyze.diagnosis.bend import least_noise
from dnanalyze.diagnosis.screening import (
    FAINT,
    FIRST,
    HOPEFUL,
    LEAST,
    PLAIN,
    SIGN,
    Prospect,
    _best,
    _two,
    prospects,
)
from dnanalyze.fitting.design import design
from dnanalyze.fitting.fit import ordinary_start
from dnanalyze.fitting.knobs import knobs_of
from dnanalyze.fitting.least_squares import converge, minimise, start
from dnanalyze.fitting.moments import moments
from dnanalyze.fitting.predictor import bench
from dnanalyze.fitting.readings import Readings
from dnanalyze.fitting.start import ordinary_model
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effect import Effect, Placing
from dnanalyze.model.laws import TableLaw
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import BASE, built_in
from dnanalyze.model.simulate import simulate

KNOWN = built_in()
POINTS = [OperatingPoint(t, 0.1, 1.0) for t in (25.0, 65.0)]


def sensor(*more):
    """A sensor of dark current with shot noise, and more."""
    effects = (
        KNOWN["convolved_lognormal"](mu=TableLaw(tuple(POINTS), (1.0, 4.0)), delta=0.3, sigma=1e-6),
        KNOWN["dark_shot_noise"](dn_per_e=0.5),
        *more,
    )
    model = NoiseModel(effects, 100.0, POINTS[0], seed=5)
    return bench(design(simulate(model, (128, 128), [(p, 6) for p in POINTS])))


def ordinary(held):
    """What every sensor has, fitted."""
    model = ordinary_model(moments(Readings(held.measured[0]), None))
    return converge(held, start(held, model, knobs_of(model)))


@pytest.fixture(scope="module")
def held():
    """A sensor whose read noise has heavy tails."""
    return sensor(
        KNOWN["heavy_tailed_read_noise"](sigma=3.0, tail=-0.2),
        KNOWN["pixel_fpn"](sigma=1.0),
        KNOWN["quantization"](),
    )


@pytest.fixture(scope="module")
def state(held):
    return ordinary(held)


def test_a_guess_is_also_tried_with_what_was_bent_in_its_absence_put_right(held, state):
    name = "heavy_tailed_read_noise"
    seen = prospects(held, state, {name: KNOWN[name]})
    assert len(seen) == 2  # the two that promise most of all guesses, bent and straight
    assert seen[0].promise >= seen[1].promise
    spreads = {p.model.get("read_noise").spread for p in seen}
    assert 0.0 in spreads
    assert state.model.get("read_noise").spread > 0.0
    for p in seen:
        assert p.model.get(name) is not None
        assert p.promise <= state.loss


def test_what_was_bent_goes_by_the_least_noise_of_all_settings(held, state, monkeypatch):
    asked = []
    monkeypatch.setattr(screening, "unbent", lambda _model, _guess, noise: asked.append(noise))
    prospects(held, state, {"heavy_tailed_read_noise": KNOWN["heavy_tailed_read_noise"]})
    assert set(asked) == {least_noise(held)}


def test_a_search_that_cannot_come_below_is_given_up_before_its_first_step(held, state):
    larger = state.model.with_effect(KNOWN["heavy_tailed_read_noise"](sigma=1.0))
    begun = start(held, larger, knobs_of(larger), like=state)
    free = minimise(held, begun, 2)
    assert free.loss < begun.loss
    given_up = minimise(held, begun, 2, below=-1e12)
    assert given_up.model == begun.model


def test_what_moves_nothing_promises_nothing_though_two_settings_alone_could_fit_better(
    held, state
):
    class Still(Effect):
        name = "still"

        def apply(self, signal, site):
            return signal

    (seen,) = prospects(held, state, {"still": Still})
    assert seen.promise == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize(("promise", "seen"), [(0.0, FIRST), (2 * LEAST, 6)])
def test_later_guesses_are_simulated_only_where_an_early_one_promises(
    held, state, monkeypatch, promise, seen
):
    class Many(KNOWN["row_noise"]):
        @classmethod
        def guess(cls, clues):
            return [cls(0.1 * (n + 1)) for n in range(6)]

    tried = []

    def at_guesses(view, guesses):
        tried.extend(guess.sigma for guess in guesses)
        return [Prospect(guess.name, state.model, promise) for guess in guesses]

    monkeypatch.setattr(screening, "_at_guesses", at_guesses)
    prospects(held, state, {"row_noise": Many})
    assert len(tried) == seen


def test_later_guesses_wait_for_what_all_effects_promise(held, state, monkeypatch):
    promised = {"row_noise": 1e4, "row_fpn": HOPEFUL * 1.1e4, "column_fpn": HOPEFUL * 0.9e4}

    def many(name):
        class Many(KNOWN[name]):
            @classmethod
            def guess(cls, clues):
                return [cls(0.1 * (n + 1)) for n in range(FIRST + 2)]

        return Many

    tried = []

    def at_guesses(view, guesses):
        tried.extend(guess.name for guess in guesses)
        return [
            Prospect(guess.name, state.model.with_effect(guess), promised[guess.name])
            for guess in guesses
        ]

    monkeypatch.setattr(screening, "_at_guesses", at_guesses)
    seen = prospects(held, state, {name: many(name) for name in promised})
    assert {name: tried.count(name) for name in promised} == {
        "row_noise": FIRST + 2, "row_fpn": FIRST + 2, "column_fpn": FIRST,
    }  # fmt: skip
    assert [p.effect for p in seen[::2]] == list(promised)


@pytest.mark.parametrize(("loss", "in_part"), [(0.9 * PLAIN, set()), (1.1 * PLAIN, {"crosstalk"})])
def test_where_much_is_missing_what_every_part_shows_is_looked_for_in_one(
    held, state, monkeypatch, loss, in_part
):
    """A promise is the same share of what an effect that does nothing would reach."""
    part = replace(held, part=None)
    whole = replace(held, part=part)
    size = np.sqrt(loss)  # a number's loss, so far below where it bends
    off = replace(state, train=np.full(len(state.train), size))
    seen, straight = {}, screening._at_guesses

    def at_guesses(view, guesses):
        seen.update((guess.name, view) for guess in guesses)
        return straight(view, guesses)

    monkeypatch.setattr(screening, "_at_guesses", at_guesses)
    monkeypatch.setattr(screening, "carried", lambda s, *_: replace(s, train=0.5 * s.train))
    names = ("crosstalk", "row_noise", "row_fpn")
    guessed = {
        n: type(n, (KNOWN[n],), {"guess": classmethod(lambda cls, clues: [cls()])}) for n in names
    }
    prospects(whole, off, guessed)
    np.testing.assert_allclose(seen["row_fpn"].state.train, size)  # may shade: the whole field
    if in_part:
        np.testing.assert_allclose(seen["crosstalk"].state.train, 0.5 * size)
    alone = replace(held, even=True)
    for name in {"crosstalk", "row_noise"} - in_part:  # half of it, beside half of it
        assert seen[name].bench.even
        np.testing.assert_array_equal(seen[name].state.train, alone.fitted_z(off.model))
        assert seen[name].idle == screening._reachable(seen[name].state, seen[name].state.train)
    weights = {name: view.weight for name, view in seen.items()}
    assert weights["row_noise"] == weights["row_fpn"] == 1.0
    assert (weights["crosstalk"] > 1.0) == bool(in_part)
    if in_part:
        views = [seen[n] for n in ("row_fpn", "crosstalk")]
        assert weights["crosstalk"] == pytest.approx(views[0].idle / views[1].idle)
        (free,) = straight(replace(views[1], weight=1.0), [guessed["crosstalk"]()])[:1]
        (weighed,) = straight(views[1], [guessed["crosstalk"]()])[:1]
        assert weighed.promise == pytest.approx(weights["crosstalk"] * free.promise)


@pytest.mark.parametrize("loss", [0.9 * PLAIN, 1.1 * PLAIN])
def test_where_much_is_missing_a_guess_that_bends_is_ready_at_the_level_of_the_moments(
    held, state, loss
):
    """The fit may have moved the level to where the codes of too little noise lie."""
    moved = replace(state.model, pedestal=state.model.pedestal + 0.5)
    off = replace(state, model=moved, train=np.full(len(state.train), np.sqrt(loss)))
    guess = KNOWN["denoise"](kind="gaussian", space=0.6)
    view = screening._View.of(held, off, [0, 1])
    straight, bent = screening._at_guesses(view, [guess])
    assert straight.levelled is None
    if loss < PLAIN:
        assert bent.levelled is None
        return
    begun = ordinary_start(held)
    assert bent.model.pedestal == moved.pedestal
    assert bent.levelled.pedestal == begun.pedestal
    assert bent.levelled.get(BASE).mu == begun.get(BASE).mu
    for name in ("denoise", "read_noise"):  # the rest as it is right with the guess
        assert bent.levelled.get(name) == bent.model.get(name)


def test_a_guess_that_moves_the_moments_is_looked_at_beside_an_ordinary_sensor(held, state):
    """Begun again by the moments less what it adds: the fit without it is another sensor."""
    off = replace(state, train=np.full(len(state.train), np.sqrt(1.1 * PLAIN)))
    guess = KNOWN["dark_current_steps"](step=5.0, mean_number=0.3)
    straight, begun = screening._at_guesses(screening._View.of(held, off, [0, 1]), [guess])
    assert straight.model.get(BASE) == off.model.get(BASE)
    wanted = ordinary_start(held, guess)
    for name in (BASE, "dark_shot_noise", "read_noise"):
        assert begun.model.get(name) == wanted.get(name)
    assert begun.model.pedestal == wanted.pedestal
    assert wanted.get(BASE) != ordinary_start(held).get(BASE)
    assert begun.model.get(guess.name) == guess
    little = replace(state, train=np.full(len(state.train), np.sqrt(0.9 * PLAIN)))
    assert len(screening._at_guesses(screening._View.of(held, little, [0, 1]), [guess])) == 1


def _shown(train, test):
    """A bench of three settings, and what it shows of "drift" at each."""
    half = SimpleNamespace(names=np.array(["drift"] * 3), setting=np.arange(3))
    held = SimpleNamespace(train=half, test=half, plan=SimpleNamespace(settings=[None] * 3))
    return held, SimpleNamespace(train=np.array(train), test=np.array(test))


@pytest.mark.parametrize(
    ("train", "test", "few", "again"),
    [
        ([0.0, 4.0, 3.0], [1.0, 3.0, 5.0], [0, 2], [1, 2]),
        ([0.0, 4.0, 3.0], [1.0, 3.0, 5.0], [1, 2], None),  # looked at already
        ([-4.0, 0.5, -3.0], [-3.0, 0.5, -5.0], [0, 1], [0, 2]),
        ([0.0, 4.0, 3.0], [1.0, -3.0, 2.0], [0, 1], None),  # one half says more, the other less
        ([0.0, SIGN - 0.1, 0.0], [9.0, 9.0, 9.0], [0, 2], None),
    ],
)
def test_what_promises_little_is_looked_at_where_both_halves_show_it(
    monkeypatch, train, test, few, again
):
    effect = SimpleNamespace(fingerprint=("drift", "mean"), placing=Placing.SOMEWHERE)
    monkeypatch.setattr(screening._View, "of", lambda held, state, settings: settings)
    monkeypatch.setattr(
        screening, "_at_guesses", lambda view, guesses: [(view, g) for g in guesses]
    )
    found = screening._looked_at_again(*_shown(train, test), effect, ["a", "b"], few)
    assert found == ([] if again is None else [(again, "a"), (again, "b")])


@pytest.mark.parametrize(("most", "asked"), [(FAINT - 1.0, ["faint"]), (FAINT + 1.0, [])])
def test_only_where_nothing_promises_much_is_anything_looked_at_again(
    held, state, monkeypatch, most, asked
):
    name = "heavy_tailed_read_noise"
    calls = []
    made = Prospect("faint", state.model, most)
    monkeypatch.setattr(screening, "_at_guesses", lambda view, guesses: [made])
    monkeypatch.setattr(
        screening, "_looked_at_again", lambda *given: calls.append("faint") or [made]
    )
    prospects(held, state, {name: KNOWN[name]})
    assert calls == asked


def test_two_guesses_of_an_effect_are_kept_before_two_ways_to_one(state):
    def seen(sigma, promise, seed=0):
        return Prospect(
            "row_noise",
            replace(state.model, seed=seed).with_effect(KNOWN["row_noise"](sigma)),
            promise,
        )

    straight, bent, other = seen(1.0, 9.0), seen(1.0, 8.0, seed=1), seen(2.0, 7.0)
    assert _two([other, bent, straight]) == [straight, other]
    assert _two([bent, straight]) == [straight, bent]
    assert _two([seen(1.0, 8.5), straight]) == [straight]  # seen at other settings too
    assert _two([other]) == [other]
    assert _two([]) == []


def test_the_best_of_another_kind_is_kept_to_spare(state):
    def seen(kind, promise, threshold=5.0):
        dpc = KNOWN["dpc"](threshold, kind=kind)
        return Prospect("dpc", state.model.with_effect(dpc), promise)

    twice = [seen("multiple", 9.0), seen("multiple", 8.0, 9.0)]
    median, clamp = seen("median", 5.0), seen("clamp", 3.0)
    assert _best([clamp, *twice, median]) == [*twice, replace(median, spare=True)]
    assert _best([clamp, median]) == [median, clamp]
    assert _best(twice) == twice
    assert _best([]) == []


@pytest.mark.parametrize("share", [0.5, 0.75])
def test_a_median_mixed_into_few_codes_promises_most_at_its_share(share):
    """No derivative leads from another share to it: what is left changes by steps."""
    hidden = KNOWN["denoise"](share, kind="median")
    few_codes = KNOWN["read_noise"](0.6), KNOWN["pixel_fpn"](0.6), KNOWN["quantization"]()
    held = sensor(*few_codes, hidden)
    first = prospects(held, ordinary(held), {"denoise": KNOWN["denoise"]})[0]
    found = first.model.get("denoise")
    assert (found.kind, found.strength) == (hidden.kind, hidden.strength)
