"""Sensors side by side in the terminal."""

from __future__ import annotations

from typing import Any

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from dnanalyze.report.benchmark import groups, headline, summary
from dnanalyze.report.words import celsius, listing, number, sentence, symbol, with_error

SHOWN = {
    "dark_current", "temporal_noise", "dsnu", "hot_pixels", "row_noise", "read_noise",
    "activation_energy", "error_gaussian", "error_paper", "error_refined",
}  # fmt: skip


def result(console: Console, outcome: Any) -> None:
    """The verdict, the figures at one common temperature, the effects of each, the caveats."""
    console.print(Padding(Text(headline(outcome), style="bold"), (0, 0, 1, 2)))
    names = [s.name for s in outcome.sensors]
    table = Table(box=SIMPLE_HEAD, pad_edge=False, show_edge=False, header_style="dim")
    wide = len(names) < 4
    table.add_column("figure", no_wrap=wide)
    letters = names if wide else [chr(ord("A") + i) for i in range(len(names))]
    for letter in letters:
        table.add_column(letter, justify="right", overflow="fold", no_wrap=not wide)
    if not wide:
        legend = ", ".join(f"{a} {b}" for a, b in zip(letters, names, strict=True))
        console.print(Padding(Text(legend), (0, 0, 1, 2)))
    for ranking in summary(outcome):
        if ranking.base not in SHOWN:
            continue
        at = f", {celsius(ranking.temperature_c)}" if ranking.temperature_c is not None else ""
        unit = f" [{symbol(ranking.unit)}]" if ranking.unit not in ("", "1") else ""
        cells = (_cell(ranking.of(name), wide) for name in names)
        table.add_row(Text(f"{ranking.title}{unit}{at}"), *cells)
    if any(s.dn_per_e.known for s in outcome.sensors):
        gains = (_cell(s.dn_per_e, wide) for s in outcome.sensors)
        table.add_row(Text("conversion gain K [DN/e⁻]"), *gains)
    console.print(Padding(table, (0, 0, 1, 2)))
    for note, known in _by_note(outcome.sensors).items():
        text = f"K of {listing(known)}: {note}"
        console.print(Padding(Text(sentence(text), style="dim"), (0, 0, 0, 2)))
    for ranking in summary(outcome):
        for names in groups(ranking) if ranking.base in SHOWN else ():
            text = f"{ranking.title}: {listing(names)} are not distinguishable"
            console.print(Padding(Text(sentence(text), style="dim"), (0, 0, 0, 2)))
    for sensor in outcome.sensors:
        made = ", ".join(e.effect for e in sensor.effects)
        if made:
            error = number(sensor.errors.get("refined"))
            console.print(
                Padding(Text(f"{sensor.name}: {made} (model error {error})"), (0, 0, 0, 2))
            )
    for note in outcome.notes:
        console.print(Padding(Text(sentence(note), style="dim"), (0, 0, 0, 2)))


def _by_note(sensors: Any) -> dict[str, list[str]]:
    """How the conversion gain was estimated, and the sensors of which."""
    found: dict[str, list[str]] = {}
    for sensor in sensors:
        if sensor.dn_per_e.known:
            found.setdefault(sensor.dn_per_e.note, []).append(sensor.name)
    return found


def _cell(figure: Any, wide: bool) -> Text:
    """With its error where there is room."""
    if not figure.known:
        return Text("–")
    return Text(with_error(figure.value, figure.se) if wide else number(figure.value))
