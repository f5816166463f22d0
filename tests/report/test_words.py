import math
import re
from dataclasses import replace
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from report_fakes import POINTS, diagnosis, refinement

from dnanalyze.analyzers.catalogue import catalogue
from dnanalyze.fitting.level import Level
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.report import words


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0, "0"), (1.0, "1"), (12.345, "12.3"), (0.001234, "0.00123"), (123456.0, "123,000"),
        (1.5e7, "1.5 × 10⁷"), (-2.0e-6, "−2 × 10⁻⁶"), (999.6, "1,000"), (math.nan, "–"),
        (None, "–"),
    ],
)  # fmt: skip
def test_numbers_are_short(value, text):
    assert words.number(value) == text


@given(st.floats(-1e12, 1e12).filter(lambda v: v == 0 or abs(v) > 1e-9))
def test_a_number_keeps_its_value_to_three_digits(value):
    text = words.number(value).translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹−", "-0123456789-", ","))
    assert float(text.replace(" × 10", "e")) == pytest.approx(value, rel=6e-3)


def test_errors_have_two_digits_and_the_value_the_same_place():
    assert words.with_error(1.23456, 0.0123, "DN") == "1.235 ± 0.012 DN"
    assert words.with_error(145.6, 3.0) == "145.6 ± 3.0"
    assert words.with_error(5615.0, 1196.0, "DN^2") == "5,600 ± 1,200 DN²"
    assert words.with_error(2.0, math.nan, "s") == "2 s"
    assert words.with_error(2.0, 0.0) == "2"


def test_a_level_that_is_not_kept_is_in_the_headline():
    at = OperatingPoint(-5.0, 300.0)
    off = Level(False, at, "", -12.3, -0.031, 41.2)
    text = words.with_remarks("Adequate.", SimpleNamespace(level=off))
    assert text == (
        "Adequate. The mean dark signal at −5 °C, 300 s is off by 12 DN (3.1 % of the signal "
        "above the black level, 41 standard errors)."
    )
    bare = SimpleNamespace(level=replace(off, relative=None, plane="Gr"))
    assert "at −5 °C, 300 s, Gr is off by 12 DN (41 standard errors)" in words.with_remarks(
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
    assert words.point_label({}) == "one operating point"


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
        (
            "missing",
            1,
            ("Missing: column_fpn", "97 %", "in addition to the baseline effects", "6.5 to 1.1"),
        ),
        ("missing", 0, ("Missing: the baseline effects", "6.5 to 2.1", "no other")),
        ("unexplained", 0, ("Unexplained: with the baseline", "6.5 to 2.1", "another effect")),
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


def test_the_headline_of_what_is_unexplained_agrees_with_the_list():
    found = diagnosis("unexplained")
    best = found.candidates[0]
    best.confidence, best.leaves = 0.45, ["temporal_psd_0.35_0.5", "hot_count_5"]
    text = words.diagnose_headline(found)
    assert "no effect of the catalogue" not in text
    assert "possibly column_fpn (or column_gain)" in text
    assert "falls from 6.5 to 1.1" in text
    assert "does not explain power of the temporal noise" in text
    found.candidates = []
    assert "no effect of the catalogue explains" in words.diagnose_headline(found)


def test_a_name_below_90_percent_is_a_possible_one_everywhere():
    from dnanalyze.report.page import render
    from dnanalyze.report.results.diagnosis import page, sections
    from dnanalyze.report.terminal import as_text, print_sections

    found = diagnosis()
    found.candidates[0].confidence = 0.55
    shown = as_text(lambda console: print_sections(console, sections(found)))
    told = [
        words.diagnose_headline(found),
        shown.split("candidate")[1],
        render(page(found)),
    ]
    for text in told:
        assert "possibly column_fpn" in text
        assert "column_gain" in text
    found.candidates[0].confidence = 0.9
    assert "possibly" not in words.diagnose_headline(found)


@pytest.mark.parametrize(
    ("after", "told"),
    [(0.913, "goes from 0.874 to 0.913, within its variation of 6 % between simulated sensors"),
     (0.5, "falls from 0.874 to 0.5"), (1.2, "rises from 0.874 to 1.2"),
     (0.874, "stays at 0.874, within")],
)  # fmt: skip
def test_which_way_the_error_goes(after, told):
    assert told in words.error_way(0.874, after)


def added(supported, after=0.913, unexplained=()):
    found = refinement()
    start, step = found.steps[:2]
    start.error, step.error, step.supported, step.confidence = 0.874, after, supported, 0.05
    found.steps, found.unexplained = [start, step], list(unexplained)
    found.verdict = "unexplained" if unexplained else "adequate"
    return found


def test_an_effect_that_is_not_needed_is_said_to_be_unsupported():
    text = words.add_headline(added(False))
    assert "not supported by these captures" in text
    assert "falls" not in text
    text = words.add_headline(added(True, 0.5, ["hot_count_5"]))
    assert "falls from 0.874 to 0.5" in text
    assert "not supported" not in text
    assert "in no catalogue" not in text  # nothing else was asked
    assert "does not explain pixels above 5" in text


def test_a_refinement_says_what_stays_and_how_sure_it_is():
    from dnanalyze.report.page import render
    from dnanalyze.report.results.refinement import page_so_far, sections
    from dnanalyze.report.terminal import as_text, print_sections

    found = refinement()
    found.steps = found.steps[:2]  # row_fpn, 60 %, or row_noise
    found.verdict, found.unexplained = "unexplained", ["temporal_psd_0.35_0.5"]
    found.diagnosis = diagnosis("unexplained")
    shown = as_text(lambda console: print_sections(console, sections(found)))
    page = render(page_so_far(found))
    assert max(map(len, shown.splitlines())) <= 80
    for text in (words.refine_headline(found), shown, page):
        assert "possibly row_fpn" in text
        assert "row_noise" in text
        assert "0.35 to 0.5 c/px" in text
    for text in (shown, page):
        assert "60 %" in text
        assert "1.234 ± 0.012" in text


def test_a_refinement_that_was_told_to_stop_names_what_is_next():
    found = refinement()
    found.verdict, found.diagnosis = "missing", diagnosis("missing")
    assert "the next effect to add is column_fpn" in words.refine_headline(found)
    found.diagnosis.candidates, found.unexplained = [], ["hot_count_5"]
    assert "was not tested: " in words.refine_headline(found)
    found.finished = False
    assert "not finished" in words.refine_headline(found)
    found.timed_out = True
    assert "time limit" in words.refine_headline(found)


def test_a_diagnosis_that_ran_out_of_time_says_so():
    found = diagnosis("missing")
    found.finished = False
    said = words.diagnose_headline(found)
    assert "time limit" in said
    assert "column_fpn" in said
    found.candidates = []
    assert "before a candidate was tested" in words.diagnose_headline(found)
    found.screened = ["rts", "dpc"]
    assert "expects most of rts and dpc" in words.diagnose_headline(found)


def test_what_was_taken_out_again_is_not_said_to_be_added():
    found = refinement()
    text = words.refine_headline(found)
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
    assert words.probability(0.0) == "< 10⁻³⁰⁰"
    assert words.probability(1.23e-9) == "1.2 × 10⁻⁹"


def test_sentences_keep_the_names_of_effects():
    assert words.sentence("column_fpn: stripes") == "column_fpn: stripes."
    assert words.sentence("stripes!") == "Stripes!"
    assert words.sentence("") == ""


def test_titles_of_statistics_are_words_without_an_article():
    """They stand in sentences, lists and at the heads of tables."""
    titles = [info.title for info in catalogue().values()]
    assert [t for t in titles if "_" in t or re.match("(the|a|an) ", t, re.IGNORECASE)] == []
