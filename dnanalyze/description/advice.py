"""Recommended captures for a structure."""

from __future__ import annotations

from dnanalyze.description.layers import Layers
from dnanalyze.model.composite.effect import CompositeEffect

MANY = 16  # frames from which time constants are told


def more_captures(effect: CompositeEffect, seen: Layers) -> list[str]:
    """Captures that would settle what these leave open."""
    points = seen.points
    recommended = []
    if len({p.temperature_c for p in points}) < 3:
        recommended.append("Three temperatures or more: they give the law over temperature.")
    if len({p.exposure_s for p in points}) < 2:
        recommended.append(
            "A second exposure time at the warmest operating point: it separates a dependence "
            "on the dark charge from a dependence on the temperature alone."
        )
    if len({p.gain for p in points}) < 2 and effect.what == "level":
        recommended.append(
            "A second analog gain: the structure is proportional to the gain if it arises before "
            "the amplifier."
        )
    if effect.when == "frame" and max(len(t.frames) for t in seen.taken) < MANY:
        recommended.append(
            f"{2 * MANY} frames at one operating point: they show whether values persist from "
            "frame to frame, and give their distribution."
        )
    return recommended
