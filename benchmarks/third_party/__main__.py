"""A truth suite of third-party simulators: does dnanalyze name what other people's simulators hide?

python benchmarks/third_party list
python benchmarks/third_party make DIR
python benchmarks/third_party verify DIR
python benchmarks/third_party run DIR --json out.jsonl
python benchmarks/third_party table out.jsonl --against other.jsonl
python benchmarks/third_party calibrate out.jsonl
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

# the folder that runs is on the path, the package that it is lies above
sys.path[0] = str(Path(__file__).resolve().parents[1])

from third_party.case import Case  # noqa: E402
from third_party.cases import GENERATORS, all_cases  # noqa: E402


def chosen(given: argparse.Namespace) -> list[Case]:
    """The cases that the options leave."""
    generators = given.generators.split(",")
    unknown = sorted(set(generators) - set(GENERATORS))
    if unknown:
        raise SystemExit(
            f"--generators {','.join(unknown)}: valid generators are {', '.join(GENERATORS)}"
        )
    cases = all_cases(generators, given.series)
    words = given.only.split(",") if given.only else []
    return [c for c in cases if not words or any(w in c.key for w in words)][: given.first]


def make(given: argparse.Namespace) -> int:
    """Write the folders that are not there, and verify each."""
    from third_party.folders import folder_of, write

    failed = 0
    for case in chosen(given):
        if not folder_of(given.root, case).exists():
            write(case, case.drawn(), given.root)
            failed += not _verified(given.root, case)
    return 1 if failed else 0


def verify(given: argparse.Namespace) -> int:
    """Measure every claim of the folders that are there; status 1 where one fails."""
    from third_party.folders import folder_of

    there = [c for c in chosen(given) if folder_of(given.root, c).exists()]
    failed = sum(not _verified(given.root, c) for c in there)
    print(f"{len(there)} cases, {failed} whose frames do not show what they claim")
    return 1 if failed else 0


def _verified(root: Path, case: Case) -> bool:
    from third_party.folders import folder_of, read, truth
    from third_party.verify import measure

    folder = folder_of(root, case)
    measured = measure(read(folder), truth(folder)["claims"])
    for m in measured:
        if not m.holds:
            print(f"{case.key}: {m}", file=sys.stderr, flush=True)
    return all(m.holds for m in measured)


def run(given: argparse.Namespace) -> int:
    """Run what is made and has no line yet, then print the tables."""
    from third_party.folders import folder_of
    from third_party.run import run_all, store, stored
    from third_party.score import falsely_sure, hidden_only, right

    rows = stored(given.json)
    there = [c for c in chosen(given) if folder_of(given.root, c).exists()]
    todo = [c for c in there if c.key not in rows]
    for count, row in enumerate(run_all(todo, given.root, given.jobs, given.limit), 1):
        store(given.json, row)
        row = rows[row["key"]] = hidden_only(row)
        sign = ("ok" if right(row) else "--") + (" FALSE" if falsely_sure(row) else "")
        said = row.get("failed") or f"{', '.join(row['named']) or 'nothing'}; {row['verdict']}"
        print(f"{count}/{len(todo)} {sign} {row['key']}: {said}", flush=True)
    _print([rows[c.key] for c in there if c.key in rows], None)
    return 0


def table(given: argparse.Namespace) -> int:
    """Print the tables of a stored result."""
    from third_party.run import stored

    others = stored(given.against) if given.against else None
    _print(list(stored(given.result).values()), others)
    return 0


def calibrate(given: argparse.Namespace) -> int:
    """Print how often effects of a stated confidence are right, by all and with one left out."""
    from hidden_scores import table as markdown

    from third_party import calibration
    from third_party.run import stored

    found = calibration.additions([r for path in given.results for r in stored(path).values()])
    print("\n" + markdown(calibration.RELIABILITY_HEAD, calibration.reliability(found)))
    print("\n" + markdown(calibration.LEFT_OUT_HEAD, calibration.left_out(found)))
    return 0


def listed(given: argparse.Namespace) -> int:
    """Print every case with what it hides and the names that are right."""
    from hidden_scores import table as markdown

    from third_party.answers import names_of

    body = [
        [
            c.key,
            ", ".join(c.recipe.hides) or "nothing",
            ", ".join(_answer(names_of(k)) for k in c.recipe.hides),
        ]
        for c in chosen(given)
    ]
    print(markdown(["case", "hidden", "right"], body))
    print(f"\n{len(body)} cases")
    return 0


def _answer(names: tuple[str, ...]) -> str:
    return "/".join(n or "nothing" for n in names) or "unexplained"


def _print(rows: list[dict[str, Any]], others: dict[str, dict[str, Any]] | None) -> None:
    from hidden_scores import table as markdown

    from third_party import score

    print("\n" + markdown(score.HEAD, score.by_generator(rows)))
    print("\n" + markdown(score.WRONG_HEAD, score.wrong(rows)))
    if others is not None:
        print("\n" + markdown(score.PAIRED_HEAD, score.paired(rows, others)))


def arguments(words: list[str] | None = None) -> argparse.Namespace:
    """Commands and options."""
    parser = argparse.ArgumentParser(
        prog="third_party", description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    which = argparse.ArgumentParser(add_help=False)
    which.add_argument(
        "--generators", default=",".join(GENERATORS), help=f"some of {','.join(GENERATORS)}; all"
    )
    which.add_argument("--only", help="cases with one of these words in their key")
    which.add_argument("--first", type=int, help="so many cases; a part is like the whole")
    which.add_argument(
        "--series", type=int, default=0, help="0: the frozen seeds; else new ones (0)"
    )
    place = argparse.ArgumentParser(add_help=False)
    place.add_argument("root", type=Path, metavar="DIR", help="where the folders lie")
    commands.add_parser("list", parents=[which], help="what there is").set_defaults(do=listed)
    for name, do, said in (
        ("make", make, "write the folders and verify each"),
        ("verify", verify, "measure again what the frames show"),
    ):
        commands.add_parser(name, parents=[place, which], help=said).set_defaults(do=do)
    running = commands.add_parser("run", parents=[place, which], help="refine and detect")
    running.add_argument("--json", type=Path, required=True, help="one line a case; resumes")
    running.add_argument("--jobs", type=int, default=1)
    running.add_argument("--limit", type=float, default=900.0, help="seconds a case may take (900)")
    running.set_defaults(do=run)
    telling = commands.add_parser("table", help="the tables of a result")
    telling.add_argument("result", type=Path, metavar="RESULT.jsonl")
    telling.add_argument("--against", type=Path, help="a stored result of another commit")
    telling.set_defaults(do=table)
    judging = commands.add_parser("calibrate", help="whether stated confidences are right")
    judging.add_argument("results", type=Path, nargs="+", metavar="RESULT.jsonl")
    judging.set_defaults(do=calibrate)
    return parser.parse_args(words)


if __name__ == "__main__":
    given = arguments()
    sys.exit(given.do(given))
