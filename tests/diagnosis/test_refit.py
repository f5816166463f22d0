"""A prospect refitted: on a part of the field first, and with derivatives of its own."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from dnanalyze.diagnosis import refit
from dnanalyze.diagnosis.screening import Prospect
from dnanalyze.fitting.least_squares import State, given
from dnanalyze.model.effect import Effect, Placing
from dnanalyze.model.noise_model import NoiseModel


class Even(Effect):
    name = "a"
    placing = Placing.EVERYWHERE


class Uneven(Effect):
    name = "a"


EVEN = NoiseModel((Even(),))


@pytest.fixture(autouse=True)
def noise(monkeypatch):
    monkeypatch.setattr(refit, "least_noise", lambda _: 1.0)


def state(train, model=EVEN):
    return State(model, [], np.full(100, train), given(np.full(100, train)), np.zeros((100, 0)))


@pytest.mark.parametrize(
    ("again", "times", "tries"),
    [(True, 2.25, 2), (False, 2.25, 1), (True, 0.9 * refit.FAR, 2), (True, 1.1 * refit.FAR, 1)],
)
def test_a_bad_beginning_is_given_derivatives_of_its_own_if_it_may_be(
    monkeypatch, again, times, tries
):
    """Not where it is still ``times`` as far off as without the effect, or more."""
    made = []
    there = state(2.0)
    far = replace(there, train=there.train * times**0.5)
    while far.loss < times * there.loss:  # the loss grows less than the squares
        far = replace(far, train=far.train * 1.001)
    monkeypatch.setattr(refit, "start", lambda *_, like: far)
    monkeypatch.setattr(refit, "derive", lambda _, begun, anew: begun)
    monkeypatch.setattr(refit, "minimise", lambda _, begun, *__, **___: made.append(begun) or begun)
    seen = Prospect("a", NoiseModel((Uneven(),)), 2 * refit.BOLD)
    refit.refitted(SimpleNamespace(part=None), seen, state(2.0), 0.0, 3, again)
    assert len(made) == tries


def test_what_is_bent_goes_by_the_noise_of_the_frames(monkeypatch):
    asked = []
    knob = SimpleNamespace(name="read_noise.sigma", effect="read_noise")
    begun = replace(state(1.0), knobs=[knob], jacobian=np.ones((100, 1)))
    monkeypatch.setattr(refit, "start", lambda *_, like: begun)
    monkeypatch.setattr(refit, "minimise", lambda _, there, *__, **___: there)
    monkeypatch.setattr(refit, "bending", lambda *more: asked.append(more[-1]) or (2.0, 0.0))
    ended = refit.refitted(SimpleNamespace(part=None), Prospect("a", EVEN, 1.0), begun, 0.0, 3)
    assert asked == [1.0]
    assert np.isnan(ended.jacobian).all()  # what is bent has other derivatives


@pytest.mark.parametrize(("kind", "fields"), [(Even, ["part", "whole"]), (Uneven, ["whole"])])
def test_what_every_part_shows_alike_is_refitted_on_a_part_first(monkeypatch, kind, fields):
    """What is wanted of the part is the same share of its loss."""
    part = SimpleNamespace(name="part", part=None)
    whole = SimpleNamespace(name="whole", part=part)
    made, model = [], NoiseModel((kind(),))
    sizes = {"part": 1.0, "whole": 2.0}

    def minimise(bench, begun, iterations, below):
        made.append((bench.name, iterations, below))
        return replace(begun, train=0.5 * begun.train)

    monkeypatch.setattr(refit, "start", lambda bench, *_, like: like)
    monkeypatch.setattr(refit, "minimise", minimise)
    monkeypatch.setattr(refit, "carried", lambda seen, _there, here: state(sizes[here.name], model))
    like = state(2.0, model)
    refit.refitted(whole, Prospect("a", model, 10.0), like, 0.6 * like.loss, 3)
    assert [(name, steps) for name, steps, _ in made] == [(name, 3) for name in fields]
    for name, _, below in made:
        assert below == pytest.approx(0.6 * state(sizes[name]).loss)


@pytest.mark.parametrize(("gained", "again"), [(0.9, False), (1.1, True)])
def test_on_a_part_less_leaves_no_doubt(monkeypatch, gained, again):
    """Derivatives of its own where it stays within the part's share of `SURE` of where it was."""
    part = SimpleNamespace(part=None)
    whole, anew = SimpleNamespace(part=part), []
    like, there = state(20.0), state(10.0)
    share = there.loss / like.loss
    after = SimpleNamespace(loss=there.loss - refit.SURE * share / gained, model=there.model)
    monkeypatch.setattr(refit, "carried", lambda _seen, _there, here: there)
    monkeypatch.setattr(refit, "start", lambda *_, like: state(30.0))
    monkeypatch.setattr(refit, "minimise", lambda *_, **__: after)
    monkeypatch.setattr(refit, "derive", lambda _, begun, anew_=anew, **__: anew.append(begun))
    refit.refitted(whole, Prospect("a", there.model, 2 * refit.BOLD), like, 0.0, 3)
    assert bool(anew) == again
