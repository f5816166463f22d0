"""Several settings of the black level: they change no dark current and are kept apart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from dnanalyze.loaders.recording import Metadata

MAX_SETTINGS = 8  # settings; more is a number that the program counts or measures


def settled(frames: Sequence[Metadata]) -> tuple[list[Metadata], str]:
    """Frames of one gain with several offsets as channels, one for each offset.

    Parameters
    ----------
    frames : sequence of Metadata

    Returns
    -------
    frames : list of Metadata
    note : str
        What was done, or "".
    """
    own: dict[tuple[str | None, float | None], set[float]] = {}
    for m in frames:
        if m.offset is not None:
            own.setdefault((m.channel, m.gain), set()).add(m.offset)
    several = max(own.values(), key=len, default=set())
    if len(several) < 2:
        return list(frames), ""
    shown = ", ".join(f"{v:g}" for v in sorted(several)[:MAX_SETTINGS])
    if len(several) > MAX_SETTINGS:
        return list(frames), (
            f"The header's offset differs from frame to frame ({shown}, ...); it is not used, and "
            "frames of several black levels may stand in one operating point."
        )
    done = [
        m
        if m.offset is None
        else replace(m, channel=" ".join(filter(None, (m.channel, f"offset {m.offset:g}"))))
        for m in frames
    ]
    return done, f"The black level was set to {shown}; each setting is taken as a channel."
