"""Glow, gradients, cosmic rays, persistence and crosstalk against their closed forms."""

import numpy as np
import pytest
from charge_bench import HERE, LONG, LOUD, WARM, MadeUpClues, flat, frames, growth
from readout_bench import Given
from scipy import stats
from scipy.ndimage import find_objects, label, sum_labels

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effects.amp_glow import PLACES, TOGETHER, AmpGlow
from dnanalyze.model.effects.cosmic_rays import (
    CosmicRays,
    mean_rounded,
    moyal,
    poisson_quantile,
)
from dnanalyze.model.effects.crosstalk import Crosstalk
from dnanalyze.model.effects.dark_gradient import DarkGradient
from dnanalyze.model.effects.dark_shot_noise import DarkShotNoise
from dnanalyze.model.effects.hot_pixels import HotPixels
from dnanalyze.model.effects.persistence import Persistence
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.guesses.cosmic_rays import readout_time
from dnanalyze.thermal import arrhenius


def blocks(frame, size=16):
    rows, columns = frame.shape
    return frame.reshape(rows // size, size, columns // size, size).mean((1, 3))


def test_glow_fades_exponentially_from_its_source():
    y = frames(AmpGlow(50.0, 0.25, 0.0, "se"), (100, 200))[0]
    assert y[-1, -1] == pytest.approx(50)
    assert y[-1, -1 - 50] == pytest.approx(50 / np.e, rel=1e-5)  # .25 of the larger side
    assert y[-1 - 30, -1 - 40] == pytest.approx(50 / np.e, rel=1e-5)
    edge = frames(AmpGlow(50.0, 0.25, 0.0, "w"), (100, 200))[0]
    np.testing.assert_allclose(edge[:, 50], 50 / np.e, rtol=1e-5)
    np.testing.assert_allclose(edge[:, 0], 50, rtol=1e-6)


def test_a_glow_of_the_readout_is_in_bias_frames_and_moves_their_level():
    readout = AmpGlow(50.0, 0.25, 0.0, "w", exposure="none")
    bias = OperatingPoint(HERE.temperature_c, 0.0, 2.0 * HERE.gain)
    y = frames(readout, (100, 200), 1, bias)[0]
    assert y[0, 0] == pytest.approx(100.0)
    shift = readout.black_shift(bias, HERE, (100, 200))
    assert shift == pytest.approx(float(np.median(y)), rel=1e-5)
    assert not frames(AmpGlow(50.0, 0.25, 0.0, "w"), (100, 200), 1, bias).any()
    assert AmpGlow(50.0, 0.25, 0.0, "w").black_shift(bias, HERE, (100, 200)) == 0.0


@pytest.mark.parametrize("place", TOGETHER)
def test_glow_of_several_sources_is_their_sum(place):
    y = frames(AmpGlow(50.0, 0.1, 0.0, place), (60, 90))[0]
    each = [frames(AmpGlow(50.0, 0.1, 0.0, p), (60, 90))[0] for p in TOGETHER[place]]
    np.testing.assert_allclose(y, np.sum(each, axis=0), rtol=1e-5)
    half = np.rot90(y, 2)  # what faces itself is the same from both ends
    if place in ("edges", "corners", "n+s", "e+w", "nw+se", "ne+sw"):
        np.testing.assert_allclose(y, half, rtol=1e-4)


def test_glow_of_the_border_follows_the_nearest_edge():
    y = frames(AmpGlow(50.0, 0.1, 0.0, "border"), (60, 90))[0]
    row, column = np.arange(60)[:, None], np.arange(90)[None, :]
    nearest = np.minimum(np.minimum(row, 59 - row), np.minimum(column, 89 - column))
    np.testing.assert_allclose(y, 50 * np.exp(-nearest / 9.0), rtol=1e-5)


@pytest.mark.parametrize("place", ["se", "edges", "corners"])
def test_the_charge_of_the_glow_has_shot_noise(place):
    """Photon transfer over blocks: 300 e- at the source, K = 1.7 DN/e-, read noise 5 DN."""
    k = 1.7
    glow = AmpGlow(300.0 * k, 0.2, 0.0, place)
    y = frames((glow, DarkShotNoise(k), ReadNoise(5.0)), (256, 256), 12)
    slope, floor = np.polyfit(
        blocks(y.mean(axis=0)).ravel(), blocks(y.var(axis=0, ddof=1)).ravel(), 1
    )
    assert slope == pytest.approx(k, rel=0.03)
    assert floor == pytest.approx(25.0, rel=0.1)


def test_glow_follows_exposure_gain_and_its_activation_energy():
    a = frames(AmpGlow(50.0, 0.25, 0.3, "nw"), (64, 64))
    for point, factor in ((LONG, 3), (LOUD, 2), (WARM, growth(0.3))):
        got = frames(AmpGlow(50.0, 0.25, 0.3, "nw"), (64, 64), point=point)
        np.testing.assert_allclose(got, factor * a, rtol=1e-5)


@pytest.mark.parametrize("place", PLACES)
def test_glow_is_found_where_it_is(place):
    points = (HERE, WARM)
    truth = AmpGlow(30.0, 0.2, 0.0, place)
    rng = np.random.default_rng(3)
    maps = [
        blocks(frames(truth, (256, 256), point=p)[0]) + rng.normal(0, 0.05, (16, 16))
        for p in points
    ]
    clues = MadeUpClues(points, HERE, (256, 256), stands_out=("shading_1_1",),
                        curves={"block_means": maps})  # fmt: skip
    first = AmpGlow.guess(clues)[0]
    assert first.location == place
    assert first.length == pytest.approx(0.2, rel=0.3)
    assert first.amplitude == pytest.approx(30, rel=0.2)
    assert first.ea_ev < 0.03


def test_gradient_has_the_rms_of_its_coefficients_and_no_mean():
    effect = DarkGradient(3.0, -4.0, 2.0, 1.0, 0.6)
    y = frames(effect, (200, 300))[0]
    assert abs(y.mean()) < 1e-3
    assert y.var() == pytest.approx(effect.variance(HERE), rel=1e-3)
    assert y[100, -1] > y[100, 0]  # x grows to the right
    assert y[-1, 150] < y[0, 150]  # y, here negative, downwards
    for point, factor in ((LONG, 3), (LOUD, 2), (WARM, growth(0.6))):
        np.testing.assert_allclose(
            frames(effect, (200, 300), point=point)[0], factor * y, rtol=1e-4, atol=1e-4
        )


def test_gradient_is_guessed_from_the_block_means():
    truth = DarkGradient(3.0, -4.0, 0.0, 1.0, 0.7)
    maps = [blocks(frames(truth, (256, 256), point=p)[0]) for p in (HERE, WARM)]
    clues = MadeUpClues((HERE, WARM), HERE, (256, 256), stands_out=("shading_0_1",),
                        curves={"block_means": maps})  # fmt: skip
    (guess,) = DarkGradient.guess(clues)
    got = [guess.x, guess.y, guess.xx, guess.yy, guess.ea_ev]
    assert got == pytest.approx([3.0, -4.0, 0.0, 1.0, 0.7], abs=0.03)
    assert guess.xx == guess.xy == 0.0  # below what the blocks tell


# second moment of the charge over the square of its mean: 2 for Exp(E); times
# (1 + 2 l + 2 l^2) / (1 + l)^2 where it goes with a length of Exp(l)
@pytest.mark.parametrize(("charge", "moment"), [("track", 2.0), ("path", 2.0 * 41 / 25)])
def test_cosmic_rays_bring_the_charge_and_number_they_should(charge, moment):
    effect = CosmicRays(rate=200.0, energy=500.0, length=4.0, charge=charge)
    y = frames(effect, (512, 512), 40, LONG)
    number = 200 * 0.262144 * 3 * 40
    # compound Poisson; the border takes a part
    assert y.sum() / (number * 500) == pytest.approx(1, abs=5 * np.sqrt(moment / number) + 0.01)
    a, b = (y[n] > 1 for n in (0, 1))
    assert (a & b).sum() < 40  # chance overlap, no repeat
    assert abs(frames(effect, (512, 512), 40, LOUD).sum() / (2 * 500 * number / 3) - 1) < 0.2


def test_a_frame_collects_hits_while_it_is_read_too():
    effect = CosmicRays(rate=200.0, energy=500.0, length=4.0, readout_s=1.5)
    bias = frames(effect, (512, 512), 40, OperatingPoint(25.0, 0.0, 1.0)).sum() / 500.0
    number = 200 * 0.262144 * 1.5 * 40
    assert bias == pytest.approx(number, abs=5 * np.sqrt(2 * number) + 0.01 * number)
    assert frames(CosmicRays(200.0, 500.0), (64, 64), 4, OperatingPoint(25.0, 0.0, 1.0)).sum() == 0


def test_the_time_of_the_readout_is_guessed_from_the_hits_over_exposure():
    """Hits of one a second and megapixel: exposures of 0 to 300 s, 40 s of readout."""
    rng = np.random.default_rng(8)
    seconds, area = np.array([0.0, 0.0, 60.0, 300.0]), np.full(4, 4.0)
    found = [readout_time(rng.poisson(area * (seconds + 40.0)), area, seconds) for _ in range(200)]
    assert np.mean(found) == pytest.approx(40.0, rel=0.05)
    none = [readout_time(rng.poisson(area * seconds), area, seconds) for _ in range(200)]
    assert np.count_nonzero(none) < 10  # 2.5 standard deviations: .6 %
    assert readout_time(np.array([5.0, 7.0]), area[:2], np.full(2, 30.0)) == 0.0  # one exposure


def test_tracks_are_as_long_as_told_in_any_direction():
    effect = CosmicRays(rate=1.0, energy=1e5, length=30.0)
    point = OperatingPoint(25.0, 4.0, 1.0)
    extents = []
    for y in frames(effect, (600, 600), 150, point):
        marked, _ = label(y > 1e-3, np.ones((3, 3)))
        extents += [[r.stop - r.start - 1, c.stop - c.start - 1] for r, c in find_objects(marked)]
    rows, columns = np.array(extents, float).T
    # exponential of mean 30 plus about a pixel and a half; the border cuts a few percent
    spread = 5 * 30 / np.sqrt(rows.size)
    assert np.hypot(rows, columns).mean() == pytest.approx(30.5, abs=spread)
    assert rows.mean() == pytest.approx(columns.mean(), abs=spread)


@pytest.mark.long
@pytest.mark.parametrize(("charge", "slope"), [("track", 0.0), ("path", 1.0)])
def test_longer_tracks_hold_more_charge_where_it_is_drawn_for_the_path(charge, slope):
    effect = CosmicRays(rate=1.0, energy=1e5, length=30.0, charge=charge)
    sums, extents = [], []
    for y in frames(effect, (600, 600), 150, OperatingPoint(25.0, 4.0, 1.0)):
        marked, count = label(y > 1e-3, np.ones((3, 3)))
        places = find_objects(marked)
        extents += [np.hypot(r.stop - r.start - 1, c.stop - c.start - 1) for r, c in places]
        sums += list(sum_labels(y, marked, np.arange(1, count + 1)))
    away = np.array(extents) / np.mean(extents) - 1.0
    relative = np.array(sums) / np.mean(sums)
    # charge over length, both over their means: 0, or nearly 1; exponential charges scatter
    found, error = away @ relative / (away @ away), 3.0 / np.sqrt(len(sums))
    assert found == pytest.approx(slope, abs=4 * error)


@pytest.mark.parametrize("kind", ["even", "landau"])
def test_charges_go_pixel_by_pixel_with_the_mean_charge_of_a_hit(kind):
    effect = CosmicRays(rate=60.0, energy=5000.0, length=9.0, charge=kind)
    y = frames(effect, (512, 512), 40)
    number = 60 * 0.262144 * 40
    # compound Poisson: E[n^2]/E[n]^2 of n = 1 + round(Exp) is below 2; the border takes a part
    assert y.sum() / (number * 5000) == pytest.approx(1, abs=5 * np.sqrt(2.0 / number) + 0.02)
    charge = 5000.0 / (1.0 + mean_rounded(9.0))
    lit = y[y > 0] / charge
    if kind == "even":  # one step a pixel, two where a shallow track steps within it
        np.testing.assert_allclose(lit, np.rint(lit), atol=1e-4)
        assert np.mean(lit < 1.5) > 0.75
    else:
        assert lit.min() > 0.0
        assert stats.variation(lit) > 0.3


@pytest.mark.parametrize("kind", ["even", "landau"])
def test_shortest_tracks_hit_single_pixels(kind):
    y = frames(CosmicRays(rate=100.0, energy=300.0, length=0.05, charge=kind), (256, 256), 20)
    number = 100 * 0.065536 * 20
    assert np.count_nonzero(y) == pytest.approx(number, abs=5 * np.sqrt(number))
    neighbours = np.count_nonzero((y[:, 1:] > 0) & (y[:, :-1] > 0))
    assert neighbours <= 5  # by chance


def test_rounded_lengths_and_moyals_charges_have_their_means():
    rng = np.random.default_rng(4)
    for length in (0.3, 2.0, 40.0):
        rounded = np.rint(rng.exponential(length, 400_000))
        se = 5 * rounded.std() / np.sqrt(rounded.size)
        assert mean_rounded(length) == pytest.approx(rounded.mean(), abs=se)
    charges = moyal((np.arange(1_000_000) + 0.5) / 1_000_000)
    assert charges.mean() == pytest.approx(1.0, abs=1e-3)
    most = 1.0 / (1.0 + 0.25 * stats.moyal.mean())
    expected = stats.moyal.var() * (0.25 * most) ** 2
    assert charges.var() == pytest.approx(expected, rel=0.01)


def test_rate_and_length_are_guessed_from_clumps_that_the_border_cuts():
    """Tracks of exponential length, a step a pixel; counted by an independent labelling."""
    rng = np.random.default_rng(8)
    side, rate, length, count = 256, 90.0, 20.0, 60
    sizes = []
    for _ in range(count):
        lit = np.zeros((side, side), bool)
        for _ in range(rng.poisson(rate * (side + 400) ** 2 * 1e-6)):
            y, x = rng.uniform(-200, side + 200, 2)
            angle, n = rng.uniform(0, 2 * np.pi), int(np.rint(rng.exponential(length))) + 1
            along = np.arange(n) - (n - 1) / 2
            r = np.floor(y + along * np.sin(angle)).astype(int)
            c = np.floor(x + along * np.cos(angle)).astype(int)
            inside = (r >= 0) & (r < side) & (c >= 0) & (c < side)
            lit[r[inside], c[inside]] = True
        marked, _ = label(lit, np.ones((3, 3)))
        sizes += list(np.bincount(marked.ravel())[1:])
    curves = {
        "transient_clumps": [np.bincount(sizes).astype(float)],
        "histogram_counts": [np.array([side * side * count])],
        "difference_hist_x": [np.array([-60.0, 0.0, 60.0])],
        "difference_hist_n": [np.array([500, 100_000, 500])],
    }
    clues = MadeUpClues(
        shape=(side, side),
        seen={"transient_high": float(np.sum(sizes)), "temporal_noise_core": 3.0},
        model={"transient_high": 0.0},
        stands_out=("transient_high",),
        curves=curves,
    )
    guesses = {g.charge: g for g in CosmicRays.guess(clues)}
    assert set(guesses) == {"track", "path", "even", "landau"}
    even = guesses["even"]
    error = 3.0 / np.sqrt(len(sizes))
    assert even.rate == pytest.approx(rate, rel=error + 0.05)
    assert even.length == pytest.approx(length, rel=error + 0.1)
    assert even.energy == pytest.approx(60.0 * np.sqrt(2.0) * (1 + even.length), rel=1e-6)


def test_number_of_tracks_is_poisson_and_grows_one_by_one():
    u = (np.arange(20000) + 0.5) / 20000
    for mean in (0.01, 0.7, 5.0, 300.0):
        got = np.array([poisson_quantile(x, mean) for x in u])
        np.testing.assert_array_equal(got, stats.poisson.ppf(u, mean))


def test_cosmic_rays_are_guessed_from_the_transients():
    clues = MadeUpClues(
        seen={"transient_high": 300.0, "transient_adjacent": 200.0, "temporal_noise_core": 3.0},
        model={"transient_high": 0.0, "transient_adjacent": 0.0},
        stands_out=("transient_high",),
    )
    guesses = CosmicRays.guess(clues)
    assert {g.charge for g in guesses} == {"track", "path"}
    for guess in guesses:
        hits = guess.rate * 0.262144 * 8
        assert 20 < hits < 300
        assert guess.length > 1


@pytest.mark.parametrize(("charge", "ends"), [(40.0, False), (400.0, True)])
def test_the_charge_of_a_hit_is_guessed_from_how_far_frames_differ(charge, ends):
    """Noise of 3 DN, hits of an exponential charge; counts end at 64 times the noise, codes at 300.

    2000 hits are among the differences, and 300 among the codes.
    """
    rng = np.random.default_rng(6)
    hits = rng.exponential(charge, 2000) * rng.choice([-1.0, 1.0], 2000) / np.sqrt(2.0)
    differences = rng.normal(0.0, 3.0, 200_000)
    differences[:2000] += hits
    n, edges = np.histogram(np.clip(differences, -191.9, 191.9), 8192, (-192.0, 192.0))
    at = (edges[1:] + edges[:-1]) / 2
    values = 100.0 + rng.normal(0.0, 3.0, 200_000)
    values[:300] += rng.exponential(charge, 300)
    codes, counts = np.unique(np.rint(np.minimum(values, 300.0)), return_counts=True)
    guesses = _of_differences([3.0], [at], [n], codes=[codes], counts=[counts])
    assert len(guesses) == (2 if ends else 1)
    a_pixel = guesses[0].energy / 2.0
    if ends:  # 1 - exp(-200 / 400) of the 300 are below the highest code
        assert charge / 4 < a_pixel < charge
        assert guesses[1].energy / 2.0 == pytest.approx(charge, rel=5 / np.sqrt(300 * 0.39))
    else:  # a thousand lie beyond the cut, with the noise on them
        assert a_pixel == pytest.approx(charge, rel=5 / np.sqrt(1000))
        hits = guesses[0].rate * 0.262144 * 8 * 2.0
        assert hits == pytest.approx(300.0 * np.exp(8 * 3.0 / a_pixel))  # with those not seen


def test_hits_that_the_noise_of_the_model_has_taken_are_guessed_too():
    few, all_of_them = _rates(model=290.0), _rates(model=0.0)
    assert all_of_them == pytest.approx([30 * few[0]])
    assert few == pytest.approx([all_of_them[0] / 30, all_of_them[0]])
    assert len(_rates(model=140.0)) == 1  # more than half is beyond the model


def _rates(model):
    at, n = np.array([-30.0, 0.0, 30.0]), np.array([50, 10_000, 50])
    return [g.rate for g in _of_differences([2.0], [at], [n], model=model)]


def _of_differences(noise, at, n, points=(HERE,), codes=None, counts=None, model=0.0):
    """Guesses of tracks from 300 pixels that stand out once, and histograms."""
    curves = {"difference_hist_x": at, "difference_hist_n": n}
    if codes is not None:
        curves |= {"histogram_codes": codes, "histogram_counts": counts}
    clues = MadeUpClues(
        points,
        seen={
            "transient_high": 300.0,
            "transient_adjacent": 0.0,
            "temporal_noise_core": np.array(noise),
        },
        model={"transient_high": model, "transient_adjacent": 0.0},
        stands_out=("transient_high",),
        curves=curves,
    )
    return [g for g in CosmicRays.guess(clues) if g.charge == "track"]


def test_the_charge_is_read_where_the_noise_is_least_and_is_that_of_the_reference_gain():
    at = np.array([-30.0, 0.0, 30.0])
    few, many = np.array([5, 10_000, 5]), np.array([50, 10_000, 50])
    loud = OperatingPoint(45.0, 1.0, 2.0)
    (guess,) = _of_differences([3.0, 2.0], [at, at], [many, few], (HERE, loud))
    assert guess.energy == pytest.approx(2.0 * np.sqrt(2.0) * (30.0 - 6 * 2.0) / 2.0)
    (guess,) = _of_differences([0.0, 2.0], [at, at], [many, few], (HERE, loud))
    assert guess.energy == pytest.approx(2.0 * np.sqrt(2.0) * (30.0 - 6 * 2.0) / 2.0)


@pytest.mark.parametrize("count", [0, 3])
def test_few_differences_tell_no_charge(count):
    guesses = _of_differences([2.0], [np.array([0.0, 30.0])], [np.array([10_000, count])])
    assert [g.energy for g in guesses] == pytest.approx([2 * 30 * 2.0])


def test_persistence_adds_the_past_with_its_weights():
    effect = Persistence(amplitude=0.2, tau_s=2.0)
    noise = (flat(100.0), DarkShotNoise(dn_per_e=1.0))
    bare = frames(noise, (64, 64), 7)
    y = frames((*noise, effect), (64, 64), 7)
    for n in range(7):
        k = np.arange(1, min(n, 4) + 1)
        expected = bare[n] + np.tensordot(0.2 * np.exp(-k / 2.0), bare[n - k], 1) if n else bare[0]
        np.testing.assert_allclose(y[n], expected, rtol=1e-5)


def test_persistence_correlates_neighbouring_frames_and_not_the_read_noise():
    charge = (flat(100.0), DarkShotNoise(dn_per_e=1.0))
    effect = Persistence(amplitude=0.3, tau_s=1.0)
    y = frames((*charge, effect), (128, 128), 2, first=10)
    w = 0.3 * np.exp(-np.arange(1, 5))
    shared = (np.r_[1, w[:-1]] * w).sum()
    expected = shared / (1 + (w**2).sum())
    r = np.corrcoef(y[0].ravel(), y[1].ravel())[0, 1]
    assert abs(r - expected) < 5 / 128
    read = frames((ReadNoise(1.0), effect), (128, 128), 2, first=10)
    assert abs(np.corrcoef(read[0].ravel(), read[1].ravel())[0, 1]) < 5 / 128


def test_persistence_fades_with_the_time_between_frames():
    step = Persistence(0.2, 2.0)
    y = frames((flat(100.0), step), (8, 8), 1, LONG, first=9)[0]
    k = np.arange(1, 5)
    assert y.mean() == pytest.approx(300 * (1 + 0.2 * np.exp(-k * 3 / 2).sum()), rel=1e-4)


def test_persistence_is_guessed_from_the_correlation_of_frames():
    clues = MadeUpClues(
        seen={"temporal_r1": 0.1}, model={"temporal_r1": 0.0}, stands_out=("temporal_r1",)
    )
    for guess in Persistence.guess(clues):
        assert guess.amplitude * np.exp(-1 / guess.tau_s) == pytest.approx(0.1)


def test_persistence_is_guessed_from_the_part_of_the_noise_that_is_of_charge():
    points = tuple(OperatingPoint(t, 1.0, 1.0) for t in (5.0, 25.0, 45.0))
    read, charge = 3.0, np.array([0.0, 2.0, 6.0])
    variance = read**2 + charge**2
    clues = MadeUpClues(
        points,
        seen={"temporal_r1": 0.05 * charge**2 / variance, "temporal_noise": np.sqrt(variance)},
        model={"temporal_r1": 0.0},
        stands_out=("temporal_r1",),
    )
    for guess in Persistence.guess(clues):
        assert guess.amplitude * np.exp(-1 / guess.tau_s) == pytest.approx(0.05)
    clues.seen["temporal_r1"] = np.array([np.nan, 0.02, 0.02])  # no setting shows charge alone
    clues.seen["temporal_noise"] = 5.0
    for guess in Persistence.guess(clues):
        assert guess.amplitude * np.exp(-1 / guess.tau_s) == pytest.approx(0.02)


@pytest.mark.parametrize("uneven", [0.0, 0.6, -1.0])
def test_crosstalk_correlates_shot_noise_by_its_kernel_and_spares_read_noise(uneven):
    a, d = 0.03, 0.5
    b = a * d
    charge = (flat(200.0), DarkShotNoise(dn_per_e=1.0))
    y = frames((*charge, Crosstalk(a, d, uneven)), (256, 256), 6)
    z = (y - 200) / np.sqrt(200)
    row, column = a * (1 + uneven), a * (1 - uneven)
    k = np.array([[b, column, b], [row, 1 - 4 * a - 4 * b, row], [b, column, b]])
    full = np.zeros((5, 5))
    for i in range(3):
        for j in range(3):
            full[i : i + 3, j : j + 3] += k[i, j] * k
    inner = z[:, 2:-2, 2:-2]
    n = inner.size
    for dy, dx in ((0, 0), (0, 1), (1, 0), (1, 1), (0, 2), (2, 1)):
        shifted = z[:, 2 + dy : 254 + dy, 2 + dx : 254 + dx]
        assert abs(np.mean(inner * shifted) - full[2 + dy, 2 + dx]) < 5 * np.sqrt(2 / n)
    assert abs(y.mean() - 200) < 5 * np.sqrt(200 / y.size)  # charge is conserved
    read = frames((ReadNoise(1.0), Crosstalk(a, d, uneven)), (256, 256), 6)
    assert abs(np.mean(read[:, :, 1:] * read[:, :, :-1])) < 5 / np.sqrt(read.size)


def test_crosstalk_gives_every_hot_pixel_the_same_halo():
    a, d = 0.02, 0.25
    chain = (HotPixels(2e-4, 100.0), Crosstalk(a, d))
    bare = frames(HotPixels(2e-4, 100.0), (512, 512))[0]
    y = frames(chain, (512, 512))[0]
    spots = [(r, c) for r, c in np.argwhere(bare > 10) if min(r, c) > 3 and max(r, c) < 508]
    alone = [(r, c) for r, c in spots if (bare[r - 3 : r + 4, c - 3 : c + 4] > 0).sum() == 1]
    assert len(alone) > 10
    for r, c in alone:
        assert y[r, c + 1] / bare[r, c] == pytest.approx(a, rel=1e-4)
        assert y[r + 1, c + 1] / bare[r, c] == pytest.approx(a * d, rel=1e-4)


def test_crosstalk_is_guessed_from_the_correlation_of_neighbours():
    clues = MadeUpClues(
        seen={"temporal_corr_10": 0.06, "temporal_corr_01": 0.02},
        model={"temporal_corr_10": 0.0, "temporal_corr_01": 0.0},
        stands_out=("temporal_corr_10",),
    )
    guesses = Crosstalk.guess(clues)
    assert [g.alpha for g in guesses] == pytest.approx([0.02] * 3)
    assert [g.anisotropy for g in guesses] == pytest.approx([0.0, 0.0, 0.5])


def test_a_scaled_gradient_multiplies_every_pixel_and_follows_the_dark_signal():
    form = {"form": "scaled"}
    added = frames(DarkGradient(x=0.1, yy=0.05, ea_ev=0.0), (64, 96))[0]
    plain = frames(HotPixels(0.3, 20.0), (64, 96))[0]
    both = frames((HotPixels(0.3, 20.0), DarkGradient(x=0.1, yy=0.05, **form)), (64, 96))[0]
    np.testing.assert_allclose(both, plain * (1 + added), rtol=1e-5, atol=1e-5)
    assert DarkGradient(**form).inactive_parameters() == ("wait", "ea_ev")
    assert "ea_ev" not in DarkGradient(wait=1.0, **form).inactive_parameters()


def test_a_share_is_guessed_from_the_slope_over_the_level():
    points = (HERE, WARM)
    levels = np.array([110.0, 190.0])  # 100 is the black level
    shape = blocks(frames(DarkGradient(x=0.08, y=-0.03, ea_ev=0.0), (256, 256))[0])
    clues = MadeUpClues(points, HERE, (256, 256), seen={"mean": levels},
                        stands_out=("shading_0_1",),
                        curves={"block_means": [(m - 100) * shape for m in levels]})  # fmt: skip
    scaled = DarkGradient.guess(clues)[1]
    assert scaled.form == "scaled"
    assert (scaled.x, scaled.y) == pytest.approx((0.08, -0.03), rel=1e-2)


def test_persistence_of_a_running_sensor_lifts_the_first_frame_as_all_others():
    running = (HotPixels(0.3, 20.0), Persistence(0.2, 2.0, "running"))
    y, plain = frames(running, (64, 64), 6), frames(running[:1], (64, 64), 6)
    lift = 1 + 0.2 * np.exp(-np.arange(1, 5) / 2.0).sum()  # exposure 1 s
    np.testing.assert_allclose(y, lift * plain, rtol=1e-5, atol=1e-5)


def test_a_twist_lifts_two_corners_and_lowers_the_others():
    y = frames(DarkGradient(xy=2.0), (200, 300))[0]
    assert y.std() == pytest.approx(2.0, rel=1e-3)
    assert abs(y.mean(axis=0)).max() < 1e-3 > abs(y.mean(axis=1)).max()
    assert y[0, 0] > 5 < y[-1, -1]  # 3 xy at the corners
    assert y[0, -1] < -5 > y[-1, 0]


def test_a_twist_is_guessed_from_the_block_means():
    truth = DarkGradient(x=1.0, xy=2.0, ea_ev=0.7)
    maps = [blocks(frames(truth, (256, 256), point=p)[0]) for p in (HERE, WARM)]
    clues = MadeUpClues((HERE, WARM), HERE, (256, 256), stands_out=("shading_1_1",),
                        curves={"block_means": maps})  # fmt: skip
    (guess,) = DarkGradient.guess(clues)
    assert [guess.x, guess.xy, guess.ea_ev] == pytest.approx([1.0, 2.0, 0.7], abs=0.03)


def test_rows_that_wait_collect_charge_at_any_exposure():
    effect = DarkGradient(wait=16.0, ea_ev=0.6)
    y = frames(effect, (64, 32))[0]
    np.testing.assert_allclose(y, np.broadcast_to(np.arange(64)[:, None] / 4, y.shape), atol=1e-4)
    for point, factor in ((LONG, 1), (LOUD, 2), (WARM, growth(0.6))):
        np.testing.assert_allclose(
            frames(effect, (64, 32), point=point)[0], factor * y, rtol=1e-5, atol=1e-4
        )
    up = frames(DarkGradient(wait=-16.0), (64, 32))[0]
    assert up[0, 0] == pytest.approx(16.0)  # the first row waits longest, and none is negative
    assert 0 <= up.min() < 1
    assert DarkGradient().inactive_parameters() == ("wait",)
    assert effect.inactive_parameters() == ("x", "y", "xx", "yy", "xy")
    assert DarkGradient(x=1.0, yy=2.0).inactive_parameters() == ("y", "xx", "xy", "wait")
    assert effect.variance(HERE) is None


def test_what_waiting_rows_collect_has_its_shot_noise():
    y = frames((DarkGradient(wait=400.0), DarkShotNoise(dn_per_e=2.0)), (256, 400), 8)
    variance = y.var(axis=0, ddof=1).mean(axis=1)
    expected = 2.0 * 400.0 * np.arange(256) / 256
    # each row: 400 pixels of 8 frames
    assert np.all(np.abs(variance - expected) < 5 * expected * np.sqrt(2 / 7 / 400) + 0.5)


def test_waiting_rows_are_guessed_from_the_shortest_exposures():
    points = tuple(OperatingPoint(t, e) for t in (25.0, 45.0) for e in (0.0, 300.0))
    row = np.arange(256)
    rng = np.random.default_rng(8)
    profiles = []
    for p in points:
        height = -12.0 * arrhenius(p.temperature_c, 25.0, 0.7) + 5.0 * p.exposure_s
        profiles.append(height * (row / 256 - 0.5) + 0.1 * rng.standard_normal(256))
    clues = Given(
        points=points, off={"pattern_rows_0_0.02": 9.0}, profiles={"rows": profiles},
        reference=OperatingPoint(25.0, 300.0),
    )  # fmt: skip
    (guess,) = DarkGradient.guess(clues)
    assert (guess.wait, guess.ea_ev) == pytest.approx((-12.0, 0.7), rel=0.03)
