"""Each hidden effect of the charge against its own formula."""

import math

import numpy as np
import pytest
from demo_stacks import CALM, COLD, HOT, added, stack
from scipy.stats import kstest

from dnanalyze.demo.charge import CHARGE
from dnanalyze.demo.hidden import Moment, Scene, generator
from dnanalyze.demo.sensor import arrhenius

SHAPE = (192, 256)
PIXELS = SHAPE[0] * SHAPE[1]
BY_NAME = {e.name: e for e in CHARGE}


def excess(name: str, celsius: float = HOT, base: float = 0.0, shape=SHAPE, **parameters):
    """Extra mean charge of an exposure, e-, that a step adds to a constant rate."""
    scene = Scene(CALM, shape)
    step = BY_NAME[name].build(scene, generator(1, name), **parameters)
    rate = np.full(shape, base)
    return (step.apply(rate, Moment(celsius, 0, generator(0))) - rate) * CALM.exposure_s


def test_hot_pixels_are_exponential_and_follow_their_own_arrhenius_law():
    hot = excess("hot_pixels", fraction=0.02, e=50.0, activation_ev=0.5)
    sites = hot[hot > 0]
    se = math.sqrt(0.02 * 0.98 / PIXELS)
    assert sites.size / PIXELS == pytest.approx(0.02, abs=5 * se)
    assert sites.mean() == pytest.approx(50.0, rel=5 / math.sqrt(sites.size))
    assert sites.std() == pytest.approx(50.0, rel=5 * math.sqrt(2 / sites.size))  # exp: sd = mean
    cold = excess("hot_pixels", COLD, fraction=0.02, e=50.0, activation_ev=0.5)
    np.testing.assert_allclose(cold, hot / arrhenius(HOT, 0.5, COLD))


def test_hot_clusters_have_the_right_number_and_are_clustered():
    fraction, offspring, radius = 2e-3, 5.0, 1.5
    hot = excess("hot_clusters", fraction=fraction, e=50.0, activation_ev=0.5,
                 offspring=offspring, radius=radius)  # fmt: skip
    # Compound Poisson: variance of the sum = n (mean^2 + variance) per offspring, 2 e^2, and the
    # parents' scatter.
    parents = fraction * PIXELS
    expected = parents * offspring * 50.0
    sd = 50.0 * math.sqrt(parents * (2 * offspring + offspring**2))
    assert hot.sum() == pytest.approx(expected, abs=5 * sd)
    mask = hot > 0
    pairs = np.mean(mask[:, 1:] & mask[:, :-1])
    chance = mask.mean() ** 2
    assert pairs > 5 * chance


def test_dark_current_steps_are_poisson_multiples():
    q = excess("dark_current_steps", mean_atoms=0.3, e=40.0, activation_ev=0.37) / 40.0
    np.testing.assert_allclose(q, np.rint(q), atol=1e-9)
    assert q.mean() == pytest.approx(0.3, abs=5 * math.sqrt(0.3 / PIXELS))
    assert q.var() == pytest.approx(0.3, abs=5 * math.sqrt((0.3 + 2 * 0.09) / PIXELS))


def test_rts_has_its_two_levels_dwell_times_and_temporal_variance():
    fraction, e, high, low = 0.1, 60.0, 2.0, 4.0
    hidden = {"rts": {"fraction": fraction, "e": e, "activation_ev": 0.0,
                      "frames_high": high, "frames_low": low}}  # fmt: skip
    x = stack(hidden, frames=40) / CALM.gain_dn_e
    bare = stack(None, frames=40) / CALM.gain_dn_e
    blinks = np.ptp(x, axis=0) > 6.5 * np.median(bare.std(axis=0)) + e / 3
    assert blinks.mean() == pytest.approx(fraction, rel=0.05)

    up = x[:, blinks] - bare.mean(axis=0)[blinks] > e / 2
    # tau_1 tau_0 / (tau_1 + tau_0)^2 holds for slow blinking; in frames, by the chances to leave.
    leave_high, leave_low = -math.expm1(-1 / high), -math.expm1(-1 / low)
    occupied = leave_low / (leave_low + leave_high)
    assert up.mean() == pytest.approx(occupied, rel=0.03)
    assert np.mean(~up[1:][up[:-1]]) == pytest.approx(leave_high, rel=0.03)
    assert np.mean(up[1:][~up[:-1]]) == pytest.approx(leave_low, rel=0.03)


def test_rts_of_the_dark_current_shrinks_when_cold():
    def amplitude(celsius):
        scene = Scene(CALM, (8, 8))
        step = BY_NAME["rts"].build(scene, generator(1), fraction=1.0, e=100.0, activation_ev=0.6,
                                    frames_high=1e9, frames_low=1e-9)  # fmt: skip
        return step.apply(np.zeros((8, 8)), Moment(celsius, 0, generator(1)))[0, 0]

    assert amplitude(HOT) == 100.0
    assert amplitude(COLD) == pytest.approx(100.0 / arrhenius(HOT, 0.6, COLD))


def test_amp_glow_falls_from_its_corner_and_is_not_thermal():
    e_s, length = 2000.0, 0.2
    glow = excess("amp_glow", COLD, e_s=e_s, length=length, corner=[1, 0])
    assert glow[-1, 0] == pytest.approx(e_s * CALM.exposure_s)
    away = length * SHAPE[1]
    k = round(away)
    assert glow[-1, k] / glow[-1, 0] == pytest.approx(math.exp(-k / away))
    np.testing.assert_allclose(glow, excess("amp_glow", HOT, e_s=e_s, length=length, corner=[1, 0]))


def test_dark_gradient_is_relative_and_keeps_the_mean():
    more = excess("dark_gradient", base=100.0, relative=0.2, angle=0.7, bow=0.3) / CALM.exposure_s
    assert np.ptp(more) == pytest.approx(20.0)
    assert more.mean() == pytest.approx(0.0, abs=1e-9)
    flat = excess("dark_gradient", base=100.0, relative=0.2, angle=0.0, bow=0.0) / CALM.exposure_s
    np.testing.assert_allclose(np.diff(flat, axis=1), 20.0 / (SHAPE[1] - 1))


@pytest.mark.parametrize("upward", [False, True])
def test_charge_of_storage_nodes_grows_until_the_row_is_read(upward):
    numbers = {"e": 30.0, "variation": 0.8, "hold": 1.0, "activation_ev": 0.6, "upward": upward}
    q = excess("storage_dark_current", **numbers) / CALM.exposure_s
    q = q[::-1] if upward else q
    wait = 30.0 * (1.0 + np.arange(SHAPE[0]) / (SHAPE[0] - 1)) / 2.0
    share = q / wait[:, None]
    assert share.mean() == pytest.approx(1.0, abs=5 * 0.8 / math.sqrt(PIXELS))
    assert share.std() == pytest.approx(0.8, rel=0.03)  # of a gamma law
    halves = [half.std() for half in np.array_split(share, 2)]
    assert halves[0] == pytest.approx(halves[1], rel=0.05)
    cold = excess("storage_dark_current", COLD, **numbers) / CALM.exposure_s
    np.testing.assert_allclose((cold[::-1] if upward else cold) * arrhenius(HOT, 0.6, COLD), q)


def test_generation_is_exponential_over_all_pixels():
    numbers = {"share": 0.4, "less_ev": 0.1}
    x = 1.0 + excess("dark_current_fpn", base=2.0, **numbers) / CALM.exposure_s / 2.0
    assert kstest(x.ravel(), "expon", (0.6, 0.4)).statistic < 1.95 / math.sqrt(PIXELS)  # 1 in 1,000
    cold = excess("dark_current_fpn", COLD, base=2.0, **numbers) / CALM.exposure_s / 2.0
    part = min(1.0, 0.4 * arrhenius(COLD, -0.1, HOT))
    np.testing.assert_allclose(cold, (x - 1.0) * part / 0.4, atol=1e-12)


def test_cosmic_rays_bring_their_charge_once():
    tracks, e, length = 4000.0, 400.0, 4.0
    hit = added({"cosmic_rays": {"per_megapixel": tracks, "e": e, "length": length}}, frames=12)
    # A track deposits e a pixel of path, 1 + Exp(length) long, less what leaves the frame.
    number = tracks * 1e-6 * PIXELS * 12
    total = number * e * (1 + length + 0.125)
    relative = 5 * math.sqrt(2 * (1 + (length / (1 + length)) ** 2) / number) + 0.02
    assert hit.sum() == pytest.approx(total, rel=relative)
    marked = hit > 50
    assert not np.any(marked[1] & marked[0] & marked[2])
    beside = np.mean(marked[:, 1:] & marked[:, :-1]) / np.mean(marked)
    assert beside > 10 * marked.mean()


def test_persistence_correlates_a_frame_with_the_one_before():
    share, tau = 0.3, 1.0
    x = stack({"persistence": {"share": share, "frames": tau}}, HOT, frames=40)
    # q_n + a sum d^k q_(n-k), d = exp(-1/tau), q Poisson: weights w_0 = 1, w_k = a d^k.
    d = math.exp(-1 / tau)
    tail = share**2 * d**2 / (1 - d**2)
    lag1 = share * d + share**2 * d**3 / (1 - d**2)
    dark, noise = CALM.dark_e(HOT), CALM.noise_e**2
    k2 = CALM.gain_dn_e**2
    # Differences two apart remove the pattern: E[(x_n - x_m)^2] / 2 = c_0 - c_(n-m).
    lag2 = lag1 * d
    for lag, c in [(1, lag1), (2, lag2)]:
        half = np.mean((x[lag:] - x[:-lag]) ** 2) / 2
        assert half == pytest.approx(k2 * (dark * (1 + tail - c) + noise), rel=0.02)
    mean = (x.mean() - CALM.pedestal_dn) / CALM.gain_dn_e
    assert mean == pytest.approx(dark * (1 + share * d / (1 - d)), rel=0.01)


def test_crosstalk_correlates_shot_noise_of_neighbours():
    share, diagonal = 0.05, 0.4
    x = stack({"crosstalk": {"share": share, "diagonal": diagonal}}, HOT, frames=12)
    d = (x[1::2] - x[::2]) / math.sqrt(2) / CALM.gain_dn_e
    dark = CALM.dark_e(HOT)
    s, g = share, share * diagonal
    centre = 1 - 4 * s - 4 * g
    # Covariances of the kernel with itself; read noise comes later and stays white.
    near = 2 * centre * s + 4 * s * g
    corner = 2 * centre * g + 2 * s**2

    def lag(dy, dx):
        a = d[:, : d.shape[1] - dy, : d.shape[2] - dx]
        return np.mean(a * d[:, dy:, dx:])

    se = d.var() / math.sqrt(d.size)
    assert lag(0, 1) == pytest.approx(dark * near, abs=5 * se + 0.02 * dark * near)
    assert lag(1, 0) == pytest.approx(dark * near, abs=5 * se + 0.02 * dark * near)
    assert lag(1, 1) == pytest.approx(dark * corner, abs=5 * se + 0.02 * dark * corner)
    assert lag(0, 3) == pytest.approx(0.0, abs=5 * se)
    power = centre**2 + 4 * s**2 + 4 * g**2
    assert d.var() == pytest.approx(dark * power + CALM.noise_e**2, rel=0.02)
