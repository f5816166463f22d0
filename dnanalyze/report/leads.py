"""The answer of a report in plain words: what is wrong with the sensor, or that nothing is."""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import cache
from typing import TYPE_CHECKING

from dnanalyze.model.registry import BASE, BASELINE
from dnanalyze.report.significant_structure import Structure, beyond, sentence_of
from dnanalyze.report.words import (
    SURE,
    closeness,
    leading,
    listing,
    net_additions,
    percent,
    sentence,
    statistics_named,
)

if TYPE_CHECKING:
    from dnanalyze.comparator.compare import Comparison
    from dnanalyze.diagnosis.results import Diagnosis, Refinement, Step

CAPITALS = {
    name: name.upper() for name in ("adc", "cds", "cfa", "dc", "dn", "dpc", "dsnu", "fpn", "hdr",
                                    "prnu", "rts")
}  # fmt: skip
NOTHING = "No fault is visible in these captures"


def plain_name(effect: str) -> str:
    """``column_fpn`` as a reader says it: column FPN."""
    return " ".join(CAPITALS.get(part, part) for part in effect.split("_"))


@cache
def _code_names() -> re.Pattern[str]:
    """Of effects; a single word, such as denoise, is none, nor is the start of a parameter's."""
    from dnanalyze.model.registry import built_in

    names = "|".join(name for name in built_in() if "_" in name)
    return re.compile(rf"\b({names})\b(?!\.\w)")


def worded(text: str) -> str:
    """A sentence with effects as a reader says them in place of their code names.

    Examples
    --------
    >>> from dnanalyze.report.leads import worded
    >>> worded("add row_noise"), worded("set row_noise.sigma")
    ('add row noise', 'set row_noise.sigma')
    """
    return _code_names().sub(lambda found: plain_name(found[0]), text)


def summary_of(effect: str) -> str:
    """The catalogue's line on an effect, without its full stop; empty for one it does not know."""
    from dnanalyze.model.registry import catalogue

    kind = catalogue().get(effect)
    text = kind.summary.rstrip(".") if kind is not None else ""
    return text[:1].lower() + text[1:]


def explained(effect: str) -> str:
    """``column FPN (fixed vertical stripes: every column has its own offset)``."""
    text = summary_of(effect)
    return plain_name(effect) + (f" ({text})" if text else "")


def compare_lead(result: Comparison) -> str:
    """Whether the model describes the sensor, and where it fails most."""
    text = sentence(closeness(result.error, result.unexplained))
    if result.adequate:
        return text
    lacking = lacks(result)
    if lacking is not None:
        return f"{text} It lacks {sentence_of(lacking, result.measured)}."
    worst = next(iter(result.failures), "")
    return f"{text} {sentence(worst)}" if worst else text


def lacks(result: Comparison) -> Structure | None:
    """The plainest structure of the sensor that the model lacks; None where it lacks none."""
    if result.adequate:
        return None
    return next(iter(beyond(result.measured, result.simulated)), None)


def diagnose_lead(found: Diagnosis) -> str:
    """What the sensor has that the model lacks."""
    best = leading(found)
    if found.verdict == "adequate":
        return f"{NOTHING}: the model describes the sensor, and no effect is missing in it."
    if not found.finished:
        return "Not finished: the time limit ended the search before every effect was tested."
    if found.verdict == "missing" and best is not None:
        if best.effect in found.ordinary:
            return f"{NOTHING}: the model only lacks noise that every sensor has."
        return f"The sensor has {_named([best.effect], [best.confidence])}, which the model lacks."
    left = statistics_named(found.unexplained)
    return "The sensor has a residual that no effect of the catalogue explains" + (
        f"; it appears in: {left}." if left else "."
    )


def refine_lead(result: Refinement) -> str:
    """What the sensor has beyond the noise of every sensor."""
    sure = {s.added: s.confidence for s in result.steps}
    found = named_effects(result.steps)
    rest = ""
    if not result.finished:
        rest = " The search is not finished."
    elif result.verdict == "unexplained":
        rest = " A residual remains that no effect of the catalogue explains."
    elif result.verdict == "missing":
        rest = " The search stopped before everything was explained."
    if found:
        named = _named(found, [sure.get(n) for n in found])
        return f"In addition to the noise of every sensor, this sensor has {named}.{rest}"
    if rest:
        return f"No effect was found in addition to the noise that every sensor has.{rest}"
    return f"{NOTHING}: it has the noise of every sensor, and no other effect is detectable."


def named_effects(steps: Sequence[Step]) -> list[str]:
    """Effects that a refinement added and kept, without those that every sensor has."""
    kept = net_additions([s.added for s in steps])
    return list(dict.fromkeys(n for n in kept if n not in (*BASELINE, BASE)))


def _named(effects: Sequence[str], sure: Sequence[float | None]) -> str:
    """One with its explanation, several by name; what is not sure says how sure it is."""
    first = explained if len(effects) == 1 else plain_name
    texts = [
        f"possibly {first(n)} ({percent(p)})" if p is not None and p < SURE else first(n)
        for n, p in zip(effects, sure, strict=True)
    ]
    return listing(texts, "; " if any("," in t for t in texts) else ", ")
