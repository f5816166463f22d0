"""Hot pixels, clusters, quantised dark current and blinking against their closed forms."""

import itertools

import numpy as np
import pytest
from charge_bench import HERE, LOUD, WARM, MadeUpClues, frames, growth
from scipy import stats

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effects.dark_current_steps import DarkCurrentSteps
from dnanalyze.model.effects.hot_clusters import HotClusters
from dnanalyze.model.effects.hot_pixels import HotPixels
from dnanalyze.model.effects.rts import LEAST_CHANGED, LEAST_RETURNED, Rts
from dnanalyze.model.guesses.hot_peaks import peaks
from dnanalyze.model.guesses.rts import SLOW
from dnanalyze.model.hot_signal import HotSignal
from dnanalyze.thermal import arrhenius

N = 512 * 512
SHAPE = (512, 512)


def test_hot_pixels_are_an_exponential_population():
    p, nu = 0.02, 40.0
    y = frames(HotPixels(fraction=p, scale=nu), SHAPE, 2)
    np.testing.assert_array_equal(y[0], y[1])
    hot = y[0][y[0] > 0]
    assert abs(hot.size - N * p) < 5 * np.sqrt(N * p)
    assert stats.kstest(hot, "expon", (0, nu)).pvalue > 1e-6
    expected = HotPixels(fraction=p, scale=nu).variance(HERE)
    # fourth moment p 24 nu^4
    assert abs(y[0].var() - expected) < 5 * nu**2 * np.sqrt(24 * p / N)


def test_hot_pixels_follow_their_activation_energy_and_the_gain():
    effect = HotPixels(fraction=0.02, scale=40.0, ea_ev=0.5)
    a = frames(effect)
    np.testing.assert_allclose(frames(effect, point=WARM), growth(0.5) * a, rtol=1e-5)
    np.testing.assert_allclose(frames(effect, point=LOUD), 2 * a, rtol=1e-5)


def test_a_larger_fraction_keeps_the_old_hot_pixels():
    few, many = (frames(HotPixels(fraction=p, scale=40.0)) for p in (0.01, 0.011))
    assert (many[few > 0] > 0).all()
    assert (many >= few).all()
    assert (many - few).max() == pytest.approx(40 * np.log(1.1), rel=1e-4)


def _counts(fraction, scale, sigma, pixels):
    return {
        f"hot_count_{k}": pixels * fraction * np.exp(-k * sigma / scale)
        for k in (5, 8, 16, 32, 64, 128)
    }


def test_hot_pixels_are_guessed_from_the_counts_over_temperature():
    points = tuple(OperatingPoint(t, 1.0, 1.0) for t in (25.0, 45.0, 65.0))
    scale = 60.0 * np.array([arrhenius(t.temperature_c, 25.0, 0.5) for t in points])
    sigma = np.array([3.0, 5.0, 9.0])
    seen = _counts(2e-3, scale, sigma, N) | {"pattern_noise_core": sigma}
    model = dict.fromkeys(_counts(1, 1, 1, 1), 0.0)
    clues = MadeUpClues(points, HERE, SHAPE, seen, model, ("hot_count_16",))
    together, each, _ = HotPixels.guess(clues)
    for guess in (together, each):
        assert guess.fraction == pytest.approx(2e-3, rel=0.3)
        assert guess.scale == pytest.approx(60, rel=0.2)
        assert guess.ea_ev == pytest.approx(0.5, abs=0.05)
    clues.stands_out = ("hot_pairs", "hot_count_16")
    small, large, *again = HotClusters.guess(clues)
    assert len(again) == 4
    for guess in (small, large, *again[:2]):
        assert guess.density * guess.members == pytest.approx(2e-3, rel=0.3)
    assert small.radius < large.radius


def test_where_only_warm_frames_show_hot_pixels_the_cold_ones_tell_their_energy_too():
    """At 45 C the mean signal is 1.5 robust sigmas; colder, a few stray pixels stand out."""
    points = tuple(OperatingPoint(t, 1.0, 1.0) for t in (5.0, 25.0, 45.0, 65.0, 85.0))
    scale = 12.0 * np.array([arrhenius(t.temperature_c, 45.0, 0.9) for t in points])
    sigma = np.array([8.0, 8.0, 8.0, 11.0, 50.0])
    expected = _counts(1e-3, scale, sigma, N)
    seen = {k: np.random.default_rng(4).poisson(v) for k, v in expected.items()}
    seen["hot_count_5"][:2] += 3
    seen["pattern_noise_core"] = sigma
    model = dict.fromkeys(expected, 0.0)
    clues = MadeUpClues(points, points[2], SHAPE, seen, model, ("hot_count_16",))
    guess, *_ = HotPixels.guess(clues)
    # 9 pixels in 100 lie beyond 5 sigma at 65 C: two dozen tell the energy
    assert guess.ea_ev == pytest.approx(0.9, abs=0.1)
    assert guess.scale == pytest.approx(12.0, rel=0.3)
    assert guess.fraction == pytest.approx(1e-3, rel=0.3)


def test_where_none_is_left_as_many_as_are_usual_are_tried():
    """Neighbours of each other stay where a correction took the rest, and tell nothing of it."""
    points = (HERE, WARM)
    sigma = np.array([3.0, 12.0])
    counts = dict.fromkeys(_counts(1, 1, 1, 1), np.zeros(2))
    (usual,) = HotPixels.guess(_hot(counts, sigma, points))
    assert usual.fraction == 1e-3
    assert usual.scale * growth(0.55) == pytest.approx(30.0 * 12.0)  # where it is most
    counts["pattern_noise_core"] = counts["frame_noise_core"] = np.full(2, np.nan)
    assert HotPixels.guess(_hot(counts, np.full(2, np.nan), points)) == []


def _hot(expected, sigma, points, model=None):
    """Clues of these counts over thresholds."""
    seen = expected | {"pattern_noise_core": sigma}
    model = model or dict.fromkeys(expected, 0.0)
    return MadeUpClues(points, points[0], SHAPE, seen, model, ("hot_count_16",))


def test_the_hot_signal_is_that_of_the_reference_exposure_and_gain():
    points = (HERE, OperatingPoint(25.0, 4.0, 1.0), OperatingPoint(25.0, 1.0, 2.0))
    scale, sigma = np.array([60.0, 240.0, 120.0]), np.array([3.0, 3.0, 6.0])
    guess, *_ = HotPixels.guess(_hot(_counts(2e-3, scale, sigma, N), sigma, points))
    assert guess.scale == pytest.approx(60.0, rel=0.1)
    assert guess.fraction == pytest.approx(2e-3, rel=0.1)
    counts = _counts(2e-3, scale, sigma, N)
    counts["hot_count_64"][[0, 2]] = np.nan
    guess, *_ = HotPixels.guess(_hot(counts, sigma, points))  # what is not known is left out
    assert guess.scale == pytest.approx(60.0, rel=0.1)


def test_where_a_correction_took_those_of_cold_frames_each_setting_is_read_by_itself():
    points = tuple(OperatingPoint(t, 1.0, 1.0) for t in (25.0, 45.0, 65.0))
    scale = 60.0 * np.array([arrhenius(t.temperature_c, 25.0, 0.5) for t in points])
    sigma = np.array([3.0, 5.0, 9.0])
    left = np.array([0.0, 1.0, 1.0])
    counts = {k: n * left for k, n in _counts(2e-3, scale, sigma, N).items()}
    together, each, _ = HotPixels.guess(_hot(counts, sigma, points))
    assert each.ea_ev == pytest.approx(0.5, abs=0.02)
    assert each.scale == pytest.approx(60.0, rel=0.05)
    assert together.ea_ev > 1.0  # none may reach there


@pytest.mark.parametrize("temperature_c", [None, 25.0])
def test_where_no_two_temperatures_tell_the_energy_it_is_the_usual_one(temperature_c):
    points = tuple(OperatingPoint(temperature_c, t, 1.0) for t in (1.0, 4.0))
    sigma = np.array([3.0, 3.0])
    counts = _counts(2e-3, np.array([60.0, 240.0]), sigma, N)
    guess, *_ = HotPixels.guess(_hot(counts, sigma, points))
    assert guess.ea_ev == 0.55
    assert guess.scale == pytest.approx(60.0, rel=0.1)  # tried in steps of an eighth


@pytest.mark.parametrize("crowd", [8000.0, -30_000.0])
def test_many_pixels_just_over_the_noise_do_not_hide_a_tail(crowd):
    """As where a log-normal ends in another way than the model's."""
    points, sigma = (HERE, WARM), np.array([3.0, 5.0])
    scale = 150.0 * np.array([1.0, growth(0.6)])
    counts = _counts(1e-3, scale, sigma, N)
    counts["hot_count_5"] = counts["hot_count_5"] + np.array([0.0, max(crowd, 0.0)])
    model = dict.fromkeys(counts, 0.0) | {"hot_count_5": np.array([0.0, max(-crowd, 0.0)])}
    guess, *_ = HotPixels.guess(_hot(counts, sigma, points, model))
    assert guess.fraction == pytest.approx(1e-3, rel=0.3)
    assert guess.scale == pytest.approx(150.0, rel=0.3)


def test_clusters_have_the_mean_and_variance_of_a_neyman_scott_process():
    effect = HotClusters(density=1e-3, members=5.0, radius=1.5, scale=10.0)
    y = np.stack([frames(effect, SHAPE, seed=s)[0] for s in range(6)])
    d, m, nu = 1e-3, 5.0, 10.0
    # sum over a cluster: compound Poisson, mean m nu, second moment 2 m nu^2 + (m nu)^2
    clusters = d * y.size
    lost = 0.004  # at the border: less than a ring of 2 pixels
    spread = 5 * nu * np.sqrt((2 * m + m * m) / clusters) / (m * nu)
    assert abs(y.mean() / (d * m * nu) - 1) < spread + lost
    each = y.var(axis=(1, 2))
    scatter = each.std(ddof=1) / np.sqrt(6)
    assert abs(each.mean() - effect.variance(HERE)) < 6 * scatter  # t with 5 degrees of freedom


def test_clusters_hold_their_radius_and_their_pairs():
    effect = HotClusters(density=2e-4, members=6.0, radius=2.0, scale=10.0)
    hot = frames(effect, SHAPE)[0] > 0

    def pairs(dy, dx):
        return np.mean(hot[: 512 - dy, : 512 - dx] & hot[dy:, dx:]) / hot.mean() ** 2

    assert pairs(0, 1) > 20  # pair correlation inside a cluster ~ m / (d m pi r^2)
    chance = pairs(11, 17)
    count = N * hot.mean() ** 2
    assert abs(chance - 1) < 5 * np.sqrt(36 / count)  # clusters of about 6 count as one


def test_steps_are_poisson_multiples():
    effect = DarkCurrentSteps(step=7.0, mean_number=0.8, ea_ev=0.35)
    y = frames(effect, SHAPE, 2)
    np.testing.assert_array_equal(y[0], y[1])
    n = np.rint(y[0] / 7)
    np.testing.assert_allclose(y[0], 7 * n, rtol=1e-6)
    expected = stats.poisson.pmf(np.arange(7), 0.8) * N
    seen = np.bincount(n.astype(int).ravel(), minlength=7)[:7]
    assert (np.abs(seen - expected) < 5 * np.sqrt(expected) + 1).all()
    assert abs(y[0].var() - effect.variance(HERE)) < 5 * 49 * np.sqrt((2 * 0.64 + 0.8) / N)
    np.testing.assert_allclose(frames(effect, SHAPE, point=WARM)[0], growth(0.35) * y[0], rtol=1e-5)


@pytest.mark.parametrize("number", [1e-4, 0.3, 6.0, 19.0])
def test_steps_have_the_right_number_from_few_to_many(number):
    n = frames(DarkCurrentSteps(step=1.0, mean_number=number), SHAPE)[0]
    assert abs(n.mean() - number) < 5 * np.sqrt(number / N)
    assert abs(n.var() - number) < 5 * np.sqrt((2 * number**2 + number) / N)


def test_steps_are_guessed_from_the_spacing_of_the_peaks():
    points = tuple(OperatingPoint(t, 1.0, 1.0) for t in (25.0, 45.0, 65.0))
    spacing = [12.0 * arrhenius(p.temperature_c, 25.0, 0.37) for p in points]
    clues = MadeUpClues(points, seen={"pattern_step_dn": spacing}, stands_out=("pattern_steps",))
    guesses = DarkCurrentSteps.guess(clues)
    assert all(g.step == pytest.approx(12, rel=1e-3) for g in guesses)
    assert all(g.ea_ev == pytest.approx(0.37, abs=1e-3) for g in guesses)


@pytest.mark.parametrize("amplitudes", ["fixed", "exponential"])
def test_blinking_pixels_have_two_levels_and_the_variance_of_the_closed_form(amplitudes):
    p, a, o = 0.2, 30.0, 0.3
    effect = Rts(p, a, o, 0.05, 0.0, amplitudes, "none")
    y = frames(effect, (256, 256), 40)
    n = y[0].size
    blinks = y.max(axis=0) > 0  # off in all of 40 frames: .7^40 < 1e-6
    assert abs(blinks.sum() - n * p) < 5 * np.sqrt(n * p * (1 - p))
    levels = [np.unique(pixel).size for pixel in y[:, blinks].T[:500]]
    assert set(levels) <= {1, 2}
    share = (y[:, blinks] > 0).mean()
    assert abs(share - o) < 5 * np.sqrt(o * (1 - o) / (40 * blinks.sum()))
    # between two frames with dwell far below one: 2 x temporal variance = 2 E[A^2] p o (1 - o)
    square = a * a * (2 if amplitudes == "exponential" else 1)
    got = np.mean((y[1::2] - y[::2]) ** 2) / 2
    assert got == pytest.approx(
        p * o * (1 - o) * square, rel=0.08
    )  # 5 sigma: 5 sqrt(c/13000), c < 3.3
    assert y.var() == pytest.approx(effect.variance(HERE), rel=0.08)


def test_states_last_as_long_as_the_dwell_says():
    dwell, o = 3.0, 0.4
    effect = Rts(0.5, 10.0, o, dwell, 0.0, "fixed", "none")
    y = frames(effect, (200, 200), 30)
    on = (y[:, y.max(axis=0) > 0] > 0).astype(float)
    pixels = on.shape[1]
    for lag in (1, 2, 5):
        r = np.mean((on[lag:] - o) * (on[:-lag] - o)) / (o * (1 - o))
        # about 30 / (2 dwell) independent stretches in each of the pixels
        assert abs(r - np.exp(-lag / dwell)) < 5 / np.sqrt(pixels * 5)


def test_a_frame_far_on_is_drawn_without_the_frames_before_it():
    effect = Rts(0.01, 10.0, 0.5, 2.0, 0.0)
    series = frames(effect, (64, 64), 12)
    np.testing.assert_array_equal(frames(effect, (64, 64), 1, first=11)[0], series[11])
    assert frames(effect, (64, 64), 1, first=100_000)[0].any()


def test_steps_of_blinking_pixels_scale_as_told():
    thermal = Rts(0.2, 10.0, 0.5, 0.5, 0.6, "fixed")
    trap = Rts(0.2, 10.0, 0.5, 0.5, 0.0, "fixed", "none", "both")
    long_ = OperatingPoint(25.0, 3.0, 1.0)
    assert frames(thermal).max() == pytest.approx(10)
    assert frames(thermal, point=WARM).max() == pytest.approx(10 * growth(0.6), rel=1e-5)
    assert frames(thermal, point=long_).max() == pytest.approx(30)
    for point, step in ((HERE, 10), (WARM, 10), (long_, 10), (LOUD, 20)):
        y = frames(trap, point=point)
        assert (y.min(), y.max()) == (-step, step)
    assert abs(frames(trap).mean()) < 5 * 10 * np.sqrt(0.1) / 256


@pytest.mark.parametrize("point", [HERE, WARM, OperatingPoint(25.0, 4.0, 1.0), LOUD])
def test_what_steps_add_to_level_and_variance_is_what_they_draw(point):
    effect = DarkCurrentSteps(step=7.0, mean_number=0.4, ea_ev=0.35)
    drawn = frames(effect, SHAPE, point=point)
    level, variance = effect.adds(point, HERE, (256, 256))
    n = drawn.size
    assert drawn.mean() == pytest.approx(level, abs=5 * np.sqrt(variance / n))
    # fourth moment of a Poisson law: 3 + 1 / lambda
    assert drawn.var() == pytest.approx(variance, rel=5 * np.sqrt((2 + 1 / 0.4) / n))


def test_steps_of_which_many_pixels_have_one_are_counted_over_temperature():
    rng = np.random.default_rng(6)
    n, core = rng.poisson(0.3, 512 * 512), rng.lognormal(0.0, 0.3, 512 * 512)
    curves = {"pattern_hist_x": [], "pattern_hist_n": []}
    for point in (HERE, WARM):
        grown = arrhenius(point.temperature_c, HERE.temperature_c, 0.35)
        y = 2.0 * grown * core + rng.standard_normal(n.size) + 9.0 * grown * n
        counts, edges = np.histogram(y, np.arange(y.min(), y.max(), 0.05 * grown))
        curves["pattern_hist_x"].append((edges[1:] + edges[:-1]) / 2)
        curves["pattern_hist_n"].append(counts)
    clues = MadeUpClues((HERE, WARM), stands_out=("pattern_q0.99",), curves=curves)
    guess = DarkCurrentSteps.guess(clues)[0]
    assert guess.step == pytest.approx(9.0, rel=0.05)
    assert guess.mean_number == pytest.approx(0.3, rel=0.2)
    assert guess.ea_ev == pytest.approx(0.35, abs=0.02)
    clues.stands_out = ()
    assert DarkCurrentSteps.guess(clues) == []


def test_steps_seen_at_one_temperature_have_either_usual_activation_energy():
    points = HERE, WARM
    seen = {"pattern_step_dn": [np.nan, 12.0]}
    clues = MadeUpClues(points, seen=seen, stands_out=("pattern_steps",))
    guesses = DarkCurrentSteps.guess(clues)
    assert {g.ea_ev for g in guesses} == {0.35, 0.55}
    for g in guesses:
        assert g.step * growth(g.ea_ev) == pytest.approx(12.0)


def test_hot_pixels_noisier_than_their_charge_may_be_telegraph_noise():
    nu, pixels = 40.0, 512 * 512 * 0.01
    counts = {f"hot_count_{k}": pixels * np.exp(-k * 4.0 / nu) for k in (5, 8, 16, 32, 64, 128)}
    seen = {"pattern_noise_core": 4.0} | counts
    clues = MadeUpClues(seen=seen, model=dict.fromkeys(counts, 0.0))
    assert Rts.guess(clues) == []
    clues.stands_out = ("noise_at_99",)
    guess = Rts.guess(clues)[0]
    assert guess.fraction * guess.occupancy * guess.amplitude == pytest.approx(
        0.01 * nu,
        rel=0.15,  # the signal is tried in steps of an eighth
    )
    assert guess.occupancy == 0.5


def test_one_peak_of_the_dark_current_makes_no_steps():
    pixels = 512 * 512
    with_two = [
        np.sum(frames(DarkCurrentSteps(10.0, n), (512, 512), 1)[0] > 15) for n in (0.002, 0.01)
    ]
    assert with_two[0] < 5 < with_two[1]
    assert not DarkCurrentSteps(10.0, 0.002).shows_in(8, pixels)
    assert DarkCurrentSteps(10.0, 0.01).shows_in(8, pixels)


@pytest.mark.parametrize(
    ("dwell", "occupancy", "shown"),
    [(0.5, 0.5, True), (28.0, 0.5, True), (40.0, 0.5, False), (0.5, 0.1, True), (20.0, 0.1, False)],
)
def test_traps_that_hardly_change_in_the_series_are_hot_pixels(dwell, occupancy, shown):
    effect = Rts(0.2, 30.0, occupancy, dwell, 0.0, "fixed", "none")
    assert effect.shows_in(8, 256 * 256) == shown
    on = frames(effect, (256, 256), 8) > 0
    changed = np.mean(on.any(axis=0) & ~on.all(axis=0)) / 0.2
    assert (changed >= LEAST_CHANGED) == shown


def test_a_single_frame_shows_no_traps():
    assert not Rts(0.05, 30.0).shows_in(1, 256 * 256)


def test_blinking_is_guessed_from_the_noisiest_pixels():
    # a noise of 3 DN, 2 % of the pixels blink by 20 DN half of the time
    total = 9 + 0.02 * 100
    top = (9 + 100) / total
    clues = MadeUpClues(
        (HERE, WARM),
        seen={
            "temporal_noise": np.sqrt(total),
            "temporal_noise_core": 3.0,
            "temporal_variance_q0.999": top,
        },
        model={"temporal_variance_q0.999": 1.0},
        stands_out=("blink_repeat",),
    )
    guesses = Rts.guess(clues)
    fixed = next(g for g in guesses if g.amplitudes == "fixed")
    assert 10 < fixed.amplitude < 40
    assert fixed.fraction * fixed.amplitude**2 == pytest.approx(0.02 * 400, rel=0.05)
    assert fixed.exposure == "none"  # alike at both temperatures
    first = guesses  # what nearly stays shows in the pattern too
    assert {g.dwell_frames for g in first} == {0.5, SLOW}


def test_few_blinking_pixels_are_guessed_from_how_far_down_the_noise_is_higher():
    rng = np.random.default_rng(8)
    noise = 3.0 * rng.standard_normal((6, 512, 512))
    where = rng.random((512, 512)) < 0.005
    noise[:, where] += 20.0 * (rng.random((6, int(where.sum()))) < 0.5)
    variance = noise.var(axis=0, ddof=1)
    levels = (0.5, 0.9, 0.99, 0.999)
    seen = {
        f"temporal_variance_q{p:g}": np.quantile(variance, p) / variance.mean() for p in levels
    } | {"temporal_noise": np.sqrt(variance.mean()), "temporal_noise_core": 2.8}
    clues = MadeUpClues(
        seen=seen,
        model={"temporal_variance_q0.999": 0.8 * seen["temporal_variance_q0.999"]},
        stands_out=("temporal_kurtosis",),
        curves={"frame_means": [noise.mean(axis=(1, 2))]},
    )
    fixed = [g for g in Rts.guess(clues) if g.amplitudes == "fixed"]
    assert any(0.002 < g.fraction < 0.02 and 10 < g.amplitude < 30 for g in fixed)


@pytest.mark.parametrize("polarity", ["up", "both", "centred", "three"])
@pytest.mark.parametrize("occupancies", ["same", "spread"])
def test_every_kind_of_blinking_has_the_variance_of_its_closed_form(polarity, occupancies):
    p, a = 0.4, 20.0
    effect = Rts(p, a, 0.3, 0.05, 0.0, "fixed", "none", polarity, occupancies)
    y = frames(effect, (256, 256), 30)
    # 26,000 blinking pixels: the mean of their squares, each below 400 DN^2, is known to .6 %
    assert y.var() == pytest.approx(effect.variance(HERE), rel=0.04)
    levels = {"up": 2, "both": 2, "centred": 2, "three": 3}[polarity]
    seen = [np.unique(np.round(pixel, 3)).size for pixel in y.reshape(30, -1).T[:2000]]
    assert max(seen) == levels
    if polarity in ("centred", "three"):  # no fixed offset: 5 sigma of the mean over all
        assert abs(y.mean()) < 5 * np.sqrt(effect.variance(HERE) / (y.size / 30))


def test_a_relative_of_blinking_pixels_has_the_same_second_and_fourth_moment():
    exponential = Rts(0.03, 5.0)
    (fixed,) = exponential.relatives()
    assert fixed.amplitudes == "fixed"
    assert fixed.fraction * fixed.amplitude**2 == pytest.approx(2 * 0.03 * 5.0**2)
    assert fixed.fraction * fixed.amplitude**4 == pytest.approx(24 * 0.03 * 5.0**4)
    (back,) = fixed.relatives()
    assert (back.fraction, back.amplitude) == pytest.approx((0.03, 5.0))


def test_atoms_in_pairs_make_a_second_peak_that_is_guessed_beside_a_power_law():
    """As a CCD shows it: .6 % and .35 % of the pixels, and a tail of 1 % over two decades."""
    rng = np.random.default_rng(6)
    effect = DarkCurrentSteps(150.0, 0.0095, pairs=0.37)
    y = frames(effect, (800, 800), 1, HERE)[0].astype(float)
    own = 0.0095 * y.size
    assert np.sum(y == 150.0) == pytest.approx(own * 0.63, abs=5 * np.sqrt(own))
    assert np.sum(y == 300.0) == pytest.approx(own * 0.37, abs=5 * np.sqrt(own))
    assert y.var() == pytest.approx(effect.variance(HERE), rel=0.1)
    assert effect.adds(HERE, HERE, y.shape)[0] == pytest.approx(y.mean(), rel=0.1)
    assert effect.shows_in(4, y.size)
    y += rng.normal(0.0, 8.0, y.shape)
    tail = rng.random(y.shape) < 0.01
    y[tail] += 50.0 * rng.random(tail.sum()) ** -0.7
    edges = np.arange(-60.0, 20_000.0, 2.0)
    centres = (edges[1:] + edges[:-1]) / 2.0
    counts = np.histogram(y, edges)[0]
    found = peaks(centres, counts, 8.0)
    assert [p.amplitude for p in found[:2]] == pytest.approx([150.0, 300.0], rel=0.02)
    assert [p.share for p in found[:2]] == pytest.approx([0.006, 0.0035], rel=0.1)
    clues = MadeUpClues(
        (HERE,),
        seen={"pattern_noise_core": [8.0]},
        stands_out=("hot_count_5",),
        curves={"pattern_hist_x": [centres], "pattern_hist_n": [counts]},
    )
    guess = DarkCurrentSteps.guess(clues)[0]
    assert (guess.step, guess.pairs) == pytest.approx((150.0, 0.37), rel=0.05)


@pytest.mark.parametrize("law", ["power", "exponential"])
def test_a_smooth_tail_has_no_peaks(law):
    rng = np.random.default_rng(7)
    edges = np.arange(-60.0, 20_000.0, 2.0)
    hot = 10.0 * rng.random(20_000) ** -0.7 if law == "power" else rng.exponential(200.0, 20_000)
    y = np.concatenate([rng.normal(0.0, 8.0, 600_000), hot])
    counts = np.histogram(y, edges)[0]
    assert peaks((edges[1:] + edges[:-1]) / 2.0, counts, 8.0) == []


def test_few_pixels_of_a_smooth_tail_are_no_peak():
    """By chance a bin has more than the median of its neighbours, but no more a DN than below."""
    rng = np.random.default_rng(6)
    edges = np.arange(-60.0, 20_000.0, 2.0)
    y = np.concatenate([rng.normal(0.0, 8.0, 600_000), rng.gamma(0.5, 60.0, 3000)])
    assert peaks((edges[1:] + edges[:-1]) / 2.0, np.histogram(y, edges)[0], 8.0) == []


@pytest.mark.parametrize(
    ("spread", "two_atoms", "alike"), [(0.02, 40, True), (0.02, 0, True), (1.0, 0, False)]
)
def test_rare_atoms_and_pixels_alike_are_guessed_from_one_peak(spread, two_atoms, alike):
    points = tuple(OperatingPoint(t, 1.0, 1.0) for t in (25.0, 45.0, 65.0))
    rng = np.random.default_rng(5)
    bins, counts = [], []
    for p in points:
        core = rng.normal(0, 2.0, 100_000)
        hot = 200 * arrhenius(p.temperature_c, 25.0, 0.37) * np.exp(rng.normal(0, spread, 800))
        hot[:two_atoms] *= 2
        n, edges = np.histogram(np.concatenate([core, hot]), 4000)
        bins.append((edges[1:] + edges[:-1]) / 2)
        counts.append(n)
    clues = MadeUpClues(
        points,
        seen={"pattern_noise_core": [2.0] * 3},
        stands_out=("hot_count_5",),
        curves={"pattern_hist_x": bins, "pattern_hist_n": counts},
    )
    guesses = DarkCurrentSteps.guess(clues)
    assert bool(guesses) == alike
    for g in guesses:
        assert (g.step, g.ea_ev) == pytest.approx((200, 0.37), rel=0.02)
        assert g.pairs == pytest.approx(two_atoms / 800, abs=5 * np.sqrt(40) / 800)
        assert g.mean_number == pytest.approx(800 / 100_800, rel=5 / np.sqrt(800))
    narrow = [g for g in HotPixels.guess(clues) if g.law == "narrow"]
    assert bool(narrow) == alike
    for g in narrow:
        assert (g.scale, g.ea_ev) == pytest.approx((200, 0.37), rel=0.02)
        assert g.fraction == pytest.approx(800 / 100_800, rel=5 / np.sqrt(800))
        # of 800 normal ones a quartile distance is known to 4 %; the core adds to it
        assert g.width == pytest.approx(0.02, abs=0.01)


@pytest.mark.parametrize("tail", [0.2, 0.7])
def test_a_heavy_tail_is_a_generalised_pareto_law(tail):
    p, nu = 0.02, 40.0
    hot = frames(HotPixels(p, nu, tail=tail), SHAPE, 1)[0]
    hot = hot[hot > 0]
    assert abs(hot.size - N * p) < 5 * np.sqrt(N * p)
    assert stats.kstest(hot, "genpareto", (tail, 0, nu)).pvalue > 1e-6
    y = frames(HotClusters(1e-3, 4.0, 6.0, nu, tail=tail), SHAPE, 1)[0]
    alone = y[y > 0]  # few share a pixel: 4 in a disc of 113
    share = stats.genpareto(tail, 0, nu).sf(5 * nu)
    assert np.mean(alone > 5 * nu) == pytest.approx(share, abs=5 * np.sqrt(share / 1000) + 0.01)


def test_the_variance_of_a_light_power_law_tail_and_none_of_a_heavy_one():
    light = HotPixels(0.05, 10.0, tail=0.1)
    law = stats.genpareto(0.1, 0, 10.0)
    mean, square = 0.05 * law.moment(1), 0.05 * law.moment(2)
    assert light.variance(HERE) == pytest.approx(square - mean**2, rel=1e-9)
    assert HotPixels(0.05, 10.0, tail=0.6).variance(HERE) is None
    assert HotClusters(tail=0.6).variance(HERE) is None


@pytest.mark.parametrize("kind", [HotPixels, HotClusters, DarkCurrentSteps])
def test_the_same_hot_signal_is_as_much_in_as_many_pixels_whatever_its_kind(kind):
    found = HotSignal(fraction=0.02, scale=40.0, ea_ev=0.4)
    for effect in kind.of_hot_signal(found):
        y = frames(effect, SHAPE)[0]
        if kind is not HotClusters:
            assert np.mean(y > 0) == pytest.approx(0.02, abs=5 * np.sqrt(0.02 / N))
        # members of clusters share pixels and come together: variance by the closed form
        most = np.sqrt(max(effect.variance(HERE), 2 * 0.02 * 40.0**2) * 8 / N)
        assert y.mean() == pytest.approx(0.02 * 40.0, abs=5 * most)
        np.testing.assert_allclose(frames(effect, SHAPE, point=WARM)[0], growth(0.4) * y, rtol=1e-4)


def test_a_heavier_relative_is_as_strong_at_a_tenth_of_the_hot_pixels():
    other, power = HotPixels(0.01, 30.0).relatives()
    assert other.relatives() == power.relatives() == []
    assert list(other.inactive_parameters()) == list(power.inactive_parameters()) == ["width"]
    assert power.scale * 10.0**power.tail == pytest.approx(30.0 * np.log(10.0))
    law = stats.genpareto(other.tail, 0, other.scale)
    assert law.isf(0.1) == pytest.approx(stats.expon(0, 30.0).isf(0.1), rel=1e-6)


def test_rates_of_a_power_law_are_pareto_from_the_least_on():
    effect = HotPixels(0.02, 5.0, tail=0.4, law="power")
    hot = frames(effect, SHAPE, 1)[0]
    rate = hot[hot > 0]
    assert abs(rate.size - N * 0.02) < 5 * np.sqrt(N * 0.02)
    law = stats.pareto(1 / 0.4, scale=5.0)
    assert stats.kstest(rate, law.cdf).pvalue > 1e-6
    p = 0.02
    assert effect.variance(HERE) == pytest.approx(p * law.moment(2) - (p * law.mean()) ** 2)


def test_rates_of_a_narrow_peak_are_normal_about_it():
    effect = HotPixels(0.02, 50.0, law="narrow", width=0.1)
    hot = frames(effect, SHAPE, 1)[0]
    rate = hot[hot > 0]
    assert abs(rate.size - N * 0.02) < 5 * np.sqrt(N * 0.02)
    assert stats.kstest(rate, stats.norm(50.0, 5.0).cdf).pvalue > 1e-6
    p = 0.02
    assert effect.variance(HERE) == pytest.approx(p * (2500 + 25) - (p * 50) ** 2)
    assert effect.inactive_parameters() == ("tail",)


@pytest.mark.parametrize(
    ("occupancy", "dwell", "frames", "shown"),
    [(0.02, 0.05, 7, False), (0.5, 0.05, 7, True), (0.1, 0.5, 7, True), (0.06, 0.05, 3, False)],
)
def test_traps_that_are_up_in_one_frame_are_pixels_that_are_hit(occupancy, dwell, frames, shown):
    """Every sequence of states with its probability; `shows_in` has the sums in closed form."""
    r = np.exp(-1.0 / dwell)
    up, down = occupancy * (1.0 - r), (1.0 - occupancy) * (1.0 - r)
    step = np.array([[1.0 - up, up], [down, 1.0 - down]])
    changed = returned = 0.0
    for states in itertools.product((0, 1), repeat=frames):
        chance = (1.0 - occupancy, occupancy)[states[0]]
        for before, after in itertools.pairwise(states):
            chance *= step[before, after]
        changed += chance * (0 < sum(states) < frames)
        returned += chance * (1 < sum(states) < frames)
    told = changed >= LEAST_CHANGED and returned >= LEAST_RETURNED * changed
    assert told == shown
    trap = Rts(0.05, 30.0, occupancy=occupancy, dwell_frames=dwell)
    assert trap.shows_in(frames, 256 * 256) == shown
