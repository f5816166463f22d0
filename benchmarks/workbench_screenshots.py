"""Screenshots of the workbench, to be looked at.

    python benchmarks/workbench_screenshots.py OUT FOLDER ...

Of each folder, or word of `workbench.py`, up to eighteen PNG files: the fitted page at four sizes,
light and dark, and at 1440 x 900 a family of statistics, two enlarged panes, swipe, blink, the
spectra of one and of all operating points, candidates, the page after an addition, and then in the
dark theme. Needs what `workbench.py` needs.
"""

from __future__ import annotations

import argparse
import shutil
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))
from workbench import FLAGS, VIRTUAL, served, settled

SIZES = {"1440x900": (1440, 900), "1440x780": (1440, 780), "1024": (1024, 813), "4k": (3840, 2160)}
PATIENCE_S = 600.0
DRAWN_MS = 4000.0  # for the last picture, which follows the error
Save = Callable[[str], None]


def at_sizes(page: Any, save: Save) -> None:
    """The fitted page at every size, at last at the first."""
    for size, (width, height) in [*SIZES.items()][::-1]:
        page.set_viewport_size({"width": width, "height": height})
        page.wait_for_timeout(DRAWN_MS)
        save(size)


def ended(page: Any) -> None:
    """Wait until a task has begun, and until nothing is under way."""
    diagnose = page.get_by_role("button", name="Diagnose")
    end = time.monotonic() + PATIENCE_S
    while diagnose.is_enabled() and time.monotonic() < end:
        page.wait_for_timeout(20)
    settled(page, PATIENCE_S)


def in_states(page: Any, save: Save) -> None:
    """Enlarged panes, views of the frames, candidates, and the page after an addition."""

    def after(name: str) -> None:
        page.wait_for_timeout(DRAWN_MS)
        save(name)

    page.locator(".family").nth(1).click()
    after("family")
    for number, name in enumerate(("fails-large", "frames-large")):
        enlarge = page.locator(".enlarge").nth(number)
        enlarge.click()
        after(name)
        enlarge.click()
    for name in ("swipe", "blink"):
        page.get_by_role("button", name=name, exact=True).click()
        after(name)
    page.get_by_role("button", name="side by side", exact=True).click()
    for name, title in (("spectrum", "Radial spectrum of"), ("all spectra", "Radial spectra of")):
        page.get_by_role("button", name=name, exact=True).click()
        page.get_by_text(title).first.wait_for()
        after(name.replace(" ", "-"))
    page.get_by_role("button", name="histogram", exact=True).click()
    page.get_by_role("button", name="Diagnose").click()
    ended(page)
    candidate = page.locator(".row").first
    if not candidate.count():
        return after("candidates")
    candidate.hover()
    page.wait_for_timeout(2 * DRAWN_MS)  # its curve is simulated first
    after("candidates")
    candidate.get_by_role("button", name="Add").click()
    ended(page)
    page.mouse.move(5, 5)
    after("added")


def taken(folder: Path, into: Path, name: str) -> None:
    """Every screenshot of a folder."""
    from playwright.sync_api import sync_playwright

    with served(folder) as (_, address), sync_playwright() as play:
        browser = play.chromium.launch(executable_path=shutil.which("chromium"), args=FLAGS)
        page = browser.new_page(viewport={"width": 1440, "height": 900})
        page.set_default_timeout(1000 * PATIENCE_S)

        def save(what: str) -> None:
            whole = what in ("added", "1440x900-dark")  # with the history, below the screen
            page.screenshot(path=str(into / f"{name}-{what}.png"), full_page=whole)

        for theme in ("dark", "light"):
            page.goto(f"{address}?theme={theme}")
            settled(page, PATIENCE_S)
            at_sizes(page, lambda size, theme=theme: save(f"{size}-{theme}"))
        in_states(page, save)
        page.goto(f"{address}?theme=dark")
        settled(page, PATIENCE_S)
        page.wait_for_timeout(DRAWN_MS)
        save("last-dark")
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
