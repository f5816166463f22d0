"""Numbers with a standard error and a unit, and tables of them."""

import math

import astropy.units as u
import numpy as np
import pytest

import dnanalyze
from dnanalyze.analyzers.statistics import Scale
from dnanalyze.demo import tiny
from dnanalyze.diagnosis.detectability import DetectionLimit
from dnanalyze.emva.quantity import Kind, Quantity, unknown
from dnanalyze.estimate import Estimate, astropy_unit, qtable
from dnanalyze.fitting.fit import Parameter, Parameters


def test_an_estimate_prints_its_value_to_the_digits_of_its_error():
    assert str(Estimate(3.0617, 0.0039, "DN")) == "3.0617 ± 0.0039 DN"
    assert str(Estimate(12.0, math.nan, "e-/s")) == "12 e⁻/s"
    assert str(unknown(Kind("k", "K", "gain", "DN/e-"), "one frame")) == "not determined"


def test_the_interval_of_95_percent_is_symmetric_unless_it_is_given():
    one = Estimate(10.0, 2.0)
    assert (one.low, one.high) == pytest.approx((10 - 3.92, 10 + 3.92))
    low, high = Scale.LOG.ends(10.0, 0.2, 1.96)
    skewed = Estimate(10.0, 2.0, "DN^2", (low, high))
    assert skewed.low * skewed.high == pytest.approx(100.0)
    assert math.isnan(Estimate(10.0).low)


@pytest.mark.parametrize(
    ("text", "unit"),
    [
        ("DN", u.DN),
        ("DN^2", u.DN**2),
        ("DN/e-", u.DN / u.electron),
        ("e-/s", u.electron / u.s),
        ("C", u.deg_C),
        ("%", u.percent),
        ("c/px", u.cycle / u.pix),
        ("eV", u.eV),
        ("1", u.dimensionless_unscaled),
        ("1/pixel", 1 / u.pix),
        ("ln DN", u.dimensionless_unscaled),
        ("1/(Mpx s)", u.dimensionless_unscaled),
    ],
)
def test_units_are_astropys(text, unit):
    assert astropy_unit(text) == unit


def test_a_quantity_converts():
    assert Estimate(2.0, 0.1, "DN/s").quantity.to(u.DN / u.h).value == pytest.approx(7200.0)
    limit = DetectionLimit("column_fpn", "sigma", 0.02, "DN")
    assert limit.quantity == 0.02 * u.DN
    assert "detectable from" in str(limit)


def test_columns_have_units_and_errors_only_where_there_are_any():
    table = qtable(
        [
            {"place": "a", "noise": Estimate(1.0, 0.1, "DN"), "time": Estimate(5.0, unit="s")},
            {"time": Estimate(6.0, unit="s"), "gain": 2.0},
        ]
    )
    assert table.colnames == ["place", "noise", "noise_se", "time", "gain"]
    assert table["noise"].unit == u.DN
    assert math.isnan(table["noise"][1].value)
    assert list(table["place"]) == ["a", ""]
    assert math.isnan(table["gain"][0])


def test_a_statistic_and_its_table_agree_with_the_table_of_the_csv():
    found = dnanalyze.analyze(tiny())
    rows, cells = found["temporal_noise"], [s["temporal_noise"] for s in found.settings]
    for column in ("value", "se", "low", "high"):
        assert rows[column].tolist() == pytest.approx([getattr(c, column) for c in cells])
    table = found.to_qtable()
    assert table["temporal_noise_se"].to_value(u.DN) == pytest.approx(rows["se"].to_numpy())
    with pytest.raises(KeyError, match="temporal_noise"):
        found.settings[0]["temporal_noize"]


def test_emva_quantities_stand_in_rows_of_where_they_hold():
    emva = dnanalyze.analyze(tiny(), system_gain=0.5).emva
    long, wide = emva.to_dataframe(), emva.to_qtable()
    noise = long[long["quantity"] == "temporal_dark_noise_e"]["value"].to_numpy(float)
    column = wide["temporal_dark_noise_e"]
    assert column.unit == u.electron
    assert column.value[np.isfinite(column.value)] == pytest.approx(noise)
    assert isinstance(emva.groups[0].points[0].quantities["dsnu_dn"], Quantity)


def test_parameters_are_one_row():
    both = Parameters((Parameter("pedestal", 64.0, 0.1, "DN"), Parameter("a.ea", 0.7, 0.02, "eV")))
    table = both.to_qtable()
    assert len(table) == 1
    assert table["a.ea"].unit == u.eV
    assert table["pedestal_se"][0] == 0.1 * u.DN
    assert both["pedestal"].high == pytest.approx(64.196)
