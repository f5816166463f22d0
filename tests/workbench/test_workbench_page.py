"""The page in a real browser; skipped where there is none."""

from __future__ import annotations

import itertools
import os
import re
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
import yaml

pytest.importorskip("panel", reason="the extra workbench is not installed")
api = pytest.importorskip("playwright.sync_api", reason="Playwright is not installed")
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
if CHROMIUM is None:
    pytest.skip("no Chromium on this machine", allow_module_level=True)

RUN = "from dnanalyze_cli.main import run; run()"
PATIENCE_S = 90.0
RAISING = """
from dataclasses import dataclass
from dnanalyze import Effect, Stage, parameter

@dataclass(frozen=True)
class Raising(Effect):
    name = "raising"
    stage = Stage.LINE_READ
    size: float = parameter(1.0, "DN", 0.1, 9.0, "raises when large")

    def apply(self, signal, site):
        if self.size > 1.5:
            raise ValueError("above 1.5 DN")
        return signal
"""
FLAGS = [
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--disable-background-networking",
    "--disable-component-update", "--disable-sync",
]  # fmt: skip


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with api.sync_playwright() as play:
        made = play.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        yield made
        made.close()


@contextmanager
def served(folder: Path, *options: str) -> Iterator[str]:
    """Address of a server on the small sensor."""
    process = subprocess.Popen(
        [sys.executable, "-c", RUN, "workbench", str(folder), "--no-browser", *options],
        stdout=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONUNBUFFERED": "1"},
    )
    assert process.stdout is not None
    try:
        yield process.stdout.readline().split()[0]
    finally:
        process.terminate()
        process.wait(PATIENCE_S)
        process.stdout.close()


@pytest.fixture(scope="module")
def address(folder) -> Iterator[str]:
    with served(folder) as found:
        yield found


class Workbench:
    """An open page."""

    def __init__(self, browser: Any, address: str) -> None:
        self.page = browser.new_page(viewport={"width": 1440, "height": 900})
        self.page.set_default_timeout(1000 * PATIENCE_S)
        self.outside: list[str] = []
        self.page.on("request", self._requested)
        self.page.goto(address)
        begun = self.page.locator("option").filter(has_text=re.compile("model(, fitted| as given)"))
        begun.first.wait_for(state="attached")
        self.settled()

    def _requested(self, request: Any) -> None:
        if not re.match(r"(http|ws)://127\.0\.0\.1[:/]|data:|blob:", request.url):
            self.outside.append(request.url)

    @property
    def error(self) -> str:
        """The error as shown, with its sign of a preview."""
        shown = self.page.locator(".error")
        return shown.inner_text() if shown.count() else ""

    def until(self, holds: Any, what: str) -> Any:
        """Wait until something holds."""
        end = time.monotonic() + PATIENCE_S
        while time.monotonic() < end:
            if found := holds():
                return found
            self.page.wait_for_timeout(50)
        raise AssertionError(f"not seen in {PATIENCE_S:g} s: {what}")

    def settled(self) -> float:
        """The full error, once no task is under way."""
        self.until(
            lambda: (
                re.fullmatch(r"[\d.]+", self.error)
                and self.page.get_by_role("button", name="Cancel").is_disabled()
            ),
            "the full error",
        )
        return float(self.error)

    def points(self, layer: str) -> int:
        """Points of a curve of the open figure."""
        script = f"""() => {{
            for (const d of Bokeh.documents) {{
                const data = d.get_model_by_name("curve of {layer}")?.data;
                if (data) return (data.x ?? data.get?.("x"))?.length ?? 0;
            }}
            return 0;
        }}"""
        return int(self.page.evaluate(script))

    def click(self, name: str) -> None:
        """A button."""
        self.page.get_by_role("button", name=name, exact=True).first.click()


@pytest.fixture(scope="module")
def bench(browser, address) -> Workbench:
    return Workbench(browser, address)


def test_the_frames_show_before_the_statistics_are_taken(bench):
    """And nothing comes from another host."""
    assert bench.page.get_by_text("Where it fails").is_visible()
    bench.until(lambda: bench.points("measured") > 0, "the measured curve")
    assert bench.outside == []


def test_a_click_on_a_family_and_a_cell_open_their_figures(bench):
    title = bench.page.locator(".statistic div").first
    for pane, across, down in ((".families", 0.5, 0.5), (".matrix", 0.95, 0.06)):
        before = title.inner_text()
        box = bench.page.locator(pane).first.bounding_box()
        bench.page.mouse.click(box["x"] + across * box["width"], box["y"] + down * box["height"])
        bench.until(lambda was=before: title.inner_text() != was, f"another title after {pane}")


def test_a_click_on_a_pixel_shows_its_values(bench):
    title = bench.page.locator(".pixel div").first
    before = title.inner_text()
    box = bench.page.locator(".measured").first.bounding_box()
    bench.page.mouse.click(box["x"] + 0.6 * box["width"], box["y"] + 0.35 * box["height"])
    bench.until(lambda: title.inner_text() != before, "the pixel")
    assert re.search(r"column \d+, row \d+.*measured.*simulated", title.inner_text())


def test_a_slider_moves_the_error_and_undo_takes_it_back(bench):
    before = bench.settled()
    bench.page.locator(".parameter").nth(1).locator("[role=slider]").focus()
    keys = itertools.cycle(["ArrowRight"] * 30 + ["ArrowLeft"] * 20)

    def previewed() -> bool:
        bench.page.keyboard.press(next(keys))
        return bench.error.startswith("≈")

    bench.until(previewed, "a preview")
    bench.until(lambda: re.fullmatch(r"[\d.]+", bench.error), "the full error")
    assert bench.settled() != before
    bench.click("Undo")
    bench.until(lambda: bench.error == f"{before:.3g}", "the error before")


def test_work_after_an_undo_is_a_branch(bench):
    nodes = bench.page.locator("option").filter(has_text="set ")
    count, before = nodes.count(), bench.settled()
    slider = bench.page.locator(".parameter").nth(2).locator("[role=slider]")
    for _ in range(12):
        slider.press("ArrowRight")
    bench.until(lambda: nodes.count() > count, "a node beside the one undone")
    bench.settled()
    bench.click("Undo")
    bench.until(lambda: bench.error == f"{before:.3g}", "the error before")


def test_what_is_missing_is_named_shown_and_added(bench):
    before = bench.settled()
    bench.click("Diagnose")
    row = bench.page.locator(".row").first
    bench.until(lambda: row.count() and "column_fpn" in row.inner_text(), "the candidate")
    assert bench.points("candidate") == 0
    row.hover()
    bench.until(lambda: bench.points("candidate") > 0, "the candidate's curve")
    bench.settled()
    row.get_by_role("button", name="Add").click()
    bench.until(lambda: bench.error != f"{before:.3g}", "another error")
    after = bench.settled()
    assert after < 1.4
    assert before > 2 * after


def test_a_running_refinement_is_cancelled_and_the_page_goes_on(bench):
    error = bench.settled()
    bench.click("Refine")
    bench.until(lambda: bench.page.get_by_role("button", name="Cancel").is_enabled(), "the task")
    bench.page.wait_for_timeout(300)
    begun = time.monotonic()
    bench.click("Cancel")
    bench.until(lambda: bench.page.get_by_role("button", name="Cancel").is_disabled(), "its end")
    assert time.monotonic() - begun < 10  # the limit on an idle machine is in the benchmark
    assert bench.settled() == error


def test_a_reload_keeps_the_session_and_another_tab_is_another_session(bench, browser, address):
    error = bench.settled()
    bench.page.reload()
    assert bench.settled() == error
    other = Workbench(browser, address)
    here = "window.location.href"
    assert other.page.evaluate(here) != bench.page.evaluate(here)
    assert bench.settled() == error
    other.page.close()


def test_model_report_and_targets_are_downloaded(bench, tmp_path):
    for label, begins in (("Model", "schema: dnanalyze/model/1"), ("Report", "<!"),
                          ("CI targets", "")):  # fmt: skip
        with bench.page.expect_download() as caught:
            bench.page.get_by_text(label, exact=True).last.click()
        text = Path(caught.value.path()).read_text(encoding="utf-8")
        assert text.strip().startswith(begins)
        assert len(text) > 100


HEADS = b"row,column,measured", b"name,family", b"layer,", b"layer,column,row"  # sensor, fails, ...


def test_every_figure_is_downloaded(bench):
    """The images, the model error, the open statistic and the pixel, as CSV, PNG and SVG."""
    for label in ("CSV", "PNG", "SVG"):
        buttons = bench.page.get_by_text(label, exact=True)
        assert buttons.count() == len(HEADS)
        heads = []
        for i in range(len(HEADS)):
            with bench.page.expect_download() as caught:
                buttons.nth(i).click()
            heads.append(Path(caught.value.path()).read_bytes()[:200])
        begins = {"PNG": b"\x89PNG", "SVG": b"<?xml"}.get(label)
        assert all(h.startswith(begins) for h in heads) if begins else _all_tables(heads)


def _all_tables(heads: list[bytes]) -> bool:
    """Whether each table is there once; their order on the page does not matter."""
    return all(any(h.startswith(begins) for h in heads) for begins in HEADS)


def test_a_step_is_named_redone_and_copied_as_commands(bench):
    before = bench.settled()
    bench.page.get_by_placeholder("name of this step").fill("with columns")
    bench.page.get_by_placeholder("name of this step").press("Enter")
    named = bench.page.locator("option").filter(has_text="with columns")
    bench.until(lambda: named.count() > 0, "the name")
    bench.click("Undo")
    bench.until(lambda: bench.error != f"{before:.3g}", "the step before")
    bench.settled()
    bench.click("Redo")
    bench.until(lambda: bench.error == f"{before:.3g}", "the step again")
    choice = bench.page.locator("select").filter(has_text="copy as")
    text = bench.page.locator("textarea")
    for what, begins in (("commands", "dnanalyze "), ("Python", "import ")):
        choice.select_option(label=what)
        bench.until(lambda b=begins: text.count() and b in text.input_value(), what)
    choice.select_option(label="copy as …")
    bench.until(lambda: not text.is_visible(), "the figure again")


def test_an_effect_that_raises_under_its_slider_is_a_message(browser, folder, fitted, tmp_path):
    own, model = tmp_path / "own.py", tmp_path / "model.yaml"
    own.write_text(RAISING)
    with_own = fitted.to_plain()
    with_own["effects"].append({"raising": {"size": 1.0}})
    model.write_text(yaml.safe_dump(with_own))
    with served(folder, "--effects", str(own), "--model", str(model)) as address:
        bench = Workbench(browser, address)
        before = bench.settled()
        slider = bench.page.locator(".parameter").last.locator("[role=slider]")
        slider.focus()
        message = bench.page.get_by_text("above 1.5 DN")

        def told() -> int:
            bench.page.keyboard.press("ArrowRight")
            return message.count()

        bench.until(told, "the message")
        bench.settled()
        slider.press("Home")
        bench.until(lambda: message.count() == 0, "the message's end")
        assert bench.settled() == before  # the effect does nothing
        bench.page.close()


def test_the_dark_theme_keeps_the_session(bench):
    error = bench.settled()
    bench.page.get_by_text("dark theme").click()
    bench.page.get_by_text("light theme").wait_for()
    assert bench.settled() == error


@pytest.mark.skipif(sys.platform == "darwin", reason="127.0.0.2 is no address of its loopback")
def test_another_host_shows_its_page_for_its_token_alone(browser, folder):
    page = browser.new_page()
    page.set_default_timeout(1000 * PATIENCE_S)
    with served(folder, "--host", "127.0.0.2") as found:
        bare, token = found.split("?token=")
        for wrong in ("", "?token=guess", "?token=%C3%A9"):
            page.goto(bare + wrong)
            page.get_by_text("needs its token").wait_for()
            assert not page.get_by_text("Where it fails").is_visible()
        page.goto(f"{bare}?token={token}")
        page.get_by_text("Where it fails").wait_for()
    page.close()
