"""Which settings of a capture set are saturated, from a few frames of each."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from dnanalyze.analyzers.estimators.saturation import Saturation, saturation
from dnanalyze.loaders.captures import CaptureSet, Setting

LOOKS = 4  # frames of a setting: each doubles what the variance of a pixel tells, 4 are plenty
ROWS = 1024  # of each frame, evenly spread, that are looked at
SPOKEN_OF = 0.1  # share of the pixels from which it is said


def saturated_settings(captures: CaptureSet) -> list[Saturation]:
    """For each setting, from where its pixels are clipped or saturated.

    A full well is the sensor's: where it shows at one setting it holds at the others of that gain
    and channel, whose frames may be too few to show it.
    """
    stacks = [_some(s) for s in captures.settings]
    own = [saturation(stack) for stack in stacks]
    wells: dict[object, float] = {}
    for setting, seen in zip(captures.settings, own, strict=True):
        if seen.plateau:
            key = (setting.point.gain, setting.point.channel)
            wells[key] = min(seen.high, wells.get(key, np.inf))
    out = []
    for setting, stack, seen in zip(captures.settings, stacks, own, strict=True):
        well = wells.get((setting.point.gain, setting.point.channel), np.inf)
        share = float(np.mean(stack >= well))
        held = replace(seen, high=well, high_share=share, plateau=True)
        out.append(held if share > seen.high_share else seen)
    return out


def notes(captures: CaptureSet, ends: list[Saturation]) -> list[str]:
    """A sentence for each setting of which a tenth of the pixels, or more, are saturated."""
    return [
        f"{setting.point.label()}: {seen.words()}"
        + ("; its mean dark signal and noise are not those of the sensor." if seen.most else ".")
        for setting, seen in zip(captures.settings, ends, strict=True)
        if seen.share >= SPOKEN_OF
    ]


def unsaturated(captures: CaptureSet) -> tuple[CaptureSet, list[str]]:
    """Without the settings most of whose pixels are saturated, and a note for each.

    As given where that would leave none.
    """
    ends = saturated_settings(captures)
    kept = tuple(s for s, seen in zip(captures.settings, ends, strict=True) if not seen.most)
    said = notes(captures, ends)
    return (replace(captures, settings=kept) if kept else captures), said


def _some(setting: Setting) -> np.ndarray:
    frames = [frame.read() for frame in setting.frames[:LOOKS]]
    step = max(1, frames[0].shape[0] // ROWS)
    return np.stack([frame[::step] for frame in frames])
