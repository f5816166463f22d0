import re
from datetime import UTC, datetime
from functools import cache
from html.parser import HTMLParser

import pytest
import report_fakes as fakes

from dnanalyze.loaders import inspect
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.laws import ArrheniusLaw, TableLaw
from dnanalyze.report.page import Page, Section, Table, render
from dnanalyze.report.pages.analyze import analyze_page
from dnanalyze.report.pages.compare import compare_page
from dnanalyze.report.pages.detect import detect_page
from dnanalyze.report.pages.diagnose import diagnose_page
from dnanalyze.report.pages.fit import fit_page
from dnanalyze.report.pages.inspect import inspect_page
from dnanalyze.report.pages.model import law
from dnanalyze.report.pages.refine import refine_page

VOID = {"meta", "img", "br", "hr", "link", "input"}
PAGES = {
    "analyze": lambda: analyze_page(fakes.captures(), fakes.statistics()),
    "compare": lambda: compare_page(fakes.captures(), fakes.comparison()),
    "diagnose": lambda: diagnose_page(fakes.captures(), fakes.diagnosis(), fakes.comparison()),
    "refine": lambda: refine_page(fakes.captures(), fakes.refinement(), fakes.comparison()),
    "fit": lambda: fit_page(fakes.captures(), fakes.fit()),
    "inspect": lambda: inspect_page(fakes.captures(), inspect(fakes.captures())),
    "detect": lambda: detect_page(fakes.captures(), fakes.detection()),
}


class Reader(HTMLParser):
    """Checks that elements nest, and gathers what the page names and says."""

    def __init__(self, text):
        super().__init__()
        self.open, self.links, self.ids, self.tags, self.said = [], [], [], [], []
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        attrs = dict(attrs)
        self.links += [attrs[k] for k in ("src", "href") if k in attrs]
        self.ids += [attrs["id"]] if "id" in attrs else []
        if tag == "img":
            assert attrs["alt"]
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.said.append(data)


@cache
def made(name):
    return PAGES[name]()


@pytest.fixture(params=PAGES)
def page(request):
    return request.param, made(request.param)


def test_pages_are_well_formed_and_hold_everything_themselves(page):
    _, text = page
    read = Reader(text)
    outside = [k for k in read.links if not k.startswith(("#", "data:image/svg+xml;base64,"))]
    assert outside == []
    assert not {"script", "link", "iframe"} & set(read.tags)
    assert "@import" not in text
    assert not re.search(r"url\(", text)
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
    assert text.index("Failure 0") < text.index('id="capture"') < text.index("Failure 7")


def test_a_refinement_shows_each_step():
    text = made("refine")
    for word in ("column_fpn", "without row_fpn", "Waterfall"):
        assert word in text


def test_a_clean_sensor_is_called_clean():
    text = detect_page(fakes.captures(), fakes.detection(False))
    assert "No sign of" in text
    assert 'class="verdict good"' in text
    mosaic = fakes.captures(cfa=(("R", "G"), ("G", "B")))
    text = detect_page(mosaic, fakes.detection())
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


def test_laws_are_said_in_a_few_words():
    assert law(ArrheniusLaw(1.5, 25.0, 0.65)) == "1.5 at 25 °C, 0.65 eV"
    points = tuple(OperatingPoint(float(t)) for t in range(8))
    assert law(TableLaw(points[:2], (1.0, 2.5))) == "1, 2.5"
    assert law(TableLaw(points, tuple(map(float, range(8))))) == "8 values from 0 to 7"
    assert law("fixed") == "fixed"
    assert law(0.25) == "0.25"
