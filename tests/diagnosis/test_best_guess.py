"""The better of an effect's guesses, by both halves."""

import numpy as np
import pytest

from dnanalyze.diagnosis import trial
from dnanalyze.diagnosis.screening import Prospect
from dnanalyze.diagnosis.trial import Trial, best_guess
from dnanalyze.fitting.least_squares import State
from dnanalyze.model.noise_model import NoiseModel

MODEL = NoiseModel(())


def state(train, test):
    z = [np.full(100, level) for level in (train, test)]
    return State(MODEL, [], *z, np.zeros((100, 0)))


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
