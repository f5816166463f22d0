"""A command that was stopped from outside, and what it left."""

from __future__ import annotations

import signal
import sys
import threading
from typing import Any

INTERRUPTED, TERMINATED = 130, 143  # exit codes: 128 + the signal's number


class Stopped(Exception):
    """Stopped by Ctrl-C or SIGTERM; the message is one line on what is kept and how to go on.

    Parameters
    ----------
    message : str
    code : int
        Exit code.
    """

    def __init__(self, message: str, code: int) -> None:
        super().__init__(message)
        self.code = code


def end_on_sigterm() -> None:
    """Make SIGTERM an exception, so that temporaries are removed.

    In some places, such as the callback of a weak reference, Python ignores exceptions. There the
    signal is sent again.
    """
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(TERMINATED))
    if hasattr(signal, "pthread_kill"):  # not on Windows
        sys.unraisablehook = _sent_again


def _sent_again(ignored: Any) -> None:
    """Send an ignored SIGTERM again; report any other ignored exception as Python does."""
    if isinstance(ignored.exc_value, SystemExit) and ignored.exc_value.code == TERMINATED:
        main = threading.main_thread().ident
        threading.Timer(0.05, signal.pthread_kill, (main, signal.SIGTERM)).start()
    else:
        sys.__unraisablehook__(ignored)
