"""Completing a model on a sensor of the independent generator, step by step."""

import importlib
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from dnanalyze.demo import draw_sensor, generate
from dnanalyze.diagnosis.confidence import CERTAIN, LUCK, NOTHING, STANDS_IN
from dnanalyze.diagnosis.refine import refine
from dnanalyze.fitting.knobs import knobs_of
from dnanalyze.fitting.least_squares import start
from dnanalyze.model.registry import BASE, EVERYDAY, built_in

FEW = (BASE, *EVERYDAY, "row_fpn", "row_noise", "column_fpn")


@pytest.fixture(scope="module")
def captures():
    sensor = draw_sensor(np.random.default_rng(11))
    return generate(sensor, {"row_fpn": {"level": "strong"}}, (128, 128), frames=4, seed=3)


@pytest.fixture(scope="module")
def known():
    return {name: effect for name, effect in built_in().items() if name in FEW}


def test_it_names_what_is_hidden_and_goes_on_from_any_model_it_kept(captures, known):
    kept, told = [], []
    whole = refine(captures, known=known, keep=kept.append, tell=told.append)
    assert whole.effects == [BASE, *sorted(EVERYDAY, key=whole.effects.index), "row_fpn"]
    assert [s.added for s in told] == [None, *EVERYDAY, "row_fpn"]
    assert kept[-1] == whole.model
    assert set(kept[0].names) == {BASE, *EVERYDAY}
    rest = refine(captures, kept[0], known=known)
    assert [s.added for s in rest.steps] == [None, "row_fpn"]
    assert set(rest.effects) == set(whole.effects)
    assert rest.steps[-1].error < 1.2 < rest.steps[0].error


def test_it_stops_where_it_is_told(captures, known):
    first = refine(captures, known=known, most_effects=0)
    assert first.verdict == "missing"
    assert "row_fpn" not in first.effects
    without = refine(captures, first.model, known=known, exclude=["row_fpn"], until_error=0.01)
    assert "row_fpn" not in without.effects
    enough = refine(captures, first.model, known=known, until_error=1e3)
    assert len(enough.steps) == 1


def test_what_stays_unexplained_halves_the_confidence_of_what_was_added(
    captures, known, monkeypatch
):
    plain = refine(captures, known=known)
    open_end = replace(plain.diagnosis, verdict="unexplained")
    monkeypatch.setattr(importlib.import_module("dnanalyze.diagnosis.refine"), "judge",
                        lambda *_, **__: open_end)  # fmt: skip
    doubted = refine(captures, known=known)
    assert plain.verdict == "adequate"
    assert [s.added for s in doubted.steps] == [s.added for s in plain.steps]
    sure, unsure = plain.steps[-1].confidence, doubted.steps[-1].confidence
    assert unsure == pytest.approx(STANDS_IN * sure)
    assert doubted.steps[0].confidence is None


def test_an_addition_that_only_led_the_others_to_their_place_goes_again(
    captures, known, monkeypatch
):
    module = importlib.import_module("dnanalyze.diagnosis.refine")
    truth = refine(captures, known=known)
    led = truth.model.with_effect(known["column_fpn"](1e-4))
    state = start(truth.bench, led, knobs_of(led))
    kept, gone = module._needless(truth.bench, state)
    assert gone == ["column_fpn"]
    assert kept.model.get("row_fpn") is not None


@pytest.mark.parametrize(
    ("gain", "fitted", "average", "without", "idle"),
    [
        (NOTHING, 0.0, 0.0, 2.0, False),
        (0.0, 2 * CERTAIN, NOTHING, 2.0, False),
        (0.0, 2 * CERTAIN, 0.0, 2.0, True),
        (0.0, CERTAIN / 2, NOTHING, 2.0, True),
        (0.0, 0.0, 0.0, 2.0 * (1.0 + 0.9 * LUCK), True),
        (0.0, 0.0, 0.0, 2.0 * (1.0 + 1.1 * LUCK), False),
    ],
)
def test_what_the_average_sensor_or_the_error_shows_to_be_needed_stays(
    monkeypatch, gain, fitted, average, without, idle
):
    module = importlib.import_module("dnanalyze.diagnosis.refine")
    monkeypatch.setattr(module, "averaged", lambda _, state: f"average {state}")
    monkeypatch.setattr(
        module,
        "judged",
        lambda _held, before, _name, _after: SimpleNamespace(
            gain=average if before.startswith("average") else gain,
            fitted_gain=fitted,
            error=2.0,
        ),
    )
    monkeypatch.setattr(module, "error_of", lambda *_: without)
    assert module._idle(None, "without", "with", "a") is idle


@pytest.mark.parametrize("poor", [True, False])
def test_before_it_gives_up_on_a_poor_model_it_asks_once_more_with_true_derivatives(
    captures, known, monkeypatch, poor
):
    module = importlib.import_module("dnanalyze.diagnosis.refine")
    begun = refine(captures, known=known, most_effects=0)
    asked, real = [], module.trials

    def blind(held, state, *more):
        """Sees nothing at first."""
        asked.append(state)
        return real(held, state, *more) if len(asked) > 1 else []

    monkeypatch.setattr(module, "trials", blind)
    monkeypatch.setattr(module, "POOR", 1.0 if poor else 1e3)
    found = refine(captures, begun.model, known=known)
    assert ("row_fpn" in found.effects) == poor
    if poor:
        assert not np.array_equal(asked[0].jacobian, asked[1].jacobian)
    else:
        assert len(asked) == 1
