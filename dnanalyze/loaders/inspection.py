"""``inspect``: what is in a capture folder, and what is missing for a full analysis."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Any

import numpy as np

from dnanalyze.loaders.captures import CaptureSet, OperatingPoint, Setting
from dnanalyze.loaders.thermometer import tells_slope

_LOOKS = 8  # frames that are read for their codes
_FEW_FRAMES = 8  # below this, variances between frames are known to worse than about 50 %


def inspect(captures: CaptureSet) -> dict[str, Any]:
    """List what a capture set holds, as plain data ready for JSON.

    Reads one frame of up to eight settings, to see which codes are used.

    Parameters
    ----------
    captures : CaptureSet
        From ``load`` or ``simulate``.

    Returns
    -------
    dict
        "frames", "format", "dtype", "shape", "bits", "codes" (smallest, largest, step and
        effective bits seen), "cfa", "black_level", "white_level", "pixel_pitch_um",
        "system_gain_dn_e", "masked" (whether optical black comes along), "tolerance_c",
        "operating_points", "taken_from" (of each quantity every source, with the number of frames
        and one example), "notes" (what is doubtful), and "missing": a sentence for each thing that
        limits the analysis.

    Examples
    --------
    >>> import dnanalyze
    >>> from dnanalyze.demo import tiny
    >>> dnanalyze.inspect(tiny())["shape"]
    [64, 64]
    """
    sensor, source = captures.sensor, captures.source
    seen = _codes(captures)
    return {
        "frames": captures.frame_count,
        "format": ", ".join(source.formats) if source else "simulation",
        "dtype": source.dtype if source else "float32",
        "region": source.region if source else "active",
        "shape": list(sensor.shape),
        "bits": sensor.bits,
        "codes": seen,
        "cfa": None if sensor.cfa is None else ["".join(row) for row in sensor.cfa],
        "black_level": sensor.black_level,
        "white_level": sensor.white_level,
        "pixel_pitch_um": sensor.pixel_pitch_um,
        "system_gain_dn_e": sensor.system_gain_dn_e,
        "masked": all(f.masked is not None for f in captures.frames()),
        "tolerance_c": source.tolerance_c if source else None,
        "operating_points": [_operating_point(s) for s in captures.settings],
        "taken_from": [asdict(t) for t in source.taken] if source else [],
        "notes": list(captures.notes),
        "missing": missing(captures),
    }


def missing(captures: CaptureSet) -> list[str]:
    """What these frames cannot tell, a sentence each."""
    points = [s.point for s in captures.settings]
    counts = [len(s.frames) for s in captures.settings]
    said = []
    if max(counts) == 1:
        said.append(
            "Every operating point has a single frame: DSNU and temporal dark noise cannot be "
            "separated."
        )
    elif min(counts) == 1:
        said.append(
            f"A single frame at {counts.count(1)} of {len(counts)} operating points: there, "
            "DSNU and temporal dark noise cannot be separated."
        )
    if 1 < max(counts) < _FEW_FRAMES:
        said.append(
            f"At most {max(counts)} frames at an operating point: temporal noise of a pixel, "
            "RTS pixels and drift are measured poorly; 16 or more are better."
        )
    return said + _missing_temperature(points) + _missing_exposure(points)


def _missing_temperature(points: list[OperatingPoint]) -> list[str]:
    known = [p.temperature_c for p in points if p.temperature_c is not None]
    if not known:
        return [
            "No temperature is recorded: no activation energy and no law over temperature; "
            "add temperature_c to a manifest."
        ]
    said = []
    if len(known) < len(points):
        said.append(
            f"{len(points) - len(known)} of {len(points)} operating points have no temperature "
            "and are excluded from the laws over temperature."
        )
    if not tells_slope(known):
        said.append(
            "One temperature only: no activation energy, and no effect can be identified by its "
            "dependence on temperature."
        )
    return said


def _missing_exposure(points: list[OperatingPoint]) -> list[str]:
    exposures = [p.exposure_s for p in points if p.exposure_s is not None]
    if not exposures:
        return [
            "No exposure is recorded: dark current is known per frame and not per second; "
            "add exposure_s to a manifest."
        ]
    said = []
    if len(exposures) < len(points):
        said.append(
            f"{len(points) - len(exposures)} of {len(points)} operating points have no exposure."
        )
    if len(set(exposures)) == 1 and exposures[0] > 0:
        temperatures = (p.temperature_c for p in points)
        by = "by temperature alone" if tells_slope(temperatures) else "not at all"
        said.append(
            f"One exposure only: dark current and offsets are separated {by}; "
            "bias frames or a second exposure would help."
        )
    if max(exposures) == 0:
        said.append("Bias frames only: they contain no dark current.")
    return said


def _operating_point(setting: Setting) -> dict[str, Any]:
    temperatures = [f.point.temperature_c for f in setting.frames]
    known = [t for t in temperatures if t is not None]
    point = setting.point
    return {
        "temperature_c": point.temperature_c,
        "temperature_span_c": [min(known), max(known)] if known else None,
        "exposure_s": point.exposure_s,
        "gain": point.gain,
        "channel": point.channel,
        "black_level": setting.black_level,
        "frames": len(setting.frames),
        "first": setting.frames[0].name,
    }


def _codes(captures: CaptureSet) -> dict[str, Any]:
    """Smallest and largest code and the step between codes over a few frames.

    The effective bits are those of the largest code counted in steps: 12-bit data shifted up to
    16 bits have a step of 16.
    """
    settings = captures.settings
    chosen = np.unique(np.linspace(0, len(settings) - 1, min(_LOOKS, len(settings))).astype(int))
    lows, highs, step = [], [], 0
    for index in chosen:
        array = settings[index].frames[0].read()
        lows.append(float(array.min()))
        highs.append(float(array.max()))
        if array.dtype.kind in "iu":
            step = math.gcd(step, int(np.gcd.reduce(array, axis=None)))
    integer = step > 0
    return {
        "smallest": min(lows),
        "largest": max(highs),
        "step": step if integer else None,
        "effective_bits": max(1, (int(max(highs)) // step).bit_length()) if integer else None,
    }
