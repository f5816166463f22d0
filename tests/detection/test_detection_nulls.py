"""Each test's null distribution, on exchangeable pixels, against theory."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from scipy import signal, stats

from dnanalyze.detection import tests, verdict
from dnanalyze.detection.correlation import (
    LagCorrelation,
    crosstalk_kernel,
    lag_correlation,
    largest_crosstalk,
    shot_share,
)
from dnanalyze.detection.excess import SLOPES, standing_out
from dnanalyze.detection.extremes import exceedance, row_phase
from dnanalyze.detection.memory import autocorrelation, expected_excess, memory_of
from dnanalyze.detection.replaced import RULES, Replaced, replaced
from dnanalyze.detection.spectrum import octave_spectrum
from dnanalyze.detection.texture import equal_neighbours, texture
from dnanalyze.detection.verdict import holm
from dnanalyze.thermal import arrhenius

MARGINALS = {
    "normal": lambda rng, shape: rng.standard_normal(shape),
    "lognormal": lambda rng, shape: np.exp(1.5 * rng.standard_normal(shape)),
    "student": lambda rng, shape: rng.standard_t(2, shape),
}


def _images(marginal: str, seed: int, shape: tuple[int, int, int] = (4, 200, 200)) -> np.ndarray:
    return MARGINALS[marginal](np.random.default_rng(seed), shape).astype(np.float32)


@pytest.mark.parametrize("marginal", MARGINALS)
def test_local_extremes_are_as_rare_as_theory_says(marginal):
    found = exceedance(_images(marginal, 8))
    assert abs(found.extremes - 1) < 5 * found.se


def test_standard_errors_of_extremes_are_those_of_repetition():
    found = [exceedance(_images("normal", s, (1, 96, 96))) for s in range(200)]
    spread = np.std([f.extremes for f in found])
    assert spread == pytest.approx(found[0].se, rel=5 / np.sqrt(400))


def test_octave_powers_of_white_noise_are_equal_and_their_errors_hold():
    z = []
    for seed in range(30):
        s = octave_spectrum(_images("normal", seed, (2, 128, 128)))
        ok = np.isfinite(s.log_power)
        z += list((s.log_power[ok] - s.log_power[-1])[:-1] / np.hypot(s.se[ok], s.se[-1])[:-1])
    assert np.std(z) == pytest.approx(1.0, abs=0.25)
    assert abs(np.mean(z)) < 5 / np.sqrt(30)


@pytest.mark.parametrize("slope", [0.5, 1.0, 2.0])
def test_white_with_pink_noise_never_bends_like_a_filter(slope):
    rng = np.random.default_rng(3)
    rho = np.hypot(np.fft.fftfreq(256)[:, None], np.fft.rfftfreq(256)[None])
    rho[0, 0] = np.inf
    white = rng.standard_normal((4, 256, 256))
    pink = np.fft.irfft2(np.fft.rfft2(rng.standard_normal((4, 256, 256))) * rho ** (-slope / 2))
    bend, se = octave_spectrum((white + pink / pink.std()).astype(np.float32)).concavity()
    assert bend < 5 * se


@pytest.mark.parametrize("slope", [0.3, 0.5, 0.7, 0.9, 1.2, 1.6])
def test_a_field_of_any_power_law_leaves_next_to_no_short_range(slope):
    size = 512
    rho = np.hypot(np.fft.fftfreq(size)[:, None], np.fft.fftfreq(size)[None])
    rho[0, 0] = np.inf
    power = rho**-slope
    power[0], power[:, 0] = 0.0, 0.0  # the tests take row and column means away
    shared = np.fft.ifft2(power).real
    shared /= shared[0, 0]
    along = tuple(float(r) for r in shared[0, 1:4])
    field = LagCorrelation(along, along, float(shared[1, 1]), 1e-3, 1.0)
    assert field.short_range < 0.035
    assert field.short_range < 0.021 or slope < 0.5


@pytest.mark.parametrize("pink", [0.0, 0.5, 1.0])
def test_the_error_of_the_short_range_holds_its_scatter(pink):
    rho = np.hypot(np.fft.fftfreq(128)[:, None], np.fft.rfftfreq(128)[None])
    rho[0, 0] = np.inf
    found = []
    for seed in range(60):
        field, white = np.random.default_rng(seed).standard_normal((2, 2, 128, 128))
        field = np.fft.irfft2(np.fft.rfft2(field) * rho**-0.37)
        found.append(lag_correlation((white + pink * field / field.std()).astype(np.float32)))
    ranges = np.array([c.short_range for c in found])
    said = np.mean([c.short_range_error for c in found])
    assert np.std(ranges) < 1.3 * said  # 60 draws give it to 9 %; the lesser of two scatters less
    assert np.std(ranges) > 0.2 * said
    assert np.mean(ranges) < 0.02


def test_lag_correlations_of_white_noise_are_zero_within_their_error():
    c = lag_correlation(_images("student", 1))
    values = np.array([*c.along_rows, *c.along_columns, c.diagonal])
    assert np.all(np.abs(values) < 5 * c.se)


def test_the_crosstalk_bound_is_the_kernels_autocorrelation():
    phi = 0.02  # rho(1,0) = (2 phi - 12 phi^2) / K_2, rho(2,0) = 3 phi^2 / K_2
    k2 = 1 - 16 * phi + 72 * phi**2
    expected = (2 * phi - 12 * phi**2 - 2.5 * 3 * phi**2) / k2
    assert largest_crosstalk().short_range == pytest.approx(expected, rel=1e-9)
    every_second = (3 * phi**2) / k2  # rho(2,0) is rho(1,0) there, and nothing reaches farther
    assert largest_crosstalk(2).short_range == pytest.approx(every_second, rel=1e-9)


@pytest.mark.parametrize("apart", [1, 2])
def test_the_largest_crosstalk_stays_within_its_bounds(apart):
    taps = crosstalk_kernel(0.02)
    white = np.random.default_rng(8).standard_normal((12, 514, 514))
    noise = signal.fftconvolve(white, taps[None], mode="valid", axes=(1, 2))
    images = noise[:, ::apart, ::apart].astype(np.float32)
    bound, seen = largest_crosstalk(apart), lag_correlation(images)
    assert abs(seen.short_range - bound.short_range) < 5 * 2.7 * seen.se
    bend, se = octave_spectrum(images).concavity()
    assert bend < bound.concavity + 5 * se
    assert abs(1 - exceedance(images).extremes - bound.extremes) < 0.005


@pytest.mark.parametrize("ea", [0.55, 0.65, 0.9])
def test_the_bound_on_shot_noise_is_never_below_the_truth(ea):
    temperatures = [25.0, 45.0, 65.0]
    shot = np.array([0.4 * arrhenius(t, 25.0, ea) for t in temperatures])
    variance = 0.6 + shot
    others = [(float(v), t) for v, t in zip(variance, temperatures, strict=True)]
    share = shot_share(float(variance[0]), 25.0, others)
    assert 0.4 <= share <= 1.0
    assert shot_share(1.0, None, []) == 1.0


@pytest.mark.parametrize("marginal", MARGINALS)
def test_texture_of_independent_pixels_is_even_whatever_their_tails(marginal):
    t = texture(_images(marginal, 5))
    assert abs(t.dispersion - 1) < 5 * t.dispersion_se
    assert abs(t.hh_excess) < 5 * t.hh_se


def test_equal_neighbours_are_as_frequent_as_equal_strangers():
    frames = np.round(_images("normal", 6) * 2)
    own, far, pixels = equal_neighbours(frames)
    assert abs(own - far) < 5 * np.sqrt(2 * far / pixels)


def test_order_in_time_is_exchangeable_even_for_coarse_codes():
    rng = np.random.default_rng(7)
    offsets = rng.uniform(-1, 1, (160, 160))
    frames = np.round(offsets + 0.4 * rng.standard_normal((8, 160, 160))).astype(np.float32)
    found = autocorrelation(frames)
    assert found is not None
    assert abs(found.excess) < 5 * found.se


def test_the_memory_of_a_recursive_filter_comes_back():
    assert expected_excess(0.0, 8) == pytest.approx(0.0, abs=1e-12)
    assert memory_of(expected_excess(0.35, 8), 8) == pytest.approx(0.35, abs=1e-6)


@pytest.mark.parametrize("marginal", MARGINALS)
def test_pixels_stand_out_of_their_neighbours_as_often_as_of_others(marginal):
    frames = _images(marginal, 8)
    out = standing_out([frames], 1, 1.0)
    for found in (out.difference, out.ratio, *map(out.along, SLOPES)):
        enough = found.control > 50
        low = stats.poisson.ppf(1e-6, found.control[enough])  # two rings: the control is rarer
        assert np.all(found.own[enough] >= low * 0.9)


def test_chance_matches_of_neighbours_are_those_of_a_ring_elsewhere():
    frames = np.round(_images("normal", 9, (4, 200, 200)) * 1.5)
    found = replaced(frames, 1.0, 1.5)
    spread = np.sqrt(found.own + found.control + 1)
    assert np.all(found.own - found.control < 5 * spread)


def test_saturated_neighbours_are_no_copies_of_one_another():
    """Two at the top in all frames but one, in which both lack as much."""
    rng = np.random.default_rng(9)
    frames = np.round(rng.normal(100, 3, (8, 120, 120))).astype(np.float32)
    for y, x in [(y, x) for y in range(10, 110, 10) for x in range(10, 110, 10)]:
        frames[:, y, x : x + 2] = 255
        frames[rng.integers(8), y, x : x + 2] -= 4
    assert replaced(frames, 1.0, 3.0).own[RULES.index("copy of a neighbour")] == 0


@pytest.mark.slow
def test_p_values_of_rows_and_chords_hold_for_the_largest_of_many():
    """Of 400 images of white noise 4 are expected below .01; chords overlap, so fewer."""
    rng = np.random.default_rng(11)
    rows, bends = [], []
    for _ in range(400):
        image = rng.standard_normal((1, 96, 96)).astype(np.float32)
        found, spectrum = row_phase(image), octave_spectrum(image)
        rows.append(found.p * found.tried)
        rise, se = spectrum.concavity()
        bends.append(spectrum.independent_chords * stats.norm.sf(rise / se))
    assert np.sum(np.array(rows) < 0.01) <= 14  # 5 standard deviations above
    assert np.sum(np.array(bends) < 0.01) <= 14


def test_no_row_phase_departs_in_exchangeable_rows_of_unequal_noise():
    images = _images("normal", 10) * (1 + (np.arange(200) % 4 == 1))[None, :, None]
    found = row_phase(images.astype(np.float32))
    assert found.z < 5.5


def test_holm_against_its_definition():
    p = np.array([0.01, 0.04, 0.03, 0.005])
    assert holm(p) == pytest.approx([0.03, 0.06, 0.06, 0.02])


@pytest.mark.parametrize(
    ("rows", "columns", "gone"),
    [
        ((0.12, 0.01, 0.0), (0.13, 0.01, 0.0), True),  # a slight blur
        ((0.378, 0.251, 0.217), (0.132, 0.014, 0.007), True),  # the same under 1/f of the scan
        ((0.741, 0.618, 0.56), (-0.02, -0.01, 0.0), False),  # 1/f noise over the scan
        ((0.307, 0.126, 0.091), (0.304, 0.122, 0.09), False),  # 1/f noise over the frame
        ((0.5, 0.25, 0.125), (0.0, 0.0, 0.0), False),  # a slow amplifier
        ((0.0, 0.0, 0.0), (0.2, 0.0, 0.0), False),  # columns alone
    ],
)
def test_only_a_blur_in_both_directions_is_short_ranged(rows, columns, gone):
    for pair in ((rows, columns), (columns, rows)):
        assert (LagCorrelation(*pair, 0.0, 1e-3, 1.0).short_range_under_flicker > 0.03) == gone


@pytest.mark.parametrize(
    ("shared", "nearly", "times"),
    [(0.0, 100, 1.0), (0.01, 100, 1.4), (0.0, 990, (995 / 105) ** (8 / 7)),
     (0.1, 990, (995 / 105) ** (8 / 7))],
)  # fmt: skip
def test_matches_by_chance_are_told_by_those_in_all_frames_but_one(shared, nearly, times):
    """Of coarse codes too, whose correlation does not show in the noise."""
    none = np.zeros(len(RULES), int)
    own, control, almost, others = (none + n for n in (200, 9, nearly, 100))
    sites = Replaced(own, control, almost, others, np.empty((0, 3), int), 50_000, 8)
    seen = SimpleNamespace(
        replaced=sites,
        listed=None,
        view="frame",
        point=SimpleNamespace(temperature_c=None),
        correlation=SimpleNamespace(along_rows=(shared, 0.0), along_columns=(0.0, 0.0)),
    )
    (asked,) = tests.sites(seen)
    assert asked.effect_size == pytest.approx(20.0)
    assert asked.limit == pytest.approx(5.0 * times)


def _seen(view: str, variance: float) -> SimpleNamespace:
    """Evidence of a setting, its noise correlated by .03 with next neighbours alone."""
    lag = LagCorrelation((0.03, 0.0, 0.0), (0.03, 0.0, 0.0), 0.0, 1e-3, variance)
    return SimpleNamespace(
        view=view, usable=True, temporal=True, fine=True, correlation=lag,
        point=SimpleNamespace(temperature_c=None, gain=1.0, channel=None), equal=(0.1, 0.1, 10000),
        spectrum=SimpleNamespace(concavity=lambda: (0.0, 0.01), independent_chords=6),
        extremes=SimpleNamespace(extremes=1.0, se=0.01),
        texture=SimpleNamespace(
            dispersion=1.0, dispersion_se=0.1, hh_excess=0.0, hh_se=0.1, hh_kurtosis=3.0
        ),
    )  # fmt: skip


def test_crosstalk_may_correlate_neighbours_but_hardly_those_of_a_colour():
    for view, told in (("frame", False), ("planes", True)):
        asked = {a.test: a for a in tests.smoothing(_seen(view, 1.0), [])}
        found = asked["crosstalk_or_denoise"]
        assert (found.effect_size > found.limit) == told


def test_a_denoise_may_show_at_any_setting_within_a_colour_and_at_the_quietest_in_the_frame():
    seen = [_seen(view, variance) for view in ("frame", "planes") for variance in (1.0, 4.0, 9.0)]
    judges = verdict._quietest(seen)
    assert [id(e) in judges for e in seen] == [True, True, False, True, True, True]


@pytest.mark.parametrize("images", [1, 4])
def test_the_error_of_an_octaves_power_is_its_scatter(images):
    """Over 200 draws of white noise; the scatter of 200 is known to 5 %."""
    rng = np.random.default_rng(3)
    drawn = [
        octave_spectrum(rng.standard_normal((images, 64, 64)).astype(np.float32))
        for _ in range(200)
    ]
    ln = np.array([d.log_power for d in drawn])
    known = np.isfinite(ln).all(axis=0)
    ratio = ln[:, known].std(axis=0) / drawn[0].se[known]
    assert np.all(np.abs(ratio - 1) < 0.2)
    assert abs(ratio.mean() - 1) < 0.06
