"""Key words under which headers of all formats keep temperature, exposure and gain."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from typing import Any

from dnanalyze.loaders.recording import Metadata

# First found wins; set points last, for they say what was asked and not what was.
TEMPERATURE = (
    "CCD-TEMP", "CCDTEMP", "CCD_TEMP", "SENSTEMP", "SENSORTEMP", "DET-TEMP", "DETTEMP", "TEMPERAT",
    "CHIPTEMP", "TEMPERATURE_C", "TEMPERATURE", "SENSOR_TEMPERATURE", "SENSORTEMPERATURE",
    "SENSOR TEMPERATURE", "CAMERATEMPERATURE", "TEMPDET", "TEMP", "SET-TEMP", "SETTEMP", "SET_TEMP",
)  # fmt: skip
EXPOSURE = (
    "EXPTIME", "EXPOSURE", "EXP_TIME", "EXPOSURE_S", "EXPOSURETIME", "EXPOSURE_TIME",
    "EXPOSURE TIME", "INTEGRATION_TIME", "INTEGRATIONTIME", "INTTIME", "ITIME", "IMG_EXP",
)  # fmt: skip
GAIN = ("GAIN", "CCDGAIN", "ANALOGGAIN", "ANALOG_GAIN", "ISO", "ISOSPEEDRATINGS", "ISOSPEED")
CHANNEL = ("CHANNEL", "READOUT_CHANNEL", "HDRCHANNEL")
FRAME = ("FRAME", "FRAMENO", "FRAME_NUMBER")
_SECONDS = (("us", 1e-6), ("µs", 1e-6), ("microsec", 1e-6), ("ms", 1e-3), ("millisec", 1e-3))
_NUMBER = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*([^\d\s].*)?$")


def from_header(values: Mapping[str, Any], comments: Mapping[str, str] | None = None) -> Metadata:
    """What a header of keys and values says.

    Parameters
    ----------
    values : mapping
        Keys in any case; numbers, or text that begins with a number and may name its unit.
    comments : mapping, optional
        Key to a comment that may name the unit ("[K] detector", "[ms] exposure").
    """
    upper = {str(k).upper(): v for k, v in values.items()}
    units = {str(k).upper(): v for k, v in (comments or {}).items()}

    def first(names: tuple[str, ...]) -> tuple[float, str] | None:
        for name in names:
            value = _number(upper.get(name))
            if value is not None:
                comment = re.match(r"\s*[\[(]([^\])]*)[\])]", units.get(name, ""))
                return value[0], (value[1] or (comment[1] if comment else "")).strip()
        return None

    temperature, exposure, gain = first(TEMPERATURE), first(EXPOSURE), first(GAIN)
    channel = next((upper[n] for n in CHANNEL if isinstance(upper.get(n), str)), None)
    frame = first(FRAME)
    return Metadata(
        None if temperature is None else _celsius(*temperature),
        None if exposure is None else _seconds(*exposure),
        None if gain is None else gain[0],
        channel.strip() or None if channel else None,
        None if frame is None else frame[0],
    )


def from_text(text: str) -> Metadata:
    """What free text says: JSON, or lines of ``key = value`` or ``key: value``."""
    if len(text) > 1 << 20:
        return Metadata()
    try:
        plain = json.loads(text)
    except (ValueError, RecursionError):
        pairs = re.findall(r"^\s*([A-Za-z][\w \-]{0,40}?)\s*[=:]\s*(.{1,80})$", text, re.MULTILINE)
        return from_header(dict(reversed(pairs)))
    return from_header(plain) if isinstance(plain, dict) else Metadata()


def image_type(values: Mapping[str, Any]) -> str:
    """What IMAGETYP and its like say: "bias", "dark", "light", "flat" or ""."""
    for key in ("IMAGETYP", "IMAGETYPE", "FRAMETYP", "OBSTYPE"):
        text = str(values.get(key, "")).strip().lower()
        for kind, words in (
            ("bias", ("bias", "zero", "offset")),
            ("dark", ("dark",)),
            ("flat", ("flat",)),
            ("light", ("light", "object", "science")),
        ):
            if any(w in text for w in words):
                return kind
    return ""


def bayer_pattern(text: Any) -> tuple[tuple[str, ...], ...] | None:
    """Rows of "RGGB" or "BAYER_RGGB"; None for anything else."""
    match = re.search(r"(RGGB|BGGR|GRBG|GBRG)", str(text).upper())
    return None if match is None else (tuple(match[1][:2]), tuple(match[1][2:]))


def _number(value: Any) -> tuple[float, str] | None:
    if isinstance(value, bool) or value is None:
        return None
    if isinstance(value, (tuple, list)) and len(value) == 2 and value[1]:
        value = value[0] / value[1]  # an EXIF rational
    if isinstance(value, bytes):
        value = value.decode("ascii", "replace")
    if isinstance(value, str):
        match = _NUMBER.match(value)
        return None if match is None else (float(match[1]), match[2] or "")
    try:
        number = float(value)
    except (TypeError, ValueError):
        return None
    return (number, "") if math.isfinite(number) else None


def _celsius(value: float, unit: str) -> float:
    return value - 273.15 if unit.strip().lower() in ("k", "kelvin") else value


def _seconds(value: float, unit: str) -> float:
    text = unit.lower()
    return value * next((scale for word, scale in _SECONDS if text.startswith(word)), 1.0)
