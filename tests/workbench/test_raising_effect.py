"""An effect of the user's that raises under its slider, on the page."""

from __future__ import annotations

import pytest
import yaml
from page_driver import Workbench, served

pytest.importorskip("panel", reason="the extra workbench is not installed")

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


def test_an_effect_that_raises_under_its_slider_is_a_message(browser, folder, fitted, tmp_path):
    own, model = tmp_path / "own.py", tmp_path / "model.yaml"
    own.write_text(RAISING)
    with_own = fitted.to_plain()
    with_own["effects"].append({"raising": {"size": 1.4}})
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
