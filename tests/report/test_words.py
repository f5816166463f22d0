import math
import re
from dataclasses import replace
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from report_fakes import POINTS, diagnosis, refinement

from dnanalyze.fitting.level import Level
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.report import words


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0, "0"), (1.0, "1"), (12.345, "12.3"), (0.001234, "0.00123"), (123456.0, "123456"),
        (1.5e7, "1.5e7"), (-2.0e-6, "-2e-6"), (999.6, "1000"), (math.nan, "–"), (None, "–"),
    ],
)  # fmt: skip
def test_numbers_are_short(value, text):
    assert words.number(value) == text


@given(st.floats(-1e12, 1e12).filter(lambda v: v == 0 or abs(v) > 1e-9))
def test_a_number_keeps_its_value_to_three_digits(value):
    assert float(words.number(value)) == pytest.approx(value, rel=6e-3)


def test_errors_have_two_digits_and_the_value_the_same_place():
    assert words.with_error(1.23456, 0.0123, "DN") == "1.235 ± 0.012 DN"
    assert words.with_error(145.6, 3.0) == "145.6 ± 3.0"
    assert words.with_error(2.0, math.nan, "s") == "2 s"
    assert words.with_error(2.0, 0.0) == "2"


def test_a_level_that_is_not_kept_is_in_the_headline():
    at = OperatingPoint(-5.0, 300.0)
    off = Level(False, at, "", -12.3, -0.031, 41.2)
    text = words.with_remarks("Adequate.", SimpleNamespace(level=off))
    assert text == (
        "Adequate. The mean dark level at -5 °C, 300 s is off by 12 DN (3.1 %, 41 standard errors)."
    )
    bare = SimpleNamespace(level=replace(off, relative=None, plane="Gr"))
    assert "at -5 °C, 300 s, Gr is off by 12 DN (41 standard errors)" in words.with_remarks(
        "", bare
    )
    for kept in (None, replace(off, kept=True)):
        assert words.with_remarks("Adequate.", SimpleNamespace(level=kept)) == "Adequate."


@pytest.mark.parametrize(
    ("measured", "simulated", "unit", "scale", "text"),
    [
        (16.0, 1.0, "DN^2", "log", "+12.0 dB"), (1.1, 1.0, "DN", "linear", "+10 %"),
        (1.02, 1.0, "DN", "linear", "+2.0 %"), (20.0, 1.0, "DN", "linear", "×20"),
        (0.0, 33.0, "pixels", "root", "−33 pixels"), (-1.0, 1.0, "DN", "linear", "−2 DN"),
        (0.04, 0.01, "", "linear", "+0.03"), (1.0, 1.0, "DN", "linear", "0 %"),
        (math.nan, 1.0, "DN", "linear", "–"),
    ],
)  # fmt: skip
def test_the_plain_size_of_a_difference(measured, simulated, unit, scale, text):
    assert words.gap(measured, simulated, unit, scale) == text


def test_labels_say_only_what_differs():
    rows = [vars(p) for p in POINTS]
    only = words.varied(rows)
    assert only == {"temperature_c"}
    assert [words.point_label(p, only) for p in POINTS] == ["25 °C", "65 °C", "105 °C"]
    assert words.point_label(POINTS[0]) == "25 °C, 0.05 s, gain 1"
    assert words.point_label(POINTS[0], set()) == "25 °C, 0.05 s, gain 1"
    assert words.point_label({}) == "one setting"


def test_verdicts_name_the_effect_the_confidence_and_the_rival():
    found = diagnosis()
    text = words.diagnose_headline(found)
    assert "column_fpn" in text
    assert "97 %" in text
    assert "column_gain" in text
    assert words.diagnose_headline(diagnosis("adequate")).startswith("Adequate")
    assert words.diagnose_headline(diagnosis("unexplained")).startswith("Unexplained")


@pytest.mark.parametrize(
    ("verdict", "beside", "told"),
    [
        ("missing", 1, ("Missing: column_fpn", "97 %", "beside what every", "6.5 to 1.1")),
        ("missing", 0, ("Missing: what every", "6.5 to 2.1", "nothing else")),
        ("unexplained", 0, ("Unexplained: with what every", "6.5 to 2.1", "something else")),
    ],
)
def test_what_every_sensor_has_is_told_beside_what_else_is_missing(verdict, beside, told):
    found = diagnosis(verdict)
    best, lesser = found.candidates
    found.ordinary = ["read_noise", "quantization"]
    steps = zip(found.ordinary, (4.0, 2.1), strict=True)
    every = [SimpleNamespace(**vars(lesser) | {"effect": n, "error_after": e}) for n, e in steps]
    found.candidates = [best][:beside] + every
    text = words.diagnose_headline(found)
    for part in (*told, "(read_noise and quantization)"):
        assert part in text


def test_what_was_taken_out_again_is_not_said_to_be_added():
    found = refinement()
    text = words.refine_headline(found.steps, found.verdict)
    assert "column_fpn" in text
    assert "row_fpn" not in text
    assert re.search(r"from 6\.5 to 1\.05", text)
    assert words.step_name("-row_fpn", 3) == "without row_fpn"
    assert words.step_name(None, 0) == "start"


def test_sentences_come_from_lists_mappings_and_text():
    assert words.texts(["one", "two."]) == ["One.", "Two."]
    assert words.texts({"rts": 0.25, "dpc": "dpc below 1 DN"}) == ["Rts: 0.25.", "dpc below 1 DN."]
    assert words.texts(None) == []
    assert words.texts("one") == ["One."]


def test_certainty_is_never_claimed():
    assert words.percent(1.0) == "over 99.9 %"
    assert words.percent(0.97) == "97 %"
    assert words.percent(1e-9) == "under 0.1 %"
    assert words.percent(None) == "–"
    assert words.probability(0.0) == "< 1e-300"
    assert words.probability(1.23e-9) == "1.2e-9"


def test_sentences_keep_the_names_of_effects():
    assert words.sentence("column_fpn: stripes") == "column_fpn: stripes."
    assert words.sentence("stripes!") == "Stripes!"
    assert words.sentence("") == ""
