"""Where a model fails, in words, worst first."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from typing import Any

import numpy as np

from dnanalyze.analyzers.catalogue import catalogue as infos
from dnanalyze.analyzers.statistics import StatisticInfo

NOTICEABLE = 4.0  # floors


def failures(rows: Sequence[dict[str, Any]], most: int = 12) -> list[str]:
    """One sentence a statistic that is off by more than a few floors.

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
    return float(np.sqrt(np.mean([min(abs(r["discrepancy"]), 1e4) ** 2 for r in group])))


def _kind(name: str) -> str:
    """Statistics that say the same thing share a kind."""
    return name.rstrip("0123456789_.")


def sentence(name: str, group: Sequence[dict[str, Any]]) -> str:
    """What a misfit of one statistic says, with its size and where it holds."""
    info = infos()[name]
    off = [r for r in group if abs(r["discrepancy"]) > NOTICEABLE] or list(group)
    worst = max(off, key=lambda r: abs(r["discrepancy"]))
    said = misfit(info, worst["measured"], worst["simulated"], worst["discrepancy"])
    return f"{said} ({_amount(worst)}) {_where(off, group)}"


def misfit(info: StatisticInfo, measured: float, simulated: float, discrepancy: float) -> str:
    """What a statistic says where it lies above (discrepancy > 0) or below the model, in words.

    Where the sentence wants a ratio to a model that has none of it, the title stands alone.
    """
    words = info.high if discrepancy > 0 else info.low
    if "{ratio}" in words and not (measured > 0 and simulated > 0):
        return info.title
    unit = "" if info.unit in ("", "1") else f" {info.unit}"
    return (
        words.format(
            measured=f"{measured:.3g}{unit}",
            ratio=f"{measured / simulated:.3g}" if simulated else "",
            difference=f"{abs(measured - simulated):.3g}{unit}",
        )
        or info.title
    )


def _amount(row: dict[str, Any]) -> str:
    measured, simulated = row["measured"], row["simulated"]
    unit = f" {row['unit']}" if row["unit"] not in ("", "1") else ""
    text = f"measured {measured:.3g}, model {simulated:.3g}{unit}"
    if row["scale"] == "log" and measured > 0 and simulated > 0:
        power = 10 if "^2" in row["unit"] else 20
        text += f", {power * np.log10(measured / simulated):+.1f} dB"
    return f"{text}; {abs(row['discrepancy']):.0f} floors"


def _where(off: Sequence[dict[str, Any]], group: Sequence[dict[str, Any]]) -> str:
    spots = sorted({_spot(r) for r in off})
    everything = {_spot(r) for r in group}
    if len(everything) == 1:
        return f"at {spots[0][1]}" if spots[0][1] else ""
    if len(spots) == len(everything):
        return "at every operating point"
    if len(spots) == 1:
        return f"at {spots[0][1]} only"
    return "at " + ", ".join(s[1] for s in spots)


def _spot(row: dict[str, Any]) -> tuple[tuple[str, float, float], str]:
    parts = []
    if row["channel"]:
        parts.append(str(row["channel"]))
    if row["temperature_c"] is not None:
        parts.append(f"{row['temperature_c']:g} C")
    if row["exposure_s"] is not None:
        parts.append(f"{row['exposure_s']:g} s")
    order = (row["channel"] or "", row["temperature_c"] or 0.0, row["exposure_s"] or 0.0)
    return order, " ".join(parts)
