"""How many processors this process may use."""

from __future__ import annotations

import os


def cpu_count() -> int:
    """Processors that this process may use; all of the machine where the system does not say.

    Returns
    -------
    int
        1 at the least.

    Examples
    --------
    >>> cpu_count() >= 1
    True
    """
    allowed = getattr(os, "sched_getaffinity", None)  # neither on macOS nor on Windows
    return len(allowed(0)) if allowed else os.cpu_count() or 1
