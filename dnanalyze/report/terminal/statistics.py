"""The outcome of `analyze` in the terminal."""

from __future__ import annotations

from typing import Any

from rich.console import Console

from dnanalyze.report.tables import info, laws
from dnanalyze.report.terminal.common import MOST_FAILURES, points, table, verdict
from dnanalyze.report.words import number, with_error

_OVERVIEW = {
    "mean": "mean",
    "temporal_noise": "temporal",
    "pattern_noise": "pattern",
    "frame_noise_core": "spread",
    "hot_count_5": "hot > 5σ",
}


def statistics(console: Console, captures: Any, measured: Any) -> None:
    """Level and noise at every operating point, then the trends."""
    from dnanalyze.analyzers.families.trends import law_doubts
    from dnanalyze.report.pages.analyze import headline

    verdict(console, captures, headline(measured))
    names = [n for n in _OVERVIEW if any(n in s.values for s in measured.settings)]
    if "temporal_noise" in names and "frame_noise_core" in names:
        names.remove("frame_noise_core")
    units = [
        f"{_OVERVIEW[n]}{f' [{info(n).unit}]' if info(n).unit not in ('', '1') else ''}"
        for n in names
    ]
    rows = (
        (
            f"{s.point.label()} {s.plane}".strip(),
            *(number(s.values[n].value, 4) if n in s.values else "–" for n in names),
        )
        for s in measured.settings
    )
    table(console, ("operating point", *units), rows)
    columns, found = laws(measured)
    table(
        console,
        ("over temperature", *columns),
        (
            (title, *(with_error(v.value, v.se, unit) if v else "–" for v in values))
            for title, values, unit in found
        ),
    )
    points(console, "Warnings", law_doubts(measured))
    reasons = sorted({reason for s in measured.settings for reason in s.missing.values()})
    points(console, "Not determined from these captures", reasons, MOST_FAILURES)
