"""Rivals at numbers that mean the same."""

from types import SimpleNamespace

import numpy as np
import pytest

from dnanalyze.diagnosis import trial
from dnanalyze.diagnosis.in_its_place import in_its_place
from dnanalyze.diagnosis.screening import Prospect
from dnanalyze.fitting.least_squares import State, given
from dnanalyze.loaders.captures import Window
from dnanalyze.model.effects.dark_current_steps import DarkCurrentSteps
from dnanalyze.model.effects.hot_clusters import HotClusters
from dnanalyze.model.effects.hot_pixels import HotPixels
from dnanalyze.model.effects.rts import Rts
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import built_in

STEPS = NoiseModel((DarkCurrentSteps(step=40.0, mean_number=2e-3, ea_ev=0.45),))


def stands(level, model=STEPS):
    """A state that is as far off everywhere, on both halves."""
    off = np.full(100, level)
    return State(model, [], off, given(off), np.zeros((100, 0)))


def test_hot_pixels_come_in_the_place_of_steps_with_as_much_signal():
    ((name, model),) = in_its_place(STEPS, "dark_current_steps", built_in())
    (hot,) = model.effects
    assert name == "hot_pixels"
    assert isinstance(hot, HotPixels)
    assert hot.fraction * hot.scale == pytest.approx(40.0 * 2e-3)
    assert hot.ea_ev == pytest.approx(0.45)


def test_those_come_that_are_confused_with_it_and_may():
    model = NoiseModel((HotPixels(),))
    assert {name for name, _ in in_its_place(model, "hot_pixels", built_in())} == {
        "hot_clusters",
        "dark_current_steps",
    }
    assert not list(in_its_place(model, "hot_pixels", {"hot_pixels": HotPixels}))
    model = NoiseModel((HotClusters(),))
    assert [n for n, _ in in_its_place(model, "hot_clusters", built_in())] == ["hot_pixels"]
    assert not list(in_its_place(NoiseModel((Rts(),)), "rts", built_in()))


@pytest.mark.parametrize(("ended", "first"), [(0.5, "hot_pixels"), (4.0, "dark_current_steps")])
def test_a_rival_that_its_own_guess_led_astray_begins_where_the_leader_ended(
    monkeypatch, ended, first
):
    names = np.array(["hot_count_8"] * 100)
    half = SimpleNamespace(names=names, families=names)
    bench = SimpleNamespace(
        train=half,
        test=half,
        plan=SimpleNamespace(windows=[Window(0, 8, 0, 8), Window(8, 16, 0, 8)]),
    )
    base, leader, astray, like = stands(5.0), stands(2.0), stands(4.5), []

    def refit(_bench, begun, *_, **__):
        if isinstance(begun, State):  # of rivals to the end
            return begun
        like.append(begun)
        return stands(ended, begun)

    guesses = [Prospect("dark_current_steps", STEPS, 900.0), Prospect("hot_pixels", STEPS, 800.0)]
    after = {"dark_current_steps": leader, "hot_pixels": astray}
    monkeypatch.setattr(trial, "prospects", lambda *_: seen)
    monkeypatch.setattr(trial, "refitted", lambda _bench, p, *_: after[p.effect])
    monkeypatch.setattr(trial, "start", lambda _bench, model, _knobs, like: model)
    monkeypatch.setattr(trial, "minimise", refit)
    monkeypatch.setattr(trial, "derive", lambda _bench, state, **_: state)
    seen = guesses[:1]
    trial.trials(bench, base, built_in())
    assert like == []  # without a sign of its own it is none
    seen = guesses
    found = trial.trials(bench, base, built_in())
    (model,) = like
    assert model.names == ["hot_pixels"]
    assert found[0].effect == first
    assert next(t for t in found if t.effect == "hot_pixels").state.model is model
