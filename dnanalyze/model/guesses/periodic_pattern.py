"""First guesses of periodic_pattern: its parameters as the statistics suggest them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dnanalyze.model.bounds import bounded
from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.column_taps import ColumnTaps
from dnanalyze.model.effects.periodic_pattern import (
    MAX_LINES,
    PARTS,
    PERIODS,
    RELATIVE,
    PeriodicPattern,
    beats,
    lies_at,
)
from dnanalyze.model.fingerprints import LINE_BANDS, named
from dnanalyze.model.guesses.evidence import shows
from dnanalyze.model.wave import SAME, Wave, strongest_wave, together

_Line = tuple[float, float, float]  # u, v, and amplitude over that of another line

SEEN_SHARE = 0.5  # share of the places with the first line at which a further one shows
WEAKEST = 0.1  # amplitude of a further line over the first's
TAPS = ColumnTaps.parameters()["taps"].choices  # fixed lines at fractions of these are taps


def guess(effect: type[PeriodicPattern], clues: Clues) -> list[Effect]:
    """The lines of the spectrum, off or on its axes, and that alone that stands highest."""
    guesses: list[Effect] = []
    for part, phase in PARTS.items():
        waves = [w for w in clues.waves(part) if _seen(clues, part, w)]
        line = strongest_wave(waves)
        if line is not None and beats(line.v, line.u, clues.field) >= PERIODS:
            further = _further(line, waves, clues, phase)
            several = [_of_lines(effect, line, further, phase)] if further else []
            guesses += [*several, _of_lines(effect, line, [], phase)]
    return guesses


def _of_lines(
    effect: type[PeriodicPattern], first: Wave, further: Sequence[_Line], phase: str
) -> PeriodicPattern:
    """The pattern of these lines, that of the largest amplitude first."""
    lines = sorted([(first.u, first.v, 1.0), *further], key=lambda line: -line[2])
    u, v, most = lines[0]
    more = tuple(n for u, v, relative in lines[1:] for n in (u, v, round(relative / most, 4)))
    return effect(bounded(effect, "amplitude", most * first.amplitude), u, v, phase, more)


def _further(first: Wave, waves: Sequence[Wave], clues: Clues, phase: str) -> list[_Line]:
    """The lines beside the first that have most of its amplitude."""
    own = [w for w in waves if _is_one(w, first, clues)]
    typical = _amplitudes(own)
    found = []
    for line, same in _apart([w for w in waves if w not in own], clues):
        seen = _amplitudes(same)
        relative = float(np.median(seen) / np.median(typical))
        if (
            len(seen) >= SEEN_SHARE * len(typical)
            and WEAKEST <= relative <= RELATIVE[1]
            and beats(line.v, line.u, clues.field) >= PERIODS
            and not (phase == "fixed" and _of_taps(line))
        ):
            found.append((line.u, line.v, relative))
    return sorted(found, key=lambda f: -f[2])[: MAX_LINES - 1]


def _amplitudes(waves: Sequence[Wave]) -> list[float]:
    """Amplitudes of a line, one a place: what a line on an axis has beside it is none of them."""
    shared = max(waves, key=lambda w: w.amplitude).shared
    return [w.amplitude for w in waves if w.shared == shared]


def _apart(waves: Sequence[Wave], clues: Clues) -> list[tuple[Wave, list[Wave]]]:
    """Each line of these once, at the mean of its measurements, and these."""
    lines = []
    left = sorted(waves, key=lambda w: -w.ratio)
    while left:
        same = [w for w in left if _is_one(w, left[0], clues)]
        lines.append((together(left[0], left).folded, same))
        left = [w for w in left if w not in same]
    return lines


def _is_one(wave: Wave, other: Wave, clues: Clues) -> bool:
    """Whether two measurements are of one line, whose frequency may wander within a mode."""
    return wave.is_same(other) or lies_at(wave, other.u, other.v, clues.shape)


def _of_taps(wave: Wave) -> bool:
    """Whether whole columns or rows repeat it, so that taps make it too."""
    f, error = (wave.u, wave.u_error) if wave.shared == "columns" else (wave.v, wave.v_error)
    away = min(abs(f - round(f * period) / period) for period in TAPS)
    return bool(wave.shared) and away < SAME * error


def _seen(clues: Clues, part: str, wave: Wave) -> bool:
    """Whether the model lacks lines such as this one."""
    if not wave.shared:
        return shows(clues, [f"{part}_line"])
    return shows(clues, named(f"{part}_{wave.shared}", LINE_BANDS))
