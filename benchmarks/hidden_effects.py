"""Does the diagnosis name what is hidden? Virtual sensors at random, every effect, three levels.

    python benchmarks/hidden_effects.py --sensors 3 --json out.jsonl
    python benchmarks/hidden_effects.py --effects column_fpn,denoise:nlm,ordinary --levels weak
    python benchmarks/hidden_effects.py --effects dpc:median+hot_pixels,rts --pairs 20
    python benchmarks/hidden_effects.py --list

The frames come from `dnanalyze.demo`, which shares no code with the model. Each case runs in a
process of its own under a time limit. With --json a line is appended as each case ends, and a
second run does only what is not there yet. The tables are Markdown.
"""

from __future__ import annotations

import argparse
import importlib
import json
import multiprocessing as mp
import os
import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Any

import numpy as np
from hidden_scores import ORDINARY, TOGETHER, called, report, right, table

from dnanalyze.demo import CATALOGUED, EFFECTS, LEVELS, draw_sensor, generate, resolve

# What every virtual sensor has, and the paper's own model: never a false addition.
EXPECTED = {"convolved_lognormal", "dark_shot_noise", "read_noise", "pixel_fpn", "quantization"}
QUICK = (
    "column_fpn,row_noise,hot_pixels,amp_glow,periodic_pattern,digital_gain,"
    "concentric_rings,ordinary"
)
KIND = {"denoise": "kind", "dpc": "mode"}


@dataclass(frozen=True)
class Case:
    """One folder to diagnose; ``effect`` may be "ordinary", carry a kind ("dpc:clamp"), be two."""

    effect: str
    level: str
    sensor: int
    seed: int
    shape: tuple[int, int] = (384, 384)
    frames: int = 6

    @property
    def key(self) -> str:
        rows, columns = self.shape
        return (
            f"{self.effect}/{self.level}/sensor{self.sensor}/seed{self.seed}"
            f"/{rows}x{columns}x{self.frames}"
        )

    @property
    def name(self) -> str:
        return TOGETHER.join(name for name, _ in parts(self.effect))

    @property
    def hidden(self) -> dict[str, dict[str, Any]]:
        return {
            name: {"level": self.level} | ({KIND[name]: kind} if kind else {})
            for name, kind in parts(self.effect)
            if name != ORDINARY
        }

    def made(self) -> tuple[Any, dict[str, Any]]:
        """The captures and the truth; levels of an effect share their sensors."""
        label = [self.seed, self.sensor, *self.effect.encode()]
        sensor = draw_sensor(np.random.default_rng(label))
        seed = int(np.random.default_rng([*label, 1]).integers(1 << 31))
        captures = generate(sensor, self.hidden, self.shape, frames=self.frames, seed=seed)
        return captures, {"sensor": asdict(sensor), "hidden": resolve(sensor, self.hidden, seed)}


def parts(effect: str) -> list[tuple[str, str]]:
    """Names and kinds ("": none given) of what a case hides together."""
    return [(p.partition(":")[0], p.partition(":")[2]) for p in effect.split(TOGETHER)]


def pairs(count: int, seed: int) -> list[str]:
    """Two different effects of the catalogue each, drawn at random; what repeats counts once."""
    rng = np.random.default_rng([seed, count])
    drawn = (TOGETHER.join(rng.choice(CATALOGUED, 2, replace=False)) for _ in range(count))
    return list(dict.fromkeys(drawn))


def cases(
    effects: Sequence[str], levels: Sequence[str], sensors: int, ordinary: int, **more: Any
) -> list[Case]:
    """Sensor by sensor, so that an unfinished run has seen every effect."""
    chosen = []
    for n in range(max(sensors, ordinary)):
        for effect in effects:
            if effect == ORDINARY:
                chosen += [Case(ORDINARY, "none", n, **more)] if n < ordinary else []
            elif n < sensors:
                chosen += [Case(effect, level, n, **more) for level in levels]
    return chosen


def outcome(result: Any) -> dict[str, Any]:
    """What is scored of a refinement: the one place that knows its form.

    ``result`` has ``effects`` and ``verdict`` of the final model, and ``steps`` with ``added``
    (None: the start; "-name": taken out), ``error`` and ``confidence``.
    """
    steps = [s for s in result.steps if s.added and not s.added.startswith("-")]
    added = [s for s in steps if s.added not in EXPECTED]
    kept = [e for e in result.effects if e not in EXPECTED]
    return {
        "verdict": result.verdict,
        "named": kept,
        "first": next((s.added for s in added if s.added in kept), None),
        "steps": [[s.added, s.error, s.confidence] for s in result.steps],
        "error_before": result.steps[0].error,
        "error_after": result.steps[-1].error,
        "additions": [[s.added, s.confidence] for s in added],
    }


def run_case(case: Case, using: Callable[[Any], Any]) -> dict[str, Any]:
    """Make the captures, refine, and return a row for the tables."""
    captures, told = case.made()
    begun = time.perf_counter()
    row = outcome(using(captures))
    seconds = time.perf_counter() - begun
    return (
        {"key": case.key, "effect": case.name, "level": case.level, "seconds": seconds} | told | row
    )


def callable_of(name: str) -> Callable[[Any], Any]:
    """``module:function``."""
    module, _, function = name.partition(":")
    return getattr(importlib.import_module(module), function)


def _child(case: Case, using: str, pipe: Connection) -> None:
    try:
        pipe.send(run_case(case, callable_of(using)))
    except Exception:  # a case that breaks is a result too
        pipe.send(_failed(case, traceback.format_exc(limit=-3)))


def _failed(case: Case, why: str) -> dict[str, Any]:
    return {"key": case.key, "effect": case.name, "level": case.level, "failed": why}


def run_all(todo: Sequence[Case], using: str, workers: int, limit_s: float) -> Iterator[dict]:
    """Rows as they come; a process a case, ended when its time is up."""
    context, waiting, running = mp.get_context("spawn"), list(todo), {}
    while waiting or running:
        while waiting and len(running) < workers:
            case = waiting.pop(0)
            ours, theirs = context.Pipe(duplex=False)
            process = context.Process(target=_child, args=(case, using, theirs), daemon=True)
            process.start()
            theirs.close()
            running[ours] = (case, process, time.monotonic() + limit_s)
        soonest = min(deadline for _, _, deadline in running.values())
        ready = wait(list(running), timeout=max(0.0, soonest - time.monotonic()))
        late = [p for p, (_, _, deadline) in running.items() if deadline <= time.monotonic()]
        for pipe in {*ready, *late}:
            case, process, _ = running.pop(pipe)
            try:
                row = pipe.recv() if pipe in ready else _failed(case, f"over {limit_s:g} s")
            except EOFError:
                row = _failed(case, "the process died")
            if pipe not in ready:
                process.terminate()
            process.join()
            pipe.close()
            yield row


def amounts() -> str:
    """What the levels mean."""
    body = [[e.name, *(f"{a:g}" for a in e.amounts), e.unit] for e in EFFECTS.values()]
    return table(["effect", *LEVELS, "unit"], body)


def _stored(path: Path | None) -> dict[str, dict[str, Any]]:
    """Rows of an earlier run; a line cut short by its end is dropped."""
    rows = {}
    if path is not None and path.exists():
        for line in path.read_text(encoding="utf-8").splitlines():
            try:
                row = json.loads(line)
            except json.JSONDecodeError:
                continue
            rows[row["key"]] = row
    return rows


def _store(path: Path | None, row: dict[str, Any]) -> None:
    """Append a row; the line break stands first, so that a line cut short spoils no other."""
    if path is not None:
        with path.open("a", encoding="utf-8") as stream:
            stream.write("\n" + json.dumps(row, default=float))


def _arguments(words: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--quick", action="store_true", help="a few effects, middling, 256x256")
    parser.add_argument(
        "--effects", help="names, 'denoise:KIND', 'dpc:MODE', 'ONE+OTHER', 'ordinary'; all"
    )
    parser.add_argument("--pairs", type=int, default=0, help="two at once, drawn at random (0)")
    parser.add_argument("--levels", help="weak,middling,strong")
    parser.add_argument("--sensors", type=int, help="sensors for each effect and level (2)")
    parser.add_argument("--ordinary", type=int, help="ordinary sensors (10 times --sensors)")
    parser.add_argument("--size", type=int, help="rows and columns (384)")
    parser.add_argument("--frames", type=int, default=6)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument(
        "--using", default="dnanalyze.diagnosis.refine:refine", help="MODULE:FUNCTION"
    )
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--limit", type=float, default=600.0, help="seconds a case may take")
    parser.add_argument("--json", type=Path, help="file of one JSON line a case; resumes")
    parser.add_argument("--retry", action="store_true", help="run again what failed")
    parser.add_argument("--list", action="store_true", help="what the levels mean, and stop")
    given = parser.parse_args(words)
    quick = given.quick
    given.effects = (given.effects or (QUICK if quick else ",".join([*EFFECTS, ORDINARY]))).split(
        ","
    )
    for name, kind in (part for effect in given.effects for part in parts(effect)):
        if name not in (*EFFECTS, ORDINARY) or (kind and name not in KIND):
            parser.error(f"--effects {name}: valid names are {', '.join([*EFFECTS, ORDINARY])}")
    given.effects += pairs(given.pairs, given.seed)
    given.levels = (given.levels or ("middling" if quick else ",".join(LEVELS))).split(",")
    if set(given.levels) - set(LEVELS):
        parser.error(f"--levels: valid levels are {', '.join(LEVELS)}")
    given.sensors = given.sensors or (1 if quick else 2)
    given.ordinary = given.ordinary or (2 if quick else 10 * given.sensors)
    given.size = given.size or (256 if quick else 384)
    return given


def main(words: Sequence[str] | None = None) -> None:
    """Run what is not done yet and print the tables."""
    a = _arguments(words)
    if a.list:
        print(amounts())
        return
    os.environ.setdefault("NUMBA_NUM_THREADS", str(max(1, (os.cpu_count() or 1) // a.workers)))
    wanted = cases(
        a.effects, a.levels, a.sensors, a.ordinary,
        seed=a.seed, shape=(a.size, a.size), frames=a.frames,
    )  # fmt: skip
    stored = _stored(a.json)
    todo = [c for c in wanted if c.key not in stored or (a.retry and stored[c.key].get("failed"))]
    for count, row in enumerate(run_all(todo, a.using, a.workers, a.limit), 1):
        stored[row["key"]] = row
        _store(a.json, row)
        sign = "ok " if right(row) else "-- "
        print(f"{count}/{len(todo)} {sign}{row['key']}: {called(row)}", flush=True)
    print("\n" + report([stored[c.key] for c in wanted]))


if __name__ == "__main__":
    main()
