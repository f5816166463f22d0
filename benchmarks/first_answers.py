"""First candidate of `diagnose` on a part of each case of the suite, and two versions in pairs.

    python benchmarks/first_answers.py run DIR --json now.jsonl
    python benchmarks/first_answers.py table now.jsonl --against then.jsonl

A part is 3 of the temperatures, 4 of the frames and 144 x 144 pixels: small enough for hundreds of
cases. DIR is what ``third_party make`` wrote. To run another version, put it first on PYTHONPATH.

Right is: with an effect of the catalogue, the first candidate beyond the baseline is one of its
names and has a confidence of at least .2; with nothing hidden, no candidate has .5; with an effect
outside the catalogue, no candidate has .9. False is a candidate with .9 that is not there.
"""

from __future__ import annotations

import argparse
import json
import random
import tempfile
import time
from pathlib import Path
from typing import Any

from third_party.answers import BASELINE, names_of
from third_party.run import store, stored
from third_party.score import (
    Row,
    accepted,
    counted,
    falsely_sure,
    is_ordinary,
    is_outside,
    mcnemar,
)

LISTED, LIKELY = 0.2, 0.5  # confidences
EVERY, FRAMES, SIDE = 2, 4, 144


def part_of(folder: Path, target: Path) -> None:
    """Write every second temperature, the first frames and the upper left corner of a case."""
    import tifffile

    points = sorted(p for p in folder.iterdir() if p.is_dir())
    for point in points[::EVERY]:
        (target / point.name).mkdir(parents=True)
        for frame in sorted(point.iterdir())[:FRAMES]:
            image = tifffile.imread(frame)[:SIDE, :SIDE]
            tifffile.imwrite(target / point.name / frame.name, image.copy())


def answer(folder: Path) -> dict[str, Any]:
    """Verdict and candidates beyond the baseline, as the suite has those that were added.

    None where the part cannot be analysed.
    """
    import dnanalyze
    from dnanalyze.errors import InputError

    begun = time.process_time()
    with tempfile.TemporaryDirectory() as place:
        part_of(folder, Path(place) / folder.name)
        try:
            found = dnanalyze.diagnose(dnanalyze.load(Path(place) / folder.name))
        except InputError as error:  # a filter that leaves no noise there
            return {"verdict": f"refused: {error}", "named": [], "additions": []}
    beyond = [c for c in found.candidates if c.effect not in found.ordinary]
    return {
        "verdict": found.verdict,
        "named": [c.effect for c in beyond],
        "additions": [(c.effect, c.confidence) for c in beyond],
        "cpu_seconds": time.process_time() - begun,
    }


def run(given: argparse.Namespace) -> None:
    """All cases that have no line yet, in an order that is random and always the same."""
    truths = sorted(given.root.glob("*/*.truth.json"))
    random.Random(given.seed).shuffle(truths)
    known = stored(given.json)
    for truth in truths[: given.first]:
        folder = truth.with_name(truth.name.removesuffix(".truth.json"))
        key = f"{truth.parent.name}/{folder.name}"
        if key in known or not folder.is_dir():
            continue
        hides = json.loads(truth.read_text("utf-8"))["hides"]
        row = {"key": key, "generator": truth.parent.name, "hides": hides}
        store(given.json, row | answer(folder))


def kind(row: Row) -> str:
    """What is hidden: nothing, or something in or outside the catalogue."""
    return "ordinary" if is_ordinary(row) else "outside" if is_outside(row) else "catalogue"


def right(row: Row) -> bool:
    """Whether the first answer is right."""
    if is_outside(row):
        return not falsely_sure(row)
    found, true = row["additions"], set().union(*accepted(row))
    if all(BASELINE in names_of(k) for k in row["hides"]):  # with nothing hidden too
        return not any(sure >= LIKELY and name not in true for name, sure in found)
    return bool(found) and found[0][0] in true and found[0][1] >= LISTED


def table(given: argparse.Namespace) -> None:
    """By generator and kind: right, false, and the paired comparison."""
    here = stored(given.result)
    there = stored(given.against) if given.against else here
    keys = [k for k in here if k in there]
    print("| generator | hidden | now | then | gained, lost | p | false: now, then |")
    print("|---|---|---|---|---|---|---|")
    for generator in [*sorted({here[k]["generator"] for k in keys}), "all"]:
        for sort in ("catalogue", "outside", "ordinary", "all"):
            mine = [
                k for k in keys
                if generator in ("all", here[k]["generator"]) and sort in ("all", kind(here[k]))
            ]  # fmt: skip
            if not mine:
                continue
            now, then = [here[k] for k in mine], [there[k] for k in mine]
            gained = sum(right(a) and not right(b) for a, b in zip(now, then, strict=True))
            lost = sum(right(b) and not right(a) for a, b in zip(now, then, strict=True))
            print(
                f"| {generator} | {sort} | {counted(now, right)} | {counted(then, right)} "
                f"| {gained}, {lost} | {mcnemar(gained, lost):.2f} "
                f"| {sum(map(falsely_sure, now))}, {sum(map(falsely_sure, then))} |"
            )


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    commands = parser.add_subparsers(required=True)
    running = commands.add_parser("run")
    running.add_argument("root", type=Path)
    running.add_argument("--json", type=Path, required=True, help="one line a case; resumes")
    running.add_argument("--first", type=int, help="so many cases")
    running.add_argument("--seed", type=int, default=7, help="of the order")
    running.set_defaults(do=run)
    telling = commands.add_parser("table")
    telling.add_argument("result", type=Path)
    telling.add_argument("--against", type=Path)
    telling.set_defaults(do=table)
    given = parser.parse_args()
    given.do(given)


if __name__ == "__main__":
    main()
