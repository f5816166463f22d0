"""What a model does without goes; what it needs stays."""

from types import SimpleNamespace

import pytest

from dnanalyze.diagnosis import needless as module
from dnanalyze.diagnosis.confidence import CERTAIN, LUCK, NOTHING
from dnanalyze.diagnosis.needless import needless
from dnanalyze.fitting.knobs import knobs_of
from dnanalyze.fitting.least_squares import converge, start


def test_an_addition_that_only_led_the_others_to_their_place_goes_again(ordinary, known):
    right = ordinary.model.with_effect(known["row_fpn"](1.0))
    truth = converge(ordinary.bench, start(ordinary.bench, right, knobs_of(right)))
    led = truth.model.with_effect(known["column_fpn"](1e-4))
    state, gone = needless(ordinary.bench, start(ordinary.bench, led, knobs_of(led)))
    assert gone == ["column_fpn"]
    assert state.model.get("row_fpn") is not None


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
    monkeypatch.setattr(module, "on_average", lambda _, state: (None, f"average {state}"))
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
