"""Places and sizes of the page's panes in a real browser; skipped where there is none."""

from __future__ import annotations

import re

import pytest

pytest.importorskip("panel", reason="the extra workbench is not installed")


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
    bench.open("Shading")
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


def test_an_enlarged_pane_covers_the_page_and_a_second_press_puts_it_back(bench):
    assert bench.page.get_by_text("ranks the effects that may be missing").is_visible()
    buttons = bench.page.locator(".enlarge")
    for i in range(buttons.count()):
        before = buttons.nth(i).bounding_box()["x"]  # a click scrolls the page
        buttons.nth(i).click()
        bench.until(lambda: bench.page.locator(".large").count(), "a large pane")
        bench.until(lambda: bench.box(".large") == (0, 0, 1440, 900), "the whole page")
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
                x, y, width, height = bench.box(part)
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
    bench.open("Distribution")
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
        assert bench.box(".curve")[3] > 90
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
    width, side = bench.box(".measured")[2], bench.box(".side")[2]
    bench.click("swipe")
    bench.until(lambda: bench.box(".side")[2] > 1.7 * side, "a wide histogram")
    for name in (".measured", ".difference"):
        assert bench.box(name)[2] == pytest.approx(width, abs=1)
    assert not bench.page.locator(".simulated").first.is_visible()
    bench.click("side by side")
    bench.until(lambda: abs(bench.box(".side")[2] - side) < 1, "three images")
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
        bench.until(lambda: bench.box(".side")[1] > bench.box(".measured")[1] + 100, "two rows")
        height = bench.still(".measured")[3]
        bench.click("swipe")
        bench.until(lambda: bench.box(".measured")[3] > 1.7 * height, "a high image")
        assert bench.box(".measured")[2] > 1.9 * bench.box(".side")[2]
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
