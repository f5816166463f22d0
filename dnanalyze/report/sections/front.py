"""The first two pages of a report: images of the sensor, Figures 1 and 2, effect, numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from dnanalyze.analyzers.statistics import SettingStatistics, Statistics
from dnanalyze.classifier.result import Classification
from dnanalyze.comparator.compare import Comparison
from dnanalyze.diagnosis.results import Diagnosis, Refinement
from dnanalyze.emva import kinds
from dnanalyze.emva.quantity import Kind, PointQuantities, Quantity
from dnanalyze.loaders.captures import CaptureSet
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.report import emva_tables
from dnanalyze.report.fields import Place, fields, worst_place
from dnanalyze.report.figures.before_after import before_after
from dnanalyze.report.figures.field_images import field_row, field_series
from dnanalyze.report.figures.style import ACCENT, GAUSSIAN, MODEL, Layer, chosen, layers
from dnanalyze.report.figures.wang_2025 import figure_1, figure_2, figure_2_of_two
from dnanalyze.report.leads import lacks, plain_name
from dnanalyze.report.page import Section, Table
from dnanalyze.report.rivals import Rivals
from dnanalyze.report.words import DIRECT, direct_rows

SIDE_BY_SIDE = 5  # operating points shown side by side
DIRECT_ROWS = 5  # of model against direct measurement, worst first
HALF = "Measured on the held-out half of the field."
NUMBERS = kinds.NOISE, kinds.DSNU, kinds.HOT_5


def front(
    result: Comparison | Diagnosis | Refinement,
    models: Mapping[str, NoiseModel | None],
    comparison: Comparison | None,
    rivals: Rivals,
    drawn: Callable[[Comparison, Rivals], list[Layer]],
    told: Classification | None = None,
) -> list[Section]:
    """What is read first of a result that judges a model.

    Parameters
    ----------
    result : Comparison, Diagnosis or Refinement
    models : mapping
        Label to model, whose frames are shown beside the measured ones.
    comparison : Comparison or None
        Of the model; without it there are no curves.
    rivals : Rivals
    drawn : callable
        Gives the layers of Figure 1, of a comparison and the rivals.
    told : Classification, optional
    """
    place = place_of(comparison, rivals)
    made = [frames_section(result.captures, place, models)]
    if comparison is not None:
        raw = None if rivals.raw is None else rivals.raw.statistics
        made += effect_section(comparison.measured, rivals)
        made += curves_sections(drawn(comparison, rivals), place, comparison.simulated, raw)
        made += numbers_section(comparison.measured, HALF)
    return [*made, *direct_front(result), *classifier_front(told)]


def frames_section(
    captures: CaptureSet | None, place: Place | None, models: Mapping[str, NoiseModel | None]
) -> Section:
    """Measured, models and difference."""
    known = {name: model for name, model in models.items() if model is not None}
    found = None if captures is None else fields(captures, place, known)
    title = "The sensor" if not known else "The sensor and the model"
    return Section("frames", title, pictures=[field_row(found)])


def series_section(
    captures: CaptureSet | None, measured: Statistics, place: Place | None
) -> Section:
    """The sensor at several operating points, in the kind of picture that tells most."""
    if place is None or captures is None:
        return Section("frames", "The sensor")
    shown = chosen(measured, SIDE_BY_SIDE)
    if all(s.point != place.point for s in shown):
        shown = [
            *shown[: SIDE_BY_SIDE - 1],
            *[s for s in measured.settings if s.point == place.point][:1],
        ]
    several = (fields(captures, Place(s.point, s.plane, place.kind), {}) for s in shown)
    picture = field_series([f for f in several if f is not None])
    return Section("frames", "The sensor", pictures=[picture])


def curves_sections(
    drawn: Sequence[Layer],
    place: Place | None,
    simulated: Statistics | None = None,
    raw: Statistics | None = None,
    beside: Layer | None = None,
) -> list[Section]:
    """Figures 1 and 2 of the paper for this sensor.

    Parameters
    ----------
    drawn : sequence of Layer
        Of Figure 1, the measured first.
    place : Place or None
        Of Figure 1.
    simulated, raw : Statistics, optional
        Of the model, and of the model without its filters, for Figure 2.
    beside : Layer, optional
        Other frames of the sensor, such as processed ones, drawn beside the measured.
    """
    setting = _setting(drawn[0].statistics, place)
    if setting is None:
        return []
    before = None if raw is None else Layer("model without its filters", raw, MODEL)
    second = [drawn[0], *layers(drawn[0].statistics, simulated)[1:]]
    first, spectra = drawn, figure_2(second, before)
    if beside is not None:
        first, spectra = [*drawn, beside], figure_2_of_two(drawn[0], beside)
    return [
        Section("figure-1", "Histogram and spectra", pictures=[figure_1(first, setting)]),
        Section("figure-2", "Spectra over all operating points", pictures=[spectra]),
    ]


def _setting(measured: Statistics, place: Place | None) -> SettingStatistics | None:
    if not measured.settings:
        return None
    if place is None:
        return measured.settings[0]
    same = [s for s in measured.settings if (s.point, s.plane) == (place.point, place.plane)]
    return (same or list(measured.settings))[0]


def effect_section(measured: Statistics, rivals: Rivals) -> list[Section]:
    """The named effect before and after; nothing where none is named."""
    before, after = rivals.before, rivals.after
    if before is None or after is None:
        return []
    names = labels_of(rivals.effect)
    picture = before_after(effect_layers(measured, rivals), before.rows, after.rows, names)
    title = f"{plain_name(rivals.effect)}: before and after"
    return [Section("effect", title[:1].upper() + title[1:], pictures=[picture])]


def labels_of(effect: str) -> tuple[str, str]:
    """Names of the models without and with an effect."""
    return f"without {plain_name(effect)}", f"with {plain_name(effect)}"


def effect_layers(measured: Statistics, rivals: Rivals) -> list[Layer]:
    """Measured, and the models of the steps without and with the named effect."""
    made = [layers(measured)[0]]
    without, with_it = labels_of(rivals.effect)
    if rivals.before is not None:
        made.append(Layer(without, rivals.before.statistics, GAUSSIAN, (0, (4, 2)), 1.1))
    if rivals.after is not None:
        made.append(Layer(with_it, rivals.after.statistics, MODEL, "-", 1.2))
    return made


def model_layers(comparison: Comparison, rivals: Rivals) -> list[Layer]:
    """Measured and model, between them the candidate or the model of the step before."""
    if rivals.before is not None and rivals.after is not None:
        return effect_layers(comparison.measured, rivals)
    return list(layers(comparison.measured, comparison.simulated, comparison.gaussian))


def candidate_layers(comparison: Comparison, rivals: Rivals) -> list[Layer]:
    """Measured, model and, of a diagnosis, the model with the leading candidate."""
    made = list(layers(comparison.measured, comparison.simulated))
    if rivals.after is not None:
        name = labels_of(rivals.effect)[1]
        made.append(Layer(name, rivals.after.statistics, ACCENT, (0, (4, 1.5)), 1.2))
    return made


def place_of(comparison: Comparison | None, rivals: Rivals) -> Place | None:
    """Where the named effect lowers the error most, or where what the model lacks is plainest.

    Without either, where the model fails most.
    """
    if rivals.before is not None:
        return worst_place(rivals.before.rows, () if rivals.after is None else rivals.after.rows)
    if comparison is None:
        return None
    lacking = lacks(comparison)
    return worst_place(comparison.statistics) if lacking is None else lacking.place


def numbers_section(measured: Statistics, part: str = "") -> list[Section]:
    """Five numbers of EMVA 1288 with their standard errors."""
    found = measured.emva
    if not found.groups:
        return []
    group = found.groups[0]
    points = emva_tables.ends(group)
    labels = emva_tables.labels(points) if len(points) > 1 else [""]
    rows = [
        (emva_tables.title(kind), label, emva_tables.cell(quantity))
        for kind in NUMBERS
        for label, quantity in _at(points, labels, kind)
        if quantity.determined
    ]
    for current in group.dark_currents[-1:]:
        known = [q for q in current.quantities if q.determined]
        first = [q for q in known if q.kind == kinds.CURRENT_E] or [
            q for q in known if q.kind == kinds.CURRENT
        ]
        at = "" if current.temperature_c is None else f"{current.temperature_c:g} °C"
        rows += [(emva_tables.title(q.kind), at, emva_tables.cell(q)) for q in first]
    rows += [
        (emva_tables.title(q.kind), "", emva_tables.cell(q))
        for q in group.quantities
        if q.kind == kinds.DOUBLING and q.determined
    ]
    if not rows:
        return []
    text = f"± is one standard error.{' ' if part else ''}{part}"
    columns = ("quantity", "at", "value")
    return [
        Section(
            "numbers", "Dark quantities", text=[text], tables=[Table(columns, rows, words=2)],
            half=True,
        )
    ]  # fmt: skip


def _at(
    points: Sequence[PointQuantities], labels: Sequence[str], kind: Kind
) -> list[tuple[str, Quantity]]:
    return [(at, p.quantities[kind.key]) for at, p in zip(labels, points, strict=True)]


def direct_front(result: Comparison | Diagnosis | Refinement) -> list[Section]:
    """Whether the model states what the frames show directly, and where it differs most."""
    every = list(getattr(result, "direct", []))
    if not every:
        return []
    off = sum(not a.kept for a in every)
    agree = "quantity agrees" if len(every) == 1 else "quantities agree"
    text = f"{len(every) - off} of {len(every)} {agree} within 3 σ or 10 %."
    order = sorted(range(len(every)), key=lambda n: (every[n].kept, -abs(every[n].sigma)))
    rows = [direct_rows(result)[n] for n in order[:DIRECT_ROWS]]
    columns: tuple[str, ...] = ("quantity", *DIRECT[1:])
    if not any(row[1] for row in rows):  # of the whole sensor
        columns, rows = columns[:1] + columns[2:], [row[:1] + row[2:] for row in rows]
    return [
        Section(
            "direct-first", "Model against direct measurement", text=[text],
            tables=[Table(columns, rows, words=columns.index("direct"), narrow=True)], half=True,
        )
    ]  # fmt: skip


def classifier_front(told: Classification | None) -> list[Section]:
    """The classifier's answer in a sentence."""
    if told is None:
        return []
    return [
        Section("classifier-first", "Classifier two-sample test", text=[told.sentence()], half=True)
    ]
