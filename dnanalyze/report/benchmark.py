"""The outcome of `benchmark` as JSON and as a table."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from dnanalyze.report.plain import document as made
from dnanalyze.report.words import is_number, listing

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
            "value": p.figure.value,
            "se": p.figure.se,
            "rank": p.rank,
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
                        "value": p.figure.value,
                        "se": p.figure.se,
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
            "value": sensor.dn_per_e.value,
            "se": sensor.dn_per_e.se,
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


def _fairest(result: Any, name: str, celsius: float | None) -> Any:
    """The ranking in electrons, where as many sensors have a place there, else the one in DN."""

    def places(ranking: Any) -> int:
        return sum(p.rank is not None for p in ranking.places)

    found = [
        r
        for r in result.rankings
        if r.criterion in (f"{name}_e", name) and r.temperature_c in (celsius, None)
    ]
    found.sort(key=lambda r: (-places(r), r.criterion == name))
    return found[0] if found else None


def headline(result: Any) -> str:
    """Who leads where, of those that no filter flatters; no overall score."""
    leads: dict[str, list[str]] = {}
    filtered = {s.name for s in result.sensors if s.filtered}  # whose places flatter them
    middle = result.temperatures[len(result.temperatures) // 2] if result.temperatures else None
    for name in ("dark_current", "read_noise", "dsnu", "hot_pixels"):
        ranking = _fairest(result, name, middle)
        if ranking is None:
            continue
        known = [p for p in ranking.places if p.rank is not None and p.sensor not in filtered]
        first = [p.sensor for p in known if p.rank == known[0].rank]
        if len(known) > 1 and len(first) == 1:
            told = "" if len(known) == len(result.sensors) else f" of the {len(known)} that tell it"
            title = f"{ranking.title} ({ranking.unit}){told}"
            leads.setdefault(first[0], []).append(title)
    at = f" at {middle:g} °C" if is_number(middle) else ""
    if not leads:
        return f"No sensor is told apart from the others in dark current, noise or hot pixels{at}."
    parts = [f"{name} leads in {listing(titles)}" for name, titles in leads.items()]
    return f"Of {len(result.sensors)} sensors{at}, {'; '.join(parts)}."
