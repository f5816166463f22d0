"""The page in a real browser; skipped where there is none."""

from __future__ import annotations

import itertools
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from page_driver import PATIENCE_S, Workbench, served
from small_sensor import write_sensor

pytest.importorskip("panel", reason="the extra workbench is not installed")


@pytest.fixture(scope="module")
def series(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A sensor of five temperatures, so that parameters share a plot on the page."""
    return write_sensor(tmp_path_factory.mktemp("page") / "sensor", every=1)


@pytest.fixture(scope="module")
def address(series) -> Iterator[str]:
    with served(series) as found:
        yield found


@pytest.fixture(scope="module")
def bench(browser, address) -> Workbench:
    return Workbench(browser, address)


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


def test_what_changes_together_is_laid_out_once(bench):
    bench.settled()
    count = """async () => {
        let root = [...Bokeh.index.roots][0], count = 0;
        const before = root.compute_layout;
        root.compute_layout = function () { count += 1; return before.call(this); };
        const frame = () => new Promise((done) => requestAnimationFrame(done));
        for (let i = 0; i < 5; i++) root.invalidate_layout();
        await frame();
        root.compute_layout = before;
        return count;
    }"""
    assert bench.page.evaluate(count) == 1


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


def test_a_layout_while_a_plot_is_still_being_made_is_tried_again(bench):
    bench.settled()
    fails_twice = """async () => {
        const root = [...Bokeh.index.roots][0];
        let count = 0;
        root.measure_layout = function () {
            count += 1;
            if (count < 3) throw new Error("no layout yet");
            delete root.measure_layout;
            root.measure_layout();
        };
        root.compute_layout();
        const end = performance.now() + 60000;
        const pause = () => new Promise((done) => setTimeout(done, 200));
        do await pause(); while (count < 3 && performance.now() < end);
        return count;
    }"""
    assert bench.page.evaluate(fails_twice) == 3
    assert bench.errors == []


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
        return _box(bench, ".curve")[1] - _box(bench, ".statistic")[1]

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


def _open(bench: Workbench, family: str) -> None:
    """Click on a family, and wait for its cells: a click on those before means another one."""
    name = re.compile(f"^{family}")
    bench.page.locator(".family").filter(has_text=name).click()
    bench.page.locator(".family.chosen").filter(has_text=name).wait_for()


WHOLE = """(list) => {
    const box = list.getBoundingClientRect();
    const rows = [...list.querySelectorAll("tbody tr")];
    const seen = rows.filter((r) => getComputedStyle(r).opacity === "1");
    const inside = seen.filter((r) => {
        const { top, bottom } = r.getBoundingClientRect();
        return top >= box.top - 1 && bottom <= box.bottom + 1;
    });
    return [rows.length, seen.length, inside.length];
}"""  # rows of the matrix, those that are not hidden, and those of them that are not cut


@pytest.mark.parametrize("height", [780, 813, 900])
def test_no_row_of_the_statistics_is_cut_and_the_number_of_others_is_said(bench, height):
    bench.page.set_viewport_size({"width": 1440, "height": height})
    _open(bench, "Shading")
    rows, more = bench.page.locator(".matrix .list"), bench.page.locator(".matrix .more")

    def whole() -> bool:
        count, seen, inside = rows.evaluate(WHOLE)
        left = re.fullmatch(r"▾ (\d+) more", more.inner_text())
        return 1 < seen == inside < count and left is not None and int(left[1]) == count - seen

    try:
        bench.until(whole, "whole rows and the number of the others")
        while (text := more.inner_text()) != "▴ first":  # until every row has been seen
            more.click()
            bench.until(lambda was=text: more.inner_text() != was, "further rows")
        more.click()
        bench.until(whole, "the first rows")
    finally:
        bench.page.set_viewport_size({"width": 1440, "height": 900})


def test_a_click_on_a_cell_marks_where_its_statistic_comes_from(bench):
    """And one of a statistic that has no place takes the marks away."""
    _open(bench, "Rows and columns")
    row = bench.page.locator("tr").filter(has_text=re.compile(r"^(?!.*(temporal|in time)).*column"))
    row.first.locator(".cell").last.click()
    marks = bench.page.locator(".marks .quiet").filter(has_text="marked: ")
    marks.filter(has_text="column").wait_for()
    _open(bench, "Hot-pixel tail")
    row = bench.page.locator("tr").filter(has_text="pixels above 5 robust sigma")
    row.locator(".cell").first.click()
    bench.until(lambda: min(_lengths(bench, "marked pixels")) > 0, "marked pixels")
    _open(bench, "Shading")

    def cleared() -> bool:  # a cell that is drawn anew meanwhile takes no click
        bench.page.locator(".cell").last.click()
        return max(_lengths(bench, "marked pixels")) == 0

    bench.until(cleared, "no marks")
    bench.until(lambda: marks.count() == 0, "no words of marks")


def test_the_histogram_of_a_narrow_page_is_as_wide_as_its_frames(bench):
    bench.page.set_viewport_size({"width": 1024, "height": 768})
    try:
        shown = bench.page.locator(".side")
        bench.until(lambda: shown.bounding_box()["width"] > 900, "a wide histogram")
    finally:
        bench.page.set_viewport_size({"width": 1440, "height": 900})


def test_nothing_is_wider_than_a_narrow_page_and_all_of_it_can_be_scrolled_to(bench):
    bench.page.set_viewport_size({"width": 1024, "height": 768})
    size = "[document.documentElement.scrollWidth, document.documentElement.scrollHeight]"
    try:
        bench.until(lambda: bench.page.evaluate(size)[0] == 1024, "a page as wide as the window")
        assert bench.page.evaluate(size)[1] > 768
        report = bench.page.get_by_text("CI targets")
        report.scroll_into_view_if_needed()
        box = report.bounding_box()
        assert 0 <= box["x"] <= 1024
        assert 0 <= box["y"] <= 768
    finally:
        bench.page.set_viewport_size({"width": 1440, "height": 900})


def test_labels_too_wide_for_the_matrix_stand_upright(bench):
    labels = bench.page.locator(".list thead th:not(:first-child) span")
    before = labels.all_inner_texts()
    write = "(spans, texts) => spans.forEach((s, i) => { s.textContent = texts[i]; })"
    fits = "t => t.classList.contains('steep') && t.offsetWidth <= t.parentElement.clientWidth"
    table = bench.page.locator(".list table")
    assert not table.evaluate(fits)
    try:
        labels.evaluate_all(write, ["0.000169 s, gain 1"] * len(before))
        bench.page.set_viewport_size({"width": 1024, "height": 900})
        bench.until(lambda: table.evaluate(fits), "upright labels")
    finally:
        labels.evaluate_all(write, before)
        bench.page.set_viewport_size({"width": 1440, "height": 900})
    bench.until(lambda: not table.evaluate(fits), "labels in a row")


def _box(bench: Workbench, which: str) -> tuple[float, ...]:
    """Left, top, width and height of the first element of a class."""
    box = bench.page.locator(which).first.bounding_box()
    return tuple(box[k] for k in ("x", "y", "width", "height"))


def _still(bench: Workbench, which: str) -> tuple[float, ...]:
    """The same, once a layout no longer moves it."""

    def same() -> tuple[float, ...]:
        before = _box(bench, which)
        bench.page.wait_for_timeout(500)
        return before if _box(bench, which) == before else ()

    return bench.until(same, f"{which} at rest")


def test_an_enlarged_pane_covers_the_page_and_a_second_press_puts_it_back(bench):
    assert bench.page.get_by_text("ranks the effects that may be missing").is_visible()
    buttons = bench.page.locator(".enlarge")
    for i in range(buttons.count()):
        before = buttons.nth(i).bounding_box()["x"]  # a click scrolls the page
        buttons.nth(i).click()
        bench.until(lambda: bench.page.locator(".large").count(), "a large pane")
        bench.until(lambda: _box(bench, ".large") == (0, 0, 1440, 900), "the whole page")
        buttons.nth(i).click()
        bench.until(lambda b=before, i=i: buttons.nth(i).bounding_box()["x"] == b, "its place")
        assert bench.page.locator(".large").count() == 0


SIDES = """() => {
    const all = Bokeh.documents.flatMap((d) => [...d.all_models]);
    const made = all.find((m) => m.name === "figure of measured");
    const {x_range: x, y_range: y} = made;
    return (x.end - x.start) / made.inner_width / ((y.start - y.end) / made.inner_height);
}"""  # width of a pixel over its height, on the screen


@pytest.mark.parametrize("size", [(1440, 780), (1024, 768), (3840, 2160), (1440, 900)])
def test_pixels_are_square_in_an_enlarged_pane_and_after_it(bench, size):
    bench.page.set_viewport_size(dict(zip(("width", "height"), size, strict=True)))
    button = bench.page.locator(".enlarge").nth(1)  # of the frames
    for large in (1, 0):
        button.click()
        bench.until(lambda n=large: bench.page.locator(".large").count() == n, "the other size")
        bench.until(lambda: abs(bench.page.evaluate(SIDES) - 1) < 0.05, "square pixels")
        if large:  # all four parts of the pane within it
            for part in (".measured", ".simulated", ".difference", ".side"):
                x, y, width, height = _box(bench, part)
                assert width > 300
                assert height > 250
                assert x >= 0
                assert y >= 0
                assert x + width <= size[0]
                assert y + height <= size[1]


@pytest.mark.parametrize("height", [780, 900])
def test_frames_and_failures_are_seen_whole_on_the_screen(bench, height):
    """And the lowest axis of the open figure, below its residuals."""
    pane = "[...Bokeh.index.roots][0].child_views[2].el.getBoundingClientRect()"
    _open(bench, "Distribution")
    bench.page.set_viewport_size({"width": 1440, "height": height})
    try:
        bench.until(
            lambda: height - 200 < bench.page.evaluate(f"() => scrollY + {pane}.bottom") <= height,
            "the lower panes",
        )
        lowest = bench.page.locator(".curve-residuals")
        bench.until(lambda: lowest.bounding_box()["height"] > 60, "the residuals")
        box = lowest.bounding_box()
        assert box["y"] + box["height"] <= height
        assert _box(bench, ".curve")[3] > 90
    finally:
        bench.page.set_viewport_size({"width": 1440, "height": 900})


def test_the_panes_take_the_height_that_a_long_verdict_leaves(bench):
    strip = "[...Bokeh.index.roots][0].child_views[1].el"
    pane = "[...Bokeh.index.roots][0].child_views[2].el.getBoundingClientRect()"
    bench.page.evaluate(f"() => {{ {strip}.style.setProperty('min-height', '76px', 'important') }}")
    try:
        bench.until(
            lambda: (
                bench.page.evaluate(f"() => {strip}.offsetHeight") >= 76
                and 700 < bench.page.evaluate(f"() => scrollY + {pane}.bottom") <= 900
            ),
            "the lower panes below a verdict of three lines",
        )
    finally:
        bench.page.evaluate(f"() => {strip}.style.removeProperty('min-height')")


def test_swiped_image_has_the_difference_beside_it_and_the_histogram_the_rest(bench):
    width, side = _box(bench, ".measured")[2], _box(bench, ".side")[2]
    bench.click("swipe")
    bench.until(lambda: _box(bench, ".side")[2] > 1.7 * side, "a wide histogram")
    for name in (".measured", ".difference"):
        assert _box(bench, name)[2] == pytest.approx(width, abs=1)
    assert not bench.page.locator(".simulated").first.is_visible()
    bench.click("side by side")
    bench.until(lambda: abs(_box(bench, ".side")[2] - side) < 1, "three images")
    bench.until(lambda: abs(bench.page.evaluate(SIDES) - 1) < 0.05, "square pixels")


@pytest.mark.parametrize("enlarged", [True, False])
def test_swiped_image_has_the_height_where_there_is_some(bench, enlarged):
    """In the enlarged pane, and on a narrow page, where images and histogram share it else."""
    enlarge = bench.page.locator(".enlarge").nth(1)
    try:
        if enlarged:
            enlarge.click()
        else:
            bench.page.set_viewport_size({"width": 1024, "height": 813})
        bench.until(lambda: _box(bench, ".side")[1] > _box(bench, ".measured")[1] + 100, "two rows")
        height = _still(bench, ".measured")[3]
        bench.click("swipe")
        bench.until(lambda: _box(bench, ".measured")[3] > 1.7 * height, "a high image")
        assert _box(bench, ".measured")[2] > 1.9 * _box(bench, ".side")[2]
        bench.until(lambda: abs(bench.page.evaluate(SIDES) - 1) < 0.05, "square pixels")
    finally:
        bench.click("side by side")
        if enlarged:
            enlarge.click()
        bench.page.set_viewport_size({"width": 1440, "height": 900})


def test_a_slider_ends_before_its_number(bench):
    for row in bench.page.locator(".parameter").all():
        slider = row.locator(".noUi-target").bounding_box()
        number = row.locator("input[type=text]").bounding_box()
        assert slider["x"] + slider["width"] <= number["x"]


def test_every_class_of_bokeh_that_the_style_sheets_name_is_on_the_page(bench):
    """It is Bokeh's own, and another version may name it otherwise."""
    from dnanalyze.workbench.page.downloads import SMALL
    from dnanalyze.workbench.page.style import LIGHT, inner

    named = set(re.findall(r"\.((?:bk|noUi)-[\w-]+)", inner(LIGHT) + SMALL))
    assert {"bk-btn", "bk-input", "noUi-handle"} < named
    assert [name for name in sorted(named) if not bench.page.locator(f".{name}").count()] == []
    assert _box(bench, ".parameter .noUi-handle")[2:] == (14, 14)
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
