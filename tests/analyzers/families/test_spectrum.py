"""Spectra against closed forms: white, 1/rho of line offsets, the 3x3 kernel, sine waves."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from structure_frames import (
    accumulated,
    log_pull,
    scatter_over_error,
    sensor,
    values,
    white,
)

from dnanalyze.analyzers.families import spectrum
from dnanalyze.analyzers.spectra.modes import (
    good_size,
    modes_of,
    power_of,
    reduce_power,
)
from dnanalyze.analyzers.spectra.peaks import largest_peak
from dnanalyze.analyzers.streaming.accumulation import Accumulation, accumulate, make_plan

NUMBERS = ("0016", "0072", "0073")  # -15 C; the last two below -60 C
POWERS = ("psd", "columns", "rows", "u", "v")


def is_power(name: str) -> bool:
    return name.split("_")[1] in POWERS


def test_white_noise_is_flat_at_its_variance_in_every_band():
    frames = white(np.random.default_rng(1), (200, 240), 5, sd=2.0)
    found = values(spectrum, frames)
    expected = {"frame": 4.0, "pattern": 4.0 / 5, "temporal": 4.0}
    checked = 0
    for name, value in found.items():
        if is_power(name):
            # 70 bands: 5 sigma; few modes are skewed on the log scale, hence the 0.3
            assert abs(log_pull(value, expected[name.split("_")[0]])) < 5, name
            checked += 1
    assert checked > 60


def test_total_is_pattern_plus_temporal_power():
    frames = [f.astype(float) for f in sensor(np.random.default_rng(2), (96, 128), 6)]
    acc = accumulated(frames)
    total, temporal = acc.spectra.frame_power(), acc.spectra.temporal_power()
    mean = power_of(np.mean([np.clip(f - acc.plan.centre, *limits(acc)) for f in frames], axis=0))
    np.testing.assert_allclose(total, mean + temporal * 5 / 6, rtol=1e-4, atol=1e-6)
    # and against a plain discrete Fourier transform
    plain = [np.abs(np.fft.rfft2(np.clip(f - acc.plan.centre, *limits(acc)))) ** 2 for f in frames]
    plain = np.mean(plain, axis=0) / frames[0].size
    plain[0, 0] = 0
    np.testing.assert_allclose(total, plain, rtol=1e-3, atol=1e-4)


def limits(acc):
    return -6 * acc.plan.sigma, 6 * acc.plan.sigma


def test_line_offsets_make_a_full_radial_1_over_rho_and_stay_off_the_masked_one():
    rng = np.random.default_rng(3)
    n, sc, sr, images = 384, 0.6, 0.4, 12
    modes = modes_of((n, n))
    full, masked = np.zeros(modes.count.size), np.zeros(modes.count.size)
    for _ in range(images):
        offsets = sc * rng.normal(size=(1, n)) + sr * rng.normal(size=(n, 1))
        reduced = reduce_power(power_of(rng.normal(size=(n, n)) + offsets), modes)
        full += np.nan_to_num(reduced.radial_mean_full()) / images
        masked += np.nan_to_num(reduced.radial_mean()) / images
    for low, high in ((0.02, 0.08), (0.08, 0.16), (0.16, 0.25), (0.25, 0.5)):
        where = modes.bins(low, high)
        weight = modes.count[where] + sum(
            np.bincount(b, minlength=modes.count.size)[where] for b in modes.axis_bin
        )
        # the mean of 1/rho over a ring is 2 / (low + high)
        beyond = (sc**2 + sr**2) * 2 / (np.pi * (low + high))
        axis = (high - low) * n  # modes of each axis; the grid rounds their number
        chance = np.sqrt((sc**4 + sr**4) / (sc**2 + sr**2) ** 2 / (images * axis)) + 1 / axis
        seen = np.average(full[where], weights=weight)
        assert abs(seen - 1 - beyond) < 4.5 * beyond * chance + 0.01
        count = modes.count[where]
        flat = np.average(masked[where], weights=count)
        assert abs(flat - 1) < 4.5 / np.sqrt(images * count.sum())


def test_the_papers_kernel_has_its_spectrum():
    """PSD = V |K|^2 + 9 sigma^2 m2 of the random-kernel log-normal model, with the seed redrawn."""
    rng = np.random.default_rng(4)
    delta, phi, sigma, shape = 0.3, 0.05, 0.02, (256, 256)
    q = np.exp(delta**2)
    m1 = np.exp(delta**2 / 2)
    m2, variance = m1**2 * q, m1**2 * (q - 1)
    frames = []
    for _ in range(5):
        seed = rng.lognormal(0, delta, (shape[0] + 2, shape[1] + 2))
        frame = np.zeros(shape)
        for dy in range(3):
            for dx in range(3):
                centre = dx == dy == 1
                kernel = (1 - 8 * phi if centre else phi) + sigma * rng.normal(size=shape)
                frame += kernel * seed[dy : dy + shape[0], dx : dx + shape[1]]
        frames.append(frame)
    found = values(spectrum, frames)
    v = np.fft.fftfreq(shape[0])[:, None]
    u = np.fft.fftfreq(shape[1])[None, :]
    transfer = (1 - 9 * phi) + phi * (1 + 2 * np.cos(2 * np.pi * u)) * (
        1 + 2 * np.cos(2 * np.pi * v)
    )
    psd = variance * transfer**2 + 9 * sigma**2 * m2
    rho, off = np.hypot(u, v), (u != 0) & (v != 0)
    for low, high in ((0.04, 0.08), (0.08, 0.16), (0.16, 0.25), (0.25, 0.35), (0.35, 0.5)):
        expected = psd[off & (rho >= low) & (rho < high)].mean()
        value = found[f"temporal_psd_{low:g}_{high:g}"]
        # winsorising at 6 robust sigma takes less than .2 % of the variance of this law
        assert abs(np.log(value.value / expected)) < 4.5 * value.se + 0.002


def test_a_sine_wave_is_found_at_its_frequency_with_its_amplitude():
    rng = np.random.default_rng(5)
    rows, columns, amplitude = 160, 200, 0.5
    y, x = np.indices((rows, columns))
    u, v = 23 / columns, -31 / rows
    frames = [
        f + amplitude * np.sin(2 * np.pi * (u * x + v * y + rng.random()))
        for f in white(rng, (rows, columns), 6)
    ]
    found = values(spectrum, frames)
    for name, at in (("temporal_line_u", u), ("temporal_line_v", v)):
        assert abs(found[name].value - at) < 4 * found[name].se
    # the mean of six random phases takes 1/sqrt(30) of the power, on one standard deviation
    power = (found["temporal_line_amplitude"].value / amplitude) ** 2
    assert abs(power - 1) < 5 * np.sqrt(1 / 30 + 36 / (amplitude**2 * rows * columns * 5))
    assert abs(log_pull(found["temporal_line"], 1 + amplitude**2 * rows * columns / 4)) < 5


def test_a_wave_between_two_modes_is_still_a_line():
    rng = np.random.default_rng(6)
    y, x = np.indices((180, 180))
    wave = 2.0 * np.sin(2 * np.pi * ((30.5 * x + 40.5 * y) / 180))
    peak = largest_peak(power_of(rng.normal(size=(180, 180)) + wave), (180, 180), 1)
    assert peak is not None
    assert peak.real
    assert peak.ratio > 100
    # three of the modes along each axis hold .855 of its power
    assert abs(peak.amplitude - 2 * 0.855) < 5 * 2 / 180
    assert abs(peak.u * 180 - 30.5) <= 0.5
    assert abs(peak.v * 180 - 40.5) <= 0.5


@pytest.mark.parametrize("repeats", [1, 5])
def test_without_a_line_the_peak_follows_gumbels_law(repeats):
    rng = np.random.default_rng(7)
    logs, errors, false = [], [], 0
    for _ in range(200):
        power = np.mean([power_of(rng.normal(size=(96, 96))) for _ in range(repeats)], axis=0)
        peak = largest_peak(power, (96, 96), repeats)
        assert peak is not None
        logs.append(np.log(peak.ratio))
        errors.append(peak.log_error)
        false += peak.real
    # the sample deviation of 200 has 5 % error, Gumbel's law about twice that
    assert 0.6 < np.std(logs) / np.mean(errors) < 1.4
    assert false <= 3  # .2 expected


def test_odd_and_even_columns_stand_at_the_nyquist_mode():
    rng = np.random.default_rng(8)
    frames = white(rng, (128, 160), 4)
    for f in frames:
        f[:, ::2] += 0.5
    found = values(spectrum, frames)
    # (offset/2)^2 of every pixel in one mode, over the mean of four frames
    expected = 1 + 0.25**2 * 128 * 160 * 4
    assert (
        abs(np.log1p(found["pattern_nyquist_10"].value) - np.log1p(expected))
        < 5 * found["pattern_nyquist_10"].se
    )
    assert found["pattern_nyquist_01"].value < 30  # chi-square of one degree
    assert found["pattern_nyquist_11"].value < 30


def test_a_slope_is_that_of_the_noise():
    rng = np.random.default_rng(9)
    shape = (256, 256)
    f = np.hypot(np.fft.fftfreq(shape[0])[:, None], np.fft.rfftfreq(shape[1]))
    f[0, 0] = 1
    pink = np.fft.irfft2(np.fft.rfft2(rng.normal(size=shape)) * f**-0.75, s=shape)
    found = values(spectrum, [100 + pink])
    for band in ("low", "mid", "high"):
        value = found[f"frame_slope_{band}"]
        # a rectangular window leaks: the images here are periodic, so it does not
        assert abs(value.value + 1.5) < 5 * value.se + 0.02, band
    assert value.se < 0.05


def test_corner_frequency_of_pink_over_white():
    rng = np.random.default_rng(10)
    shape, corner = (300, 300), 0.05
    f = np.hypot(np.fft.fftfreq(shape[0])[:, None], np.fft.rfftfreq(shape[1]))
    f[0, 0] = 1
    shaped = np.fft.rfft2(rng.normal(size=shape)) * np.sqrt(1 + (corner / f) ** 2)
    found = values(spectrum, [100 + np.fft.irfft2(shaped, s=shape)])
    # power 1 + (fc / f)^2 is twice its floor at fc; the mean above 1/4 is .02 above 1
    assert found["frame_corner_frequency"].value == pytest.approx(corner, rel=0.2)


def test_period_three_columns_whose_phase_moves_show_at_one_third():
    rng = np.random.default_rng(11)
    frames = white(rng, (120, 180), 4)
    for n, f in enumerate(frames):
        f[:, n % 3 :: 3] += 3
    curves = spectrum.finish(accumulated(frames)).curves
    f, power = curves["column_spectrum_f"], curves["temporal_column_spectrum"]
    assert f[np.argmax(power)] == pytest.approx(1 / 3)
    others = np.delete(power, np.argmax(power))
    assert power.max() > 100 * others.max()


@pytest.mark.parametrize("shape", [(16, 16), (17, 41), (9, 200)])
@pytest.mark.parametrize("count", [1, 2, 3])
def test_small_frames_give_finite_values_or_a_reason(shape, count):
    result = spectrum.finish(accumulated(sensor(np.random.default_rng(12), shape, count)))
    names = {info.name for info in spectrum.INFOS}
    assert set(result.values) <= names
    for name, value in result.values.items():
        assert np.isfinite([value.value, value.se]).all(), name
        assert value.se > 0, name
    if count == 1:
        assert all(name.startswith("frame_") for name in result.values)
        assert "spectrum" in result.missing
    else:
        told = set(result.values) | set(result.missing)
        assert {n for n in names if not n.startswith("frame_")} <= told
        assert not any(n.startswith(("frame_columns", "frame_rows", "frame_line")) for n in told)


def test_a_single_frame_has_the_power_of_its_columns_and_its_lines():
    rng = np.random.default_rng(15)
    rows, columns, offset, amplitude = 240, 360, 0.5, 0.8
    frame = white(rng, (rows, columns), 1) + rng.normal(0.0, offset, columns)
    u, v = 50 / columns, 30 / rows
    y, x = np.mgrid[:rows, :columns]
    frame[0] += amplitude * np.sin(2 * np.pi * (u * x + v * y))
    values = spectrum.finish(accumulated(frame)).values
    noise = np.mean([values[f"frame_v_{b}"].value for b in ("0.1_0.3", "0.3_0.5")])
    for band in ("0.02_0.1", "0.1_0.3", "0.3_0.5"):
        found = values[f"frame_columns_{band}"]
        assert found.value == pytest.approx(noise + rows * offset**2, rel=5 * found.se)
    assert values["frame_rows_0.1_0.3"].value == pytest.approx(
        noise, rel=5 * values["frame_rows_0.1_0.3"].se
    )
    assert values["frame_line_u"].value == pytest.approx(u, abs=1e-3)
    assert abs(values["frame_line_v"].value) == pytest.approx(v, abs=1e-3)
    assert values["frame_line_amplitude"].value == pytest.approx(amplitude, rel=0.05)
    assert values["frame_nyquist_10"].value == pytest.approx(
        1.0, abs=5 * values["frame_nyquist_10"].se
    )


def test_constant_frames_have_no_power():
    result = spectrum.finish(accumulated([np.full((64, 64), 7, np.uint16)] * 3))
    assert not result.values
    assert result.missing["temporal_psd_0.08_0.16"]


def test_large_prime_sides_are_cropped_by_a_few_lines():
    for size in range(8, 3000):
        good = good_size(size)
        assert good % 2 == 0
        assert size - good <= max(1, 0.03 * size)
    assert [good_size(n) for n in (2048, 1024, 2039, 26)] == [2048, 1024, 2016, 26]


@settings(max_examples=25, deadline=None)
@given(st.integers(1, 6), st.integers(0, 2**32 - 1))
def test_merging_equals_one_pass(cut, seed):
    frames = sensor(np.random.default_rng(seed), (20, 34), 7)
    plan = make_plan(frames[0], frames[1])
    whole = accumulate(frames, plan)
    first, later = accumulate(frames[:cut], plan), accumulate(frames[cut:], plan, cut)
    first.merge(later)
    a, b = parts(whole), parts(first)
    np.testing.assert_allclose(b.power_sum, a.power_sum, rtol=1e-12, atol=1e-9)
    np.testing.assert_allclose(b.sum, a.sum, rtol=1e-12, atol=1e-9)
    assert b.frames == a.frames


def parts(accumulation: Accumulation):
    return accumulation.parts["spectra"]


def test_errors_are_those_of_independent_captures():
    captures = [sensor(np.random.default_rng((13, k))) for k in range(80)]
    ratios = scatter_over_error(spectrum, captures)
    assert len(ratios) > 60
    # 80 captures: the scatter has 8 % error; over 80 statistics 4 sigma, and honest to 25 %
    for name, ratio in ratios.items():
        assert 0.6 < ratio < 1.5, (name, ratio)
    assert 0.85 < np.median(list(ratios.values())) < 1.15


def test_known_spectra_of_a_cooling_sensor(captures_root):
    """Seen with independent code: red when warm, white below -60 C, columns of period three."""
    fits = pytest.importorskip("astropy.io.fits")
    folder = captures_root / "real" / "fp30_cooling"
    frames = {n: fits.getdata(folder / f"dark_{n}.fits").astype(np.float32) for n in NUMBERS}
    warm = values(spectrum, [frames["0016"][:, :1024]])
    cold = values(spectrum, [frames["0072"][:, :1024]])
    low, mid = "frame_psd_0.01_0.02", "frame_psd_0.08_0.16"
    assert warm[low].value > 20 * warm[mid].value
    assert 0.3 < cold[low].value / cold[mid].value < 1.2
    curves = spectrum.finish(accumulated([frames["0072"], frames["0073"]])).curves
    strongest = np.argmax(curves["temporal_column_spectrum"])
    assert curves["column_spectrum_f"][strongest] == pytest.approx(1 / 3, abs=1e-3)


def test_the_quiet_ratio_does_not_see_hits_that_span_pixels():
    rng = np.random.default_rng(31)
    (frame,) = white(rng, (256, 256), 1)
    for r, c in rng.integers(2, 254, (300, 2)):
        frame[r - 1 : r + 1, c - 1 : c + 1] += 60.0
    found = values(spectrum, [frame])
    assert found["frame_hf_mf"].value < 0.8
    quiet = found["frame_hf_mf_quiet"]
    # what is cut out is white too: the ratio of white noise is 1; 5 standard errors
    assert abs(np.log(quiet.value)) < 5 * quiet.se
