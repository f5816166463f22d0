"""The way of the rival, where that of the effect that was taken ends poor.

While much is missing two effects may explain nearly as much. The better by a hair may lead to where
nothing more can be added, and its refit to where the other is no longer seen; which of them it
should have been, their ends tell.
"""

from __future__ import annotations

from dataclasses import replace

from dnanalyze.diagnosis.completion import POOR
from dnanalyze.diagnosis.confidence import confidences
from dnanalyze.diagnosis.path import Fork, Path, Step
from dnanalyze.diagnosis.trial import error_of, judged, preferred
from dnanalyze.diagnosis.walk import Walk


def by_another_way(walk: Walk, path: Path) -> Path:
    """The path, or that of its nearest fork's other effect, if that ends clearly better.

    Parameters
    ----------
    walk : Walk
    path : Path
        At its end.
    """
    held = walk.held
    if not path.forks or error_of(held, path.state) <= POOR or walk.stops(path):
        return path
    fork = max(path.forks, key=lambda f: f.nearness)
    aside = replace(walk, tell=lambda _: None, keep=lambda _: None)
    other = aside.to_end(aside.add(fork.before, fork.other, 0.0))
    if preferred(path.state, other.state) is path.state or other.error > path.error:
        return _sure_by(walk, fork, path, other)
    kept = _sure_by(walk, fork, other, path)
    before = fork.before
    for name in (n for n in path.state.model.names if before.state.model.get(n) is None):
        walk.tell(Step(f"-{name}", before.error))
    for step in kept.steps[len(before.steps) :]:
        walk.tell(step)
    walk.keep(kept)
    return kept


def _sure_by(walk: Walk, fork: Fork, kept: Path, left: Path) -> Path:
    """The path that was kept, its effect at the fork as sure as both ends make it."""
    was, place = fork.before, len(fork.before.steps)
    ends = [
        judged(walk.held, was.state, str(path.steps[place].added), path.state)
        for path in (kept, left)
    ]
    sure = float(confidences(ends, error_of(walk.held, was.state))[0])
    step = kept.steps[place]
    both = (fork.taken.effect, fork.other.effect)
    near = dict.fromkeys([*step.confused_with, *(e for e in both if e != step.added)])
    step = replace(step, confidence=sure, confused_with=list(near))
    return replace(kept, steps=(*kept.steps[:place], step, *kept.steps[place + 1 :]))
