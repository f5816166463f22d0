"""Screenshots of the workbench, to be looked at.

    python benchmarks/workbench_screenshots.py OUT FOLDER ...

Of each folder, or word of `workbench.py`, fifteen PNG files: the fitted page at four sizes, light
and dark, and at 1440 x 900 a family of statistics, candidates, the page after an addition, and four
views of the frames and the curves. Needs what `workbench.py` needs.
"""

from __future__ import annotations

import argparse
import shutil
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))
from workbench import FLAGS, VIRTUAL, served, settled

SIZES = {"1440x900": (1440, 900), "1440x780": (1440, 780), "1024": (1024, 813), "4k": (3840, 2160)}
PATIENCE_MS = 600_000.0
DRAWN_MS = 4000.0  # for the last picture, which follows the error


def looked_at(page: Any, save: Callable[[str], None]) -> None:
    """The page's states at one size."""

    def after(name: str) -> None:
        page.wait_for_timeout(DRAWN_MS)
        save(name)

    page.locator(".family").nth(1).click()
    after("family")
    enlarge = page.locator(".enlarge")
    for number, name in ((1, "frames-large"), (0, "fails-large")):
        enlarge.nth(number).click()
        after(name)
        enlarge.nth(number).click()
    for name in ("swipe", "blink"):
        page.get_by_role("button", name=name, exact=True).click()
        after(name)
    page.get_by_role("button", name="side by side", exact=True).click()
    page.get_by_role("button", name="Diagnose").click()
    page.wait_for_timeout(DRAWN_MS)
    settled(page, PATIENCE_MS / 1000)
    row = page.locator(".row").first
    if row.count():
        row.hover()
        page.wait_for_timeout(2 * DRAWN_MS)  # its curve is simulated first
    after("candidates")
    add = page.locator(".row").get_by_role("button", name="Add")
    if add.count():
        add.first.click()
        page.wait_for_timeout(DRAWN_MS)
        settled(page, PATIENCE_MS / 1000)
        page.mouse.move(5, 5)
    after("added")


def taken(folder: Path, into: Path, name: str) -> None:
    """Every screenshot of a folder."""
    from playwright.sync_api import sync_playwright

    with served(folder) as (_, address), sync_playwright() as play:
        browser = play.chromium.launch(executable_path=shutil.which("chromium"), args=FLAGS)
        for theme in ("dark", "light"):
            page = browser.new_page(viewport={"width": 1440, "height": 900})
            page.set_default_timeout(PATIENCE_MS)
            page.goto(f"{address}?theme={theme}")
            settled(page, PATIENCE_MS / 1000)

            def save(what: str, of: Any = page) -> None:
                of.screenshot(path=str(into / f"{name}-{what}.png"))

            for size, (width, height) in SIZES.items():
                page.set_viewport_size({"width": width, "height": height})
                page.wait_for_timeout(DRAWN_MS)
                save(f"{size}-{theme}")
            if theme == "light":
                page.set_viewport_size({"width": 1440, "height": 900})
                looked_at(page, save)
            page.close()
        browser.close()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("into", type=Path, metavar="OUT")
    parser.add_argument("folders", nargs="+", type=Path, metavar="FOLDER")
    options = parser.parse_args()
    options.into.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as temporary:
        for named in options.folders:
            make = VIRTUAL.get(str(named))
            folder = named if make is None else make(Path(temporary) / named)
            taken(folder, options.into, named.name)


if __name__ == "__main__":
    main()
