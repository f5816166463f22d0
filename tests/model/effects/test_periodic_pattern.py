from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from readout_bench import POINT, Given, added, frames
from scipy.signal import hilbert

from dnanalyze.errors import InputError
from dnanalyze.fitting.free_parameters import free_parameters
from dnanalyze.loaders.captures import OperatingPoint, Window
from dnanalyze.model.effects.periodic_pattern import NARROW, PeriodicPattern, harmonic
from dnanalyze.model.noise_model import NoiseModel, load_model
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
    told = PeriodicPattern(u=-0.1, v=0.2).measured_parameters(clues)
    assert (told["u"].value, told["u"].se) == (pytest.approx(-0.1005), pytest.approx(1e-4))
    told = PeriodicPattern(u=0.01, v=0.4).measured_parameters(clues)
    assert (told["u"].value, told["v"].value) == (pytest.approx(0.3), pytest.approx(0.1))
    assert PeriodicPattern(phase="fixed").measured_parameters(clues) == {}


def test_frequency_is_left_alone_by_a_fit():
    names = [k.name for k in free_parameters(NoiseModel((PeriodicPattern(),), 64.0))]
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


SEVERAL = PeriodicPattern(
    1.5, 5 / 128, 22 / 128, more=(10 / 128, 44 / 128, 0.5, 0.0, -37 / 128, 0.25)
)


def test_further_lines_hold_their_share_of_the_variance():
    assert SEVERAL.variance(POINT) == pytest.approx(1.5**2 / 2 * (1 + 0.5**2 + 0.25**2))
    for frame in added(SEVERAL, count=3):
        power = np.abs(np.fft.fft2(frame)) ** 2 / frame.size**2
        for i, k, relative in ((22, 5, 1.0), (44, 10, 0.5), (-37, 0, 0.25)):
            assert power[i, k] == pytest.approx((1.5 * relative) ** 2 / 4, rel=1e-4)
        assert power.sum() == pytest.approx(SEVERAL.variance(POINT), rel=1e-4)


def test_every_line_has_a_phase_of_its_own():
    spectra = np.fft.fft2(added(SEVERAL, count=40))
    turns = [spectra[:, i, k] / np.abs(spectra[:, i, k]) for i, k in ((22, 5), (44, 10), (-37, 0))]
    for n, one in enumerate(turns):
        assert abs(one.mean()) < 3 / np.sqrt(40)  # Rayleigh: exp(-9) by chance
        for other in turns[n + 1 :]:
            assert abs((one * other.conj()).mean()) < 3 / np.sqrt(40)
    fixed = PeriodicPattern(1.5, 0.11, 0.07, "fixed", (0.2, 0.3, 0.4))
    first, second = added(fixed, count=2)
    np.testing.assert_allclose(first, second, atol=1e-4)


def test_a_part_of_the_frame_has_the_same_waves():
    window = Window(20, 90, 30, 110)
    whole, part = (frames(SEVERAL, window=w)[0] for w in (None, window))
    np.testing.assert_allclose(part, whole[window.slices], atol=1e-4)


class OneSine(PeriodicPattern):
    """The effect as it was before it had further lines."""

    def apply(self, signal, site):
        stream = site.fixed_stream if self.phase == "fixed" else site.frame_stream
        start = 2.0 * np.pi * float(stream.child("phase").generator().random())
        along = 2.0 * np.pi * self.u * site.column_index
        down = 2.0 * np.pi * self.v * site.row_index + start
        signal += np.outer(self.amplitude * np.sin(down), np.cos(along)).astype(np.float32)
        signal += np.outer(self.amplitude * np.cos(down), np.sin(along)).astype(np.float32)
        return signal


@pytest.mark.parametrize("phase", ["random", "fixed"])
def test_frames_of_one_line_are_what_they_were(phase):
    given = (1.5, 0.11, -0.07, phase)
    was, now = (frames(kind(*given)) for kind in (OneSine, PeriodicPattern))
    np.testing.assert_array_equal(was, now)


def test_a_model_file_keeps_the_lines(tmp_path):
    NoiseModel((SEVERAL,), 64.0).save(tmp_path / "model.yaml")
    assert load_model(tmp_path / "model.yaml").get("periodic_pattern") == SEVERAL
    assert "more" not in [k.name for k in free_parameters(NoiseModel((SEVERAL,), 64.0))]


@pytest.mark.parametrize(
    "more",
    [
        (0.1, 0.2),
        (0.1, 0.2, 0.5) * 8,
        (0.51, 0.2, 0.5),
        (0.1, -0.7, 0.5),
        (0.1, 0.2, 1e-4),
        (0.1, 0.2, 11.0),
        (0.1, 0.2, float("nan")),
        ("a", 0.2, 0.5),
        0.5,
    ],
)
def test_what_is_no_further_line_is_refused(more):
    with pytest.raises(InputError, match=r"periodic_pattern\.more"):
        PeriodicPattern(more=more)


FREQUENCY = st.integers(-31, 31)


@settings(max_examples=15, deadline=None)
@given(
    modes=st.lists(
        st.tuples(st.integers(1, 31), FREQUENCY, st.floats(0.01, 10.0)),
        min_size=1,
        max_size=7,
        unique_by=lambda line: line[:2],
    ),
    amplitude=st.floats(0.1, 5.0),
)
def test_power_of_any_lines_is_the_closed_form(modes, amplitude):
    more = tuple(x for u, v, a in modes for x in (u / 64, v / 64, a))
    effect = PeriodicPattern(amplitude, 0.0, 0.25, more=more)
    (frame,) = added(effect, count=1, shape=(64, 64))
    assert frame.var() == pytest.approx(effect.variance(POINT), rel=1e-3)


def seen_at(places, **given):
    return Given(spectral={"temporal": places}, off={"temporal_line": 12.0}, **given)


def test_guess_has_the_further_lines_and_the_first_alone():
    first, harmonic = (0.05, -0.17), (0.1, -0.34)
    places = [line(*first), line(*first), line(*harmonic, 0.3, ratio=9.0)]
    several, alone = PeriodicPattern.guess(seen_at(places))
    assert several.further == [(*harmonic, 0.5)]
    assert (several.u, several.v) == (alone.u, alone.v) == first
    assert several.amplitude == alone.amplitude
    assert alone.more == ()


def test_of_several_lines_that_of_the_largest_amplitude_is_the_first():
    """The other stands higher over its own floor."""
    clear, large = line(0.05, -0.17, 0.3), line(0.1, -0.34, 1.2, ratio=9.0)
    several, alone = PeriodicPattern.guess(seen_at([clear, large]))
    assert (several.u, several.v, several.amplitude) == (0.1, -0.34, pytest.approx(1.2))
    assert several.further == [(0.05, -0.17, 0.25)]
    assert (alone.u, alone.v, alone.amplitude) == (0.05, -0.17, 0.3)


def test_guess_leaves_out_what_is_weak_or_seldom_or_beside_the_first():
    first = (0.05, -0.17)
    weak, seldom = line(0.1, -0.34, 0.05, ratio=9.0), line(0.3, 0.2, 0.5, ratio=9.0)
    beside = line(0.05 + 0.7 / 256, -0.17, 0.5, 1e-5, ratio=9.0)
    places = [line(*first, error=1e-5)] * 3 + [weak, weak, seldom, beside]
    (alone,) = PeriodicPattern.guess(seen_at(places))
    assert alone.more == ()
    (alone,) = PeriodicPattern.guess(seen_at([*places, line(0.3, 1 / 256, 0.5)]))
    assert alone.more == ()  # less than a period and a half beside what every line repeats


def test_fixed_lines_of_taps_are_no_further_ones():
    first = line(0.05, -0.17)
    taps, other = line(0.125, 0.0, shared="columns"), line(0.1453, 0.0, shared="columns")
    clues = Given(
        spectral={"pattern": [first, taps, other]},
        off={"pattern_line": 12.0, "pattern_columns_0.1_0.3": 12.0},
    )
    several, _ = PeriodicPattern.guess(clues)
    assert several.further == [(other.u, other.v, 1.0)]


def test_the_first_line_is_told_beside_the_further_ones():
    waves = [line(0.3, 0.1, ratio=50.0), line(0.1005, -0.2, error=1e-4, ratio=20.0)]
    clues = Given(spectral={"temporal": waves})
    told = PeriodicPattern(u=0.4, v=0.4, more=(0.3, 0.1, 0.5)).measured_parameters(clues)
    assert (told["u"].value, told["v"].value) == (pytest.approx(0.1005), pytest.approx(-0.2))


def test_a_phase_that_walks_makes_a_lorentzian_line():
    """Autocorrelation A^2 / 2 cos(2 pi v k) exp(-pi linewidth k) of the rows."""
    amplitude, v, width = 3.0, 0.13, 0.004
    d = added(PeriodicPattern(amplitude, 0.0, v, linewidth=width), count=60, shape=(2048, 4))
    r = d[:, :, 0]
    for lag in (1, 20, 77, 150):
        seen = np.mean(r[:, lag:] * r[:, :-lag])
        wanted = amplitude**2 / 2 * np.cos(2 * np.pi * v * lag) * np.exp(-np.pi * width * lag)
        # coherent over 1 / (pi width) = 80 rows: 60 x 25 independent pieces
        assert seen == pytest.approx(wanted, abs=5 * amplitude**2 / 2 / np.sqrt(60 * 25))


def test_harmonics_walk_with_their_line_and_other_lines_by_themselves():
    first = PeriodicPattern(1.0, 0.0, 1 / 16, linewidth=2e-3)

    def share_in_step(v):
        """Of the variance of another line, what twice the phase of the first explains."""
        both = replace(first, more=(0.0, v, 1.0))
        one, other = (added(e, count=1, shape=(4096, 2))[0, :, 0] for e in (first, both))
        theta = np.angle(hilbert(one))
        basis = np.stack([np.cos(2 * theta), np.sin(2 * theta)], 1)
        further = other - one
        left = further - basis @ np.linalg.lstsq(basis, further, rcond=None)[0]
        return 1 - np.var(left) / np.var(further)

    assert share_in_step(2 / 16) > 0.95
    assert share_in_step(2 / 16 + 3 / 4096) < 0.5  # three modes beside: another source


def test_a_window_of_a_wide_line_is_that_of_the_whole_frame():
    effect = PeriodicPattern(2.0, 0.03, 0.17, linewidth=0.01)
    whole = frames(effect, count=1, shape=(64, 48))
    for window in (Window(0, 9, 0, 48), Window(33, 64, 7, 20)):
        part = frames(effect, count=1, shape=(64, 48), window=window)
        rows, columns = slice(window.top, window.bottom), slice(window.left, window.right)
        np.testing.assert_allclose(part, whole[:, rows, columns], atol=1e-5)


def test_which_harmonic_a_line_is():
    field = (512, 512)
    assert harmonic((0.0, 0.0355), (0.0, 0.0177), field) == 2
    assert harmonic((0.1, -0.34), (0.05, -0.17), field) == 2
    assert harmonic((0.0, 0.4), (0.0, 0.3), field) == 2  # 0.6, folded
    assert harmonic((0.0, 0.05), (0.0, 0.0177), field) == 0


def test_a_sharp_line_has_a_narrow_form():
    sharp = PeriodicPattern(1.0, 0.0, 0.1)
    assert sharp.inactive_parameters() == ("linewidth",)
    (narrow,) = sharp.relatives()
    assert (narrow.linewidth, narrow.amplitude, narrow.relatives()) == (NARROW, 1.0, [])
