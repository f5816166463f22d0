"""The page in a real browser; skipped where there is none."""

from __future__ import annotations

import itertools
import re
import sys
from pathlib import Path
from typing import Any

import pytest
from page_driver import PATIENCE_S, Workbench, served

pytest.importorskip("panel", reason="the extra workbench is not installed")


def test_the_frames_show_before_the_statistics_are_taken(bench):
    """And nothing comes from another host."""
    assert bench.page.get_by_text("Where it fails").is_visible()
    bench.until(lambda: bench.points("measured") > 0, "the measured curve")
    assert bench.outside == []


def test_a_second_page_begins_with_the_view_of_the_first(bench, browser, address):
    def view(of: Workbench) -> list[str]:
        return [of.page.locator(f".{c} select").input_value() for c in ("point", "kind")]

    other = Workbench(browser, address)
    assert view(other) == view(bench)
    other.page.close()


def test_a_slow_browser_opens_the_page_without_an_error(browser, address):
    """It draws the panes while the first results arrive."""
    slow = Workbench(browser, address, slower=6)
    for side in ("all spectra", "spectrum"):
        slow.click(side)
    slow.settled()
    assert slow.errors == []
    slow.page.close()


@pytest.mark.parametrize(
    ("side", "source", "column"),
    [("spectrum", "beside of measured", "x"), ("all spectra", "all spectra of measured", "xs"),
     ("histogram", "beside of measured", "x")],
)  # fmt: skip
def test_each_figure_beside_the_images_is_drawn_when_it_is_chosen(bench, side, source, column):
    bench.settled()
    bench.click(side)
    script = f"""() => {{
        const found = Bokeh.documents.map((d) => d.get_model_by_name("{source}")).find((m) => m);
        return found ? found.data.{column}.length : 0;
    }}"""
    bench.until(lambda: bench.page.evaluate(script) > 3, f"the curves of {side}")
    canvas = bench.page.locator(".side .bk-Figure").filter(visible=True)
    bench.until(lambda: canvas.count() and canvas.first.bounding_box()["height"] > 60, "a plot")


def _drawn(bench: Workbench) -> dict[str, Any]:
    """The figure of a statistic as the browser has it."""
    return bench.page.evaluate(
        """() => {
        const all = Bokeh.documents.flatMap((d) => d.all_models ? [...d.all_models] : []);
        const figures = all.filter((m) => m.name === "curve" && m.x_scale);
        const views = document.querySelectorAll("*");
        const made = figures[0];
        return {
            count: figures.length,
            x: made.below[0].axis_label, y: made.left[0].axis_label,
            log: [made.x_scale.type === "LogScale", made.y_scale.type === "LogScale"],
            tickers: [made.below[0].ticker.type, made.left[0].ticker.type],
            x_range: [made.x_range.start, made.x_range.end],
        };}"""
    )


AXES = {  # of a family's figure: label of the abscissa, logarithmic scales, its ticks
    "Spectrum": ("frequency", [True, True], "CustomJSTicker"),
    "Distribution": ("dark value [DN]", [False, True], "BasicTicker"),
    "Hot-pixel tail": ("deviation", [True, True], "CustomJSTicker"),
    "Shading": ("operating point", [False, None], "FixedTicker"),
    "Neighbouring pixels": ("operating point", [False, None], "FixedTicker"),
}


def _all_pairs(names: list[str]) -> list[str]:
    """A walk in which every name follows every other one."""
    walk = []
    for i, one in enumerate(names):
        for other in names[i + 1 :]:
            walk += [one, other, one]
    return walk


def test_one_figure_follows_every_pair_of_families_however_quickly(bench):
    """And a family that is slow to arrive leaves nothing of the one before."""
    bench.settled()
    families = bench.page.locator(".family")

    def click(name: str) -> None:
        families.filter(has_text=re.compile(f"^{name}")).click()

    def right(name: str) -> bool:
        label, log, ticker = AXES[name]
        found = _drawn(bench)
        kinds = [a if b is None else b for a, b in zip(found["log"], log, strict=True)]
        return (
            found["count"] == 1 and label in found["x"] and found["log"] == kinds
            and found["tickers"][0] == ticker and (found["x_range"][0] > 0 or not kinds[0])
        )  # fmt: skip

    def below() -> float:
        return bench.box(".curve")[1] - bench.box(".statistic")[1]

    gap = below()
    for step, name in enumerate(_all_pairs(list(AXES))):
        click(name)
        if step % 5 == 4:
            bench.until(lambda n=name: right(n), f"the axes of {name}")
            assert below() == gap  # of titles of one line and of two
    click("Distribution")
    bench.until(lambda: right("Distribution"), "the histogram")


def test_a_click_on_a_family_and_a_cell_open_their_figures(bench):
    title = bench.page.locator(".statistic div").first
    for chosen in (".family", ".cell"):
        bench.settled()  # what is drawn anew takes no click
        before = title.inner_text()
        bench.page.locator(f"{chosen}:not(.chosen)").last.click()
        bench.until(lambda was=before: title.inner_text() != was, f"another title after {chosen}")
    assert bench.page.locator(".cell.chosen").count() == 1


def _lengths(bench: Workbench, source: str) -> list[int]:
    """Numbers of entries in the columns of a data source of the page."""
    return bench.page.evaluate(
        f"""() => {{
        const found = Bokeh.documents.map((d) => d.get_model_by_name("{source}")).find((m) => m);
        return Object.values(found.data).map((column) => column.length);
        }}"""
    )


def test_the_residuals_of_a_curve_are_drawn_below_it(bench):
    bench.page.locator(".family").filter(has_text=re.compile("^Spectrum")).click()
    bench.until(
        lambda: min(_lengths(bench, "curve residual of present model")) > 5, "the residuals"
    )


def test_a_click_on_a_cell_marks_where_its_statistic_comes_from(bench):
    """And one of a statistic that has no place takes the marks away."""
    bench.open("Rows and columns")
    row = bench.page.locator("tr").filter(has_text=re.compile(r"^(?!.*(temporal|in time)).*column"))
    row.first.locator(".cell").last.click()
    marks = bench.page.locator(".marks .quiet").filter(has_text="marked: ")
    marks.filter(has_text="column").wait_for()
    bench.open("Hot-pixel tail")
    row = bench.page.locator("tr").filter(has_text="pixels above 5 robust sigma")
    row.locator(".cell").first.click()
    bench.until(lambda: min(_lengths(bench, "marked pixels")) > 0, "marked pixels")
    bench.open("Shading")

    def cleared() -> bool:  # a cell that is drawn anew meanwhile takes no click
        bench.page.locator(".cell").last.click()
        return max(_lengths(bench, "marked pixels")) == 0

    bench.until(cleared, "no marks")
    bench.until(lambda: marks.count() == 0, "no words of marks")


def test_every_class_of_bokeh_that_the_style_sheets_name_is_on_the_page(bench):
    """It is Bokeh's own, and another version may name it otherwise."""
    from dnanalyze.workbench.page.downloads import SMALL
    from dnanalyze.workbench.page.style import LIGHT, inner

    named = set(re.findall(r"\.((?:bk|noUi)-[\w-]+)", inner(LIGHT) + SMALL))
    assert {"bk-btn", "bk-input", "noUi-handle"} < named
    assert [name for name in sorted(named) if not bench.page.locator(f".{name}").count()] == []
    assert bench.box(".parameter .noUi-handle")[2:] == (14, 14)
    saves = bench.page.locator("button").filter(has=bench.page.get_by_text("CI targets"))
    assert saves.bounding_box()["height"] <= 28  # as the choices beside it


def test_a_question_mark_opens_the_sentence_of_the_glossary(bench):
    mark = bench.page.locator(".number .term")
    sentence = mark.locator("div")
    assert not sentence.is_visible()
    mark.locator("summary").click()
    assert "a second sensor of the same design" in sentence.inner_text()
    mark.locator("summary").click()


def test_a_click_on_a_pixel_shows_its_values_and_the_tooltip_names_the_same(bench):
    title = bench.page.locator(".pixel div").first
    box = bench.page.locator(".measured").first.bounding_box()
    at = box["x"] + 0.6 * box["width"], box["y"] + 0.35 * box["height"]
    tip = bench.page.locator(".bk-tooltip-content").filter(has_text="simulated")

    def tooltip():  # the figure takes its tooltip down where it is drawn again meanwhile
        bench.page.mouse.move(at[0] + 3, at[1])
        bench.page.mouse.move(*at)
        return tip.count() and tip.first.is_visible()

    bench.until(tooltip, "the tooltip")
    said = " ".join(tip.first.inner_text().split())
    bench.page.mouse.click(*at)
    shown = re.compile(r"column (\d+), row (\d+).*measured.*simulated")
    bench.until(lambda: shown.search(title.inner_text()), "the pixel")
    column, row = shown.search(title.inner_text()).groups()
    assert re.search(rf"column:? {column} row:? {row} ", said)
    assert re.search(r"measured:? [\d.]+ DN simulated:? [\d.]+ DN difference:? -?[\d.]+ DN", said)


def test_the_scale_of_the_frames_is_typed(bench):
    low = bench.page.locator(".low input")
    low.fill("5000")
    low.press("Enter")
    bench.page.get_by_text("min below max").wait_for()
    auto = bench.page.get_by_role("button", name="auto scale")
    bench.until(lambda: "bk-active" not in auto.get_attribute("class"), "no automatic scale")
    low.fill("10.5")
    low.press("Enter")
    scale = """() => Bokeh.documents.flatMap((d) => [...d.all_models])
        .filter((m) => m.name === "figure of measured")[0].right[0].color_mapper.low"""
    bench.until(lambda: bench.page.evaluate(scale) == 10.5, "the typed end")
    auto.click()
    bench.until(lambda: float(low.input_value()) > 20.0, "an end from the image, near 60 DN")


def test_a_value_beyond_its_limits_is_not_applied_and_the_limits_are_shown(bench):
    before, nodes = bench.settled(), bench.page.locator("option").filter(has_text="set ")
    count = nodes.count()
    row = bench.page.locator(".parameter").first
    field = row.locator("input[type=text]")
    value = field.input_value()
    field.fill("1e9")
    field.press("Enter")
    bench.page.get_by_text("not applied; valid: −1 × 10⁶ to 1 × 10⁶ DN").wait_for()
    assert (bench.settled(), nodes.count()) == (before, count)
    field.fill(value)
    field.press("Enter")
    bench.until(lambda: not bench.page.get_by_text("not applied").is_visible(), "no limits")
    assert (bench.settled(), nodes.count()) == (before, count)  # as it stood


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


def test_a_slider_does_not_rest_before_the_browser_has_drawn_its_move(bench):
    before, nodes = bench.settled(), bench.page.locator("option").filter(has_text="set ")
    bench.page.evaluate(
        """() => {
        window.held = [];
        window.drawn = window.requestAnimationFrame;
        window.requestAnimationFrame = (call) => window.held.push(call);
    }"""
    )
    count = nodes.count()
    bench.move_a_slider()
    bench.until(lambda: bench.error.startswith("≈"), "a preview")
    bench.page.wait_for_timeout(1500)
    assert (bench.error[0], nodes.count()) == ("≈", count)
    bench.page.evaluate(
        """() => {
        window.requestAnimationFrame = window.drawn;
        window.held.forEach((call) => window.drawn.call(window, call));
    }"""
    )
    bench.until(lambda: nodes.count() > count, "a step of the history")
    bench.settled()
    bench.click("Undo")
    bench.until(lambda: bench.error == f"{before:.3g}", "the error before")


def test_work_after_an_undo_is_a_branch(bench):
    nodes = bench.page.locator("option").filter(has_text="set ")
    count, before = nodes.count(), bench.settled()
    bench.move_a_slider()
    bench.until(lambda: nodes.count() > count, "a node beside the one undone")
    bench.settled()
    bench.click("Undo")
    bench.until(lambda: bench.error == f"{before:.3g}", "the error before")


def test_steps_are_cards_of_a_tree_with_pictures_and_a_click_goes_there(bench):
    steps = bench.page.locator(".step")
    if steps.count() < 3:  # the tests before were another process's
        bench.settled()
        bench.move_a_slider()
    bench.until(lambda: steps.count() > 2, "cards")
    bench.until(lambda: bench.page.locator(".step img").count() == steps.count(), "pictures")
    here = bench.page.locator(".step.present").get_attribute("data-number")
    steps.first.click()
    first = bench.page.locator(".step.present[data-number='0']")
    first.wait_for()
    bench.page.locator(f".step[data-number='{here}']").click()
    bench.page.locator(f".step.present[data-number='{here}']").wait_for()
    bench.settled()


def test_what_is_missing_is_named_shown_and_added(bench):
    before = bench.settled()
    bench.click("Find what is missing")
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
    verdict = bench.page.locator(".verdict div").first
    assert "With Column FPN column_fpn the model error falls" in verdict.inner_text()
    assert "these captures support it" in verdict.inner_text()


def test_a_running_refinement_is_cancelled_and_the_page_goes_on(bench):
    error = bench.settled()
    bench.click("Refine")
    bench.until(lambda: bench.page.get_by_role("button", name="Cancel").is_enabled(), "the task")
    bench.page.wait_for_timeout(300)
    bench.click("Cancel")
    bench.until(lambda: bench.page.get_by_role("button", name="Cancel").is_disabled(), "its end")
    assert bench.settled() == error
    message = bench.page.get_by_text("cancelled after")
    bench.until(lambda: message.count() == 0, "that the message goes away")


def test_a_reload_and_another_tab_show_the_same_session(bench, browser, address):
    """And widgets that Bokeh has not drawn yet are not changed, which it answers by errors."""
    error = bench.settled()
    bench.page.reload()
    assert bench.settled() == error
    assert bench.errors == []
    other = Workbench(browser, address)
    assert other.settled() == error
    other.page.locator(".step").first.click()
    bench.page.locator(".step.present[data-number='0']").wait_for()
    other.page.close()
    bench.page.locator(".step").last.click()
    bench.until(lambda: bench.settled() == error, "the last step")


def test_model_report_and_targets_are_downloaded(bench, tmp_path):
    for label, begins in (("Model", "schema: dnanalyze/model/1"), ("Report", "<!"),
                          ("CI targets", "")):  # fmt: skip
        with bench.page.expect_download() as caught:
            bench.page.get_by_text(label, exact=True).last.click()
        text = Path(caught.value.path()).read_text(encoding="utf-8")
        assert text.strip().startswith(begins)
        assert len(text) > 100


def test_the_report_is_two_pages_and_as_wide_as_a_telephone(bench, browser, tmp_path):
    with bench.page.expect_download() as caught:
        bench.page.get_by_text("Report", exact=True).last.click()
    caught.value.save_as(tmp_path / "report.html")
    page = browser.new_page(viewport={"width": 1440, "height": 900})
    page.goto((tmp_path / "report.html").as_uri())
    verdict = page.locator("#verdict").bounding_box()
    assert verdict["y"] + verdict["height"] <= 600
    assert page.locator("details.fold").first.bounding_box()["y"] <= 3000
    page.set_viewport_size({"width": 390, "height": 844})
    assert page.evaluate("document.documentElement.scrollWidth") == 390
    page.close()


HEADS = (
    b"row,column,rows,columns,measured_mean_dn",
    b"name,family",
    b"layer,",
    b"layer,column,row",
)  # sensor, fails, ...


def test_every_figure_is_downloaded(bench):
    """The images, the model error, the open statistic and the pixel, as CSV, PNG and SVG."""
    bench.click("pixel")
    for label in ("CSV", "PNG", "SVG"):
        buttons = bench.page.get_by_text(label, exact=True)
        bench.until(lambda b=buttons: b.count() == len(HEADS), f"the buttons {label}")
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


def test_the_dark_theme_keeps_the_session(bench):
    error = bench.settled()
    bench.page.get_by_text("dark theme").click()
    bench.page.get_by_text("light theme").wait_for()
    assert bench.settled() == error
    assert bench.errors == []


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
