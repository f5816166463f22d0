"""Parts that the JSON documents of several results share; keys are the product's public face."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from dnanalyze.report.plain import estimate

if TYPE_CHECKING:
    from dnanalyze.comparator.compare import Comparison
    from dnanalyze.diagnosis.results import Diagnosis, Refinement
    from dnanalyze.emva.quantity import Group, Quantities
    from dnanalyze.fitting.fit import Fit
    from dnanalyze.loaders.captures import OperatingPoint


PARAMETER = "name", "value", "se", "unit", "determined", "upper"
Document = dict[str, Any]


def point(point: OperatingPoint) -> Document:
    """An operating point."""
    return {key: getattr(point, key) for key in ("temperature_c", "exposure_s", "gain", "channel")}


def emva_group(group: Group) -> Document:
    """The EMVA 1288 quantities of one gain, channel and colour plane."""
    return {
        "gain": group.gain,
        "channel": group.channel,
        "plane": group.plane,
        "quantities": _quantities(group.quantities),
        "dark_currents": [
            {
                "temperature_c": c.temperature_c,
                "exposures_s": c.exposures_s,
                "quantities": _quantities(c.quantities),
            }
            for c in group.dark_currents
        ],
        "operating_points": [
            point(p.point) | {"frames": p.frames, "quantities": _quantities(p.quantities)}
            for p in group.points
        ],
    }


def _quantities(items: Quantities) -> list[Document]:
    return [
        fields_of(q.kind, "key", "symbol", "name", "unit")
        | fields_of(q, "value", "se", "reason", "note")
        for q in items
    ]


def level(result: Comparison | Diagnosis | Refinement) -> Document:
    """The mean dark level where it is farthest off; null where none was measured."""
    found = result.level
    if found is None:
        return {"level": None}
    fields = fields_of(
        found, "kept", "statistic", "plane", "difference_dn", "relative", "standard_errors"
    )
    return {"level": point(found.point) | fields}


def coverage(result: Comparison | Diagnosis | Refinement) -> Document:
    """What of the captures a verdict rests on; null where the result does not say."""
    seen = result.coverage
    if seen is None:
        return {"coverage": None}
    keys = "settings", "all_settings", "frames", "all_frames", "window", "field", "share", "pooled"
    off = seen.departures
    fields = "kind", "place", "row", "column", "difference_dn", "sigma", "share"
    told = None if off is None else [point(d.point) | fields_of(d, *fields) for d in off]
    return {"coverage": fields_of(seen, *keys) | {"departures": told}}


def direct(result: Fit | Diagnosis | Refinement) -> list[Document]:
    """Quantities measured directly, beside the model's."""
    keys = "quantity", "unit", "direct", "error", "model", "sigma", "kept"
    return [
        (point(a.point) if a.point is not None else {}) | fields_of(a, *keys) for a in result.direct
    ]


def fields_of(item: Any, *keys: str) -> Document:
    """These attributes of an object.

    A value with a standard error has the ends of its interval beside it.
    """
    found = {k: getattr(item, k) for k in keys}
    if {"value", "se"} <= found.keys():
        found |= estimate(found["value"], found["se"])
    return found
