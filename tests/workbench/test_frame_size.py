"""Frame sizes are rows × columns, on the page as in the terminal and in reports."""

from __future__ import annotations

import re

import pytest

pytest.importorskip("panel", reason="the extra workbench is not installed")

import dnanalyze
from dnanalyze.report.capture_facts import facts, one_line
from dnanalyze.workbench.page.app import TopBar
from dnanalyze.workbench.page.context import Context
from dnanalyze.workbench.page.style import palette
from dnanalyze.workbench.session import WorkbenchSession
from dnanalyze.workbench.source import CaptureSource


def test_the_page_the_terminal_and_reports_state_rows_by_columns(folder):
    captures = dnanalyze.load(str(folder))
    rows, columns = captures.sensor.shape
    assert rows != columns
    session = WorkbenchSession(CaptureSource(folder))
    bar = TopBar(Context(session, palette("light"), None), "", {})
    page = re.sub("<[^>]*>", "", " ".join(str(p.object) for p in bar.view if hasattr(p, "object")))
    for text in (page, one_line(captures), facts(captures)["frames"]):
        assert f"{rows} × {columns}" in text
