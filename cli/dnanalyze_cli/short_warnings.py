"""Warnings of numerical libraries, as one line that says what to do."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TextIO

MOST = 3  # lines of a run; what overflows once does so at every step of a fit


class ShortWarnings:
    """Takes the place of ``warnings.showwarning``, which prints a line of source code."""

    def __init__(self) -> None:
        self._seen: set[tuple[str, int]] = set()

    def __call__(
        self,
        message: Warning | str,
        category: type[Warning],
        filename: str,
        lineno: int,
        file: TextIO | None = None,
        line: str | None = None,
    ) -> None:
        """Tell a warning, each place once and three in all."""
        if (filename, lineno) in self._seen or len(self._seen) >= MOST:
            return
        self._seen.add((filename, lineno))
        what = " ".join(str(message).split())
        print(
            f"note: {what} ({category.__name__} at {Path(filename).name}:{lineno}): a value is "
            "beyond what the arithmetic holds; if frames and options are as meant, please report "
            "it with the command",
            file=sys.stderr,
        )
