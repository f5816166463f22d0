"""A command that was stopped from outside, and what it left."""

from __future__ import annotations

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
