import pytest

from dnanalyze.model.wave import Wave, strongest_wave, together


def wave(u, v, error=1e-3, ratio=10.0):
    return Wave(u, v, error, error, 1.0, ratio)


def test_conjugates_and_whole_cycles_are_one_wave():
    here = wave(0.25, -0.125)
    for other in (wave(-0.25, 0.125), wave(0.75, 0.125), wave(0.25, 0.875), wave(0.252, -0.124)):
        assert here.is_same(other)
    for other in (wave(0.25, 0.125), wave(0.26, -0.125)):
        assert not here.is_same(other)
    nyquist = wave(0.5, 0.25)
    assert nyquist.is_same(wave(0.5, -0.25))


def test_one_wave_measured_twice_is_at_the_weighted_mean():
    first = wave(0.2, 0.1, 1e-3, ratio=30.0)
    both = strongest_wave([wave(-0.203, -0.1, 2e-3), first, wave(0.4, 0.1)])
    assert both.u == pytest.approx((0.2 * 4 + 0.203) / 5)
    assert both.v == pytest.approx(0.1)
    # 3e-3 apart with errors of 1 and 2e-3: chi-square 9/5, by whose root the error of 1e-3
    # times sqrt(4/5) grows
    assert both.u_error == pytest.approx(1e-3 * (4 / 5) ** 0.5 * (9 / 5) ** 0.5)
    assert both.v_error == pytest.approx(1e-3 * (4 / 5) ** 0.5)
    assert strongest_wave([]) is None
    assert together(first, [first]) == first


def test_frequencies_of_a_mean_lie_within_a_half():
    twice = [wave(0.4998, 0.25, ratio=20.0), wave(0.4996, -0.25)]  # the second also at .5004
    found = strongest_wave(twice)
    assert (found.u, found.v) == (pytest.approx(-0.4999), pytest.approx(0.25))
    found = strongest_wave([wave(0.75, 0.125)])
    assert (found.u, found.v) == (pytest.approx(-0.25), pytest.approx(0.125))
