"""How long the figures of a report take on this machine, measured on one of them."""

from __future__ import annotations

from time import monotonic

import numpy as np

from dnanalyze.report.figures.pictures import Cell, panels

# Time of a report of a search over that of one panel: 137, 142 and 164 with 4, 5 and 28 operating
# points, 39 with one.
PANELS = 165
TIMED = 3  # panels: the slowest counts, since a report must not take longer


def drawing_time() -> float:
    """Time that the report of a search takes here, s."""
    _panel()  # loads what all share
    times = []
    for _ in range(TIMED):
        begun = monotonic()
        _panel()
        times.append(monotonic() - begun)
    return PANELS * max(times)


def _panel() -> None:
    x = np.arange(5.0)
    panels([Cell(lambda ax: ax.errorbar(x, x, np.ones(5)))], "", "")
