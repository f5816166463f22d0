"""What the panes of one page share: the session, the colours, the document, what is chosen."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, field
from threading import Thread
from typing import Any

import panel as pn

from dnanalyze.errors import InputError
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.workbench.curves import Address
from dnanalyze.workbench.evaluation import Evaluation
from dnanalyze.workbench.history import Node
from dnanalyze.workbench.page.background import Latest
from dnanalyze.workbench.page.drawn import Drawn
from dnanalyze.workbench.page.style import Palette
from dnanalyze.workbench.session import WorkbenchSession

LIVE = ("preview", "compared", "error")  # news for which no model of the page is exchanged


@dataclass
class Context:
    """State of one open page; panes tell one another through it.

    Parameters
    ----------
    session : WorkbenchSession
    palette : Palette
    document : bokeh Document
    brushed : Address or None
        The statistic whose pixels, rows or columns are marked in the images.
    shown : Evaluation or None
        What the panes draw as the present model.
    draft : NoiseModel or None
        Where a slider has been moved to, until that is a node.
    """

    session: WorkbenchSession
    palette: Palette
    document: Any
    family: str = ""
    address: Address | None = None
    brushed: Address | None = None
    candidate: tuple[str, Evaluation] | None = None
    shown: Evaluation | None = None
    draft: NoiseModel | None = None
    compared: Node | None = None
    listeners: list[Callable[[str], None]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.latest = Latest(self.back)
        self._undrawn: Drawn | None = None  # of the panes that were sent last
        self._held: list[Callable[[], None]] = []

    @property
    def drawing(self) -> bool:
        """Whether the browser has still to draw panes that it was sent."""
        return self._undrawn is not None

    def back(self, call: Callable[[], None]) -> None:
        """Call a function in the document's thread; nothing where the page has been closed.

        While the browser has still to draw panes that it was sent, the call waits.
        """
        session = self.document.session_context  # none, once the document is gone
        if session is not None and not session.destroyed:
            self.document.add_next_tick_callback(lambda: self._call(call))

    def _call(self, call: Callable[[], None]) -> None:
        if self.drawing:
            self._held.append(call)
        else:
            call()

    def every(self, period_ms: int, call: Callable[[], None]) -> Any:
        """Call a function periodically, but not while the browser has still to draw panes."""

        def tick() -> None:
            if not self.drawing:
                call()

        return pn.state.add_periodic_callback(tick, period=period_ms)

    def send(self, place: Any, panes: Sequence[Any]) -> None:
        """Put new panes in a place of the page; in the document's thread.

        A browser makes a widget in several steps, and fails at a change of one that is not drawn
        yet: what would change the page waits until it has drawn these.
        """
        self._undrawn = Drawn(self._drawn)
        place.objects = [*panes, self._undrawn]

    def _drawn(self, mark: Drawn) -> None:
        """The browser has drawn panes; those that others have replaced do not count."""
        if mark is self._undrawn:
            self._undrawn, held, self._held = None, self._held, []
            for call in held:
                self.back(call)

    def tell(self, what: str) -> None:
        """Tell every pane what has changed, in one message; in the document's thread."""
        if self.drawing:
            self.later(what)
            return
        with self.combined(exchanging=what not in LIVE):
            for listener in self.listeners:
                listener(what)

    @contextmanager
    def combined(self, exchanging: bool = False) -> Iterator[None]:
        """Send what changes within as one message: a browser never draws the half of it.

        Where models of the page are exchanged, Bokeh searches the page for them once, at the end;
        else at every exchange, which takes seconds on a busy machine.
        """
        within = self.document.callbacks.hold_value is not None
        self.document.hold("combine")
        search = self.document.models.freeze() if exchanging else nullcontext()
        search.__enter__()
        try:
            yield
        finally:
            search.__exit__(None, None, None)  # after an error too: Bokeh's own does not
            if not within:
                self.document.unhold()

    def later(self, what: str) -> None:
        """As `tell`, from the callback of a widget: these may run without the document's lock."""
        self.back(lambda: self.tell(what))

    def act(self, action: Callable[[], Any]) -> None:
        """Something the user asked for, in a thread; what is wrong becomes a message."""

        def work() -> None:
            try:
                action()
            except InputError as error:
                self.session.tell(str(error))
            except Exception as error:  # an effect of the user's may raise anything
                self.session.tell(f"{type(error).__name__}: {error}")

        Thread(target=work, daemon=True).start()
