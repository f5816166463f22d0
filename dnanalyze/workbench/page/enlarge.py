"""A button that shows a pane alone, over the whole page."""

from __future__ import annotations

from typing import Any

import panel as pn

OVER = {"position": "fixed", "inset": "8px", "z-index": "1000", "width": "auto", "height": "auto"}


def enlarger(pane: Any, style: list[str]) -> Any:
    """The button of a pane; a second press puts the pane back."""
    button = pn.widgets.Toggle(
        name="⤢", value=False, width=26, margin=(0, 0, 0, 4), stylesheets=style,
        css_classes=["enlarge"],
    )  # fmt: skip

    def turned(event: Any) -> None:
        kept = {k: v for k, v in pane.styles.items() if k not in OVER}
        pane.styles = kept | OVER if event.new else kept
        button.name = "✕" if event.new else "⤢"

    button.param.watch(turned, "value")
    return button
