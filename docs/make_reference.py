"""Write docs/statistics.md and docs/commands.md from the code; a test compares them with it."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import typer
from dnanalyze_cli.main import app

from dnanalyze.analyzers.catalogue import FAMILIES, catalogue
from dnanalyze.analyzers.statistics import StatisticInfo
from dnanalyze.digits import symbol
from dnanalyze.report.words import family_title

HERE = Path(__file__).resolve().parent


def main() -> None:
    """Write both pages."""
    (HERE / "statistics.md").write_text(statistics(), encoding="utf-8")
    (HERE / "commands.md").write_text(commands(), encoding="utf-8")


def statistics() -> str:
    """Every statistic by family."""
    families: dict[str, list[StatisticInfo]] = {}
    for info in catalogue().values():
        families.setdefault(info.family, []).append(info)
    about = {f.__name__.rsplit(".", 1)[-1]: _first_paragraph(f) for f in FAMILIES}  # type: ignore[attr-defined]
    compared = sum(i.compared for i in catalogue().values())
    parts = [
        "# Statistics\n",
        f"{len(catalogue())} statistics in {len(families)} families; {compared} are part of the "
        "model error (marked •); the others are reported only. Each is computed at every operating "
        "point and, for a mosaic, in every colour plane, with its standard error on the scale "
        "given here: linear, log (natural logarithm), root (2 sqrt(n + 3/8), for counts), ratio "
        "(ln(1 + r)). Spatial frequencies are in cycles/pixel (c/px). Spectra are normalized so "
        "that white noise of variance s² has the power s² at every frequency. Terms are in the "
        "[glossary](glossary.md). "
        "Generated from the code by `docs/make_reference.py`.\n",
    ]
    for family, infos in families.items():
        rows = [
            f"| `{i.name}` | {'•' if i.compared else ''} | {_unit(i.unit)} | {i.scale.value} | "
            f"{_cell(i.title)} |"
            for i in infos
        ]
        parts.append(f"## {family_title(family)}\n")
        if family in about:
            parts.append(about[family] + "\n")
        parts.append("| name | in the error | unit | scale | meaning |\n|---|---|---|---|---|")
        parts.append("\n".join(rows) + "\n")
    return "\n".join(parts)


def commands() -> str:
    """Every command with its arguments and options."""
    group: Any = typer.main.get_command(app)
    shown = {name: c for name, c in group.commands.items() if not c.hidden}
    parts = [
        "# Commands\n",
        "Exit codes: 0 done, 1 a check failed, 2 bad input, 3 an internal error "
        "(`DNANALYZE_DEBUG=1` shows its traceback). Progress goes to stderr; it is silent "
        "with `--quiet` or without a terminal. Generated from the code by "
        "`docs/make_reference.py`; `dnanalyze COMMAND --help` prints the same.\n",
        "A file of results that exists is replaced. A folder of frames, an effect file, a map and "
        "a targets file may hold work of yours: they are replaced with `--force` only. `-` prints "
        "any one output.\n",
        "| command | gives |\n|---|---|",
        "\n".join(f"| [{n}](#{n}) | {_cell(_help(c.help))} |" for n, c in shown.items()),
        "",
    ]
    for name, command in shown.items():
        arguments = [p for p in command.params if p.param_type_name == "argument"]
        options = [p for p in command.params if p.param_type_name == "option" and p.name != "help"]
        usage = " ".join(p.metavar if p.required else f"[{p.metavar}]" for p in arguments)
        parts.append(f"## {name}\n\n{_help(command.help)}\n")
        parts.append(f"`dnanalyze {name} {usage} [OPTIONS]`\n".replace("  ", " "))
        parts.append("| | | |\n|---|---|---|")
        rows = [f"| `{p.metavar}` | | {_cell(p.help or '')} |" for p in arguments]
        rows += [f"| {_flags(p)} | {_default(p)} | {_cell(p.help or '')} |" for p in options]
        parts.append("\n".join(rows) + "\n")
    return "\n".join(parts)


def _flags(option: Any) -> str:
    value = "" if option.is_flag else f" {option.metavar or 'VALUE'}"
    return f"`{', '.join(option.opts)}{value}`"


def _default(option: Any) -> str:
    return "" if option.default in (None, False, ()) else f"default {option.default}"


def _help(text: str | None) -> str:
    return " ".join(re.sub(r"\[/?\w+\]", "", text or "").split())


def _first_paragraph(module: Any) -> str:
    return " ".join((module.__doc__ or "").strip().split("\n\n")[0].split())


def _unit(unit: str) -> str:
    return symbol(unit)


def _cell(text: str) -> str:
    return " ".join(text.replace("|", "\\|").split())


if __name__ == "__main__":
    main()
