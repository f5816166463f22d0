"""When a slider rests, as the browser sees it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import param
from panel.custom import JSComponent

REST_MS = 300  # without a move after the browser has drawn a preview: the full error is computed


class Rest(JSComponent):
    """Calls a function when the browser has drawn the last move and none has come for a while.

    Parameters
    ----------
    rested : callable
        Called in the document's thread.

    Notes
    -----
    `move` counts the moves. `draw` goes to the browser in the message of what it draws; the browser
    answers with the same number, and the answer to an earlier move is passed over.
    """

    drawn = param.Integer(default=0, doc="Number of the move whose preview is drawn.")
    rest_ms = param.Integer(default=REST_MS, doc="Wait after the drawing.")

    _esm = Path(__file__).with_name("rest.js").read_text(encoding="utf-8")

    def __init__(self, rested: Callable[[], None], **params: Any) -> None:
        super().__init__(width=1, height=1, margin=0, **params)
        self._rested = rested
        self._moves = 0

    def move(self) -> None:
        """A slider has moved: what the browser has drawn is of an earlier move."""
        self._moves += 1

    def draw(self) -> None:
        """The last move is drawn with this message."""
        self.drawn = self._moves

    def _handle_msg(self, message: Any) -> None:
        if message == self._moves:
            self._rested()
