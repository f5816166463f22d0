"""Laws over temperature."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.laws import ArrheniusLaw, TableLaw, law_from_plain, value_at
from dnanalyze.thermal import arrhenius


def test_arrhenius_doubles_every_8_5_kelvin_for_depletion_current():
    # physics: k T^2 ln 2 / Ea at 300 K and Ea = .634 eV is 8.5 K
    step = 8.617333e-5 * 300**2 * math.log(2) / 0.634
    at = 300 - 273.15
    assert arrhenius(at + step / 2, at - step / 2, 0.634) == pytest.approx(2.0, rel=1e-3)


def test_arrhenius_of_unknown_temperature_is_one():
    assert arrhenius(None, 25.0, 0.6) == 1.0


def test_a_law_without_slope_is_its_number_to_the_last_bit():
    flat = ArrheniusLaw(0.3712345, 7.0, 0.0)
    assert {value_at(flat, OperatingPoint(t)) for t in (-40.0, 7.0, 105.0)} == {0.3712345}


def test_a_negative_energy_falls_as_it_warms():
    law = ArrheniusLaw(0.145, -10.2, -0.265)
    # .145 exp(.265 / 8.617333e-5 (1/272.95 - 1/262.95)) at -.2 C
    assert law.at(OperatingPoint(-0.2)) == pytest.approx(0.09447, rel=1e-4)
    assert law.at(OperatingPoint(-10.2)) == 0.145


def test_table_gives_its_rows_and_is_linear_in_inverse_temperature_between():
    law = TableLaw((OperatingPoint(0.0), OperatingPoint(100.0)), (1.0, 3.0))
    assert law.at(OperatingPoint(0.0)) == 1.0
    assert law.at(OperatingPoint(100.0)) == 3.0
    middle = 2.0 / (1 / 273.15 + 1 / 373.15) - 273.15
    assert law.at(OperatingPoint(middle)) == pytest.approx(2.0)
    assert law.at(OperatingPoint(150.0)) == 3.0


def test_table_prefers_the_matching_channel_then_exposure():
    rows = tuple(
        OperatingPoint(t, e, None, c)
        for c in ("hcg", "lcg")
        for e in (0.1, 1.0)
        for t in (20.0, 40.0)
    )
    law = TableLaw(rows, tuple(float(i) for i in range(8)))
    assert law.at(OperatingPoint(40.0, 1.0, None, "lcg")) == 7.0
    assert law.at(OperatingPoint(20.0, 0.1, None, "hcg")) == 0.0
    assert law.at(OperatingPoint(20.0, 0.9, None, "lcg")) == 6.0


@given(
    st.one_of(
        st.floats(-1e6, 1e6),
        st.builds(ArrheniusLaw, st.floats(1e-3, 1e3), st.floats(-100, 150), st.floats(-2, 2)),
        st.lists(st.tuples(st.floats(-100, 150), st.floats(-9, 9)), min_size=1, max_size=5).map(
            lambda rows: TableLaw(
                tuple(OperatingPoint(t) for t, _ in rows), tuple(v for _, v in rows)
            )
        ),
    )
)
def test_laws_survive_their_written_form(law):
    plain = law.to_plain() if hasattr(law, "to_plain") else law
    again = law_from_plain("x", plain)
    point = OperatingPoint(31.0)
    assert value_at(again, point) == value_at(law, point)


@pytest.mark.parametrize(
    "bad", [None, "x", True, float("nan"), {}, {"value": 1}, {"table": []}, []]
)
def test_what_is_no_law_is_refused_with_the_valid_forms(bad):
    with pytest.raises(InputError, match=r"x: .*give a number"):
        law_from_plain("x", bad)
