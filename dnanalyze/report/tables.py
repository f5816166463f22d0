"""The numbers as pandas tables, for CSV files and for whoever goes on in a notebook."""

from __future__ import annotations

from collections.abc import Collection
from functools import cache
from typing import TYPE_CHECKING, Any

from dnanalyze.analyzers.statistics import Scale, StatisticInfo
from dnanalyze.estimate import NORMAL_95
from dnanalyze.report.plain import estimate
from dnanalyze.report.words import is_number, point_label, varied

if TYPE_CHECKING:
    import pandas as pd

POINT = ("temperature_c", "exposure_s", "gain", "channel")


@cache
def _infos() -> dict[str, StatisticInfo]:
    from dnanalyze.analyzers.catalogue import catalogue

    return dict(catalogue())


def info(name: str) -> StatisticInfo:
    """What a statistic is; one that the registry does not know gets its bare name."""
    return _infos().get(name) or StatisticInfo(name, "", "", name.replace("_", " "))


def named(name: str) -> str:
    """A statistic in words, its name behind them; other text as it is."""
    title = info(name).title
    return f"{title} ({name})" if name in _infos() and title else name


def measured_value(scale: Scale, value: Any, repeated: bool = False) -> dict[str, float | None]:
    """A statistic with its errors in its own unit, and its standard error on its scale.

    ``low``, ``high``: interval of 95 %, symmetric on the scale. ``repeated``: whether the column of
    the repeatability is there also where this value has none.
    """
    again = value.repeatability
    low, high = scale.ends(value.value, value.se, NORMAL_95)
    return {
        "value": value.value,
        "se": scale.plain_error(value.value, value.se),
        "low": low,
        "high": high,
        "se_scaled": value.se,
        **(
            {"repeatability": None if again is None else scale.plain_error(value.value, again)}
            if repeated or again is not None
            else {}
        ),
    }


def statistics(measured: Any) -> pd.DataFrame:
    """One row a statistic, operating point and colour plane; with the repeatability if known."""
    values = [v for s in measured.settings for v in s.values.values()]
    known = any(v.repeatability is not None for v in values)
    rows = [
        _point(setting.point)
        | {"plane": setting.plane, "name": name, "family": info(name).family}
        | measured_value(info(name).scale, value, known)
        | {
            "unit": info(name).unit,
            "scale": info(name).scale.value,
        }
        for setting in measured.settings
        for name, value in setting.values.items()
    ]
    return _frame(rows)


def comparison(result: Any) -> pd.DataFrame:
    """The rows behind the error."""
    return _frame([dict(row) for row in result.statistics])


def parameters(result: Any) -> pd.DataFrame:
    """The fitted parameters."""
    return _frame(
        [{"name": p.name} | estimate(p.value, p.se) | {"unit": p.unit} for p in result.parameters]
    )


def candidates(result: Any) -> pd.DataFrame:
    """The candidates of a diagnosis, best first."""
    rows = [
        {
            "effect": c.effect,
            "error_after": c.error_after,
            "explained": c.explained,
            "confidence": c.confidence,
            "confused_with": " ".join(c.confused_with),
        }
        for c in result.candidates
    ]
    return _frame(rows)


def description(result: Any) -> pd.DataFrame:
    """The numbers of a description."""
    return _frame(
        [
            {"name": n.name} | estimate(n.value, n.se) | {"unit": n.unit, "in_model": n.in_model}
            for n in result.numbers
        ]
    )


def laws(
    measured: Any, without: Collection[str] = ()
) -> tuple[list[str], list[tuple[str, list[Any], str]]]:
    """Laws over temperature: columns (each channel, or one), rows (title, values, unit).

    ``without`` names laws that are shown elsewhere.
    """
    from dnanalyze.analyzers.families.trends import channel_trends

    found = channel_trends(measured) or {"value": measured.trends}
    names = dict.fromkeys(n for own in found.values() for n in own if n not in without)
    return list(found), [
        (info(n).title, [own.get(n) for own in found.values()], info(n).unit) for n in names
    ]


def steps(result: Any) -> pd.DataFrame:
    """The error step by step."""
    rows = [
        {
            "step": n,
            "added": s.added,
            "error": s.error,
            "confidence": s.confidence,
            "confused_with": " ".join(s.confused_with),
        }
        for n, s in enumerate(result.steps)
    ]
    return _frame(rows)


def findings(result: Any) -> pd.DataFrame:
    """The tests behind a detection."""
    keys = ("test", "kind", "temperature_c", "p_value", "effect_size", "flagged", "reason")
    return _frame([{k: getattr(f, k) for k in keys} for f in result.findings])


def checks(result: Any) -> pd.DataFrame:
    """The targets with their limits and values."""
    rows = [
        _point(c.point)
        | {
            "name": c.name,
            "kind": c.kind,
            "plane": c.plane,
            "min": c.lower,
            "max": c.upper,
            "value": c.value,
            "measured": c.measured,
            "unit": c.unit,
            "passed": c.passed,
            "enforced": c.enforced,
        }
        for c in result.checks
    ]
    return _frame(rows)


def classifier(result: Any) -> pd.DataFrame:
    """The area under the ROC curve by operating point and kind of picture.

    Rows without an operating point are of all operating points together.
    """
    keys = ("view", "auc", "low", "high", "control")
    every = (*result.cells, *result.together)
    places = [dict.fromkeys(POINT) if c.point is None else _point(c.point) for c in every]
    return _frame(
        [p | {k: getattr(c, k) for k in keys} for p, c in zip(places, every, strict=True)]
    )


def classifier_rows(result: Any) -> list[tuple[str, ...]]:
    """The same as text: operating point, picture, area, interval, control."""
    parts = varied(vars(c.point) for c in result.cells)
    return [
        (
            "all together" if c.point is None else point_label(c.point, parts),
            c.name,
            f"{c.auc:.2f}",
            f"{c.low:.2f} to {c.high:.2f}",
            f"{c.control:.2f}",
        )
        for c in (*result.cells, *result.together)
    ]


def worst(rows: list[Any], family: str | None = None, most: int = 8) -> list[Any]:
    """Rows of a comparison by the size of their discrepancy, each statistic once, worst first."""
    own = [r for r in rows if is_number(r["discrepancy"]) and family in (None, r["family"])]
    own.sort(key=lambda r: -abs(r["discrepancy"]))
    seen: dict[str, Any] = {}
    for row in own:
        seen.setdefault(row["name"], row)
    return list(seen.values())[:most]


def _point(point: Any) -> dict[str, Any]:
    return {key: getattr(point, key) for key in POINT}


def _frame(rows: list[dict[str, Any]]) -> pd.DataFrame:
    import pandas as pd

    return pd.DataFrame(rows)
