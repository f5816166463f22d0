"""Sensors side by side: the sections of the report of `benchmark`."""

from __future__ import annotations

from collections.abc import Mapping

from dnanalyze.benchmarking.benchmark_value import BenchmarkValue
from dnanalyze.benchmarking.model_findings import Strength
from dnanalyze.benchmarking.run import BenchmarkResult, Ranking
from dnanalyze.report.capture_facts import facts
from dnanalyze.report.figures import benchmark as figures
from dnanalyze.report.page import Section, Table
from dnanalyze.report.words import FILTERS, celsius, listing, number, sentence, symbol, with_error


def fairest(result: BenchmarkResult, name: str, at: float | None) -> Ranking | None:
    """The ranking in electrons, where it tells two sensors or more; else in DN; None without one.

    DN of different conversion gains compare nothing.
    """
    found = {r.criterion: r for r in result.rankings if r.base == name and r.temperature_c == at}
    electrons = found.get(f"{name}_e")
    if electrons and sum(p.figure.known for p in electrons.places) > 1:
        return electrons
    return found.get(name)


def middle_of(result: BenchmarkResult) -> float | None:
    """The middle one of the common temperatures."""
    return result.temperatures[len(result.temperatures) // 2] if result.temperatures else None


def summary(result: BenchmarkResult) -> list[Ranking]:
    """One ranking a criterion: at the middle temperature, in the unit that compares most fairly."""
    names = dict.fromkeys(r.base for r in result.rankings)
    middle = middle_of(result)
    found = (fairest(result, n, middle) or fairest(result, n, None) for n in names)
    return [r for r in found if r is not None]


def groups(ranking: Ranking) -> list[list[str]]:
    """Sensors that share a rank, since their errors do not tell them apart; best first."""
    ranks = sorted({p.rank for p in ranking.places if p.rank is not None})
    shared = ([p.sensor for p in ranking.places if p.rank == rank] for rank in ranks)
    return [names for names in shared if len(names) > 1]


GLANCE = (
    "dark_current", "temporal_noise", "dsnu", "row_noise", "column_noise", "hot_pixels",
    "read_noise", "spectral_slope", "tail_index", "activation_energy", "doubling_step",
    "error_refined",
)  # fmt: skip
FILTERED, ONE_FRAME = "†", "*"
MARKS = (
    (FILTERED, "filtered output: not a property of the sensor, not ranked."),
    (ONE_FRAME, "from single frames: DSNU and temporal noise are not separated."),
)


def _cell(figure: BenchmarkValue) -> str:
    if not figure.known:
        return "–"
    return with_error(figure.value, figure.se) + (f" {ONE_FRAME}" if figure.one_frame else "")


def _names(result: BenchmarkResult) -> list[str]:
    """The sensors, those with a filtered output marked."""
    return [f"{s.name} {FILTERED}" if s.filtered else s.name for s in result.sensors]


def _marks(result: BenchmarkResult) -> list[str]:
    """What the marks say, of those that stand in the tables."""
    figures = [p.figure for r in result.rankings for p in r.places]
    used = {
        FILTERED: any(s.filtered for s in result.sensors),
        ONE_FRAME: any(f.known and f.one_frame for f in figures),
    }
    return [f"{mark} {text}" for mark, text in MARKS if used[mark]]


def glance(result: BenchmarkResult) -> Section:
    """A row a sensor, a column a criterion."""
    shown = [r for r in summary(result) if r.base in GLANCE]
    columns = [r.title + (f" [{symbol(r.unit)}]" if r.unit not in ("", "1") else "") for r in shown]
    rows = []
    for sensor, name in zip(result.sensors, _names(result), strict=True):
        cells = []
        for r in shown:
            (place,) = (p for p in r.places if p.sensor == sensor.name)
            text = number(place.figure.value) if place.figure.known else "–"
            mark = f" {ONE_FRAME}" if place.figure.known and place.figure.one_frame else ""
            cells.append(text + mark + (f" ({place.rank})" if place.rank else ""))
        rows.append((name, *cells))
    middle = middle_of(result)
    at = (
        f"Figures that depend on temperature are those at {celsius(middle)}. "
        if middle is not None
        else ""
    )
    return Section(
        "glance",
        "Overview by criterion",
        text=[f"{at}In brackets the rank; equal ranks are not distinguishable.",
              *_marks(result)],
        tables=[Table(("sensor", *columns), rows, sortable=True, narrow=True)],
    )  # fmt: skip


def temperatures(result: BenchmarkResult) -> Section:
    """What runs with temperature: a row a criterion and temperature, a column a sensor."""
    head = ("figure", "unit", "°C", *_names(result))
    shown: list[tuple[str, ...]] = []
    rest: list[tuple[str, ...]] = []
    for r in result.rankings:
        if r.temperature_c is not None:
            cells = (_cell(r.of(s.name)) for s in result.sensors)
            row = (r.title, symbol(r.unit), number(r.temperature_c), *cells)
            (rest if _told_in_electrons(result, r) else shown).append(row)
    tables = [Table(head, shown, words=2, sortable=True)]
    if rest:
        tables.append(Table(head, rest, words=2, title="The same in DN", folded=True))
    return Section(
        "temperatures",
        "Figures at common temperatures",
        text=[
            "A figure measured at the temperature is given as measured. Any other is interpolated "
            "with the law of the sensor over temperature; its standard error includes sampling, "
            "misfit, the choice of the law and the distance to the measurements."
        ],
        pictures=[figures.over_temperature(result)],
        tables=tables,
    )


def _told_in_electrons(result: BenchmarkResult, ranking: Ranking) -> bool:
    """Whether every sensor that has this figure in DN has it in electrons, too."""
    told = [
        r
        for r in result.rankings
        if r.criterion == f"{ranking.criterion}_e" and r.temperature_c == ranking.temperature_c
    ]
    known = [p.sensor for p in ranking.places if p.figure.known]
    return bool(told) and all(told[0].of(name).known for name in known)


def one_each(result: BenchmarkResult) -> Section:
    """What has no temperature: a row a figure, a column a sensor."""
    cells = [
        (r.title, symbol(r.unit), *(_cell(r.of(s.name)) for s in result.sensors))
        for r in result.rankings
        if r.temperature_c is None and not r.criterion.startswith("error_")
    ]
    gains = [
        ("conversion gain K", "DN/e⁻", *(_cell(s.dn_per_e) for s in result.sensors)),
        ("K estimated from", "", *(s.dn_per_e.note for s in result.sensors)),
    ]
    return Section(
        "figures",
        "Figures without temperature",
        tables=[
            Table(("figure", "unit", *_names(result)), [*cells, *gains], words=2, sortable=True)
        ],
    )


def models(result: BenchmarkResult) -> Section:
    """How well each is described, and by which effects."""
    rows = []
    for s in result.sensors:
        kind = "not tested" if s.filtered is None else "no"
        if s.filtered:
            kind = f"yes: {FILTERS.get(s.filter_kind, s.filter_kind)}"
        told = (number(s.errors.get(k)) for k in ("gaussian", "paper", "refined"))
        rows.append((s.name, kind, s.verdict or "not refined", *told))
    columns = (
        "sensor",
        "filtered",
        "verdict",
        "Gaussian model",
        "Wang 2025 model",
        "refined model",
    )
    tables = [Table(columns, rows, words=3, sortable=True)]
    strengths = [
        (e.effect, s.name, number(e.rms_dn), _numbers(e.parameters))
        for s in result.sensors
        for e in s.effects
    ]
    if strengths:
        names = [s.name for s in result.sensors]
        head, title = ("effect", "sensor", "rms [DN]", "parameters"), "Parameters of every effect"
        tables.append(Table(("rms of the effect [DN]", *names), _strengths(result)))
        tables.append(Table(head, sorted(strengths), words=4, title=title, folded=True))
    return Section(
        "models",
        "Models of the sensors",
        text=[
            "Filtered: a defect-pixel correction or a denoise was detected in the frames; noise, "
            "hot pixels and spectra are then not those of the sensor. Verdict: adequate, no "
            "further missing effect is detectable; unexplained, no effect of the catalogue "
            "explains the residual. The strength of an effect is the rms that it adds to a pixel "
            "at the operating point of the first row, or its first parameter where it is unknown."
        ],
        pictures=[figures.errors(result)],
        tables=tables,
    )


def _strengths(result: BenchmarkResult) -> list[tuple[str, ...]]:
    """A row an effect, a column a sensor: its rms, a parameter where no closed form tells it."""
    effects = dict.fromkeys(e.effect for s in result.sensors for e in s.effects)
    found = [{e.effect: e for e in s.effects} for s in result.sensors]

    def cell(effect: Strength | None) -> str:
        if effect is None:
            return "–"
        if effect.rms_dn is not None:
            return number(effect.rms_dn)
        return _numbers(dict(list(effect.parameters.items())[:1])) or "yes"

    at = ("at", *(s.reference or "–" for s in result.sensors))
    return [at] + [(name, *(cell(own.get(name)) for own in found)) for name in effects]


def _numbers(parameters: Mapping[str, tuple[float, str]]) -> str:
    """``sigma 2.1 DN, tau 3``."""
    return ", ".join(
        f"{key} {number(value)}{f' {unit}' if unit not in ('', '1') else ''}"
        for key, (value, unit) in parameters.items()
    )


def rankings(result: BenchmarkResult) -> Section:
    """Per criterion, best first, in the unit that compares most fairly."""
    names = dict(zip((s.name for s in result.sensors), _names(result), strict=True))
    rows = []
    for r in result.rankings:
        ranked = [p for p in r.places if p.rank is not None]
        if len(ranked) < 2 or r is not fairest(result, r.base, r.temperature_c):
            continue
        at = celsius(r.temperature_c) if r.temperature_c is not None else ""
        order = "; ".join(
            f"{p.rank}. {p.sensor} ({_cell(p.figure)})"
            + (f", not distinguishable from {listing(p.alike)}" if p.alike else "")
            for p in ranked
        )
        left = [names[p.sensor] for p in r.places if p.rank is None and p.figure.known]
        order += f"; not ranked: {listing(left)}" if left else ""
        rows.append((r.title, symbol(r.unit), at, order))
    return Section(
        "rankings",
        "Ranking",
        text=[
            "The rank is 1 plus the number of sensors that are better by more than two standard "
            "errors of the difference, on the scale that is printed; figures that differ by less "
            "are not distinguishable.",
            *_marks(result),
        ],
        tables=[Table(("criterion", "unit", "at", "best first"), rows, words=4)] if rows else [],
    )


def captures(result: BenchmarkResult) -> Section:
    """What was captured of each sensor."""
    keys = ("frames", "temperature", "exposure", "gain", "pixel pitch")
    rows = [(s.name, *(facts(s.captures).get(k, "–") for k in keys)) for s in result.sensors]
    notes = [f"{s.name}: {sentence(n)}" for s in result.sensors for n in s.notes]
    columns = ("sensor", *keys)
    return Section("captures", "Captures", points=notes, tables=[Table(columns, rows, words=6)])
