"""Work beside the page: in threads, with its results brought back to the document."""

from __future__ import annotations

from collections.abc import Callable
from threading import Lock, Thread
from typing import Any

from dnanalyze.workbench.measuring import Superseded

Show = Callable[[Any], None]


class Latest:
    """Carries out the latest of many requests, one at a time, in a thread.

    Requests that arrive while one is carried out replace one another: a slider that moves faster
    than a preview is computed skips the positions between. Work that raises `Superseded` has no
    result.

    Parameters
    ----------
    back : callable
        Brings a function call back to the document's thread.
    """

    def __init__(self, back: Callable[[Callable[[], None]], None]) -> None:
        self._back = back
        self._lock = Lock()
        self._waiting: tuple[Callable[[], Any], Show, Show] | None = None
        self._busy = False

    @property
    def waiting(self) -> bool:
        """Whether a request has come since what is carried out was begun."""
        return self._waiting is not None

    def ask(self, work: Callable[[], Any], show: Show, failed: Show) -> None:
        """Carry out ``work`` in the thread, then ``show`` its result, or ``failed`` its error."""
        with self._lock:
            self._waiting = work, show, failed
            if self._busy:
                return
            self._busy = True
        Thread(target=self._go_on, daemon=True).start()

    def _go_on(self) -> None:
        while True:
            with self._lock:
                if self._waiting is None:
                    self._busy = False
                    return
                (work, show, failed), self._waiting = self._waiting, None
            try:
                found = work()
            except Superseded:
                continue
            except Exception as error:  # an effect of the user's may raise anything: it is shown
                self._call(failed, error)
            else:
                self._call(show, found)

    def _call(self, function: Show, content: Any) -> None:
        self._back(lambda: function(content))
