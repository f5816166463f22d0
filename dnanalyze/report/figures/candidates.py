"""What each candidate effect would do to the error, and how sure that is."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from dnanalyze.diagnosis.results import Candidate
from dnanalyze.report.figures.palette import CALM
from dnanalyze.report.figures.style import INK, MODEL, Cell, Picture, panels
from dnanalyze.report.refinement_stages import BASELINE_STAGE
from dnanalyze.report.words import is_number, number, percent


def draw_candidates(
    ax: Any,
    found: Sequence[Candidate],
    error: float | None,
    ordinary: Sequence[str] = (),
    most: int = 10,
) -> Any:
    """Error after each candidate's full refit, best first, from the error before it.

    Parameters
    ----------
    ax : matplotlib axes
    found : sequence of Candidate
        Best first.
    error : float or None
        Of the model as it is.
    ordinary : sequence of str
        Candidates of the baseline model: put in one after the other, before the rest.
    most : int
        Candidates shown.
    """
    bars = _bars(found, error, ordinary)[:most]
    if not bars:
        return ax
    names, before, after, sure = zip(*bars, strict=True)
    places = list(range(len(bars)))
    ax.grid(visible=False, axis="y")
    ax.hlines(places, after, before, color=CALM, linewidth=6)
    ax.plot(after, places, "o", color=MODEL, markersize=5)
    for place, start, end in zip(places, before, after, strict=True):
        falls = end <= start  # the number stands off the line
        ax.annotate(number(end), (end, place), (-6 if falls else 6, 0), va="center",
                    ha="right" if falls else "left", textcoords="offset points",
                    fontsize=7.5)  # fmt: skip
    ax.axvline(1.0, color=INK, linewidth=0.8, linestyle=(0, (3, 2)), zorder=0.5)
    ax.set_yticks(places, names)
    ax.tick_params(axis="y", length=0)
    ax.set_ylim(len(bars) - 0.4, -0.6)
    ax.set_xlim(0, 1.12 * max(*before, *after, 1.0))
    ax.set_xlabel("model error after a full refit")
    right = ax.secondary_yaxis("right")
    right.set_yticks(places, [percent(s) for s in sure])
    right.tick_params(length=0)
    right.spines["right"].set_visible(False)
    right.set_ylabel("confidence")
    return ax


def _bars(
    found: Sequence[Candidate], error: float | None, ordinary: Sequence[str]
) -> list[tuple[str, float, float, float]]:
    """Name, error before, error after, confidence; the baseline model is one, and first."""
    known = [c for c in found if is_number(c.error_after)]
    base = [c for c in known if c.effect in ordinary]
    now = error if is_number(error) else max((c.error_after for c in known), default=0.0)
    assert now is not None
    bars = []
    if base:
        sure = max(c.confidence for c in base)
        bars.append(
            (BASELINE_STAGE if len(base) > 1 else base[0].effect, now, base[-1].error_after, sure)
        )
        now = base[-1].error_after
    rest = [c for c in known if c.effect not in ordinary]
    return bars + [(c.effect, now, c.error_after, c.confidence) for c in rest]


def candidates(
    found: Sequence[Candidate], error: float | None, ordinary: Sequence[str] = (), most: int = 10
) -> Picture | None:
    """The candidates as a picture."""
    count = min(most, len(_bars(found, error, ordinary)))
    how = (
        f"The {BASELINE_STAGE} comes first; every other candidate is added to it alone"
        if ordinary
        else "Each candidate is added alone"
    )
    return panels(
        [Cell(lambda ax: draw_candidates(ax, found, error, ordinary, most), 4.4,
              0.75 + 0.27 * count)],
        f"{how}, and all parameters are fitted again. Each line runs from the model error before "
        "to the error after (dot). Dashed line: 1, a second sensor of the same design.",
        "Candidates with the error after a refit and their confidence.",
    )  # fmt: skip
