"""Detection limits: the strength that would be called missing."""

from dataclasses import replace

import numpy as np
import pytest

from dnanalyze.diagnosis.detectability import _View, detection_limits
from dnanalyze.diagnosis.selection import EVIDENCE_ODDS_10
from dnanalyze.fitting.derivatives import derive
from dnanalyze.fitting.design import design
from dnanalyze.fitting.problem import fit_problem
from dnanalyze.fitting.state import start
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effect import Placing
from dnanalyze.model.laws import TableLaw
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import built_in
from dnanalyze.model.simulate import simulate

KNOWN = built_in()
POINTS = [OperatingPoint(t, 0.1, 1.0) for t in (25.0, 45.0, 65.0)]
OF_READOUT, OF_CHARGE = "row_fpn", "crosstalk"


@pytest.fixture(scope="module")
def state():
    effects = (
        KNOWN["convolved_lognormal"](
            mu=TableLaw(tuple(POINTS), (0.0, 2.5, 5.0)), delta=0.5, sigma=1e-6
        ),
        KNOWN["dark_shot_noise"](dn_per_e=0.5),
        KNOWN["read_noise"](sigma=2.0),
        KNOWN["pixel_fpn"](sigma=1.0),
        KNOWN["quantization"](),
    )
    model = NoiseModel(effects, 100.0, POINTS[0], seed=5)
    problem = fit_problem(design(simulate(model, (128, 128), [(p, 4) for p in POINTS])))
    return problem, derive(problem, start(problem, model))


def with_effect(state, name, **numbers):
    return state.model.with_effect(KNOWN[name](**numbers))


def test_several_settings_show_what_the_best_of_them_shows(state):
    problem, fitted = state
    both = _View.of(problem, fitted, [0, 2], Placing.SOMEWHERE)
    alone = [_View.of(problem, fitted, [s], Placing.SOMEWHERE) for s in (0, 2)]
    for name, numbers, best in (
        (OF_READOUT, {"sigma": 1.0}, 0), (OF_CHARGE, {"alpha": 0.03}, 1),
    ):  # fmt: skip
        model = with_effect(fitted, name, **numbers)
        gains = [view.gains([model])[0] for view in alone]
        assert int(np.argmax(gains)) == best
        assert both.gains([model])[0] == pytest.approx(gains[best])


def test_what_the_models_own_numbers_absorb_is_not_seen(state):
    problem, fitted = state
    view = _View.of(problem, fitted, [0], Placing.SOMEWHERE)
    noise = fitted.model.get("read_noise")
    moved = fitted.model.with_effect(replace(noise, sigma=noise.sigma * 1.05))
    (change,) = view.changes.by([moved])
    assert view.gains([moved])[0] < 0.3 * float(np.sum(change**2))


@pytest.mark.parametrize(("name", "parameter"), [(OF_READOUT, "sigma"), (OF_CHARGE, "alpha")])
def test_at_its_limit_an_effect_gains_about_what_is_asked(state, name, parameter):
    problem, fitted = state
    found = detection_limits(problem, fitted, {name: KNOWN[name]})[name]
    limit = found.value
    assert (found.effect, found.parameter) == (name, parameter)
    assert str(found).startswith(f"{name} is detectable from {parameter} = ")
    view = _View.of(problem, fitted, [0, 2], Placing.SOMEWHERE)
    gains = view.gains([with_effect(fitted, name, **{parameter: limit * f}) for f in (0.3, 1, 3)])
    # a power law carries the limit from where the effect shows plainly
    assert EVIDENCE_ODDS_10 / 5 < gains[1] < 5 * EVIDENCE_ODDS_10
    assert gains[0] < EVIDENCE_ODDS_10 / 2
    assert gains[2] > 2 * EVIDENCE_ODDS_10


def test_what_is_in_the_model_or_has_no_strength_has_no_limit(state):
    problem, fitted = state
    known = {n: KNOWN[n] for n in ("read_noise", "quantization")}
    assert detection_limits(problem, fitted, known) == {}
