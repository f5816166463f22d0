import numpy as np
import pytest
from readout_bench import POINT, Given, added

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effects.periodic_pattern import PeriodicPattern

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


def test_guess_from_the_line_off_the_axes():
    clues = Given(
        seen={"temporal_line_u": 0.05, "temporal_line_v": -0.17, "temporal_line_amplitude": 0.6},
        off={"temporal_line": 12.0},
    )
    (effect,) = PeriodicPattern.guess(clues)
    assert (effect.u, effect.v, effect.phase) == (0.05, -0.17, "random")
    assert effect.amplitude == pytest.approx(0.6, rel=1e-6)


@pytest.mark.parametrize("beside", [(0.0, 0.0), (0.5, 0.0), (0.0, -0.5), (0.5, 0.5)])
@pytest.mark.parametrize(("periods", "pattern"), [(1.0, False), (2.0, True)])
def test_less_than_a_period_and_a_half_over_the_field_is_no_pattern(beside, periods, pattern):
    """Nor is what beats so slowly with every other line, for a slope under a checkerboard does."""
    size = Given().field[0]
    u, v = beside
    clues = Given(
        seen={
            "temporal_line_u": abs(u - periods / size),
            "temporal_line_v": v + 1.0 / size if v < 0 else v - 1.0 / size,
            "temporal_line_amplitude": 0.6,
        },
        off={"temporal_line": 12.0},
    )
    assert bool(PeriodicPattern.guess(clues)) == pattern


def test_guess_from_a_line_on_an_axis():
    spectrum = np.random.default_rng(1).exponential(4.0, 129)
    spectrum[32] = 0.36 / 4 * 256 * 256
    curves = {"temporal_row_spectrum": [spectrum], "row_spectrum_f": [np.arange(129) / 256]}
    clues = Given(off={"temporal_rows_0.1_0.3": 9.0}, curves=curves)
    (effect,) = PeriodicPattern.guess(clues)
    assert (effect.u, effect.v) == (0.0, 0.125)
    assert effect.amplitude == pytest.approx(0.6, rel=1e-6)
    spectrum[32] = 4.0
    assert PeriodicPattern.guess(clues) == []


@pytest.mark.parametrize("off", [-0.4, -0.1, 0.3])
def test_guess_places_a_line_between_two_modes(off):
    n, v = 256, (40 + off) / 256
    wave = 0.8 * np.sin(2 * np.pi * v * np.arange(n) + 1.0)
    power = np.abs(np.fft.rfft(wave)) ** 2  # of rows of n pixels: n^2 / n^2 of the frame's modes
    spectrum = power / n * n + np.random.default_rng(2).exponential(1.0, n // 2 + 1)
    curves = {"temporal_row_spectrum": [spectrum], "row_spectrum_f": [np.arange(129) / 256]}
    clues = Given(off={"temporal_rows_0.1_0.3": 9.0}, curves=curves)
    (effect,) = PeriodicPattern.guess(clues)
    assert effect.v == pytest.approx(v, abs=0.03 / 256)
    assert effect.amplitude == pytest.approx(0.8, rel=0.05)


def test_no_guess_where_curves_are_absent():
    assert PeriodicPattern.guess(Given(off={"temporal_rows_0.1_0.3": 9.0})) == []
    assert PeriodicPattern.guess(Given(off={"temporal_line": 9.0})) == []
