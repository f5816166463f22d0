import pytest

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.laws import TableLaw
from dnanalyze.model.registry import built_in
from dnanalyze.model.strength import STRENGTHS, at_factor, strength_of

KNOWN = built_in()


def test_a_strength_is_multiplied_and_nothing_else():
    glow = KNOWN["amp_glow"](amplitude=30.0, length=0.2)
    weaker = at_factor(glow, 0.1)
    assert weaker.amplitude == pytest.approx(3.0)
    assert weaker == KNOWN["amp_glow"](amplitude=weaker.amplitude, length=0.2)


def test_of_a_surface_all_terms_are_multiplied():
    slope = KNOWN["dark_gradient"](x=-8.0, y=4.0, xx=2.0, ea_ev=0.6)
    weaker = at_factor(slope, 0.25)
    assert (weaker.x, weaker.y, weaker.xx, weaker.ea_ev) == (-2.0, 1.0, 0.5, 0.6)


def test_a_strength_stays_within_its_bounds():
    rows = KNOWN["row_noise"](sigma=0.3)
    assert at_factor(rows, 1e-12).sigma == rows.parameters()["sigma"].lower


def test_an_effect_without_a_strength_has_no_other():
    assert at_factor(KNOWN["quantization"](), 0.5) is None
    points = OperatingPoint(20.0), OperatingPoint(40.0)
    assert at_factor(KNOWN["row_noise"](sigma=TableLaw(points, (0.1, 0.2))), 0.5) is None


def test_what_a_kind_does_not_use_is_no_strength_of_it():
    assert at_factor(KNOWN["dpc"](kind="median"), 0.5) is None
    assert at_factor(KNOWN["dpc"](kind="static", fraction=1e-3), 0.5).fraction == 5e-4


@pytest.mark.parametrize("name", KNOWN)
def test_half_an_effect_is_an_effect(name):
    """Of every effect of the catalogue, and so is the half of that."""
    half = at_factor(KNOWN[name](), 0.5)
    named = strength_of(KNOWN[name])
    assert named is None or named in STRENGTHS
    if half is not None:
        assert type(half) is KNOWN[name]
        assert half != KNOWN[name]()
