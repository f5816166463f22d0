"""What a recorded signal notes, and what it refuses."""

import numpy as np
import pytest

from dnanalyze.model.gpu.source import passes, source
from dnanalyze.model.gpu.tape import Recorded, Tape, Unrecordable
from dnanalyze.model.memo import Memo

SHAPE = (3, 5)


@pytest.fixture
def signal():
    tape = Tape(SHAPE, Memo().get)
    return Recorded(tape, tape.scalar(1.0))


def names(signal):
    return [step[0] for step in signal.tape.steps]


def test_arrays_are_spread_as_numpy_does(signal):
    signal += np.ones(SHAPE, np.float32)
    signal += np.ones(SHAPE[1], np.float32)
    signal += np.ones((1, SHAPE[1]), np.float32)
    signal += np.ones((SHAPE[0], 1), np.float32)
    signal *= np.float32(2)
    signal = 1 - signal
    kinds = [n for n in names(signal) if n not in ("add", "multiply", "subtract")]
    assert kinds == ["scalar", "field", "columns", "columns", "rows", "scalar", "scalar"]
    assert signal.tape.steps[-1] == ("subtract", 11, signal.step - 2)
    assert signal.shape == SHAPE
    assert signal.size == 15


def test_in_place_changes_the_signal_itself(signal):
    same = signal
    signal += np.float32(1)
    np.rint(signal, out=signal)
    assert np.clip(signal, np.float32(0), np.float32(9), out=signal) is same
    signal[np.ones(SHAPE, bool)] = np.float32(3)
    assert names(signal)[-1] == "where"
    assert same is signal
    few = np.array([0, 2]), np.array([1, 4])
    signal[few] = np.float32([7, 8])
    assert names(signal)[-1] == "replaced"
    places, _ = (n for n in signal.tape.numbers if isinstance(n, np.ndarray) and n.ndim == 1)
    assert np.array_equal(np.flatnonzero(places >= 0), [1, 14])
    assert signal.step == len(signal.tape.steps) - 1
    other = signal + np.float32(1)
    assert other.step != signal.step


@pytest.mark.parametrize(
    "act",
    [
        lambda s: s + np.ones(SHAPE),  # NumPy would add in double precision
        lambda s: s + np.float64(1),
        lambda s: s + np.ones((2, 2), np.float32),
        lambda s: np.exp(s),
        lambda s: np.add.reduce(s),
        lambda s: np.sort(s),
        lambda s: np.stack([s, s]),
        lambda s: np.asarray(s),
        lambda s: s[1:],
        lambda s: s.__setitem__((0, 0), 1.0),
        lambda s: s > 3 and 1,
        lambda s: bool(s),
    ],
)
def test_what_has_no_step_is_refused(signal, act):
    with pytest.raises(Unrecordable):
        act(signal)


def test_a_random_field_has_values_until_it_is_changed(signal):
    white = np.full(SHAPE, 2, np.float32)
    field = Recorded(signal.tape, 0, lambda: white)
    assert np.array_equal(np.exp(field), np.exp(white))
    assert np.array_equal(np.ascontiguousarray(field), white)
    field *= np.float32(2)
    with pytest.raises(Unrecordable):
        np.asarray(field)


def test_only_what_is_read_around_a_pixel_takes_a_pass_more(signal):
    signal += np.ones(SHAPE, np.float32)
    before = signal.step
    assert len(passes(signal.tape, signal.step)) == 1
    signal = signal.note("share_with_neighbours", 0.1, 0.01, 0.02)
    signal += np.float32(1)
    first, second = passes(signal.tape, signal.step)
    assert (first.step, second.step) == (before, signal.step)
    assert first.size == second.size == 15
    code = source(signal.tape, signal.step, 16)
    assert code.count("__global__") == 2
    assert code.count("field") > 0
    assert "(u16*)" in code
    assert "(float*)" in code
