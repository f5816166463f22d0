import numpy as np
import pytest
from readout_bench import Given, frames
from scipy import ndimage

from dnanalyze.loaders.captures import OperatingPoint, Window
from dnanalyze.model import filters, wavelets
from dnanalyze.model.effects.denoise import WIDE, Denoise
from dnanalyze.model.effects.missing_codes import MissingCodes
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.laws import ArrheniusLaw
from dnanalyze.model.white_codes import left_of, likeness, noise_before

SENSOR = (ReadNoise(5.0),)
KINDS = ("gaussian", "median", "bilateral", "nlm", "wavelet", "haar", "db2")


def before():
    return frames(*SENSOR)


@pytest.mark.parametrize("strength", [0.0, 0.4, 1.0])
def test_strength_mixes_the_filtered_frame_with_the_original(strength):
    y = before()[0]
    smooth = ndimage.median_filter(y, 3, mode="mirror")
    z = frames(*SENSOR, Denoise(strength, kind="median"))[0]
    np.testing.assert_allclose(z, y + strength * (smooth - y), atol=1e-4)


def test_each_kind_is_its_filter():
    y = before()[0].astype(np.float32)
    filtered = {
        "gaussian": ndimage.gaussian_filter(y.astype(float), 0.8, radius=6, mode="mirror"),
        "median": ndimage.median_filter(y, 3, mode="mirror"),
        "bilateral": filters.bilateral(y, 7.0, 0.8, 2),
        "nlm": filters.nonlocal_means(y, 7.0, 5, 5),
        "wavelet": wavelets.over_all_shifts(y, 7.0),
        "haar": wavelets.on_grid(y, 7.0, wavelets.HAAR),
        "db2": wavelets.on_grid(y, 7.0, wavelets.DB2),
    }
    for kind in KINDS:
        z = frames(*SENSOR, Denoise(1.0, 7.0, 0.8, kind))[0]
        np.testing.assert_allclose(z, filtered[kind], rtol=1e-5)


def test_gaussian_variance_and_correlation_have_their_closed_form():
    z = frames(*SENSOR, Denoise(1.0, space=0.6, kind="gaussian"), shape=(512, 512), pedestal=0.0)
    x = np.arange(-6, 7)
    w = np.exp(-0.5 * (x / 0.6) ** 2)
    w /= w.sum()
    lag0, lag1 = np.sum(w * w), np.sum(w[1:] * w[:-1])
    # a narrow kernel leaves most pixels independent: 10 % more than sqrt(2 / n) holds 5 sigma
    assert z.var() == pytest.approx(25 * lag0**2, rel=7 * np.sqrt(2 / z.size))
    found = np.mean(z[:, :, 1:] * z[:, :, :-1]) / z.var()
    assert found == pytest.approx(lag1 / lag0, abs=7 / np.sqrt(z.size))


@pytest.mark.parametrize("kind", KINDS)
def test_on_a_mosaic_neighbours_of_another_colour_do_not_mix(kind):
    z = frames(*SENSOR, Denoise(0.8, 7.0, kind=kind, spacing=2), shape=(256, 256), pedestal=0.0)
    lag1, lag2 = (np.mean(z[:, :, k:] * z[:, :, :-k]) / z.var() for k in (1, 2))
    assert abs(lag1) < 12 / np.sqrt(z.size)  # smoothing makes fewer pixels independent
    assert lag2 > 0.05


@pytest.mark.parametrize("kind", KINDS)
def test_edge_preserving_kinds_leave_large_signals_alone(kind):
    hot = np.zeros((64, 64), np.float32)
    hot[20, 30] = hot[40, 10] = 500.0
    effect = Denoise(1.0, 5.0, 0.8, kind)
    kept = effect.filtered(hot)[20, 30] / 500.0
    if kind in ("bilateral", "nlm"):
        assert kept > 0.95
    elif kind in ("wavelet", "haar", "db2"):
        assert kept > 0.9
    else:
        assert kept < 0.5


def test_codes_stay_codes():
    z = frames(*SENSOR, MissingCodes(1e-3), Denoise(0.5))
    assert np.array_equal(z, np.rint(z))


def test_guess_offers_every_kind_scaled_to_the_noise():
    clues = Given(
        seen={"temporal_corr_10": 0.2, "temporal_corr_20": 0.01, "temporal_noise": 3.0},
        off={"temporal_psd_0.5_0.71": -8.0},
    )  # fmt: skip
    every = Denoise.guess(clues)
    found = {e.kind: e for e in reversed(every)}
    assert set(found) == {*KINDS} - {"haar"}  # a kind of the other wavelets
    assert {e.spacing for e in every} == {1}
    assert {e.strength for e in every if e.kind == "median"} == {0.25, 0.4, 0.5, 0.75, 1.0}
    patches = [e for e in every if e.kind == "nlm"]
    assert [e.patch for e in patches] == [5, 2, 4] * 2
    for e, wider in zip(patches[:3], patches[3:], strict=True):
        assert wider.range == pytest.approx(2.0 * e.range)  # neighbours tell little of many's mean
    sized = [*patches[:3], *(found[kind] for kind in ("bilateral", "wavelet", "db2"))]
    for effect in sized:
        left = left_of(effect.filtered, noise_before(effect.filtered, 3.0))
        assert left.std() == pytest.approx(3.0, rel=0.1)
        assert likeness(left) == pytest.approx(0.2, abs=0.02)
    clues.seen.update({"temporal_corr_10": 0.0, "temporal_corr_20": 0.2})
    assert {e.spacing for e in Denoise.guess(clues)} == {2}
    assert Denoise.guess(Given()) == []


@pytest.mark.parametrize("space", [0.5, 0.85])
def test_a_bilateral_that_is_wide_for_the_noise_is_guessed_from_what_it_leaves(space):
    """Of noise of 5 DN over 30 DN it leaves a Gaussian's share, and neighbours that alike."""
    wide = Denoise(1.0, 30.0, space, "bilateral")
    y = frames(*SENSOR, wide, count=2, shape=(200, 200)).astype(float)
    y -= y.mean()
    left, alike = y.std(), np.mean(y[..., 1:] * y[..., :-1]) / y.var()
    clues = Given(
        seen={"temporal_corr_10": alike, "temporal_corr_20": 0.1, "temporal_noise": left},
        off={"temporal_psd_0.5_0.71": -8.0},
    )  # fmt: skip
    guess = max((e for e in Denoise.guess(clues) if e.kind == "bilateral"), key=lambda e: e.range)
    assert guess.space == pytest.approx(space, rel=0.1)
    # kernel cut at two pixels, likeness of 30 DN, codes: a tenth of the noise
    assert guess.range == pytest.approx(1.5 * WIDE * 5.0, rel=0.15)
    factor, shift = guess.nuisance_bias("read_noise.sigma", "DN", left)
    assert left * factor + shift == pytest.approx(5.0, rel=0.15)


@pytest.mark.parametrize("noise", [5.0, 20.0])
@pytest.mark.parametrize(
    ("kind", "share"), [("bilateral", 1.4), ("wavelet", 1.4), ("nlm", 0.6), ("db2", 1.4)]
)
def test_what_goes_by_the_size_of_noise_is_tried_on_codes(kind, share, noise):
    """The noise before it comes back from what it leaves, with it the range from the likeness."""
    hidden = Denoise(1.0, share * noise, 1.5, kind)
    y = frames(ReadNoise(noise), MissingCodes(1e-3), hidden, count=4, shape=(200, 200))
    y = y.astype(float) - y.mean()
    left, alike = y.std(), np.mean(y[..., 1:] * y[..., :-1]) / y.var()
    factor, before = hidden.nuisance_bias("read_noise.sigma", "DN", left)
    assert factor == 0.0
    assert before == pytest.approx(noise, rel=0.2)  # where between codes the mean lies matters
    assert hidden.nuisance_bias("read_noise.spread", "1", left) == (0.0, 0.0)
    assert hidden.nuisance_bias("pixel_fpn.sigma", "DN", left)[1] > 0
    assert hidden.nuisance_bias("dark_shot_noise.dn_per_e", "DN/e-", left) == (1.0, 0.0)
    clues = Given(
        seen={"temporal_corr_10": alike, "temporal_corr_20": 0.0, "temporal_noise": left},
        off={"temporal_psd_0.5_0.71": -8.0},
    )  # fmt: skip
    guess = next(e for e in Denoise.guess(clues) if e.kind == kind)
    assert guess.range == pytest.approx(share * noise, rel=0.4)  # of 9,000 pixels, and a kernel's


@pytest.mark.parametrize("noise", [0.0, np.inf])
def test_frames_without_noise_tell_nothing_of_what_was_before(noise):
    assert Denoise(1.0, 4.0, 0.8, "nlm").nuisance_bias("read_noise.sigma", "DN", noise) == (
        1.0,
        0.0,
    )


def test_the_filter_is_read_off_the_quietest_setting_whose_codes_change_often_enough():
    points = tuple(OperatingPoint(t, 1.0, 1.0) for t in (5.0, 25.0, 45.0))
    clues = Given(
        points=points,
        seen={"temporal_corr_10": (0.0, 0.2, 0.0), "temporal_corr_20": 0.0,
              "temporal_noise": (0.1, 0.5, 4.0)},
        off={"temporal_psd_0.5_0.71": -8.0},
    )  # fmt: skip
    alone = Given(
        seen={"temporal_corr_10": 0.2, "temporal_corr_20": 0.0, "temporal_noise": 0.5},
        off={"temporal_psd_0.5_0.71": -8.0},
    )
    assert Denoise.guess(clues)[:4] == Denoise.guess(alone)[:4]
    mosaic = Given(
        seen={"temporal_corr_10": 0.0, "temporal_corr_20": 0.2, "temporal_noise": 0.5},
        off={"temporal_psd_0.5_0.71": -8.0},
    )
    ranges = [[e.range for e in Denoise.guess(c)[:4]] for c in (alone, mosaic)]
    assert ranges[0] == ranges[1]
    clues.seen["temporal_noise"] = (0.01, 0.05, 0.2)  # all of them seldom: then the least
    assert all(e.range <= 0.08 for e in Denoise.guess(clues)[:4])


def test_a_filter_whose_range_varies_bends_nothing_that_is_known():
    varying = Denoise(1.0, ArrheniusLaw(30.0, 25.0, 0.5), 0.85, "bilateral")
    assert varying.nuisance_bias("read_noise.sigma", "DN", 1.0) == (1.0, 0.0)


def test_idle_parameters():
    assert Denoise(kind="median").inactive_parameters() == ("range", "space", "patch", "window")
    assert Denoise(kind="gaussian").inactive_parameters() == ("range", "patch", "window")
    assert Denoise(kind="bilateral").inactive_parameters() == ("patch", "window")
    assert Denoise(kind="nlm").inactive_parameters() == ("space",)


def test_a_share_near_a_quarter_is_tried_as_one_and_then_held():
    (plain,) = Denoise(strength=0.46, kind="median").relatives()
    assert plain.strength == 0.5
    assert "strength" in plain.inactive_parameters()
    assert plain.relatives() == []
    assert "strength" not in Denoise(strength=1.0, kind="gaussian").inactive_parameters()
    assert Denoise(strength=0.95).relatives() == []


@pytest.mark.parametrize("strength", [0.5, 1.0])
@pytest.mark.parametrize("kind", KINDS)
def test_a_fit_without_it_takes_the_noise_for_smaller_by_what_the_filter_leaves(kind, strength):
    filtered = Denoise(strength, 1e-2, 0.7, kind)  # a range below the noise changes nothing
    y = frames(*SENSOR, filtered, count=4, shape=(200, 200))
    factor, shift = filtered.nuisance_bias("read_noise.sigma", "DN")
    # smoothed pixels are worth a few times fewer
    assert y.std() * factor + shift == pytest.approx(5.0, rel=5 * 3 / np.sqrt(2 * y.size))
    assert filtered.nuisance_bias("dark_shot_noise.dn_per_e", "DN/e-")[0] == pytest.approx(
        factor**2
    )
    assert filtered.nuisance_bias("convolved_lognormal.phi", "1") == (0.0, 0.0)


@pytest.mark.parametrize("spacing", [1, 2])
@pytest.mark.parametrize("kind", KINDS)
def test_a_window_is_that_part_of_the_frame(kind, spacing):
    """Whatever its corner, and however far the kind looks around."""
    chain = *SENSOR, Denoise(0.8, 7.0, kind=kind, spacing=spacing)
    (whole,) = frames(*chain, count=1, shape=(150, 160))
    for window in (Window(63, 90, 45, 101), Window(0, 11, 150, 160), Window(148, 150, 0, 160)):
        (part,) = frames(*chain, count=1, shape=(150, 160), window=window)
        np.testing.assert_allclose(part, whole[window.slices], rtol=1e-5)


def test_a_grid_leaves_a_lattice_and_all_shifts_none():
    """Where every detail is dropped, blocks of 8 pixels stay: steps are at their seams alone."""

    def across_seams(kind):
        z = frames(*SENSOR, Denoise(1.0, 25.0, kind=kind), shape=(256, 256), pedestal=0.0)
        steps = np.mean(np.diff(z, axis=2) ** 2, axis=(0, 1))
        return steps[7::8].sum() / steps.sum()

    assert across_seams("haar") > 0.999
    assert across_seams("wavelet") == pytest.approx(1 / 8, rel=0.1)
    assert 1 / 8 < across_seams("db2") < 0.5  # a basis that is continuous
