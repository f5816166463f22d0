"""``dnanalyze describe``: what no effect of the catalogue explains."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated

from dnanalyze.errors import InputError
from dnanalyze_cli.options import FILES, Budget, Force, ModelOptions, ModelOut, option, takes


@takes(ModelOptions)
def describe(
    options: ModelOptions,
    output: ModelOut = None,
    write: Annotated[
        Path | None,
        option(
            "--write OWN.py",
            "Write the structure as an effect of your own, which simulates the same frames.",
            FILES,
        ),
    ] = None,
    map_file: Annotated[
        Path | None,
        option(
            "--map MAP.npy",
            "Learn the fixed pattern of this very sensor; -o adds it to the model.",
            FILES,
        ),
    ] = None,
    budget: Budget = None,
    force: Force = False,
) -> None:
    """Describe the residual that no effect of the catalogue explains; add it to the model."""
    from dnanalyze.description.describe import describe_on as run
    from dnanalyze.description.pattern import check_pattern, learn_pattern
    from dnanalyze.model.learned.field_map import map_bytes
    from dnanalyze.model.learned.pattern_map import named
    from dnanalyze.model.noise_model import dump_model
    from dnanalyze.report.output_files import check_kept, check_output
    from dnanalyze.report.results import description as report
    from dnanalyze.report.results import learnedpattern

    session = options.session("describe", output=output)
    session.remaining(budget)
    taken = list(session.files)
    for name, path in (("--write", write), ("--map", map_file)):
        if path is None:
            continue
        check_output(path, options.captures)
        check_kept(path, force, name)
        if path in taken:
            raise InputError(f"{path}: named for two outputs; give each its own file")
        taken.append(path)
    if map_file is not None and map_file.suffix != ".npy":
        raise InputError(f"--map {map_file}: valid: a name that ends in .npy")
    found, own = options.begin(session)
    if len(found.channels) > 1:
        names = ", ".join(str(c) for c in found.channels)
        raise InputError(f"--channel: describe takes one channel; valid: {names}")
    if map_file is not None:
        check_pattern(found, own)
    with session.progress("Reading frames") as progress:
        problem = progress.fit_problem(found)
        result = run(
            found,
            own,
            budget=session.remaining(budget),
            known=session.known(),
            problem=problem,
            on_progress=progress.now,
        )
        pattern = None
        if map_file is not None:
            pattern = learn_pattern(found, result.model, progress=progress)
    session.show(result)
    extra: dict[Path, str | bytes] = {}
    model = result.model
    if pattern is not None and map_file is not None:
        session.print([replace(s, printed=True) for s in learnedpattern.sections(pattern)])
        if pattern.supported:
            model = pattern.model.with_effect(named(pattern.effect, map_file, output))
            extra[map_file] = map_bytes(pattern.effect.map)
    if result.verdict == "described":
        session.not_kept()
    if write is not None and result.effect is not None:
        extra[write] = result.source()
    more = {} if pattern is None else {"pattern": learnedpattern.body(pattern)}
    session.finish(
        result, lambda: report.page(result, pattern), more, extra, lambda: dump_model(model)
    )
