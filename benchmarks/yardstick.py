"""Whether the stated errors of the statistics are those that repeated captures and sensors show.

    python benchmarks/yardstick.py                          every design, as a Markdown table
    python benchmarks/yardstick.py --design four_edge_glow --worst 20
    python benchmarks/yardstick.py --json yardstick.json

The virtual sensor, which shares no code with the model, makes 40 sensors of one design and 40
captures of one sensor, for each design: ordinary and with each structure that real fields have.
The standard deviation of a statistic over the 40 is divided by its stated one (root mean square):
the ratio of sensors by the standard error, that of captures by the repeatability. A ratio is
calibrated within .8 and 1.25, widened by two standard errors of a deviation of 40 values.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from dnanalyze.analyzers.analyze import analyze
from dnanalyze.analyzers.catalogue import catalogue
from dnanalyze.analyzers.repeatability import repeatability
from dnanalyze.analyzers.statistics import Scale, Statistics
from dnanalyze.demo import VirtualSensor, generate
from dnanalyze.demo.hidden import Scene
from dnanalyze.loaders.captures import CaptureSet, Frame, Setting, Window

LOW, HIGH = 0.8, 1.25  # ratios that count as calibrated
FEWEST = 4.0  # mean of a count below which its root has no stable error (Anscombe 1948)
SHAPE = (256, 256)
CELSIUS = (45.0, 75.0, 105.0)
FRAMES = 6
EDGE_DN, EDGE_PX = 18.0, 30.0  # four edges: amplitude at the edge, and length
CLOUD_DN = 3.0  # smooth shading: standard deviation over the field
CLOUD_PX = 60.0  # and its length
MOVED = 1.10  # of an amplitude, for the test that it is found


@dataclass(frozen=True)
class Design:
    """Effects of the virtual sensor, and a fixed offset of the field, DN."""

    effects: dict[str, Any]
    offset: str = ""


DESIGNS = {
    "ordinary": Design({}),
    "glow": Design({"amp_glow": "strong"}),
    "four_edge_glow": Design({}, "edges"),
    "dark_gradient": Design({"dark_gradient": "strong"}),
    "offset_gradient": Design({}, "plane"),
    "smooth_shading": Design({}, "cloud"),
    "flicker_fpn": Design({"flicker_fpn": "middling"}),
    "column_taps": Design({"column_taps": "middling"}),
    "column_fpn": Design({"column_fpn": "middling"}),
    "row_fpn": Design({"row_fpn": "middling"}),
    "periodic_pattern": Design({"periodic_pattern": "middling"}),
    "hot_pixels": Design({"hot_pixels": "middling"}),
    "hot_clusters": Design({"hot_clusters": "middling"}),
}


def surface(kind: str, shape: tuple[int, int]) -> np.ndarray:
    """The fixed offset of a design, DN: of the design, not of one sensor."""
    scene = Scene(VirtualSensor(), shape)
    rows, columns = scene.row, scene.column
    if kind == "edges":
        ends = (rows, shape[0] - 1 - rows, columns, shape[1] - 1 - columns)
        return EDGE_DN * sum(np.exp(-d / EDGE_PX) for d in ends)
    if kind == "plane":
        return 10.0 * (rows / shape[0] + 0.5 * columns / shape[1])
    y, x = rows / CLOUD_PX, columns / CLOUD_PX
    return CLOUD_DN * (np.sin(1.3 * y + 0.4) * np.cos(0.9 * x) + np.cos(y - 1.7 * x + 1.0))


def captured(design: Design, seed: int, capture: int, scale: float = 1.0) -> CaptureSet:
    """One capture of one sensor; ``scale`` multiplies the fixed offset."""
    first = capture * len(CELSIUS)
    made = generate(
        VirtualSensor(), design.effects, SHAPE, CELSIUS, frames=FRAMES, seed=seed, first=first
    )
    if not design.offset:
        return made
    added = scale * surface(design.offset, SHAPE)
    settings = tuple(
        Setting(s.point, tuple(_shifted(f, added, seed) for f in s.frames)) for s in made.settings
    )
    return CaptureSet(made.name, made.sensor, settings)


def _shifted(frame: Frame, added: np.ndarray, seed: int) -> Frame:
    """The frame on an offset; rounded at random, so that the codes hold its fraction."""
    codes = frame.read(None)
    luck = np.random.default_rng([seed, *frame.name.encode()]).random(codes.shape)
    moved = np.floor(codes + added + luck).astype(np.uint16)

    def load(window: Window | None) -> np.ndarray:
        return moved.copy() if window is None else np.ascontiguousarray(moved[window.slices])

    return Frame(frame.name, frame.point, load)


Row = dict[tuple[float, str], tuple[float, float]]


def row(found: Statistics) -> Row:
    """Coordinates and stated errors, by temperature and statistic."""
    infos = catalogue()
    return {
        (s.point.temperature_c, name): (infos[name].scale.coordinate(v.value), v.se)
        for s in found.settings
        for name, v in s.values.items()
        if name in infos and infos[name].compared
    }


def one(task: tuple[str, int, int]) -> tuple[Row, Row]:
    """Stated by the standard error, and by the repeatability."""
    name, seed, capture = task
    captures = captured(DESIGNS[name], seed, capture)
    found = analyze(captures, workers=1)
    again = repeatability(captures, found, workers=1) if seed == 0 else found
    return row(found), row(again)


def ratios(rows: list[Row]) -> dict[tuple[float, str], float]:
    """Standard deviation over the stated one, by temperature and statistic."""
    infos, out = catalogue(), {}
    for key in rows[0]:
        pairs = np.array([r[key] for r in rows if key in r])
        counts = infos[key[1]].scale is Scale.ROOT
        if counts and np.mean([Scale.ROOT.plain(c) for c, _ in pairs]) < FEWEST:
            continue
        if len(pairs) == len(rows) and np.isfinite(pairs).all():
            stated = float(np.sqrt(np.mean(pairs[:, 1] ** 2)))
            out[key] = float(pairs[:, 0].std(ddof=1)) / max(stated, 1e-30)
    return out


def measured(pool: ProcessPoolExecutor, name: str, count: int) -> dict[str, Any]:
    """Ratios of sensors and of captures of one design."""
    sensors = list(pool.map(one, [(name, seed, 0) for seed in range(1, count + 1)]))
    captures = list(pool.map(one, [(name, 0, n) for n in range(count)]))
    return {
        "sensors": ratios([r[0] for r in sensors]),
        "captures": ratios([r[1] for r in captures]),
    }


def calibrated(values: np.ndarray, count: int) -> float:
    """Share of the ratios within the limits and their sampling error."""
    wide = 1.0 + 2.0 / np.sqrt(2.0 * (count - 1))
    return float(np.mean((values > LOW / wide) & (values < HIGH * wide)))


def lines(name: str, found: dict[str, Any], count: int, worst: int) -> Iterator[str]:
    cells = []
    for kind in ("sensors", "captures"):
        values = np.array(list(found[kind].values()))
        cells.append(f"{100 * calibrated(values, count):.0f} % of {values.size}")
        cells.append(f"{np.median(values):.2f}")
    yield f"| {name} | " + " | ".join(cells) + " |"
    for kind in ("sensors", "captures"):
        ranked = sorted(found[kind].items(), key=lambda kv: -abs(np.log(max(kv[1], 1e-9))))
        for (celsius, statistic), value in ranked[:worst]:
            yield f"    {kind}: {statistic} at {celsius:g} C {value:.2f}"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--design", action="append", choices=list(DESIGNS))
    parser.add_argument("--count", type=int, default=40)
    parser.add_argument("--worst", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--json", type=Path)
    asked = parser.parse_args()
    out = {}
    print("| design | sensors calibrated | median | captures calibrated | median |")
    print("|---|---|---|---|---|")
    with ProcessPoolExecutor(asked.jobs) as pool:
        for name in asked.design or DESIGNS:
            found = measured(pool, name, asked.count)
            for line in lines(name, found, asked.count, asked.worst):
                print(line, flush=True)
            out[name] = {k: {f"{c:g} {n}": v for (c, n), v in found[k].items()} for k in found}
    if asked.json:
        asked.json.write_text(json.dumps(out, indent=1))
    return 0


if __name__ == "__main__":
    sys.exit(main())
