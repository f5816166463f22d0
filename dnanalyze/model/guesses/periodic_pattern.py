"""First guesses of periodic_pattern: its parameters as the statistics suggest them."""

from __future__ import annotations

from dnanalyze.model.bounds import bounded
from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.periodic_pattern import PARTS, PERIODS, PeriodicPattern, beats
from dnanalyze.model.fingerprints import LINE_BANDS, named
from dnanalyze.model.guesses.evidence import shows
from dnanalyze.model.wave import Wave, strongest_wave


def guess(effect: type[PeriodicPattern], clues: Clues) -> list[Effect]:
    """The line of the spectrum that stands highest over its floor, off or on its axes."""
    guesses: list[Effect] = []
    for part, phase in PARTS.items():
        line = strongest_wave([w for w in clues.waves(part) if _seen(clues, part, w)])
        if line is not None and beats(line.v, line.u, clues.field) >= PERIODS:
            amplitude = bounded(effect, "amplitude", line.amplitude)
            guesses.append(effect(amplitude, line.u, line.v, phase))
    return guesses


def _seen(clues: Clues, part: str, wave: Wave) -> bool:
    """Whether the model lacks lines such as this one."""
    if not wave.shared:
        return shows(clues, [f"{part}_line"])
    return shows(clues, named(f"{part}_{wave.shared}", LINE_BANDS))
