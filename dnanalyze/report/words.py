"""Numbers and verdicts in words, the same in the terminal and on the page."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from dnanalyze.comparator.error import TOLERABLE
from dnanalyze.digits import is_number, minus, number, symbol, unit_text, with_error
from dnanalyze.loaders.captures import OperatingPoint

if TYPE_CHECKING:
    from dnanalyze.comparator.compare import Comparison
    from dnanalyze.description.describe import Description
    from dnanalyze.diagnosis.results import Candidate, Diagnosis, Refinement
    from dnanalyze.fitting.agreement import Agreement
    from dnanalyze.fitting.fit import Fit, Parameter
    from dnanalyze.fitting.level import Level
    from dnanalyze.fitting.whole_field import Coverage, Departure


FAMILIES = {
    "level": "Mean dark signal and noise",
    "distribution": "Distribution",
    "tails": "Hot-pixel tail",
    "spectrum": "Spectrum",
    "lines": "Rows and columns",
    "neighbours": "Neighbouring pixels",
    "time": "Frame to frame",
    "codes": "Codes",
    "shading": "Shading",
    "trends": "Over temperature",
}

FILTERS = {
    "dpc": "defect-pixel correction",
    "denoise": "spatial denoise",
    "temporal_denoise": "temporal denoise",
}


def family_title(name: str) -> str:
    """Heading of a family of statistics."""
    return FAMILIES.get(name, name.replace("_", " ").capitalize())


def celsius(value: Any) -> str:
    """``−10.2 °C``."""
    return f"{number(value)} °C"


POINT_FORMS = {
    "temperature_c": celsius,
    "exposure_s": lambda v: f"{number(v)} s",
    "gain": lambda v: f"gain {number(v)}",
}


def varied(rows: Iterable[Mapping[str, Any]]) -> set[str]:
    """The parts of the operating point, and "plane", in which rows differ."""
    seen: dict[str, set[Any]] = {}
    for row in rows:
        for key in (*POINT_FORMS, "channel", "plane"):
            seen.setdefault(key, set()).add(row.get(key))
    return {key for key, values in seen.items() if len(values) > 1}


def percent(share: Any) -> str:
    """A probability or share as text; certainty is never claimed."""
    if not is_number(share):
        return "–"
    if 0 < share < 0.001:
        return "under 0.1 %"
    return "over 99.9 %" if share > 0.999 else f"{100 * share:.3g} %"


def probability(p: Any) -> str:
    """A p-value; below 10⁻³⁰⁰, near what numbers can hold, only that it is."""
    return "< 10⁻³⁰⁰" if is_number(p) and p < 1e-300 else number(p, 2)


def point_label(row: Any, only: Iterable[str] | None = None) -> str:
    """Operating point of a row of a table (mapping or object): ``65 °C, 0.05 s``.

    ``only`` names the parts to say, such as those in which the rows of the table differ.
    """
    only = only or None

    def get(key: str) -> Any:
        if only is not None and key not in only:
            return None
        return row.get(key) if isinstance(row, Mapping) else getattr(row, key, None)

    parts = [str(get("channel"))] if get("channel") is not None else []
    for key, form in POINT_FORMS.items():
        if is_number(get(key)):
            parts.append(form(get(key)))
    if get("plane"):
        parts.append(str(get("plane")))
    return ", ".join(parts) or "one operating point"


def gap(measured: Any, simulated: Any, unit: str = "", scale: str = "") -> str:
    """The plain size of a difference: dB between powers, else %, else the difference itself."""
    if not (is_number(measured) and is_number(simulated)):
        return "–"
    if unit in ("DN^2", "DN²") and measured > 0 and simulated > 0:
        return minus(f"{10 * math.log10(measured / simulated):+.1f} dB")
    if measured == simulated:
        return "0 %"
    bare = scale == "linear" and unit in ("", "1")  # correlations, shares: the difference says more
    if not bare and simulated != 0 and measured * simulated > 0:
        percent = 100 * (measured / simulated - 1)
        if percent > 900:
            return f"×{number(measured / simulated, 2)}"
        return minus(f"{percent:+.1f} %" if abs(percent) < 10 else f"{percent:+.0f} %")
    tail = unit_text(unit)
    sign = "+" if measured > simulated else minus("-")
    return f"{sign}{number(abs(measured - simulated), 2)}{tail}"


def closeness(error: Any, unexplained: Sequence[str] | None = None) -> str:
    """What a model error means.

    ``unexplained``: statistics that differ by more than sensors of the same design do, where that
    is known: a model that leaves none is adequate.
    """
    if not is_number(error):
        return "the model could not be compared with these captures"
    second = "as close to this sensor as a second sensor of the same design"
    adequate = error < TOLERABLE if unexplained is None else not unexplained
    if adequate:
        return f"the model is {second}"
    if unexplained and error < TOLERABLE:
        differ = "differs" if len(unexplained) == 1 else "differ"
        but = f"{statistics_named(unexplained)} {differ} by more than such sensors do"
        return f"on average the model is {second}, but not everywhere: {but}"
    if error < 2:
        return "the model is close to this sensor; differences remain"
    if error < 5:
        return "the model does not describe part of this sensor"
    return "the model does not describe much of this sensor"


def sentence(text: str) -> str:
    """With a capital and a full stop; a name such as ``column_fpn`` keeps its letters."""
    text = text.strip()
    if not text:
        return text
    first = text[0] if "_" in text.split()[0] else text[0].upper()
    return first + text[1:] + ("" if text[-1] in ".!?" else ".")


def listing(names: Iterable[str], between: str = ", ") -> str:
    """``a, b and c``; ``a; b and c`` where they have commas of their own."""
    items = list(names)
    if len(items) < 2:
        return "".join(items)
    return f"{between.join(items[:-1])} and {items[-1]}"


def plural(count: int, noun: str) -> str:
    """``1 frame``, ``2 frames``."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def compare_headline(result: Comparison) -> str:
    """The verdict of a comparison in one sentence, the Gaussian model beside it."""
    error, gaussian = result.error, result.baselines.get("gaussian")
    text = f"Model error {number(error)}: {closeness(error, result.unexplained)}"
    if is_number(error) and is_number(gaussian):
        text += (
            "; a Gaussian model of the same mean and standard deviation has a model error of "
            f"{number(gaussian)}"
        )
    return sentence(text)


SURE = 0.9  # confidence below which an effect is only possible
NAMED = 3  # statistics that a sentence names


def naming(effect: str, confidence: Any) -> str:
    """The name of an effect, ``possibly`` where it is not sure."""
    return f"possibly {effect}" if is_number(confidence) and confidence < SURE else effect


def with_rivals(effect: str, confidence: Any, rivals: Iterable[str]) -> str:
    """The name, with what it may be instead where it is not sure."""
    text, rivals = naming(effect, confidence), list(rivals)
    return f"{text} (or {' or '.join(rivals)})" if rivals and text != effect else text


def statistics_named(names: Sequence[str], most: int = NAMED) -> str:
    """Statistics by their titles, the first few of them."""
    from dnanalyze.analyzers.catalogue import catalogue

    known = catalogue()
    titles = [known[n].title if n in known else n for n in names[:most]]
    if len(names) > most:
        titles.append(f"{len(names) - most} more")
    return listing(titles, "; " if any("," in t for t in titles) else ", ")


def error_way(before: Any, after: Any) -> str:
    """Which way the error goes: it falls, rises, or stays within its own scatter."""
    from dnanalyze.comparator.error import ERROR_SCATTER, way

    if not (is_number(before) and is_number(after)):
        return f"the model error goes from {number(before)} to {number(after)}"
    gone = way(before, after)
    if gone == "stays":
        where = (
            f"stays at {number(after)}"
            if number(before) == number(after)
            else (f"goes from {number(before)} to {number(after)}")
        )
        scatter = f"{100 * ERROR_SCATTER:.0f} % between simulated sensors"
        return f"the model error {where}, within its variation of {scatter}"
    return f"the model error {gone} from {number(before)} to {number(after)}"


def candidates_of(found: Diagnosis) -> tuple[list[Candidate], list[Candidate]]:
    """The candidates of a diagnosis, and apart from them the baseline effects."""
    baseline = [c for c in found.candidates if c.effect in found.ordinary]
    return [c for c in found.candidates if c.effect not in found.ordinary], baseline


def leading(found: Diagnosis) -> Candidate | None:
    """The candidate that a diagnosis names first, or None."""
    others, baseline = candidates_of(found)
    return next(iter(others or baseline), None)


def diagnose_headline(found: Diagnosis) -> str:
    """The verdict of a diagnosis in one sentence, and what else it must say."""
    return with_remarks(_diagnosed(found), found)


def _diagnosed(found: Diagnosis) -> str:
    ordinary = found.ordinary
    baseline = f"the baseline effects ({listing(ordinary)})"
    others, named = candidates_of(found)
    put_in = [c.error_after for c in named]
    if not found.finished:
        return _timed_out(found, others)
    if found.verdict == "adequate":
        return (
            "Adequate: no missing effect is detectable in these captures "
            f"(model error {number(found.error)})."
        )
    if found.verdict == "missing" and found.candidates and found.candidates[0].effect in ordinary:
        return sentence(
            f"Missing: {baseline}; with them {error_way(found.error, put_in[-1])}, and no other "
            "missing effect is detectable in these captures"
        )
    if found.verdict == "missing" and others:
        return _missing(found, others[0], baseline if ordinary else "")
    error = found.error
    text = f"Unexplained: an effect is missing (model error {number(error)})"
    if ordinary:
        error = put_in[-1]
        text = f"Unexplained: with {baseline} {error_way(found.error, error)}"
        text += "; another effect is missing"
    left = statistics_named(found.unexplained)
    if not others:
        return sentence(f"{text}, and no effect of the catalogue explains {left or 'it'}")
    best = others[0]
    nearest = with_rivals(best.effect, best.confidence, best.confused_with)
    text += f". The closest candidate is {nearest}: with it {error_way(error, best.error_after)}"
    if best.leaves:
        return sentence(f"{text}, but it does not explain {statistics_named(best.leaves)}")
    return sentence(f"{text}, but these captures do not support it; not explained: {left}")


def describe_headline(found: Description) -> str:
    """The sentence of a description, and what the structure does to the model error."""
    if not is_number(found.error_after):
        return found.text
    text = f"{found.text} With it {error_way(found.error_before, found.error_after)}"
    text += f", confidence {percent(found.confidence)}"
    if found.verdict == "possible":
        return sentence(f"Possible, not supported by these captures: {text}")
    text += (
        "; the model is then adequate"
        if found.after == "adequate"
        else ("; another structure remains unexplained")
    )
    return sentence(text)


def first_answer(effects: Sequence[str]) -> str:
    """What first-order screening of a quarter of the field expects."""
    return sentence(
        "first answer, from a quarter of the field: first-order screening expects most of "
        f"{listing(effects[:3])}; the search confirms or corrects it"
    )


def _timed_out(found: Diagnosis, others: Sequence[Candidate]) -> str:
    """What is known when the time is up."""
    text = "Not finished: the time limit ended the diagnosis "
    if not others:
        text += f"before a candidate was tested (model error {number(found.error)})"
        if found.screened:
            text += f"; first-order screening expects most of {listing(found.screened[:3])}"
        return sentence(text)
    best = others[0]
    return sentence(
        f"{text}before every candidate was tested; the closest one so far is {best.effect}: with "
        f"it {error_way(found.error, best.error_after)} ({percent(best.confidence)} confidence)"
    )


def _missing(found: Diagnosis, best: Candidate, baseline: str) -> str:
    """What is missing, the model error with it, what it does not explain, the confounders."""
    more, it = (f", in addition to {baseline}", "all of them") if baseline else ("", "it")
    text = (
        f"Missing: {naming(best.effect, best.confidence)}, with {percent(best.confidence)} "
        f"confidence{more}; with {it} {error_way(found.error, best.error_after)}"
    )
    if found.unexplained:
        text += f"; it does not explain {statistics_named(found.unexplained)}"
    if best.confused_with:
        text += f". It is confounded with {listing(best.confused_with)} in these captures"
    return sentence(text)


def with_remarks(headline: str, result: Comparison | Diagnosis | Refinement) -> str:
    """A headline, and what else it must say: a law put in, a mean dark signal that is off."""
    law, level = getattr(result, "law", ""), getattr(result, "level", None)
    more = [sentence(law)] if law else []
    if level is not None and not level.kept:
        more.append(sentence(level_words(level)))
    more += [sentence(direct_words(a)) for a in getattr(result, "direct", []) if not a.kept]
    more += coverage_words(getattr(result, "coverage", None))
    return " ".join([headline, *more])


def coverage_words(seen: Coverage | None) -> list[str]:
    """What a result rests on, where that is not all of the captures, and what is off elsewhere."""
    if seen is None:
        return []
    parts = []
    if seen.settings < seen.all_settings:
        parts.append(f"{seen.settings} of {plural(seen.all_settings, 'operating point')}")
    if seen.frames < seen.all_frames:
        parts.append(f"{seen.frames} of {plural(seen.all_frames, 'frame')}")
    if not seen.whole:
        (rows, columns), window = seen.window.shape, seen.window
        parts.append(
            f"{rows:,} × {columns:,} of {seen.field[0]:,} × {seen.field[1]:,} pixels "
            f"({number(100 * seen.share, 2)} %: from row {window.top:,} and column {window.left:,})"
        )
    made = [sentence(f"this result is based on {listing(parts)}")] if parts else []
    if seen.pooled:
        made.append(
            sentence(
                f"the frames of {seen.pooled} operating points differ by noise and drift alone: "
                f"they count as {seen.pools}"
            )
        )
    if seen.whole or seen.departures is None:
        return made
    if not seen.departures:
        more = "means of blocks, rows and columns deviate from the model no more than inside them"
        return [*made, sentence(f"outside of these pixels, {more}")]
    return [*made, *(sentence(departure_words(d)) for d in seen.departures)]


def departure_words(found: Departure) -> str:
    """Where the rest of the field departs from the model, and by how much."""
    way = "above" if found.difference_dn > 0 else "below"
    noun = "block of 32 × 32 pixels" if found.kind == "blocks" else found.kind[:-1]
    what = f"at the {found.place} a {noun}" if found.kind == "blocks" else found.place
    return (
        f"outside of these pixels, {what} lies {number(abs(found.difference_dn), 2)} DN {way} the "
        f"model at {point_label(found.point)} ({number(found.sigma, 2)} sigma; "
        f"{number(100 * found.share, 2)} % of the {found.kind} deviate)"
    )


def direct_words(found: Agreement) -> str:
    """A quantity of the model that is not what the frames show directly."""
    where = "" if found.point is None else f" at {point_label(found.point)}"
    return (
        f"the {found.quantity}{where} is {with_error(found.direct, found.error)} "
        f"{symbol(found.unit)} by direct measurement and {number(found.model)} in the model"
    )


def direct_rows(result: Fit | Diagnosis | Refinement | Comparison) -> list[tuple[str, ...]]:
    """Quantity, operating point, direct value, model's value and difference of each."""
    return [
        (
            a.quantity,
            "" if a.point is None else point_label(a.point),
            with_error(a.direct, a.error),
            number(a.model),
            symbol(a.unit),
            minus(f"{a.sigma:+.1f} σ") + ("" if a.kept else " (differs)"),
        )
        for a in getattr(result, "direct", [])
    ]


DIRECT = "quantity", "at", "direct", "model", "unit", "difference"


def level_words(level: Level) -> str:
    """How far the mean dark signal is off at its worst operating point."""
    share = (
        "" if level.relative is None
        else f"{number(100 * abs(level.relative), 2)} % of the signal above the black level, "
    )  # fmt: skip
    where = ", ".join(filter(None, (point_label(level.point), level.plane)))
    return (
        f"the {level.statistic} dark signal at {where} is off by "
        f"{number(abs(level.difference_dn), 2)} DN "
        f"({share}{number(level.standard_errors, 2)} standard errors)"
    )


def net_additions(added: Iterable[str | None]) -> list[str]:
    """What was added and stayed: an entry ``-name`` takes that name out again."""
    kept: list[str] = []
    for name in added:
        if name and name.startswith("-"):
            kept = [k for k in kept if k != name[1:]]
        elif name:
            kept.append(name)
    return kept


def refine_headline(result: Refinement) -> str:
    """The verdict of a refinement in one sentence, and what else it must say."""
    return with_remarks(_refined(result), result)


def _refined(result: Refinement) -> str:
    steps, verdict = list(result.steps), result.verdict
    first, last = steps[0].error, steps[-1].error
    by_name = {s.added: s for s in steps}  # the last time that it was added
    added = [
        with_rivals(name, by_name[name].confidence, by_name[name].confused_with)
        for name in net_additions([s.added for s in steps])
    ]
    if not added:
        text = f"No effect was added; {error_way(first, last)}"
    else:
        text = f"{sentence(error_way(first, last))[:-1]} with {listing(added)}"
    if not result.finished:
        why = "the time limit ended the search" if result.timed_out else "not finished"
        return sentence(f"{text}; {why}: the residual was not tested yet")
    left = statistics_named(result.unexplained)
    ending = {
        "adequate": "no further missing effect is detectable in these captures",
        "missing": _stopped(result),
        "unexplained": f"no effect of the catalogue explains the residual in {left}",
    }
    told = result.classification
    if not result.unexplained:
        ending["unexplained"] = "no statistic shows a residual, but the model is not adequate"
    if told is not None and told.tells and not result.unexplained:
        ending["unexplained"] = (
            "no statistic shows a residual, but a classifier distinguishes simulated from "
            "measured frames"
        )
    return sentence(f"{text}; {ending.get(verdict, verdict)}")


def _stopped(result: Refinement) -> str:
    """What is missing yet in a refinement that reached a limit of the user's."""
    found = [] if result.diagnosis is None else list(result.diagnosis.candidates)
    if found:
        best = found[0]
        name = with_rivals(best.effect, best.confidence, best.confused_with)
        return f"the search stopped at the requested limit; the next effect to add is {name}"
    left = statistics_named(result.unexplained)
    return f"the search stopped at the requested limit; the residual was not tested: {left}"


def add_headline(result: Refinement) -> str:
    """What one effect that the user chose does to the model error, and whether it is supported."""
    before, after = result.steps[0], result.steps[-1]
    effect = after.added or ""
    text = f"With {effect} {error_way(before.error, after.error)}"
    if not after.supported:
        text += "; it is not supported by these captures"
    elif naming(effect, after.confidence) != effect:
        text += f"; these captures support it weakly ({percent(after.confidence)} confidence)"
    else:
        text += f"; these captures support it ({percent(after.confidence)} confidence)"
    if result.unexplained:
        left = statistics_named(result.unexplained)
        text += f". The model does not explain {left}; `dnanalyze diagnose` tests other effects"
    elif result.verdict == "adequate":
        text += ". No further missing effect is detectable in these captures"
    return with_remarks(sentence(text), result)


def step_name(added: str | None, place: int) -> str:
    """What happened at a step of a refinement: the start, an addition, a removal (``-name``)."""
    if not added:
        return "start" if place == 0 else "refit"
    return f"without {added[1:]}" if added.startswith("-") else added


def _plain(value: Any) -> str:
    return number(value) if is_number(value) else str(value)


def texts(items: Any) -> list[str]:
    """Sentences from a list, a mapping of names to sentences or numbers, or a single text."""
    if not items:
        return []
    if isinstance(items, str):
        return [sentence(items)]
    if isinstance(items, Mapping):
        return [
            f"{value}." if str(value).startswith(key) else sentence(f"{key}: {_plain(value)}")
            for key, value in items.items()
        ]
    return [sentence(str(item)) for item in items]


def parameter_rows(result: Fit | Refinement) -> tuple[list[tuple[str, str, str, str]], str]:
    """Name, value with standard error, unit and operating point of each parameter.

    Beside them what all those operating points have in common, which the rows leave out.
    """
    points = [_where(p.name, result.model) for p in result.parameters]
    known = [vars(point) for point in points if point is not None]
    apart = varied(known)
    common = {k: v for k, v in (known[0] if known else {}).items() if k not in apart}
    rows = [
        (
            p.name,
            parameter_value(p),
            symbol(p.unit),
            point_label(point, apart) if apart and point is not None else "",
        )
        for p, point in zip(result.parameters, points, strict=True)
    ]
    return rows, point_label(common) if any(v is not None for v in common.values()) else ""


def parameter_value(parameter: Parameter) -> str:
    """A parameter with its standard error, or that the captures do not determine it."""
    if parameter.determined:
        return with_error(parameter.value, parameter.se)
    if parameter.upper is None:
        return "not determined"
    return f"not determined, < {number(parameter.upper, 2)}"


def _where(name: str, model: Any) -> OperatingPoint | None:
    """The operating point at which a model states a parameter; None for an energy."""
    effect, _, rest = name.partition(".")
    parameter, _, part = rest.partition(".")
    if "ea_ev" in (parameter, part):
        return None
    effect, _, row = effect.partition("[")
    if "[" in parameter:
        parameter, _, row = parameter.partition("[")
    bearer = model.get(effect)
    law: Any = model.pedestal if effect == "pedestal" else getattr(bearer, parameter, None)
    number_of_row = row.rstrip("]")
    if hasattr(law, "points") and number_of_row.isdigit():
        found = law.points[int(number_of_row)]
        return replace(model.reference, **{k: v for k, v in vars(found).items() if v is not None})
    if hasattr(law, "at_c"):
        return replace(model.reference, temperature_c=law.at_c)
    return model.reference
