"""ROC of `detect` over random virtual sensors: by filter, strength, frames and temperatures.

    python benchmarks/detection_roc.py --sensors 10 --size 320 [--mosaic]
    python benchmarks/detection_roc.py --sensors 0 --false-alarms 600 --size 512

Score of a capture set: the largest effect size over its limit, among findings that are significant
at 1e-6. AUC: chance that a filtered set of a sensor scores above an unfiltered set of another.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter, defaultdict
from dataclasses import replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "detection"))

import hidden_filters as hidden
from unfiltered import KINDS, series
from virtual_sensor import BAYER, Traits, VirtualSensor, captures, random_traits

from dnanalyze.detection import Detection, detect

DESIGNS = {
    "1 frame": ((45.0,), 1),
    "8 frames": ((45.0,), 8),
    "5 T x 1": ((25.0, 45.0, 65.0, 85.0, 105.0), 1),
    "5 T x 8": ((25.0, 45.0, 65.0, 85.0, 105.0), 8),
}
LADDERS = {
    "dynamic DPC": ("dpc", {"8 sigma": hidden.dynamic_dpc(8), "4 sigma": hidden.dynamic_dpc(4)}),
    "DPC from median": ("dpc", {"4 sigma": hidden.dynamic_dpc_median(4)}),
    "clamp": ("dpc", {"24": hidden.clamp(hidden.RING24), "8": hidden.clamp()}),
    "static DPC": ("dpc", {"100 ppm": hidden.static_dpc(100), "500 ppm": hidden.static_dpc(500)}),
    "median 3x3": ("denoise", {"1/4": hidden.median(0.25), "1/2": hidden.median(0.5)}),
    "bilateral": ("denoise", {"1/4": hidden.bilateral(0.25), "1/2": hidden.bilateral(0.5)}),
    "NLM": ("denoise", {"h .8 sigma": hidden.nlm(0.8)}),
    "wavelet": ("denoise", {".5 sigma": hidden.wavelet(0.5), "1 sigma": hidden.wavelet(1.0)}),
    "Gaussian .5": ("denoise", {"1/4": hidden.gaussian(share=0.25), "1/2": hidden.gaussian()}),
    "recursive": (
        "temporal_denoise",
        {"10 %": hidden.recursive(0.1), "20 %": hidden.recursive(0.2)},
    ),
}


def fine(traits: Traits, seed: int) -> Traits:
    """The sensor read out finely enough (noise 1.2 to 10 DN) that rounding hides no filter."""
    noise = np.exp(np.random.default_rng([seed, 9]).uniform(np.log(1.2), np.log(10.0)))
    return replace(traits, gain=float(noise) / traits.read, comb=1.0, white=65535.0)


def score(detection: Detection) -> float:
    """Largest effect over its limit."""
    return max(
        (f.effect_size / f.limit for f in detection.findings if f.p_value < 1e-6), default=0.0
    )


def auc(filtered: list[float], clean: list[float]) -> float:
    """Mann-Whitney."""
    a, b = np.array(filtered)[:, None], np.array(clean)[None]
    return float(((a > b) + 0.5 * (a == b)).mean())


def power(sensors: int, size: int, mosaic: bool) -> None:
    """Print the table over ``sensors`` seeds; the state of progress goes to stderr."""
    names = [(n, s) for n, (_, ladder) in LADDERS.items() for s in ladder]
    hits: dict[tuple, list[bool]] = defaultdict(list)
    named: dict[tuple, list[bool]] = defaultdict(list)
    scores: dict[tuple, list[float]] = defaultdict(list)
    for seed in range(sensors):
        sensor = VirtualSensor(
            fine(random_traits(np.random.default_rng(seed)), seed), (size, size), seed
        )
        for design, (temperatures, frames) in DESIGNS.items():
            print(f"sensor {seed}, {design}", file=sys.stderr, flush=True)
            clean = detect(captures(sensor, temperatures, frames, None, BAYER if mosaic else None))
            scores[design, "none"].append(score(clean))
            for name, strength in names:
                if frames == 1 and name == "recursive":
                    continue
                kind, ladder = LADDERS[name]
                run = hidden.in_planes(ladder[strength]) if mosaic else ladder[strength]
                seen = detect(
                    captures(sensor, temperatures, frames, run, BAYER if mosaic else None)
                )
                key = (design, name, strength)
                hits[key].append(seen.filtered)
                named[key].append(seen.kind == kind)
                scores[key].append(score(seen))
    print(f"{sensors} sensors, {size}x{size}, {'Bayer mosaic' if mosaic else 'monochrome'}")
    print("found % / right kind % / AUC")
    print("| filter | strength | " + " | ".join(DESIGNS) + " |")
    print("|---|---|" + "---|" * len(DESIGNS))
    for name, strength in names:
        cells = []
        for design in DESIGNS:
            key = (design, name, strength)
            cells.append(
                f"{100 * np.mean(hits[key]):.0f} / {100 * np.mean(named[key]):.0f} / "
                f"{auc(scores[key], scores[design, 'none']):.2f}"
                if hits[key]
                else "-"
            )
        print(f"| {name} | {strength} | " + " | ".join(cells) + " |", flush=True)


def false_alarms(count: int, largest: int, first: int) -> None:
    """Print the flagged among ``count`` unfiltered series, a third of each kind."""
    started = time.perf_counter()
    wrong: Counter[str] = Counter()
    silent: Counter[str] = Counter()
    each = count // len(KINDS)
    for seed in range(first, first + each):
        for kind in KINDS:
            made, said = series(kind, seed, largest)
            seen = detect(made)
            silent[kind] += not seen.filtered and seen.confidence == 0
            if seen.filtered:
                wrong[kind] += 1
                tests = Counter(f.test for f in seen.findings if f.flagged)
                print(f"  {kind} {seed}: {said}: {seen.kind} {dict(tests)}", flush=True)
        print(f"{seed - first + 1} of {each}", file=sys.stderr, flush=True)
    print(f"unfiltered series up to {largest}x{largest}, from seed {first}: false alarms (95 %)")
    for kind in KINDS:
        print(f"  {kind}: {_share(wrong[kind], each)}; cannot tell: {silent[kind]}")
    seconds = (time.perf_counter() - started) / max(1, each * len(KINDS))
    print(f"  all: {_share(sum(wrong.values()), each * len(KINDS))}; {seconds:.1f} s each")


def _share(flagged: int, tried: int) -> str:
    """With Wilson's interval."""
    z = 1.96
    middle = (flagged + z**2 / 2) / (tried + z**2)
    half = z / (tried + z**2) * np.sqrt(flagged * (tried - flagged) / tried + z**2 / 4)
    return f"{flagged} of {tried} ({max(0.0, middle - half):.2%} to {middle + half:.2%})"


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sensors", type=int, default=10)
    parser.add_argument("--size", type=int, default=320)
    parser.add_argument("--mosaic", action="store_true")
    parser.add_argument("--false-alarms", type=int, default=0, help="series, a third of each kind")
    parser.add_argument("--first", type=int, default=10_000, help="seed of the first of a kind")
    options = parser.parse_args()
    if options.sensors:
        power(options.sensors, options.size, options.mosaic)
    if options.false_alarms:
        false_alarms(options.false_alarms, options.size, options.first)
