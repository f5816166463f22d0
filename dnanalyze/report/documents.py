"""The JSON documents, one function a command; their keys are the product's public face."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from dnanalyze.report import words
from dnanalyze.report.plain import document, estimate

PARAMETER = "name", "value", "se", "unit", "determined", "upper"
Document = dict[str, Any]


def _point(point: Any) -> Document:
    return {key: getattr(point, key) for key in ("temperature_c", "exposure_s", "gain", "channel")}


def inspection(where: str, found: dict[str, Any]) -> Document:
    """What `inspect` found."""
    return document("inspect", where, **found)


def statistics(where: str, measured: Any, quantities: Any = None) -> Document:
    """Every statistic with its standard error; the EMVA 1288 quantities under "emva"."""
    from dnanalyze.analyzers.families.trends import channel_trends, law_doubts
    from dnanalyze.report.tables import info, measured_value

    rows = []
    for setting in measured.settings:
        values = [
            {
                "name": name,
                "family": info(name).family,
                "unit": info(name).unit,
                "scale": info(name).scale,
                **measured_value(info(name).scale, value),
            }
            for name, value in setting.values.items()
        ]
        rows.append(
            _point(setting.point)
            | {
                "plane": setting.plane,
                "frames": setting.frames,
                "shape": setting.shape,
                "statistics": values,
                "missing": setting.missing,
            }
        )
    channels = {name: {"trends": _values(t)} for name, t in channel_trends(measured).items()}
    more: Document = {"channels": channels} if channels else {}
    if quantities is not None:
        more["emva"] = [emva_group(g) for g in quantities.groups]
    trends = _values(measured.trends)
    return document(
        "analyze",
        where,
        sensor=measured.sensor,
        settings=rows,
        trends=trends,
        doubts=law_doubts(measured),
        **more,
    )


def emva_group(group: Any) -> Document:
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
            _point(p.point) | {"frames": p.frames, "quantities": _quantities(p.quantities)}
            for p in group.points
        ],
    }


def _quantities(items: Any) -> list[Document]:
    return [
        _fields(q.kind, "key", "symbol", "name", "unit")
        | _fields(q, "value", "se", "reason", "note")
        for q in items
    ]


def _values(named: Mapping[str, Any]) -> Document:
    return {k: estimate(v.value, v.se) for k, v in named.items()}


def fit(where: str, result: Any, output: Path | None) -> Document:
    """Parameters with their uncertainties, the pairs that the data cannot tell apart, the model."""
    return document(
        "fit",
        where,
        parameters=[_fields(p, *PARAMETER) for p in result.parameters],
        direct=direct(result),
        correlations=result.correlations,
        undetermined=result.undetermined,
        model=output,
        effects=result.model.names,
        fitted=result.model.to_plain(),
    )


def comparison(
    where: str | None, result: Any, command: str = "compare", judged: Any = None
) -> Document:
    """The error, the baselines and every row behind them.

    ``judged``: the classification of the same frames, if any.
    """
    return document(
        command,
        where,
        error=result.error,
        baselines=result.baselines,
        families=result.families,
        failures=result.failures,
        statistics=result.statistics,
        model=result.model,
        **_level(result),
        **_coverage(result),
        **({} if judged is None else {"classifier": classifier(judged)}),
    )


def classification(where: str, result: Any) -> Document:
    """Whether a classifier can tell the simulated frames from the measured ones."""
    return document("classify", where, **classifier(result), model=result.model)


def classifier(result: Any) -> Document:
    """The area under the ROC curve where it tells most, and at every operating point."""
    keys = "view", "auc", "low", "high", "control"
    own = _fields(result, "auc", "low", "high", "control", "tells", "telling", "finished")
    return own | {
        "sentence": result.sentence(),
        "reason": result.reason or None,
        "points": [_point(c.point) | _fields(c, *keys) for c in result.cells],
        "together": [_fields(c, *keys) for c in result.together],
    }


def _level(result: Any) -> Document:
    """The mean dark level where it is farthest off; null where none was measured."""
    level = getattr(result, "level", None)
    if level is None:
        return {"level": None}
    fields = _fields(
        level, "kept", "statistic", "plane", "difference_dn", "relative", "standard_errors"
    )
    return {"level": _point(level.point) | fields}


def _coverage(result: Any) -> Document:
    """What of the captures a verdict rests on; null where the result does not say."""
    seen = getattr(result, "coverage", None)
    if seen is None:
        return {"coverage": None}
    keys = "settings", "all_settings", "frames", "all_frames", "window", "field", "share"
    off = seen.departures
    fields = "kind", "place", "row", "column", "difference_dn", "sigma", "share"
    told = None if off is None else [_point(d.point) | _fields(d, *fields) for d in off]
    return {"coverage": _fields(seen, *keys) | {"departures": told}}


def diagnosis(where: str, result: Any) -> Document:
    """The verdict and the candidates, best first."""
    keys = (
        "effect", "error_after", "explained", "confidence", "confused_with", "evidence", "leaves",
    )  # fmt: skip
    return document(
        "diagnose",
        where,
        error=getattr(result, "error", None),
        verdict=result.verdict,
        headline=words.diagnose_headline(result),
        ordinary=result.ordinary,
        candidates=[_fields(c, *keys) for c in result.candidates],
        unexplained=result.unexplained,
        detection_limits={n: str(v) for n, v in result.detection_limits.items()},
        next_capture=result.next_capture,
        law=getattr(result, "law", "") or None,
        direct=direct(result),
        finished=getattr(result, "finished", True),
        screened=getattr(result, "screened", []),
        **_level(result),
        **_coverage(result),
    )


def description(
    where: str, result: Any, output: Path | None = None, pattern: Any = None
) -> Document:
    """Structure of the residual that no effect of the catalogue explains, in words and numbers.

    ``pattern``: the learned pattern of the sensor, if any.
    """
    effect = result.effect
    return document(
        "describe",
        where,
        verdict=result.verdict,
        headline=words.describe_headline(result),
        description=result.text,
        error_before=result.error_before,
        error_after=result.error_after,
        confidence=result.confidence,
        after=result.after,
        composite=None if effect is None else effect.to_plain(),
        numbers=[_fields(n, "name", "value", "se", "unit", "in_model") for n in result.numbers],
        evidence=result.evidence,
        nearest=[_fields(n, "effect", "error_after", "why") for n in result.nearest],
        removed=result.removed,
        others=result.others,
        next_capture=result.next_capture,
        finished=result.finished,
        effects=result.model.names,
        model=output,
        fitted=result.model.to_plain(),
        **_classified(result),
        **({} if pattern is None else {"pattern": _pattern(pattern)}),
    )


def learned_pattern(where: str, result: Any) -> Document:
    """The pattern of one sensor, and the model with it."""
    return document("pattern", where, **_pattern(result), fitted=result.model.to_plain())


def _pattern(pattern: Any) -> Document:
    """The learned pattern of one sensor, and what it predicts."""
    return {
        "supported": pattern.supported,
        "text": pattern.sentence(),
        "law": pattern.effect.law,
        "ea_ev": pattern.effect.ea_ev if pattern.effect.law == "thermal" else None,
        "rms": pattern.rms,
        "frames_share": pattern.frames_share,
        "points_share": pattern.points_share,
        "error_before": pattern.error_before,
        "error_after": pattern.error_after,
    }


def _classified(result: Any) -> Document:
    """The classifier two-sample test of the model, where it was made."""
    told = getattr(result, "classification", None)
    return {} if told is None else {"classifier": classifier(told)}


def refinement(
    where: str, result: Any, output: Path | None, headline: str | None = None
) -> Document:
    """The error step by step and what the final model holds.

    A refinement that is not finished has verdict "missing", and no errors of its parameters.
    """
    return document(
        "refine",
        where,
        steps=[_step(s) for s in result.steps],
        effects=result.effects,
        verdict=result.verdict,
        headline=headline or words.refine_headline(result),
        unexplained=result.unexplained,
        parameters=parameters(result),
        undetermined=getattr(result, "undetermined", []),
        direct=direct(result),
        finished=getattr(result, "finished", True),
        timed_out=getattr(result, "timed_out", False),
        model=output,
        fitted=result.model.to_plain(),
        **_level(result),
        **_coverage(result),
        **_classified(result),
    )


def direct(result: Any) -> list[Document]:
    """Quantities measured directly, beside the model's."""
    keys = "quantity", "unit", "direct", "error", "model", "sigma", "kept"
    return [
        (_point(a.point) if a.point is not None else {}) | _fields(a, *keys)
        for a in getattr(result, "direct", [])
    ]


def parameters(result: Any) -> list[Document]:
    """The numbers of a model with their standard errors and the effects that they belong to."""
    return [
        {"effect": p.name.split(".")[0].split("[")[0]} | _fields(p, *PARAMETER)
        for p in result.parameters
    ]


def _step(step: Any) -> Document:
    """A step; what was taken out again stands under "removed"."""
    gone = bool(step.added) and step.added.startswith("-")
    made = {"added": None if gone else step.added, "error": step.error}
    return (
        made
        | ({"removed": step.added[1:]} if gone else {})
        | _fields(step, "confidence", "confused_with", "evidence")
    )


def addition(where: str, effect: str, result: Any, output: Path | None) -> Document:
    """The error before and after one effect, and whether the captures support it."""
    return refinement(where, result, output, words.add_headline(result)) | {
        "schema": "dnanalyze/add/1",
        "supported": result.steps[-1].supported,
        "added": effect,
        "error_before": document("add", where, e=result.steps[0].error)["e"],
        "error_after": document("add", where, e=result.steps[-1].error)["e"],
    }


def detection(where: str, result: Any) -> Document:
    """The verdict and every test behind it."""
    return document("detect", where, **result.to_plain())


def simulation(
    made: Any, out: Path, form: str, model: Path, seed: int, like: str | None = None
) -> Document:
    """What was written where."""
    return document(
        "simulate",
        str(out),
        model=model,
        seed=seed,
        like=like,
        format=form,
        shape=made.sensor.shape,
        settings=[_point(s.point) | {"frames": len(s.frames)} for s in made.settings],
    )


def effects(known: Mapping[str, Any]) -> Document:
    """The catalogue."""
    return document("effects", "", effects=[effect(e) for e in known.values()])


def effect(kind: Any) -> Document:
    """One effect of the catalogue."""
    return {
        "name": kind.name,
        "stage": kind.stage.name.lower(),
        "varies": kind.varies,
        "summary": kind.summary,
        "physics": kind.physics,
        "formula": kind.formula,
        "parameters": {
            name: {
                "unit": p.unit,
                "lower": None if p.scale == "choice" else p.lower,
                "upper": None if p.scale == "choice" else p.upper,
                "choices": p.choices,
                "doc": p.doc,
            }
            for name, p in kind.parameters().items()
        },
        "fingerprint": kind.fingerprint,
        "confused_with": kind.confused_with,
        "references": kind.references,
    }


def _fields(item: Any, *keys: str) -> Document:
    """These attributes of an object; what it lacks is left out.

    A value with a standard error has the ends of its interval beside it.
    """
    found = {k: getattr(item, k) for k in keys if hasattr(item, k)}
    if {"value", "se"} <= found.keys():
        found |= estimate(found["value"], found["se"])
    return found
