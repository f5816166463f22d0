"""Several gains whose unit the files do not say: a linear factor, or a camera's own scale."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from dnanalyze.loaders.recording import Doubt, Metadata

UNIT = "gain unit"  # kind of the doubt that a header without a unit raises


def settled(
    frames: Sequence[Metadata], per_electron: Sequence[float | None]
) -> tuple[list[Metadata], str]:
    """Gains in proportion to DN per electron, as far as the files tell.

    One gain needs no unit. Of several, each with its own conversion factor in the files, the
    factor is the gain; otherwise the numbers stand as linear factors, and the note says so.

    Parameters
    ----------
    frames : sequence of Metadata
    per_electron : sequence of float or None
        DN/e- of each frame, where its file states it.

    Returns
    -------
    frames : list of Metadata
    note : str
        What was done or is doubtful, or "".
    """
    asked = [any(d.kind == UNIT for d in m.doubts) for m in frames]
    plain = [replace(m, doubts=tuple(d for d in m.doubts if d.kind != UNIT)) for m in frames]
    gains = {m.gain for m, a in zip(plain, asked, strict=True) if a}
    if len(gains) < 2:
        return plain, ""
    shown = ", ".join("0" if g is None else f"{g:g}" for g in sorted(gains, key=lambda g: g or 0))
    pairs = {(m.gain, k) for m, k, a in zip(plain, per_electron, asked, strict=True) if a}
    if len(pairs) == len({k for _, k in pairs}) == len(gains) and all(k for _, k in pairs):
        taken = ("header EGAIN", "")
        done = [
            replace(m, gain=k, taken=dict(m.taken) | {"gain": taken}) if a else m
            for m, k, a in zip(plain, per_electron, asked, strict=True)
        ]
        return done, f"The gains {shown[:80]} have no unit; EGAIN of each is used, in DN/e-."
    return plain, (
        f"The gains {shown[:80]} have no unit and are taken as linear factors; where the camera "
        "counts in dB or steps of its own, give the factors as gain in a manifest."
    )


def without_unit(text: str) -> Doubt:
    """The doubt of a header whose gain has no unit."""
    return Doubt("gain", UNIT, text)
