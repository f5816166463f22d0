"""What a capture set is, in facts and in what it lacks."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from dnanalyze.report.words import is_number, number, plural

if TYPE_CHECKING:
    from dnanalyze.loaders.captures import CaptureSet


def title(captures: CaptureSet) -> str:
    """The folder's own name."""
    return str(captures.name).rstrip("/").rsplit("/", 1)[-1] or str(captures.name)


def spread(values: list[float], unit: str) -> str:
    """``25 to 105 °C``, ``0.05 s``, or nothing where nothing is known."""
    known = sorted(set(values))
    if not known:
        return ""
    if len(known) == 1:
        return f"{number(known[0])} {unit}"
    return f"{number(known[0])} to {number(known[-1])} {unit}"


def known(captures: CaptureSet, key: str) -> list[float]:
    """The values of a field of the operating points, where they are known."""
    values = [getattr(s.point, key) for s in captures.settings]
    return [v for v in values if is_number(v)]


def size(shape: tuple[int, int]) -> str:
    """Rows × columns, the order of array shapes, of ``--shape`` and of every frame size stated.

    Examples
    --------
    >>> from dnanalyze.report.capture_facts import size
    >>> size((4000, 6000))
    '4000 × 6000'
    """
    return f"{shape[0]} × {shape[1]}"


def facts(captures: CaptureSet) -> dict[str, str]:
    """What to know of the captures, a word to a few words."""
    sensor = captures.sensor
    counts = sorted({len(s.frames) for s in captures.settings})
    each = f"{counts[0]}" if len(counts) == 1 else f"{counts[0]} to {counts[-1]}"
    made = {
        "frames": f"{captures.frame_count} of {size(sensor.shape)} pixels",
        "operating points": f"{len(captures.settings)}, {each} frame{'s' * (each != '1')} each",
        "temperature": spread(known(captures, "temperature_c"), "°C"),
        "exposure": spread(known(captures, "exposure_s"), "s"),
        "gain": spread(known(captures, "gain"), ""),
        "channels": ", ".join(
            sorted({s.point.channel for s in captures.settings if s.point.channel})
        ),
        "format": ", ".join(captures.source.formats) if captures.source else "",
        "converter": f"{sensor.bits} bit" if sensor.bits else "",
        "black level": f"{sensor.black_level:g} DN" if sensor.black_level is not None else "",
        "colour filter": "/".join("".join(row) for row in sensor.cfa) if sensor.cfa else "",
        "pixel pitch": f"{sensor.pixel_pitch_um:g} µm" if sensor.pixel_pitch_um else "",
        "system gain": f"{sensor.system_gain_dn_e:.4g} DN/e⁻" if sensor.system_gain_dn_e else "",
    }
    return {key: text.strip() for key, text in made.items() if text.strip()}


def one_line(captures: CaptureSet) -> str:
    """``column: 5 operating points, 25 to 105 °C, 30 frames of 384 × 384``."""
    return f"{title(captures)}: {about(captures)}"


def about(captures: CaptureSet) -> str:
    """``5 operating points, 25 to 105 °C, 30 frames of 384 × 384``."""
    sensor = captures.sensor
    channels = list(dict.fromkeys(s.point.channel for s in captures.settings if s.point.channel))
    named = f"channel {channels[0]}" if len(channels) == 1 else plural(len(channels), "channel")
    parts = [
        named if channels else "",
        plural(len(captures.settings), "operating point"),
        spread(known(captures, "temperature_c"), "°C"),
        f"{plural(captures.frame_count, 'frame')} of {size(sensor.shape)}",
    ]
    return ", ".join(p for p in parts if p)


def codes(seen: Mapping[str, Any]) -> dict[str, str]:
    """Range of the codes and the bits that they use, from what `inspect` saw."""
    made = {"values": f"{seen['smallest']:g} to {seen['largest']:g} DN"}
    if seen["step"]:
        step = f", in steps of {seen['step']}" if seen["step"] > 1 else ""
        made["bits in use"] = f"{seen['effective_bits']}{step}"
    return made


QUANTITIES = {
    "temperature_c": "temperature", "exposure_s": "exposure", "gain": "gain",
    "channel": "channel", "frame": "order of frames", "offset": "black level setting",
}  # fmt: skip


def sources(seen: Mapping[str, Any]) -> list[tuple[str, str, str]]:
    """Quantity, where it was taken from, and one example, of what `inspect` saw."""
    rows = []
    for row in seen["taken_from"]:
        frames = "" if row["frames"] == seen["frames"] else f", {plural(row['frames'], 'frame')}"
        example = f"{row['example']} in {row['file']}" if row["example"] else str(row["file"])
        rows.append((QUANTITIES[row["quantity"]], f"{row['source']}{frames}", example))
    return rows
