"""Evidence in sentences, and recommended captures."""

from __future__ import annotations

import numpy as np

from dnanalyze.analyzers.catalogue import catalogue as infos
from dnanalyze.analyzers.statistics import Scale
from dnanalyze.comparator.error import SATURATION
from dnanalyze.comparator.words import listed, misfit, short_labels, side_by_side
from dnanalyze.diagnosis.results import Candidate
from dnanalyze.digits import number, unit_text
from dnanalyze.fitting.problem import FitProblem
from dnanalyze.fitting.state import State
from dnanalyze.model.effect import Effect
from dnanalyze.model.registry import built_in
from dnanalyze.significance import STATED


def profile(problem: FitProblem, state: State) -> dict[str, float]:
    """Root mean square misfit of each statistic, over operating points and both halves."""
    names = np.concatenate([problem.train.names, problem.test.names])
    z = np.minimum(np.abs(np.concatenate([state.train, state.test])), SATURATION)
    unique, inverse = np.unique(names, return_inverse=True)
    size = np.sqrt(np.bincount(inverse, z**2) / np.bincount(inverse))
    return dict(zip(unique.tolist(), size.tolist(), strict=True))


def evidence_for(
    problem: FitProblem, before: State, after: State, effect: type[Effect], most: int = 3
) -> list[str]:
    """Sentences on the statistics that the effect corrects, largest first.

    Its own come before others: these may be off because the model without it made up for it.
    """
    was, now = profile(problem, before), profile(problem, after)
    relief = {n: was[n] ** 2 - now[n] ** 2 for n in was}
    closer = [n for n in relief if relief[n] > 0 and _size(was, n) != _size(now, n)]
    own = [n for n in closer if n in effect.fingerprint and was[n] >= max(STATED, 2.0 * now[n])]
    closer.sort(key=lambda n: (n not in own, -relief[n]))
    sentences = [
        f"{_sentence(problem, before, name)}; with {effect.name} "
        f"the difference falls from {_size(was, name)} to {_size(now, name)} sigma"
        for name in [n for n in closer if was[n] >= STATED][:most]
    ]
    if not sentences:
        sentences = [_in_sum(effect.name, was, now, closer[:most])]
    character = {
        "fixed": "it is the same in every frame: a nonuniformity of the pixels or of the readout",
        "temporal": "it differs from frame to frame: temporal noise, not a nonuniformity",
    }.get(effect.varies)
    return [*sentences, character] if character else sentences


def _size(of: dict[str, float], name: str) -> str:
    return number(of[name], 2)


def _in_sum(effect: str, was: dict[str, float], now: dict[str, float], names: list[str]) -> str:
    """The sum of many small corrections, where no single one is large."""
    if not names:
        return f"no statistic comes closer with {effect}"
    parts = [f"{infos()[n].title} (from {_size(was, n)} to {_size(now, n)} sigma)" for n in names]
    return (
        f"no single statistic that {effect} improves differed by {STATED:g} sigma before; "
        f"several small differences fall, the largest in {', '.join(parts)}"
    )


def evidence_against(
    problem: FitProblem, rival: State, best: State, rival_name: str, name: str
) -> str | None:
    """Statistics that the best candidate corrects and the competitor does not."""
    left, right = profile(problem, rival), profile(problem, best)
    gap = {n: left[n] - right[n] for n in left}
    worst = max(gap, key=lambda n: gap[n])
    if gap[worst] < STATED:
        return None
    title = infos()[worst].title
    return (
        f"with {rival_name} instead of {name} the difference in {title} is {left[worst]:.1f} "
        f"sigma, not {right[worst]:.1f} sigma"
    )


def _sentence(problem: FitProblem, state: State, name: str) -> str:
    """Measured over modelled for one statistic and how it runs over the operating points."""
    info = infos()[name]
    train = problem.train
    here = np.flatnonzero(train.names == name)
    if not here.size:
        return info.title
    z, model = state.train[here], train.predicted(state.train)[here]
    finite = np.isfinite(model)
    if not finite.any():
        return f"the model shows nothing of it: {info.title}"
    worst = int(np.argmax(np.where(finite, np.abs(z), -1.0)))
    # the held-out half may be the one that differs
    off = np.abs(z) >= min(STATED, abs(z[worst]))
    i = here[worst]
    measured, simulated = float(train.values[i]), info.scale.plain(float(model[worst]))
    reproducibility_sd = float(train.reproducibility_sd[i])
    words = misfit(info, measured, simulated, float(z[worst]), reproducibility_sd)
    unit = unit_text(info.unit)
    size = f"measured {number(measured)}, model {number(simulated)}{unit}"
    if side_by_side(info, measured, simulated, reproducibility_sd):
        size = ""
    elif info.scale is Scale.LOG and "{ratio}" not in info.high:
        size = f"{number(measured / simulated)} times the model"
    more = ", ".join(part for part in (size, _places(problem, train.setting[here], off)) if part)
    return f"{words} ({more})" if more else words


def _places(problem: FitProblem, settings: np.ndarray, off: np.ndarray) -> str:
    """At which operating points; nothing where there is but one."""
    if len(set(settings)) == 1:
        return ""
    if off.all():
        return "at every operating point"
    places = sorted({int(s) for s in settings[off]})
    names = short_labels([point for point, _ in problem.plan.settings])
    more = " and more" if len(places) > 3 else ""
    return "at " + listed([names[s] for s in places[:3]]) + more


def next_capture(problem: FitProblem, verdict: str, candidates: list[Candidate]) -> list[str]:
    """Recommended captures, most useful first."""
    points = [p for p, _ in problem.plan.settings]
    frames = [n for _, n in problem.plan.settings]
    advice = []
    if min(frames) < 2:
        advice.append("a second frame at each operating point separates DSNU from temporal noise")
    elif min(frames) < 4:
        advice.append(
            "eight frames at each operating point: with fewer than four, RTS pixels and "
            "temporal filters cannot be separated from noise"
        )
    if candidates and candidates[0].confused_with:
        best = candidates[0]
        advice.append(_to_separate(problem, best.effect, best.confused_with[0]))
    temperatures = {p.temperature_c for p in points if p.temperature_c is not None}
    if len(temperatures) < 3:
        advice.append(
            "at least three temperatures, 20 °C apart: dark current grows with temperature, "
            "readout effects do not"
        )
    exposures = {p.exposure_s for p in points if p.exposure_s is not None}
    if len(exposures) < 2 and verdict != "adequate":
        advice.append(
            "the warmest operating point at a quarter of the exposure: charge effects shrink "
            "with it, readout effects do not"
        )
    return advice


def _to_separate(problem: FitProblem, one: str, other: str) -> str:
    """The capture that tells two effects apart, from what they vary with."""
    known = built_in()
    a, b = known.get(one), known.get(other)
    reason = ""
    if a is not None and other in a.confused_with:
        reason = f": {a.confused_with[other]}"
    if a is not None and b is not None and {a.varies, b.varies} == {"fixed", "temporal"}:
        coldest = problem.plan.settings[0][0].label()
        return f"eight more frames at {coldest} separate {one} from {other}{reason}"
    warmest = problem.plan.settings[-1][0].label()
    return (
        f"eight more frames at {warmest}, and as many at twice the exposure, help to separate "
        f"{one} from {other}{reason}"
    )
