"""A button that shows a pane alone, over the whole page."""

from __future__ import annotations

from typing import Any

import panel as pn

LARGE = "large"  # class of the enlarged pane: Bokeh does not take back a style that is removed
OVER = f"""
:host(.{LARGE}) {{ position:fixed !important; inset:0 !important; z-index:1000 !important;
  width:auto !important; height:auto !important; }}
"""


def enlarger(pane: Any, style: list[str]) -> Any:
    """The button of a pane; a second press puts the pane back."""
    pane.stylesheets = [*pane.stylesheets, OVER]
    button = pn.widgets.Toggle(
        name="⤢", value=False, width=26, margin=(0, 0, 0, 4), stylesheets=style,
        css_classes=["enlarge"],
    )  # fmt: skip

    def turned(event: Any) -> None:
        others = [c for c in pane.css_classes or [] if c != LARGE]
        pane.css_classes = [*others, LARGE] if event.new else others
        button.name = "✕" if event.new else "⤢"

    button.param.watch(turned, "value")
    return button
