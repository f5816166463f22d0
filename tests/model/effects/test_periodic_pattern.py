import numpy as np
import pytest
from readout_bench import POINT, Given, added

from dnanalyze.fitting.knobs import knobs_of
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effects.periodic_pattern import PeriodicPattern
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.wave import Wave

WAVE = PeriodicPattern(1.5, 5 / 128, 22 / 128)


def test_one_line_of_the_spectrum_holds_the_variance():
    d = added(WAVE, count=3)
    for frame in d:
        power = np.abs(np.fft.fft2(frame)) ** 2 / frame.size**2
        assert power[22, 5] == pytest.approx(1.5**2 / 4, rel=1e-4)
        assert power.sum() == pytest.approx(WAVE.variance(POINT), rel=1e-4)


def test_phase_is_new_in_every_frame_or_fixed():
    phases = np.angle(np.fft.fft2(added(WAVE, count=40, shape=(128, 128)))[:, 22, 5])
    assert abs(np.exp(1j * phases).mean()) < 3 / np.sqrt(40)  # Rayleigh: exp(-9) by chance
    fixed = added(PeriodicPattern(1.5, 0.11, 0.07, "fixed"), count=2)
    np.testing.assert_allclose(fixed[0], fixed[1], atol=1e-4)


def test_follows_gain_but_not_temperature():
    fixed = PeriodicPattern(1.0, 0.11, 0.07, "fixed")
    cold = added(fixed)[0]
    np.testing.assert_allclose(
        added(fixed, point=OperatingPoint(85.0, 9.0, 2.0))[0], 2 * cold, atol=1e-4
    )


def line(u, v, amplitude=0.6, error=1e-3, ratio=40.0, shared=""):
    return Wave(u, v, error, error, amplitude, ratio, shared)


def test_guess_from_the_line_off_the_axes():
    clues = Given(spectral={"temporal": [line(0.05, -0.17)]}, off={"temporal_line": 12.0})
    (effect,) = PeriodicPattern.guess(clues)
    assert (effect.u, effect.v, effect.phase) == (0.05, -0.17, "random")
    assert effect.amplitude == pytest.approx(0.6, rel=1e-6)


def test_guess_takes_the_line_that_stands_highest_and_all_that_is_measured_of_it():
    waves = [
        line(0.3, 0.1, ratio=50.0),
        line(0.101, -0.2, error=2e-3, ratio=90.0),
        line(-0.1, 0.2, error=1e-3, ratio=20.0),  # the same wave
        line(0.899, 0.2 - 1.0, error=2e-3, ratio=20.0),  # and again, by whole cycles
    ]
    clues = Given(spectral={"temporal": waves}, off={"temporal_line": 12.0})
    (effect,) = PeriodicPattern.guess(clues)
    u = (0.101 / 4 + 0.1 + 0.101 / 4) / 1.5
    assert (effect.u, effect.v) == (pytest.approx(u), pytest.approx(-0.2))


def test_a_pattern_is_told_where_its_own_line_lies_else_the_strongest():
    waves = [line(0.3, 0.1, ratio=50.0), line(0.1005, -0.2, error=1e-4, ratio=20.0)]
    clues = Given(spectral={"temporal": waves})
    told = PeriodicPattern(u=-0.1, v=0.2).told(clues)
    assert (told["u"].value, told["u"].se) == (pytest.approx(-0.1005), pytest.approx(1e-4))
    told = PeriodicPattern(u=0.01, v=0.4).told(clues)
    assert (told["u"].value, told["v"].value) == (pytest.approx(0.3), pytest.approx(0.1))
    assert PeriodicPattern(phase="fixed").told(clues) == {}


def test_frequency_is_left_alone_by_a_fit():
    names = [k.name for k in knobs_of(NoiseModel((PeriodicPattern(),), 64.0))]
    assert names == ["pedestal", "periodic_pattern.amplitude"]


@pytest.mark.parametrize("beside", [(0.0, 0.0), (0.5, 0.0), (0.0, -0.5), (0.5, 0.5)])
@pytest.mark.parametrize(("periods", "pattern"), [(1.0, False), (2.0, True)])
def test_less_than_a_period_and_a_half_over_the_field_is_no_pattern(beside, periods, pattern):
    """Nor is what beats so slowly with every other line, for a slope under a checkerboard does."""
    size = Given().field[0]
    u, v = beside
    wave = line(abs(u - periods / size), v + (1.0 if v < 0 else -1.0) / size)
    clues = Given(spectral={"temporal": [wave]}, off={"temporal_line": 12.0})
    assert bool(PeriodicPattern.guess(clues)) == pattern


def test_guess_from_a_line_on_an_axis():
    wave = line(0.0, 0.125, shared="rows")
    given = {"spectral": {"temporal": [wave]}}
    (effect,) = PeriodicPattern.guess(Given(**given, off={"temporal_rows_0.1_0.3": 9.0}))
    assert (effect.u, effect.v) == (0.0, 0.125)
    assert PeriodicPattern.guess(Given(**given, off={"temporal_columns_0.1_0.3": 9.0})) == []


def test_no_guess_where_there_is_no_line():
    off = {"temporal_line": 9.0, "temporal_rows_0.1_0.3": 9.0}
    assert PeriodicPattern.guess(Given(off=off)) == []
