"""How often an effect is named at its stated detection limit, and at twice that.

    python benchmarks/detection_limits.py --sensors 2 --json limits.jsonl
    python benchmarks/detection_limits.py --effects row_noise,crosstalk --sensors 10

A virtual sensor without a missing effect is diagnosed. Its fitted model, with one effect at the
stated limit times 1 and 2, is then the truth: it is simulated with another seed, and diagnosed from
the Wang 2025 model. An effect counts as found where it is the first of the candidates beyond the
baseline, and the verdict is not "adequate".
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from third_party.score import wilson

import dnanalyze
from dnanalyze.demo import draw_sensor, generate
from dnanalyze.model.registry import built_in

SHAPE, FRAMES = (256, 256), 8
TIMES = (1.0, 2.0)


def limits_of(found: dnanalyze.Diagnosis, wanted: list[str]) -> Iterator[tuple[str, str, float]]:
    """Effect, parameter and strength of each stated limit."""
    for name, limit in found.detection_limits.items():
        if np.isfinite(limit.value) and (not wanted or name in wanted):
            yield name, limit.parameter, limit.value


def case(captures: Any, model: Any, name: str, parameter: str, strength: float) -> dict[str, Any]:
    """Whether an effect of a strength is found in a simulation of the model with it."""
    kind = built_in()[name]
    strength = min(strength, kind.parameters()[parameter].upper)
    effect = replace(kind(), **{parameter: strength})
    truth = replace(model.with_effect(effect), seed=model.seed + 1000)
    points = [(s.point, len(s.frames)) for s in captures.settings]
    found = dnanalyze.diagnose(dnanalyze.simulate(truth, captures.sensor.shape, points))
    beyond = [c for c in found.candidates if c.effect not in found.ordinary]
    first = beyond[0] if beyond and found.verdict != "adequate" else None
    return {
        "strength": strength,
        "first": first.effect if first else None,
        "confidence": first.confidence if first else None,
        "found": first is not None and first.effect == name,
    }


def table(rows: list[dict[str, Any]]) -> str:
    """Markdown: share found at each multiple, and the effects that were not."""
    lines = [
        "| times the limit | found | 95 % | named otherwise | not found |",
        "|---|---|---|---|---|",
    ]
    for times in TIMES:
        here = [r for r in rows if r["times"] == times]
        if not here:
            continue
        count = sum(r["found"] for r in here)
        low, high = wilson(count, len(here))
        other = sorted(
            f"{r['effect']} ({r['first']})" for r in here if r["first"] and not r["found"]
        )
        none = sorted({r["effect"] for r in here if not r["first"]})
        lines.append(
            f"| {times:g} | {count} of {len(here)} | {low:.0%} to {high:.0%} "
            f"| {', '.join(other)} | {', '.join(none)} |"
        )
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--sensors", type=int, default=2)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--effects", default="", help="names, with commas; all by default")
    parser.add_argument("--json", type=Path, help="one line a case")
    given = parser.parse_args()
    wanted = [name for name in given.effects.split(",") if name]
    rows: list[dict[str, Any]] = []
    for number in range(given.seed, given.seed + given.sensors):
        sensor = draw_sensor(np.random.default_rng(number))
        captures = generate(sensor, {}, SHAPE, frames=FRAMES, seed=number)
        plain = dnanalyze.diagnose(captures)
        for name, parameter, limit in limits_of(plain, wanted):
            for times in TIMES:
                row = {"effect": name, "sensor": number, "times": times, "limit": limit}
                row |= case(captures, plain.model, name, parameter, times * limit)
                rows.append(row)
                print(json.dumps(row), flush=True)
                if given.json:
                    with given.json.open("a", encoding="utf-8") as stream:
                        stream.write(json.dumps(row) + "\n")
    print(table(rows))


if __name__ == "__main__":
    main()
