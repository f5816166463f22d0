"""The fit finds known parameters, and its standard errors mean what they say."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import small_series as small
from scipy.stats import f as fisher

from dnanalyze.fitting.fit import Fit, fit, with_uncertainties
from dnanalyze.fitting.state import start
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import built_in
from dnanalyze.model.simulate import simulate

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

import fit_pulls

REPLICATES = 24


def percentile(found: Fit, pulls: dict[str, float]) -> float:
    """Of Hotelling's T^2 = p' C^-1 p, C the correlations as estimated from REPLICATES sensors."""
    p = np.array(list(pulls.values()))
    count = len(p)
    t2 = p @ np.linalg.solve(found.correlations, p)
    scaled = t2 * (REPLICATES - count) / (count * (REPLICATES - 1))
    return float(fisher.cdf(scaled, count, REPLICATES - count))


@pytest.mark.long
@pytest.mark.parametrize("seed", ["fixed", pytest.param("redrawn", marks=pytest.mark.slow)])
def test_all_parameters_together_lie_within_their_errors(seed):
    pulls, found = fit_pulls.one(seed, 1001, (64, 96), 3, REPLICATES)
    assert found.undetermined == []
    assert 1e-4 < percentile(found, pulls) < 1 - 1e-4


@pytest.mark.slow
def test_the_model_s_own_random_numbers_hardly_matter():
    # Two fits of one series share the measured sensor; they differ by their 25 simulated ones, 2/25
    # of the variance of one sensor against the 26/25 that are quoted: .28 of the error. 5 sigma.
    true = fit_pulls.truth("fixed", 1002)
    series, begun = fit_pulls.captures(true, (64, 96)), fit_pulls.begin(true, 1002)
    one, other = (
        fit(series, replace(begun, seed=seed), replicates=REPLICATES) for seed in (7000, 8000)
    )
    for a, b in zip(one.parameters, other.parameters, strict=True):
        assert abs(a.value - b.value) < 5 * 0.28 * max(a.se, b.se), a.name


def test_what_one_temperature_cannot_tell_is_said():
    known = built_in()
    base = replace(fit_pulls.truth("fixed", 1).effects[0], mu=2.4, sigma=1e-6)
    point = fit_pulls.POINTS[2]
    effects = (
        base,
        known["dark_shot_noise"](dn_per_e=0.3),
        known["hot_pixels"](fraction=0.01, scale=60.0, ea_ev=0.5),
        known["read_noise"](sigma=1.5),
    )
    true = NoiseModel(effects, 64.0, point, seed=1003)
    series = simulate(true, (64, 96), [(point, 4)])
    found = fit(
        series, replace(true, seed=9000), frozen=["read_noise.spread"], replicates=REPLICATES
    )
    said = found.undetermined
    assert (
        "not determined: hot_pixels.ea_ev, kept; these captures give no activation energy" in said
    )
    # Level, shot noise and skewness of the Poisson count are all that tells the pedestal from mu.
    assert any("pedestal and convolved_lognormal.mu" in s for s in said)


@pytest.mark.slow
def test_pulls_over_a_hundred_fits():
    # Asked: mean 0 +- .2, sd 1 +- .2. The mean of 100 has an error of .1, their sd one of .07:
    # two of them are allowed on top.
    rows = [fit_pulls.one("fixed", n, (96, 96), 3, REPLICATES)[0] for n in range(1, 101)]
    for name in rows[0]:
        x = np.array([row[name] for row in rows])
        assert abs(x.mean()) < 0.2 + 2 * 0.1, name
        assert abs(x.std(ddof=1) - 1) < 0.2 + 2 * 0.07, name


@pytest.mark.slow
def test_paper_and_ten_effects_over_five_temperatures():
    known = built_in()
    effects = (
        *fit_pulls.truth("fixed", 1).effects,
        known["dark_shot_noise"](dn_per_e=0.3),
        known["hot_pixels"](fraction=4e-3, scale=60.0, ea_ev=0.5),
        known["amp_glow"](amplitude=8.0, length=0.3, ea_ev=0.6),
        known["read_noise"](sigma=1.5, spread=0.2),
        known["pixel_fpn"](sigma=1.5),
        known["column_fpn"](sigma=0.6),
        known["row_noise"](sigma=0.5),
        known["periodic_pattern"](amplitude=0.8, u=0.07, v=0.19),
        known["flicker_noise"](rms=0.8, alpha=1.0),
        known["quantization"](bits=12),
    )
    true = NoiseModel(effects, 64.0, fit_pulls.POINTS[2], seed=1004)
    found = fit(
        fit_pulls.captures(true, (160, 160), 4),
        fit_pulls.begin(true, 1004),
        replicates=REPLICATES,
    )
    pulls = fit_pulls.pulls(found, true)
    assert len(pulls) == 25
    # Student's t of 23 degrees of freedom: beyond 5 once in 20000.
    assert max(abs(p) for p in pulls.values()) < 5, pulls
    assert np.mean(np.square(list(pulls.values()))) < 2.5, pulls
    # The spread of 80 drawn offsets is known to 1/sqrt(160) at best, whatever the model.
    column = next(p for p in found.parameters if p.name == "column_fpn.sigma")
    assert 0.5 / np.sqrt(160) < column.se / column.value < 3 / np.sqrt(160)
    assert np.all(np.abs(found.correlations) < 1 + 1e-9)


def test_standard_errors_do_not_depend_on_the_weights_with_which_a_fit_began():
    """They are those of the misfit that is left at its end."""
    problem, model = small.fit_problem_of(), small.model()
    state = start(problem, model)
    one, other = (
        with_uncertainties(problem.weighted(share), state, 4).parameters for share in (0.0, 1.0)
    )
    assert [p.se for p in one] == [p.se for p in other]
