"""The method page names the functions that do it, and states their constants."""

import re
from importlib import import_module

import pytest
from docs_tree import DOCS

from dnanalyze.diagnosis.candidates import REFITS
from dnanalyze.diagnosis.selection import EVIDENCE_DECISIVE, EVIDENCE_NULL, EVIDENCE_ODDS_10
from dnanalyze.fitting.design import BUDGET_PIXELS, MOST_FRAMES, MOST_SETTINGS
from dnanalyze.fitting.state import SCALE
from dnanalyze.fitting.yardstick import REPLICATES

PAGE = (DOCS / "method.md").read_text()
NAMES = sorted(set(re.findall(r"`(dnanalyze(?:\.\w+)+)`", PAGE)))
TWO_PAGES = 1000  # words


def found(dotted):
    """The object of a dotted name: a module, and attributes of it."""
    parts = dotted.split(".")
    for n in range(len(parts), 0, -1):
        try:
            there = import_module(".".join(parts[:n]))
        except ModuleNotFoundError:
            continue
        for name in parts[n:]:
            there = getattr(there, name)
        return there
    raise AssertionError(dotted)


@pytest.mark.parametrize("dotted", NAMES)
def test_each_function_named_there_exists(dotted):
    assert found(dotted).__doc__


def test_the_page_fits_on_two_pages():
    assert len(PAGE.split()) <= TWO_PAGES
    assert len(NAMES) > 15


def test_constants_are_those_of_the_code():
    asked = f"asks for {EVIDENCE_NULL:.0f} where"
    assert asked in PAGE
    assert f"{EVIDENCE_ODDS_10:.0f} where it corrects another" in PAGE
    assert f"{EVIDENCE_DECISIVE:.0f} where it corrects none" in PAGE
    assert f"c = {SCALE:.0f}" in PAGE
    assert (MOST_SETTINGS, MOST_FRAMES, BUDGET_PIXELS) == (8, 8, 12_000_000)
    assert "8 operating points, 8 frames each and 12 million pixels" in PAGE
    assert REPLICATES == 8
    assert "eight other sensors" in PAGE
    assert REFITS == 4
    assert "the four most promising" in PAGE
