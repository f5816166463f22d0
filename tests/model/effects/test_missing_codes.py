import numpy as np
import pytest
from readout_bench import Given, Ramp, frames

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model import draws
from dnanalyze.model.effects.missing_codes import MissingCodes

SHAPE = (512, 512)
BLOCKS = slice(64, 64 + 192)  # whole blocks of codes inside the ramp


def counts(effect, **more):
    """How often a code occurs over its share of an even ramp: an estimate of its width."""
    top = 400.0
    y = frames(Ramp(top), effect, shape=SHAPE, pedestal=0.0, count=4, **more).ravel()
    assert np.array_equal(y, np.rint(y))
    n = np.bincount(y.astype(int), minlength=402)
    return n[BLOCKS] / (y.size / top), 1 / np.sqrt(y.size / top)


def test_widths_scatter_by_sigma():
    width, se = counts(MissingCodes(0.3))
    expected = 0.3**2 * 63 / 64 + se**2
    assert np.var(width) == pytest.approx(expected, rel=6 * np.sqrt(2 / width.size))
    assert width.reshape(-1, 64).mean(axis=1) == pytest.approx(1.0, abs=5 * se / 8)


def test_periodic_widths_repeat_and_have_exactly_the_stated_rms():
    width, se = counts(MissingCodes(0.3, "periodic", 8))
    folded = width.reshape(-1, 8)
    mean = folded.mean(axis=0)
    assert np.std(mean) == pytest.approx(0.3, abs=5 * se / np.sqrt(len(folded)))
    assert np.abs(folded - mean).max() < 5.5 * se * np.sqrt(1 + 0.6)


def test_edges_that_repeat_are_in_place_on_average():
    one_edge = (-1.0, *[0.0] * 14, 1.0)
    x, y = (
        frames(Ramp(400.0), *e, shape=SHAPE, pedestal=0.0, count=4)
        for e in ((), (MissingCodes(0.25, "periodic", 16, one_edge),))
    )
    off = (y - x)[(x > 63) & (x < 255)].mean()  # .7 DN where all edges but one gave way
    assert abs(off) < 5 * np.sqrt(0.25 / y.size) + 0.01  # an end of the cut may fall within a code


def test_wide_errors_leave_codes_that_never_occur():
    width, _ = counts(MissingCodes(1.0))
    share = np.mean(width == 0)  # P(1 + d < 0) = 16 %
    assert share == pytest.approx(0.159, abs=5 * np.sqrt(0.13 / width.size))


def test_the_transfer_is_straight_over_blocks_and_the_error_small():
    x = frames(Ramp(400.0), shape=SHAPE, pedestal=0.0)
    y = frames(Ramp(400.0), MissingCodes(0.2), shape=SHAPE, pedestal=0.0)
    assert np.abs(y - x).max() < 0.5 + 0.2 * 8 * 2.5  # a bridge of 64 steps: sd sigma sqrt(64) / 2
    fine = frames(Ramp(400.0), MissingCodes(1e-3), shape=SHAPE, pedestal=0.0)
    assert np.mean(fine != np.rint(x)) < 0.01


def test_the_codes_are_the_same_at_any_temperature_and_below_zero():
    warm, _ = counts(MissingCodes(0.5), point=OperatingPoint(85.0, 1.0, 1.0))
    cold, se = counts(MissingCodes(0.5))
    assert np.abs(warm - cold).max() < 6 * np.sqrt(2) * se * 1.6
    below = frames(Ramp(50.0), MissingCodes(0.1), pedestal=-100.0)
    assert abs(below.mean() + 75.0) < 0.5


@pytest.mark.parametrize("scatter", [0.0, 2.0, 60.0])
def test_a_code_is_the_number_of_levels_that_are_reached(scatter):
    rng = np.random.default_rng(3)
    at = np.arange(-200, 200)
    levels = np.sort(at + rng.normal(0, scatter, at.size)).astype(np.float32)
    levels[7] = levels[8]  # a code that is never given
    signal = rng.uniform(-300, 300, 5000).astype(np.float32)
    signal[: levels.size] = levels
    expected = np.searchsorted(levels, signal, side="right")
    np.testing.assert_array_equal(draws.rank(signal, levels, -200), expected)


@pytest.mark.parametrize("kind", ["random", "periodic"])
def test_signals_far_beyond_any_converter_cost_no_memory(kind):
    y = frames(Ramp(1e5), MissingCodes(0.1, kind), shape=(8, 8), pedestal=1e12)
    assert 0 < y.max() <= 1 << 20


def test_guess_from_the_roughness_of_the_histogram():
    clues = Given(
        seen={"code_roughness": 0.25, "code_comb_period": 8 / 3},
        model={"code_roughness": 0.05}, off={"code_roughness": 9.0},
    )  # fmt: skip
    (effect,) = MissingCodes.guess(clues)
    assert effect.kind == "random"
    assert effect.sigma == pytest.approx(0.245, abs=0.01)
    clues.off["code_comb"] = 9.0
    first = MissingCodes.guess(clues)[0]
    assert (first.kind, first.period) == ("periodic", 8)
    assert MissingCodes.guess(Given()) == []


WIDTHS = (-0.6, 0.0, 0.0, 0.6)


def rough(settings, period):
    """Clues of a rough histogram, its codes and counts at each setting, and the comb it shows."""
    codes, n = zip(*settings, strict=True)
    return Given(
        points=tuple(OperatingPoint(25.0 + 20.0 * i, 1.0, 1.0) for i in range(len(settings))),
        seen={"code_roughness": 0.4, "code_comb_period": period},
        off={"code_roughness": 9.0, "code_comb": 9.0},
        curves={"histogram_codes": codes, "histogram_counts": n},
    )


def converted(x):
    """Codes and counts where every fourth edge is .6 DN too high."""
    upper = np.arange(1, 401)
    edges = upper - 0.5 + 0.6 * (upper % 4 == 0)
    return np.unique(np.searchsorted(edges, x, side="right"), return_counts=True)


def test_measured_widths_keep_their_places():
    width, se = counts(MissingCodes(0.3, "periodic", 4, WIDTHS))
    folded = width.reshape(-1, 4).mean(axis=0)
    wanted = 1.0 + 0.3 * np.array(WIDTHS) / np.std(WIDTHS)
    np.testing.assert_allclose(folded, wanted, atol=5 * se / np.sqrt(width.size / 4))


@pytest.mark.parametrize("widths", [(1.0, 2.0), (1.0, 1.0, 1.0, 1.0)])
def test_widths_that_make_no_pattern_are_refused(widths):
    with pytest.raises(InputError, match=r"missing_codes\.widths"):
        MissingCodes(0.3, "periodic", 4, widths)


def test_guess_reads_the_widths_off_the_histogram():
    codes, n = converted(200.3 + 20.0 * np.random.default_rng(3).standard_normal(200_000))
    clues = rough([(codes, n)], 4.0)
    effect = MissingCodes.guess(clues)[0]
    assert (effect.kind, effect.period) == ("periodic", 4)
    d = effect.sigma * np.array(effect.widths)
    # counts of 50,000 in each class of codes: .5 %
    np.testing.assert_allclose(d, WIDTHS, atol=5 * 0.005 * 1.6)


def test_one_edge_is_tried_without_the_noise_of_the_others_and_no_period_twice():
    rng = np.random.default_rng(4)
    settings = [converted(64.2 + level + 0.9 * rng.standard_normal(50_000)) for level in (0, 2, 5)]
    clues = rough(settings, 4.0)
    first, second, *rest = MissingCodes.guess(clues)
    np.testing.assert_allclose(first.widths, np.array(WIDTHS) / np.std(WIDTHS), atol=1e-3)
    assert first.sigma == pytest.approx(np.std(WIDTHS), abs=0.1)
    assert second.period == 4
    assert second.widths != first.widths
    assert [e.kind for e in rest] == ["random"]


@pytest.mark.parametrize("period", [2, 8, 16])
def test_the_period_is_the_one_that_the_next_longer_only_repeats(period):
    edges = np.arange(1, 4096) - 0.5 + 0.6 * (np.arange(1, 4096) % period == 0)
    rng = np.random.default_rng(5)
    # a tail, as of dark current, that no short polynomial follows
    x = (
        200.3
        + 1.2 * rng.standard_normal(300_000)
        + np.exp(3.0 + 0.8 * rng.standard_normal(300_000))
    )
    codes, n = np.unique(np.searchsorted(edges, x, side="right"), return_counts=True)
    clues = rough([(codes, n)], 3.0)  # the harmonic that is strongest
    effect = MissingCodes.guess(clues)[0]
    assert (effect.kind, effect.period) == ("periodic", period)
    d = effect.sigma * np.array(effect.widths)
    np.testing.assert_allclose(d[[0, -1]], (-0.6, 0.6), atol=0.05)


@pytest.mark.parametrize(("gain", "kinds"), [(0.8, ["random"]), (4 / 3, ["random"])])
def test_widths_that_a_digital_gain_makes_are_left_to_it(gain, kinds):
    x = 200.3 + 20.0 * np.random.default_rng(6).standard_normal(200_000)
    codes, n = np.unique(np.rint(np.rint(x) * gain), return_counts=True)
    clues = rough([(codes, n)], 4.0)
    assert [e.kind for e in MissingCodes.guess(clues)] == kinds


@pytest.mark.parametrize("wide", [1.5, 2.6])
def test_one_wide_code_that_is_not_just_twice_as_wide_is_the_converters(wide):
    widths = np.tile([wide, 1.0, 1.0, 1.0], 300)
    edges = np.cumsum(widths / widths.mean()) - 0.5
    x = 200.3 + 20.0 * np.random.default_rng(6).standard_normal(200_000)
    codes, n = np.unique(np.searchsorted(edges, x, side="right"), return_counts=True)
    clues = rough([(codes, n)], 4.0)
    first = MissingCodes.guess(clues)[0]
    assert (first.kind, first.period) == ("periodic", 4)
