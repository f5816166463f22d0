"""What each candidate effect would do to the error, and how sure that is."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from dnanalyze.report.figures.style import INK, MODEL, QUIET, Picture, figure, picture
from dnanalyze.report.words import is_number, number


def candidates(
    found: Sequence[Any], error: float | None, ordinary: Sequence[str] = (), most: int = 10
) -> Picture | None:
    """Error after each candidate's full refit, best first, beside the error now.

    ``ordinary``: candidates that were put in one after the other, before the rest.
    """
    shown = [c for c in found if is_number(c.error_after)][:most][::-1]
    if not shown:
        return None

    def draw() -> Any:
        fig, axes = figure(
            1, 2, 0.75 + 0.26 * len(shown), sharey=True, gridspec_kw={"width_ratios": (2.2, 1)}
        )
        left, right = axes[0]
        places = range(len(shown))
        left.grid(False, axis="y")
        right.grid(False, axis="y")
        now = error if is_number(error) else max(c.error_after for c in shown)
        assert now is not None
        worst = max(c.error_after for c in shown)
        left.hlines(places, [c.error_after for c in shown], now, color="#8fbbd9", linewidth=5)
        left.plot([c.error_after for c in shown], places, "o", color=MODEL, markersize=5)
        for place, c in enumerate(shown):
            beyond = c.error_after > now  # the label stands off the line
            left.annotate(number(c.error_after), (c.error_after, place), (6 if beyond else -6, 0),
                          va="center", ha="left" if beyond else "right",
                          textcoords="offset points", fontsize=7.5)  # fmt: skip
        left.axvline(now, color=INK, linewidth=0.9)
        left.axvline(1.0, color=QUIET, linewidth=0.8, linestyle=(0, (3, 2)))
        left.set_yticks(places, [c.effect for c in shown])
        left.set_title("error after a full refit, from the error now")
        left.set_xlim(0, 1.05 * now if worst <= now else 1.12 * worst)
        right.barh(places, [100 * c.confidence for c in shown], color=MODEL, height=0.5)
        right.set_xlim(0, 100)
        right.set_title("confidence [%]")
        for ax in (left, right):
            ax.tick_params(axis="y", length=0)
        return fig

    how = (
        "What every sensor has is put in step by step, any other candidate beside all of it"
        if ordinary
        else "Each candidate put in alone"
    )
    return picture(
        draw,
        f"{how} and everything refitted; the dashed line is a second sensor.",
        "Candidates with the error after a refit and their confidence.",
    )
