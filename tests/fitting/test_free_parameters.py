"""The free numbers of a model as a vector."""

import numpy as np
import pytest

from dnanalyze.fitting.free_parameters import free_parameters, positions, settings_of, with_values
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.laws import ArrheniusLaw, TableLaw
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import built_in

COLD, HOT = OperatingPoint(25.0, 0.1), OperatingPoint(65.0, 0.1)


def model() -> NoiseModel:
    known = built_in()
    mu = TableLaw((OperatingPoint(25.0), OperatingPoint(65.0)), (0.5, 2.5))
    sigma = ArrheniusLaw(1.5, 25.0, 0.1)
    effects = (
        known["convolved_lognormal"](mu=mu, delta=0.4, sigma=1e-6),
        known["read_noise"](sigma=sigma),
    )
    return NoiseModel(effects, 64.0)


def test_every_free_number_is_named_once_and_what_is_off_is_left_out():
    names = [k.name for k in free_parameters(model())]
    assert len(set(names)) == len(names)
    assert {"pedestal", "convolved_lognormal.mu[0]", "convolved_lognormal.mu[1]"} <= set(names)
    assert {"read_noise.sigma", "read_noise.sigma.ea_ev"} <= set(names)
    assert "convolved_lognormal.sigma" not in names  # at its lower bound: off
    assert "pedestal" not in [k.name for k in free_parameters(model(), ("pedestal",))]


def test_turning_to_the_present_positions_changes_nothing():
    free = free_parameters(model())
    again = with_values(model(), free, positions(model(), free))
    np.testing.assert_allclose(positions(again, free), positions(model(), free), rtol=1e-12)


def test_turning_moves_what_it_names_and_stays_within_bounds():
    free = free_parameters(model())
    where = positions(model(), free)
    i = [k.name for k in free].index("read_noise.sigma")
    where[i] += np.log(2.0)
    assert np.isclose(with_values(model(), free, where).get("read_noise").value("sigma", COLD), 3.0)
    where[i] = 1e3
    assert with_values(model(), free, where).get("read_noise").sigma.value == 1e4


def test_an_energy_may_be_negative():
    """Of what falls as it warms, such as the relative spread of dark current."""
    spread = ArrheniusLaw(0.4, 25.0, -0.3)
    light = built_in()["convolved_lognormal"](delta=spread)
    free = free_parameters(NoiseModel((light,), 64.0))
    at = [k.name for k in free].index("convolved_lognormal.delta.ea_ev")
    falling = NoiseModel((light,), 64.0)
    where = positions(falling, free)
    assert where[at] == -0.3
    assert with_values(falling, free, where).get("convolved_lognormal").delta.ea_ev == -0.3


def test_rows_of_a_table_move_their_own_settings():
    free = {k.name: k for k in free_parameters(model())}
    settings = [(COLD, 4), (HOT, 4)]
    row = free["convolved_lognormal.mu[1]"]
    assert settings_of(row, model(), settings).tolist() == [False, True]
    assert settings_of(free["pedestal"], model(), settings).tolist() == [True, True]
    assert row.group == free["convolved_lognormal.mu[0]"].group


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_sign_that_was_measured_is_kept(sign):
    effect = built_in()["cfa_mismatch"](u=0.3 * sign, v=-0.2 * sign, uv=0.0)
    made = NoiseModel((effect,), 64.0)
    free = free_parameters(made, ("pedestal",))
    for step in (-5.0, 5.0):
        where = [k.inside(x + step) for k, x in zip(free, positions(made, free), strict=True)]
        moved = with_values(made, free, np.array(where)).get("cfa_mismatch")
        assert moved.u * sign >= 0.0
        assert moved.v * sign <= 0.0
        assert moved.uv == step  # of no sign yet


def test_a_length_at_its_lower_bound_stays_free():
    made = NoiseModel((built_in()["column_fpn"](settle=9.0, length=1.0),), 64.0)
    assert "column_fpn.length" in [k.name for k in free_parameters(made)]


@pytest.mark.parametrize(
    ("effect", "held"),
    [
        ("periodic_pattern", {"u", "v", "phase", "more", "linewidth", "added"}),
        ("stuck_pixels", {"code", "codes", "columns", "rows"}),
        ("digital_gain", {"gain", "offset", "top"}),
        ("black_clipping", {"level"}),
        (
            "column_taps",
            {
                "kind",
                "taps",
                "levels",
                "slip",
                "begins",
                "axis",
                "settle",
                "length",
                "side",
                "added",
            },
        ),
        ("missing_codes", {"kind", "period", "widths"}),
        ("defect_lines", {"axis", "lines", "offsets", "begins", "ends"}),
    ],
)
def test_what_a_statistic_locates_is_no_free_number(effect, held):
    made = NoiseModel((built_in()[effect](),), 64.0)
    free = {k.parameter for k in free_parameters(made, ("pedestal",))}
    assert set(built_in()[effect].parameters()) - free == held
