"""Make the pictures of the workbench from the real page: a screenshot and a short animation.

    python docs/make_workbench.py

Needs the extra ``browser`` and Debian's chromium. Writes docs/figures/workbench.png and
docs/figures/workbench.gif: diagnosis, candidate, addition, on the sensor of ``--demo``.
"""

from __future__ import annotations

import io
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

from PIL import Image
from playwright.sync_api import sync_playwright

FIGURES = Path(__file__).parent / "figures"
RUN = "from dnanalyze_cli.main import run; run()"
FLAGS = ["--no-sandbox", "--disable-gpu", "--disable-background-networking"]
LIMIT_MS = 300_000.0
CURVE_MS = 10_000  # until the curve of a candidate is drawn, on a slow machine
KEEPS = Image.Quantize.FASTOCTREE  # the colours of thin curves, which the median cut gives up
ANIMATED = 960, 600  # of the animation, pixels


def settled(page: Any) -> None:
    """Wait until no task is under way and the full error shows."""
    error = page.locator(".error").filter(has_text=re.compile(r"^[\d.]+$"))
    for _ in range(2):  # the first may lie before the task
        page.wait_for_timeout(900)
        page.get_by_role("button", name="Diagnose", disabled=False).wait_for(timeout=LIMIT_MS)
        error.wait_for(timeout=LIMIT_MS)
    page.wait_for_timeout(900)


def shown(page: Any) -> Image.Image:
    """The page as a picture."""
    return Image.open(io.BytesIO(page.screenshot())).convert("RGB")


def scenes(page: Any) -> list[tuple[Image.Image, int]]:
    """Pictures of the work, with how long each is shown, ms."""
    fitted = page.locator("option").filter(has_text="model, fitted")
    fitted.first.wait_for(state="attached", timeout=LIMIT_MS)
    settled(page)
    found = [(shown(page), 1800)]
    page.get_by_role("button", name="Find what is missing", exact=True).click()
    page.wait_for_timeout(2500)
    found.append((shown(page), 1200))
    row = page.locator(".row").first
    row.wait_for(timeout=LIMIT_MS)
    settled(page)
    page.wait_for_timeout(2500)
    found.append((shown(page), 1800))
    row.hover()
    page.wait_for_timeout(CURVE_MS)
    found.append((shown(page), 2500))
    row.get_by_role("button", name="Add").click()
    settled(page)
    told = page.locator(".verdict").filter(has_text="A classifier")  # not what is asked of it
    told.wait_for(timeout=LIMIT_MS)
    settled(page)
    page.wait_for_timeout(1500)
    found.append((shown(page), 4000))
    return found


def main() -> None:
    """Write both pictures."""
    process = subprocess.Popen(
        [sys.executable, "-c", RUN, "workbench", "--demo", "--no-browser"],
        stdout=subprocess.PIPE, text=True, env=os.environ | {"PYTHONUNBUFFERED": "1"},
    )  # fmt: skip
    assert process.stdout is not None
    try:
        address = process.stdout.readline().split()[0]
        with sync_playwright() as play:
            browser = play.chromium.launch(executable_path=shutil.which("chromium"), args=FLAGS)
            page = browser.new_page(viewport={"width": 1440, "height": 900})
            page.goto(address)
            made = scenes(page)
            browser.close()
    finally:
        process.terminate()
        process.wait(60)
        process.stdout.close()
    made[3][0].quantize(256, KEEPS).save(FIGURES / "workbench.png", optimize=True)
    small = [
        image.resize(ANIMATED, Image.Resampling.LANCZOS).quantize(128, KEEPS) for image, _ in made
    ]
    small[0].save(
        FIGURES / "workbench.gif", save_all=True, append_images=small[1:],
        duration=[ms for _, ms in made], loop=0, optimize=True,
    )  # fmt: skip


if __name__ == "__main__":
    main()
