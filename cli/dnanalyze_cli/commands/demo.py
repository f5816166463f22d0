"""``dnanalyze demo``: the whole story on a built-in virtual sensor."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path
from typing import Annotated

import typer

from dnanalyze_cli.options import Force, Json, Quiet, Report, option
from dnanalyze_cli.session import Session

SHAPE, FRAMES = (256, 256), 6


def demo(
    folder: Annotated[
        Path | None,
        typer.Argument(
            metavar="FOLDER",
            help="Where to keep the frames; a temporary folder by default.",
            show_default=False,
        ),
    ] = None,
    hide: Annotated[str, option("--hide EFFECT", "Effect to hide in the sensor.")] = "column_fpn",
    level: Annotated[
        str, option("--level", "Strength of the effect: weak, middling or strong.")
    ] = "middling",
    seed: Annotated[int, option("--seed", "Seed of the virtual sensor.", min=0)] = 1,
    json: Json = None,
    report: Report = None,
    force: Force = False,
    quiet: Quiet = False,
) -> None:
    """Make frames of a virtual sensor with a hidden effect, compare, and identify the effect."""
    from dnanalyze.report.output_files import check_folder

    if folder is not None:
        check_folder(folder, force)
        _tell(folder, hide, level, seed, json, report, quiet, True)
        return
    with tempfile.TemporaryDirectory(prefix="dnanalyze-") as temporary:
        _tell(Path(temporary) / "demo", hide, level, seed, json, report, quiet, False)


def _tell(
    folder: Path,
    hide: str,
    level: str,
    seed: int,
    json: Path | None,
    report: Path | None,
    quiet: bool,
    keep: bool,
) -> None:
    """Make the frames, compare the Wang 2025 model with them, let `refine` find what is hidden."""
    import numpy as np

    from dnanalyze.comparator.compare import compare_on
    from dnanalyze.demo import draw_sensor, generate, truth, write_folder
    from dnanalyze.diagnosis.refine import refine_on
    from dnanalyze.report.words import number, texts

    where = f"Frames: {folder}" if keep else "Name a folder to keep the frames."
    session = Session("demo", str(folder), json, report, quiet=quiet, cache=False)
    print = session.console.print
    sensor = draw_sensor(np.random.default_rng(seed))
    hidden = {hide: level}
    with session.progress("Simulating frames"):
        made = generate(sensor, hidden, SHAPE, frames=FRAMES, seed=seed)
        if folder.exists():  # empty, or to be replaced
            shutil.rmtree(folder)
        write_folder(made, folder, truth(sensor, hidden, seed))
    print(
        f"1. A virtual sensor, simulated in electrons: {made.frame_count} dark frames at "
        f"{len(made.settings)} temperatures, with one hidden effect.\n   {where}\n"
    )
    found = session.load()
    with session.progress("Comparing") as progress:
        problem = progress.fit_problem(found)  # what is simulated here, the search need not
        first = compare_on(found, problem=problem)
    print("2. The Wang 2025 model, fitted and compared with it (`dnanalyze compare`):\n")
    session.show(first)
    print("3. Missing effects, added until no further one is detectable (`dnanalyze refine`):\n")
    with session.progress("Refining") as progress:
        result = refine_on(found, problem=problem, on_progress=progress.trying)
        progress.now("Standard errors of the parameters")
        _ = result.parameters
    session.show(result)
    verdict = "identified" if hide in result.effects else "not identified"
    print(f"\n4. The hidden effect, {hide} at level {level}, was {verdict}.")
    last = number(result.steps[-1].error)
    print(
        f"   Model error: {number(first.error)} with the Wang 2025 model, "
        f"{last} with the final model."
    )
    session.finish(result, more={"schema": "dnanalyze/demo/1", "hidden": texts(hidden)})
