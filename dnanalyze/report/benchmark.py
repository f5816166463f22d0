"""The outcome of `benchmark` as JSON and as a table."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from dnanalyze.report.plain import document as made
from dnanalyze.report.plain import estimate
from dnanalyze.report.words import celsius, is_number, listing, symbol

if TYPE_CHECKING:
    import pandas as pd


def rows(result: Any) -> list[dict[str, Any]]:
    """One row a criterion, temperature and sensor."""
    return [
        {
            "criterion": r.criterion,
            "title": r.title,
            "unit": r.unit,
            "temperature_c": r.temperature_c,
            "sensor": p.sensor,
            **estimate(p.figure.value, p.figure.se),
            "rank": p.rank,
            "not_distinguishable_from": " ".join(p.alike),
            "note": p.figure.note,
        }
        for r in result.rankings
        for p in r.places
    ]


def table(result: Any) -> pd.DataFrame:
    """The same for CSV."""
    import pandas as pd

    return pd.DataFrame(rows(result))


def document(folders: Sequence[str], result: Any) -> dict[str, Any]:
    """The JSON document."""
    return made(
        "benchmark",
        ", ".join(folders),
        folders=list(folders),
        temperatures_c=result.temperatures,
        sensors=[_sensor(s) for s in result.sensors],
        rankings=[
            {
                "criterion": r.criterion,
                "title": r.title,
                "unit": r.unit,
                "temperature_c": r.temperature_c,
                "better": r.better,
                "places": [
                    {
                        "sensor": p.sensor,
                        "rank": p.rank,
                        "not_distinguishable_from": p.alike,
                        **estimate(p.figure.value, p.figure.se),
                        "note": p.figure.note,
                    }
                    for p in r.places
                ],
            }
            for r in result.rankings
        ],
        notes=result.notes,
    )


def _sensor(sensor: Any) -> dict[str, Any]:
    return {
        "name": sensor.name,
        "folder": sensor.folder,
        "shape": sensor.sensor.shape,
        "pixel_pitch_um": sensor.sensor.pixel_pitch_um,
        "temperatures_c": sensor.temperatures,
        "dn_per_e": {
            **estimate(sensor.dn_per_e.value, sensor.dn_per_e.se),
            "note": sensor.dn_per_e.note,
        },
        "errors": sensor.errors,
        "verdict": sensor.verdict,
        "effects": [
            {
                "effect": e.effect,
                "rms_dn": e.rms_dn,
                "parameters": {
                    k: {"value": v, "unit": unit} for k, (v, unit) in e.parameters.items()
                },
            }
            for e in sensor.effects
        ],
        "filtered": sensor.filtered,
        "filter": sensor.filter_kind,
        "readings": {
            name: [vars(r) for r in readings] for name, readings in sensor.readings.items()
        },
        "notes": sensor.notes,
    }


def fairest(result: Any, name: str, celsius: float | None) -> Any:
    """The ranking in electrons, where it tells two sensors or more; else in DN; None without one.

    DN of different conversion gains compare nothing.
    """
    found = {
        r.criterion: r for r in result.rankings if r.base == name and r.temperature_c == celsius
    }
    electrons = found.get(f"{name}_e")
    if electrons and sum(p.figure.known for p in electrons.places) > 1:
        return electrons
    return found.get(name)


def middle_of(result: Any) -> float | None:
    """The middle one of the common temperatures."""
    return result.temperatures[len(result.temperatures) // 2] if result.temperatures else None


def summary(result: Any) -> list[Any]:
    """One ranking a criterion: at the middle temperature, in the unit that compares most fairly."""
    names = dict.fromkeys(r.base for r in result.rankings)
    middle = middle_of(result)
    found = (fairest(result, n, middle) or fairest(result, n, None) for n in names)
    return [r for r in found if r is not None]


HEADLINE = ("dark_current", "read_noise", "dsnu", "hot_pixels")


def headline(result: Any) -> str:
    """Who leads where, of those that are ranked, and where none does; no overall score."""
    leads: dict[str, list[str]] = {}
    alike: list[str] = []
    middle = middle_of(result)
    for ranking in summary(result):
        known = [p for p in ranking.places if p.rank is not None]
        if ranking.base not in HEADLINE or len(known) < 2:
            continue
        first = [p.sensor for p in known if p.rank == 1]
        told = "" if len(known) == len(result.sensors) else f" of the {len(known)} ranked"
        title = f"{ranking.title} ({symbol(ranking.unit)}){told}"
        if len(first) == 1:
            leads.setdefault(first[0], []).append(title)
        else:
            alike.append(title)
    at = f" at {celsius(middle)}" if is_number(middle) else ""
    if not leads:
        return f"The sensors do not differ significantly in dark current, noise or hot pixels{at}."
    parts = [f"{name} is best in {listing(titles)}" for name, titles in leads.items()]
    parts += [f"the best do not differ significantly in {listing(alike)}"] if alike else []
    return f"Of {len(result.sensors)} sensors{at}, {'; '.join(parts)}."


def groups(ranking: Any) -> list[list[str]]:
    """Sensors that share a rank, since their errors do not tell them apart; best first."""
    ranks = sorted({p.rank for p in ranking.places if p.rank is not None})
    shared = ([p.sensor for p in ranking.places if p.rank == rank] for rank in ranks)
    return [names for names in shared if len(names) > 1]
