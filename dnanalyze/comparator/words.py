"""Largest misfits of a model in sentences."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from dnanalyze.analyzers.catalogue import catalogue as infos
from dnanalyze.analyzers.statistics import Scale, StatisticInfo
from dnanalyze.comparator.error import SATURATION
from dnanalyze.digits import minus, number, unit_text
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.significance import NOTICEABLE

RESOLVED_SHARE = 1e-6  # of another number, that the sums behind a statistic hardly resolve
FEWEST = 0.5  # a count below it is none


def failures(rows: Sequence[dict[str, Any]], most: int = 12) -> list[str]:
    """One sentence a statistic that is off by more than a few sigma.

    Parameters
    ----------
    rows : sequence of dict
        Rows of a comparison.
    most : int
        Sentences at most; of statistics that say the same (bands of one spectrum), the worst.
    """
    by_name: dict[str, list[dict[str, Any]]] = defaultdict(list)
    for row in rows:
        by_name[row["name"]].append(row)
    ranked = sorted(by_name.items(), key=lambda item: -_size(item[1]))
    sentences: list[str] = []
    said: set[str] = set()
    for name, group in ranked:
        if _size(group) < NOTICEABLE or len(sentences) >= most:
            break
        if (kind := _kind(name)) not in said:
            said.add(kind)
            sentences.append(sentence(name, group))
    return sentences


def _size(group: Sequence[dict[str, Any]]) -> float:
    return float(np.sqrt(np.mean([min(abs(r["discrepancy"]), SATURATION) ** 2 for r in group])))


def _kind(name: str) -> str:
    """Statistics that say the same thing share a kind."""
    return name.rstrip("0123456789_.")


def sentence(name: str, group: Sequence[dict[str, Any]]) -> str:
    """What a misfit of one statistic says, with its size and where it holds."""
    info = infos()[name]
    worst = max(group, key=lambda r: abs(r["discrepancy"]))
    way = np.sign(worst["discrepancy"])  # what lies on the other side is not what is said
    off = [r for r in group if way * r["discrepancy"] > NOTICEABLE] or [worst]
    pair = worst["measured"], worst["simulated"]
    said = misfit(info, *pair, worst["discrepancy"], worst.get("floor", 0.0))
    size = f"{number(abs(worst['discrepancy']), 2)} sigma"
    if not side_by_side(info, *pair, worst.get("floor", 0.0)):
        size = f"{_amount(worst)}; {size}"
    return f"{said} ({size}) {_where(off, group)}".rstrip()


def misfit(
    info: StatisticInfo,
    measured: float,
    simulated: float,
    discrepancy: float,
    floor: float = 0.0,
) -> str:
    """What a statistic says where it lies above (discrepancy > 0) or below the model, in words.

    Where the sentence wants a ratio, and the model's number is zero within its error, it gives both
    numbers instead.

    Parameters
    ----------
    info : StatisticInfo
    measured, simulated : float
        Plain units.
    discrepancy : float
        Sigma.
    floor : float
        Error of the difference, on the scale of the statistic.
    """
    if side_by_side(info, measured, simulated, floor):
        there, model = (_or_none(info, *v) for v in ((measured, simulated), (simulated, measured)))
        return f"{info.title}: {there} measured, {model} in the model"
    if not np.isfinite(simulated):
        return f"{info.title}: not determined in the frames of the model"
    words, unit = info.high if discrepancy > 0 else info.low, unit_text(info.unit)
    there, apart = (f"{number(x)}{unit}" for x in (measured, abs(measured - simulated)))
    ratio = number(measured / simulated) if simulated else ""
    return words.format(measured=there, ratio=ratio, difference=apart) or info.title


def side_by_side(info: StatisticInfo, measured: float, simulated: float, floor: float) -> bool:
    """Whether a statistic told by a ratio has none here: the model's number may be zero."""
    if "{ratio}" not in info.high + info.low:
        return False
    if measured <= 0 or simulated <= RESOLVED_SHARE * measured:
        return True
    if info.scale is Scale.LOG:  # its error is a share of it
        return False
    return info.scale.coordinate(simulated) - info.scale.coordinate(0.0) < floor


def _or_none(info: StatisticInfo, value: float, other: float) -> str:
    """A number with its unit, or that there is none."""
    if value <= max(RESOLVED_SHARE * abs(other), FEWEST if info.scale is Scale.ROOT else 0.0):
        return "none"
    text = number(value)
    unit = unit_text(info.unit)
    return text + (unit.removesuffix("s") if text == "1" and info.scale is Scale.ROOT else unit)


def _amount(row: dict[str, Any]) -> str:
    measured, simulated = row["measured"], row["simulated"]
    unit = unit_text(row["unit"])
    text = f"measured {number(measured)}, model {number(simulated)}{unit}"
    if row["unit"] == "DN^2" and measured > 0 and simulated > 0:  # a power
        text += minus(f", {10 * np.log10(measured / simulated):+.1f} dB")
    return text


def _where(off: Sequence[dict[str, Any]], group: Sequence[dict[str, Any]]) -> str:
    points = sorted({_point(r) for r in group}, key=OperatingPoint.sort_key)
    here = {_point(r) for r in off}
    if len(points) == 1:
        return f"at {points[0].label()}" if points[0] != OperatingPoint() else ""
    if len(here) == len(points):
        return "at every operating point"
    named = [text for p, text in zip(points, short_labels(points), strict=True) if p in here]
    return "at " + listed(named) + (" only" if len(named) == 1 else "")


def _point(row: dict[str, Any]) -> OperatingPoint:
    return OperatingPoint(row["temperature_c"], row["exposure_s"], row.get("gain"), row["channel"])


def short_labels(points: Sequence[OperatingPoint]) -> list[str]:
    """Operating points in a few words: only what differs between them."""
    known = vars(OperatingPoint())
    same = {k: None for k in known if len({getattr(p, k) for p in points}) == 1}
    return [replace(p, **same).label() if len(points) > 1 else p.label() for p in points]


def listed(labels: Sequence[str]) -> str:
    """Labels in a row; those with commas of their own are set apart by semicolons."""
    return ("; " if any("," in text for text in labels) else ", ").join(labels)
