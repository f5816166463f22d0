import re
from dataclasses import replace
from datetime import UTC, datetime
from functools import cache
from html.parser import HTMLParser
from types import SimpleNamespace

import pytest
import report_fakes as fakes

from dnanalyze.fitting.fit import Parameter
from dnanalyze.loaders import inspect
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effects.convolved_lognormal import ConvolvedLognormal
from dnanalyze.model.laws import ArrheniusLaw, TableLaw
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.report.page import Page, Section, Table, render
from dnanalyze.report.results import (
    comparison,
    detection,
    diagnosis,
    fit,
    inspection,
    refinement,
    statistics,
)
from dnanalyze.report.sections.model import model_section

VOID = {"meta", "img", "br", "hr", "link", "input"}
PAGES = {
    "analyze": lambda: statistics.page(fakes.statistics()),
    "compare": lambda: comparison.page(fakes.comparison()),
    "classifier": lambda: comparison.page(fakes.comparison(), fakes.classification()),
    "diagnose": lambda: diagnosis.page(fakes.diagnosis(), fakes.comparison()),
    "refine": lambda: refinement.page_so_far(fakes.refinement(), fakes.comparison()),
    "fit": lambda: fit.page(fakes.fit()),
    "inspect": lambda: inspection.page(fakes.captures(), inspect(fakes.captures())),
    "detect": lambda: detection.page(fakes.detection()),
}


class Reader(HTMLParser):
    """Checks that elements nest, and gathers what the page names and says."""

    def __init__(self, text):
        super().__init__()
        self.open, self.links, self.ids, self.tags, self.said = [], [], [], [], []
        self.pictures, self.headings = [], []
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        attrs = dict(attrs)
        self.links += [attrs[k] for k in ("src", "href", "xlink:href") if k in attrs]
        self.ids += [attrs["id"]] if "id" in attrs else []
        if attrs.get("role") == "img":
            self.pictures.append(attrs["aria-label"])
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.handle_endtag(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.said.append(data)
        if self.open[-1:] == ["h2"]:
            self.headings.append(data.strip())


@cache
def made(name):
    return render(PAGES[name]())


@pytest.fixture(params=PAGES)
def page(request):
    return request.param, made(request.param)


def test_pages_are_well_formed_and_hold_everything_themselves(page):
    _, text = page
    read = Reader(text)
    outside = [k for k in read.links if not k.startswith(("#", "data:image/png;base64,"))]
    assert outside == []
    assert not {"script", "link", "iframe"} & set(read.tags)
    assert "@import" not in text
    assert set(re.findall(r"url\((.)", text)) <= {"#"}
    assert len(read.ids) == len(set(read.ids))
    assert {k[1:] for k in read.links if k.startswith("#")} <= set(read.ids)


def test_names_and_sentences_are_escaped(page):
    name, text = page
    assert "<script" not in text
    assert "&lt;sensor&gt; &amp; co" in text
    assert "a note with &lt;b&gt;" in text
    if name == "compare":
        assert "Failure 0 &lt;script&gt;" in text


def test_the_verdict_stands_first(page):
    _, text = page
    read = Reader(text)
    assert read.ids[0] == "verdict"
    assert text.index('class="lead"') < text.index('id="capture"')


def test_a_comparison_shows_each_family_with_its_error_and_the_model():
    text = made("compare")
    for word in (
        'id="family-level"',
        'id="family-spectrum"',
        ">9<",
        ">1.1<",
        "convolved_lognormal",
    ):
        assert word in text


def test_the_failures_stand_in_one_list_beside_the_verdict():
    text = made("compare")
    assert [text.count(f"Failure {n} ") for n in range(8)] == [1] * 8
    assert text.index("Failure 0") < text.index("Failure 7") < text.index('id="capture"')


def test_no_page_is_heavier_than_one_and_a_half_megabytes(page):
    _, text = page
    assert len(text.encode()) < 1.5e6


def test_every_picture_is_described_and_every_colour_has_a_dark_tone(page):
    _, text = page
    assert all(Reader(text).pictures)
    light, dark = (set(re.findall(r"--(\w+):", part)) for part in text.split("@media", 2)[:2])
    used = set(re.findall(r"var\(--(\w+)", text)) - {"w"}
    assert used <= light
    assert light == dark


def test_parameters_stand_before_the_panels():
    text = made("refine")
    place = text.index("convolved_lognormal.mu")
    assert text.index('id="steps"') < place < text.index('id="family-level"')


def test_the_baseline_model_is_one_step_and_its_parts_are_folded():
    told = fakes.refinement()
    first, *rest = told.steps
    baseline = [
        SimpleNamespace(added=a, error=e, confidence=None, evidence=["x"], confused_with=[])
        for a, e in (("read_noise", 7.0), ("pixel_fpn", 5.0), ("quantization", 4.5))
    ]
    told.steps = [first, *baseline, *rest]
    text = render(refinement.page_so_far(told))
    shown, _, folded = text[text.index('id="steps"') :].partition("<details>")
    assert "baseline model" in shown
    assert "<td>read_noise" not in shown
    assert "<td>read_noise" in folded.partition("</details>")[0]
    assert "read_noise: x" not in text.lower()  # no evidence for what every sensor has


def test_a_refinement_shows_each_step():
    text = made("refine")
    for word in ("column_fpn", "without row_fpn", "Waterfall"):
        assert word in text


def test_a_clean_sensor_is_called_clean():
    text = render(detection.page(fakes.detection(False)))
    assert "No sign of" in text
    assert 'class="verdict good"' in text
    mosaic = fakes.captures(cfa=(("R", "G"), ("G", "B")))
    text = render(detection.page(replace(fakes.detection(), captures=mosaic)))
    for word in ("passed defect-pixel correction", "over 99.9 %", "2,000 to 3,000", "dynamic"):
        assert word in text


def test_empty_sections_are_left_out_and_the_date_is_the_callers():
    table = Table(("a", "b"), [("<1>", 2)], title="T", folded=True)
    sections = [Section("empty", "Empty"), Section("full", "Full", tables=[table])]
    text = render(Page("K", "T", "V", sections), datetime(2030, 1, 2, 3, 4, tzinfo=UTC))
    Reader(text)
    assert "Empty" not in text
    assert "&lt;1&gt;" in text
    assert "2030-01-02 03:04 UTC" in text


def test_a_parameter_stands_with_its_error_unit_and_operating_point():
    points = tuple(OperatingPoint(float(t)) for t in (25, 65))
    effect = ConvolvedLognormal(mu=TableLaw(points, (1.0, 2.5)), delta=0.5)
    model = NoiseModel((effect,), ArrheniusLaw(1.5, 25.0, 0.65))
    found = [
        Parameter("convolved_lognormal.mu[1]", 2.5, 0.1, "ln DN"),
        Parameter("pedestal.ea_ev", 0.65, 0.02, "eV"),
        Parameter("gain", 2.0, 0.1, "DN/e-"),
    ]
    by_point, fixed = model_section(model, found).tables
    assert list(by_point.columns) == ["parameter", "unit", "25 °C", "65 °C"]
    assert by_point.rows[0] == (
        "convolved_lognormal.mu",
        "ln(DN)",
        "1",
        "2.50 ± 0.10",
    )
    rows = {row[0]: row[1:] for row in fixed.rows}
    assert rows["pedestal"][:2] == ("1.5", "DN")
    assert rows["pedestal"][2] == "25 °C; activation energy 0.650 ± 0.020 eV"
    assert rows["convolved_lognormal.delta"][:3] == ("0.5", "ln(DN)", "all")
    assert rows["gain"][:2] == (
        "2.00 ± 0.10",
        "DN/e⁻",
    )  # told by a statistic, not of the model


def test_many_operating_points_stand_one_below_the_other():
    points = tuple(OperatingPoint(float(t)) for t in range(8))
    effect = ConvolvedLognormal(mu=TableLaw(points, tuple(map(float, range(8)))))
    table = model_section(NoiseModel((effect,), 64.0)).tables[0]
    assert table.folded
    assert table.rows[3] == ("convolved_lognormal.mu", "ln(DN)", "3 °C", "3")


def test_a_page_without_a_model_has_no_section_of_it():
    assert model_section(None).empty
