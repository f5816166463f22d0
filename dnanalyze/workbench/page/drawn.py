"""Tells that the browser has drawn the panes beside it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from panel.custom import JSComponent


class Drawn(JSComponent):
    """Calls a function once, when the browser has drawn what was sent with this.

    Parameters
    ----------
    drawn : callable
        Called with this component, in the document's thread.
    """

    _esm = Path(__file__).with_name("drawn.js").read_text(encoding="utf-8")

    def __init__(self, drawn: Callable[[Drawn], None], **params: Any) -> None:
        super().__init__(width=1, height=1, margin=0, styles={"position": "absolute"}, **params)
        self._call = drawn

    def _handle_msg(self, message: Any) -> None:
        self._call(self)
