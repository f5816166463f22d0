"""Numbers and verdicts in words, the same in the terminal and on the page."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

FAMILIES = {
    "level": "Level and noise",
    "distribution": "Distribution",
    "tails": "Hot-pixel tail",
    "spectrum": "Spectrum",
    "lines": "Rows and columns",
    "neighbours": "Neighbours",
    "time": "Time",
    "codes": "Codes",
    "shading": "Shading",
    "trends": "Over temperature",
}


def family_title(name: str) -> str:
    """Heading of a family of statistics."""
    return FAMILIES.get(name, name.replace("_", " ").capitalize())


def is_number(value: Any) -> bool:
    """A finite number, not a truth value."""
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def number(value: Any, digits: int = 3) -> str:
    """Short text of a number: ``digits`` significant, no exponent where it reads well without."""
    if not is_number(value):
        return "–"
    if value == 0:
        return "0"
    size = abs(value)
    if size >= 1e6 or size < 1e-4:
        mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
        return (
            f"{mantissa.rstrip('0').rstrip('.') if '.' in mantissa else mantissa}e{int(exponent)}"
        )
    decimals = max(0, digits - 1 - math.floor(math.log10(size)))
    text = f"{value:.{decimals}f}"
    return text.rstrip("0").rstrip(".") if "." in text else text


def with_error(value: Any, error: Any, unit: str = "") -> str:
    """``1.23 ± .04 DN``, the error to two digits and the value to the same decimal place."""
    tail = f" {unit}" if unit and unit != "1" else ""
    if not (is_number(value) and is_number(error)) or error <= 0:
        return number(value, 4) + tail
    decimals = max(0, 1 - math.floor(math.log10(error)))
    if decimals > 6 or abs(value) >= 1e6:
        return f"{number(value, 4)} ± {number(error, 2)}{tail}"
    return f"{value:.{decimals}f} ± {error:.{decimals}f}{tail}"


POINT_FORMS = {"temperature_c": "{:.4g} °C", "exposure_s": "{:.4g} s", "gain": "gain {:.4g}"}


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
    """A p-value; below what numbers can hold it is said to be so."""
    return "< 1e-300" if p == 0 else number(p, 2)


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
            parts.append(form.format(get(key)))
    if get("plane"):
        parts.append(str(get("plane")))
    return ", ".join(parts) or "one setting"


def gap(measured: Any, simulated: Any, unit: str = "", scale: str = "") -> str:
    """The plain size of a difference: dB between powers, else %, else the difference itself."""
    if not (is_number(measured) and is_number(simulated)):
        return "–"
    if unit in ("DN^2", "DN²") and measured > 0 and simulated > 0:
        return f"{10 * math.log10(measured / simulated):+.1f} dB"
    if measured == simulated:
        return "0 %"
    bare = scale == "linear" and unit in ("", "1")  # correlations, shares: the difference says more
    if not bare and simulated != 0 and measured * simulated > 0:
        percent = 100 * (measured / simulated - 1)
        if percent > 900:
            return f"×{number(measured / simulated, 2)}"
        return f"{percent:+.1f} %" if abs(percent) < 10 else f"{percent:+.0f} %"
    tail = f" {unit}" if unit and unit != "1" else ""
    return f"{'+' if measured > simulated else '−'}{number(abs(measured - simulated), 2)}{tail}"


def closeness(error: Any) -> str:
    """What an error means."""
    if not is_number(error):
        return "the model could not be held against these frames"
    if error < 1.3:
        return "the model is as close to this sensor as a second one of its make would be"
    if error < 2:
        return "the model is close to this sensor, yet a small part of it is missing"
    if error < 5:
        return "the model misses part of this sensor"
    return "the model misses much of this sensor"


def sentence(text: str) -> str:
    """With a capital and a full stop; a name such as ``column_fpn`` keeps its letters."""
    text = text.strip()
    if not text:
        return text
    first = text[0] if "_" in text.split()[0] else text[0].upper()
    return first + text[1:] + ("" if text[-1] in ".!?" else ".")


def listing(names: Iterable[str]) -> str:
    """``a, b and c``."""
    items = list(names)
    if len(items) < 2:
        return "".join(items)
    return f"{', '.join(items[:-1])} and {items[-1]}"


def plural(count: int, noun: str) -> str:
    """``1 frame``, ``2 frames``."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def compare_headline(error: Any, baselines: Mapping[str, Any]) -> str:
    """The verdict of a comparison in one sentence, the Gaussian beside it."""
    text = f"Error {number(error)}: {closeness(error)}"
    gaussian = baselines.get("gaussian")
    if is_number(error) and is_number(gaussian):
        text += f"; a plain Gaussian of the same mean and spread errs by {number(gaussian)}"
    return sentence(text)


def diagnose_headline(found: Any) -> str:
    """The verdict of a diagnosis in one sentence."""
    candidates, ordinary = list(found.candidates), found.ordinary
    every = f"what every sensor has ({listing(ordinary)})"
    falls = f"the error falls from {number(found.error)} to "
    put_in = [number(c.error_after) for c in candidates if c.effect in ordinary]
    if found.verdict == "adequate":
        return (
            "Adequate: nothing is missing that these frames could show "
            f"(error {number(found.error)})."
        )
    if found.verdict == "missing" and candidates and candidates[0].effect in ordinary:
        return (
            f"Missing: {every}; with it {falls}{put_in[-1]}, and nothing else is missing that "
            "these frames could show."
        )
    if found.verdict == "missing" and candidates:
        best = candidates[0]
        beside, it = (f", beside {every}", "all of it") if ordinary else ("", "it")
        text = (
            f"Missing: {best.effect}, with {percent(best.confidence)} confidence{beside}; "
            f"with {it} {falls}{number(best.error_after)}"
        )
        if best.confused_with:
            rivals = listing(best.confused_with)
            text += f". These frames cannot always tell it from {rivals}"
        return sentence(text)
    if ordinary:
        return (
            f"Unexplained: with {every} {falls}{put_in[-1]}; something else is missing, and no "
            "effect of the catalogue accounts for it."
        )
    return (
        f"Unexplained: something is missing (error {number(found.error)}), "
        "and no effect of the catalogue accounts for it."
    )


def with_remarks(headline: str, result: Any) -> str:
    """A headline, and what else it must say: a law that was put in, a level that is not kept."""
    law, level = getattr(result, "law", ""), getattr(result, "level", None)
    more = [sentence(law)] if law else []
    if level is not None and not level.kept:
        more.append(sentence(level_words(level)))
    return " ".join([headline, *more])


def level_words(level: Any) -> str:
    """How far the mean dark level is off at its worst operating point."""
    share = "" if level.relative is None else f"{number(100 * abs(level.relative), 2)} %, "
    where = ", ".join(filter(None, (point_label(level.point), level.plane)))
    return (
        f"the mean dark level at {where} is off by {number(abs(level.difference_dn), 2)} DN "
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


def refine_headline(steps: list[Any], verdict: str) -> str:
    """The verdict of a refinement in one sentence."""
    first, last = steps[0].error, steps[-1].error
    added = net_additions([s.added for s in steps])
    if not added:
        text = f"Nothing was added; the error stays at {number(first)}"
    else:
        text = f"The error falls from {number(first)} to {number(last)} with {listing(added)}"
    ending = {
        "adequate": "nothing is left to find in these frames",
        "missing": "more could be added, but was not asked for",
        "unexplained": "what remains is in no catalogue",
    }
    return sentence(f"{text}; {ending.get(verdict, verdict)}")


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
