"""What the tests of the page in a browser drive: a server of a folder, and an open page."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

PATIENCE_S = 300.0  # several times what a page that works takes to open on a slow machine
REST_S = 1.0  # between two states the error of the first is shown, and no task, for less


@contextmanager
def served(folder: Path, *options: str) -> Iterator[str]:
    """Address of a server on the small sensor."""
    process = subprocess.Popen(
        [sys.executable, "-m", "dnanalyze", "workbench", str(folder), "--no-browser", *options],
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


class Workbench:
    """An open page, of a browser that is slower by a factor."""

    def __init__(self, browser: Any, address: str, slower: float = 1) -> None:
        self.page = browser.new_page(viewport={"width": 1440, "height": 900})
        speed = self.page.context.new_cdp_session(self.page)
        speed.send("Emulation.setCPUThrottlingRate", {"rate": slower})
        self.page.set_default_timeout(1000 * PATIENCE_S)
        self.outside: list[str] = []
        self.errors: list[str] = []
        self.page.on("request", self._requested)
        self.page.on("pageerror", lambda error: self.errors.append(str(error)))
        self.page.on("console", self._said)
        self.page.goto(address)
        begun = self.page.locator("option").filter(has_text=re.compile("model(, fitted| as given)"))
        begun.first.wait_for(state="attached")
        self.settled()

    def _requested(self, request: Any) -> None:
        if not re.match(r"(http|ws)://127\.0\.0\.1[:/]|data:|blob:", request.url):
            self.outside.append(request.url)

    def _said(self, message: Any) -> None:
        if message.type == "error":
            self.errors.append(message.text)

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
        """The full error, once no task has been under way, and it the same, for a while."""
        seen, since = "", time.monotonic()

        def same() -> str:
            nonlocal seen, since
            shown = (
                self.error if self.page.get_by_role("button", name="Diagnose").is_enabled() else ""
            )
            if shown != seen or not re.fullmatch(r"[\d.]+", shown):
                seen, since = shown, time.monotonic()
            return seen if time.monotonic() - since > REST_S else ""

        return float(self.until(same, "the full error"))

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

    def move_a_slider(self) -> None:
        """Twelve steps up."""
        slider = self.page.locator(".parameter").nth(2).locator("[role=slider]")
        for _ in range(12):
            slider.press("ArrowRight")

    def click(self, name: str) -> None:
        """A button."""
        self.page.get_by_role("button", name=name, exact=True).first.click()

    def open(self, family: str) -> None:
        """Click on a family, and wait for its cells: a click on those before means another one."""
        name = re.compile(f"^{family}")
        self.page.locator(".family").filter(has_text=name).click()
        self.page.locator(".family.chosen").filter(has_text=name).wait_for()

    def box(self, which: str) -> tuple[float, ...]:
        """Left, top, width and height of the first element of a class."""
        box = self.page.locator(which).first.bounding_box()
        return tuple(box[k] for k in ("x", "y", "width", "height"))

    def still(self, which: str) -> tuple[float, ...]:
        """The same, once a layout no longer moves it."""

        def same() -> tuple[float, ...]:
            before = self.box(which)
            self.page.wait_for_timeout(500)
            return before if self.box(which) == before else ()

        return self.until(same, f"{which} at rest")
