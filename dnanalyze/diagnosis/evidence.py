"""Evidence in words: what an effect puts right, and what its rivals leave wrong."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dnanalyze.analyzers.catalogue import catalogue as infos
from dnanalyze.analyzers.statistics import Scale
from dnanalyze.comparator.words import listed, misfit, short_labels
from dnanalyze.fitting.least_squares import State
from dnanalyze.fitting.predictor import Bench
from dnanalyze.model.effect import Effect

CLEAR = 3.0  # floors


@dataclass(frozen=True)
class Profile:
    """Size of the misfit of each statistic, pooled over settings and both halves, in floors."""

    names: np.ndarray
    size: np.ndarray

    def of(self, name: str) -> float:
        """Root mean square misfit of a statistic; 0 where it is absent."""
        where = np.flatnonzero(self.names == name)
        return float(self.size[where[0]]) if where.size else 0.0


def profile(bench: Bench, state: State) -> Profile:
    """Misfit by statistic."""
    names = np.concatenate([bench.train.names, bench.test.names])
    z = np.minimum(np.abs(np.concatenate([state.train, state.test])), 1e4)
    unique, inverse = np.unique(names, return_inverse=True)
    size = np.sqrt(np.bincount(inverse, z**2) / np.bincount(inverse))
    return Profile(unique, size)


def evidence_for(
    bench: Bench, before: State, after: State, effect: type[Effect], most: int = 3
) -> list[str]:
    """Sentences on the statistics that the effect puts right, most telling first."""
    was, now = profile(bench, before), profile(bench, after)
    relief = {n: was.of(n) ** 2 - now.of(n) ** 2 for n in was.names}
    for name in effect.fingerprint:  # of statistics that tell as much, the effect's own come first
        if name in relief:
            relief[name] *= 1.5
    ranked = sorted(relief, key=lambda n: -relief[n])
    told: list[str] = []
    for name in ranked:
        if len(told) >= most or was.of(name) < CLEAR or relief[name] <= 0:
            break
        told.append(
            f"{_sentence(bench, before, name)}; with {effect.name} in, "
            f"{was.of(name):.0f} floors become {now.of(name):.1f}"
        )
    character = {
        "fixed": "the same in every frame: a pattern of the silicon or the readout",
        "temporal": "new in every frame: noise, not a pattern",
    }.get(effect.varies)
    if told and character:
        told.append(character)
    return told


def evidence_against(
    bench: Bench, rival: State, best: State, rival_name: str, name: str
) -> str | None:
    """What the rival leaves wrong that the best candidate puts right."""
    left, right = profile(bench, rival), profile(bench, best)
    gap = {n: left.of(n) - right.of(n) for n in left.names}
    worst = max(gap, key=lambda n: gap[n])
    if gap[worst] < CLEAR:
        return None
    title = infos()[worst].title
    return (
        f"{rival_name} instead of {name} would leave {title} {left.of(worst):.1f} floors off, "
        f"against {right.of(worst):.1f}"
    )


def _sentence(bench: Bench, state: State, name: str) -> str:
    """Measured over modelled for one statistic and how it runs over the operating points."""
    info = infos()[name]
    train = bench.train
    here = np.flatnonzero(train.names == name)
    if not here.size:
        return info.title
    z = state.train[here]
    off = np.abs(z) > CLEAR
    worst = int(np.argmax(np.abs(z)))
    i = here[worst]
    model = train.coordinates[i] - state.train[i] * train.floor[i]
    measured, simulated = float(train.values[i]), info.scale.plain(float(model))
    words = misfit(info, measured, simulated, float(z[worst]))
    unit = "" if info.unit == "1" else f" {info.unit}"
    size = f"{measured:.3g} against {simulated:.3g}{unit}"
    if info.scale is Scale.LOG and "{ratio}" not in info.high:
        size = f"{measured / simulated:.3g} times the model"
    settings = train.setting[here]
    if len(set(settings)) == 1:
        where = ""
    elif off.all():
        where = ", at every operating point"
    else:
        places = sorted({int(s) for s in settings[off]})
        names = short_labels([point for point, _ in bench.plan.settings])
        where = ", at " + listed([names[s] for s in places[:3]])
        where += " and more" if len(places) > 3 else ""
    return f"{words} ({size}{where})"
