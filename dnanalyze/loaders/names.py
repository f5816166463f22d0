"""What folder and file names say: ``T+065C/dark_exp_0.05s_gain4.tif``.

The patterns ask for a delimiter before and after, and for a unit or a key word, so that serial
numbers, dates and binning factors (``2x2``) are not read as measurements.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from dnanalyze.errors import InputError
from dnanalyze.loaders.matching import named_groups
from dnanalyze.loaders.physical import fault
from dnanalyze.loaders.recording import Metadata

NAMED = ("temperature_c", "exposure_s", "gain", "channel", "frame")

_START = r"(?<![A-Za-z0-9.])"  # a number or key word begins here
_END = r"(?![A-Za-z0-9])"
_NUMBER = r"\d{1,6}(?:[.p]\d+)?"

_TEMPERATURES = (
    # T+065C, temp_25, T=-7.5C
    re.compile(
        rf"{_START}t(?:emp(?:erature)?)?[_=]?(?P<sign>[+-]|m|neg)?(?P<value>\d{{1,3}}(?:\.\d+)?)"
        rf"_?(?:deg|°)?_?c{_END}",
        re.IGNORECASE,
    ),
    # t025 and temp_25: two digits at least (t1, t2 count frames) or the key word
    re.compile(
        rf"{_START}(?:t(?P<sign>[+-]|m|neg)?(?P<value>\d{{2,3}}(?:\.\d+)?))(?:deg|°)?{_END}(?!\.\d)",
        re.IGNORECASE,
    ),
    re.compile(
        rf"{_START}temp(?:erature)?[_=]?(?P<sign>[+-]|m|neg)?(?P<value>\d{{1,3}}(?:\.\d+)?)"
        rf"(?:deg|°)?{_END}",
        re.IGNORECASE,
    ),
    # 65C, m10C, -7.00C; digits may follow only a decimal fraction (-7.00C00003216)
    re.compile(
        r"(?:(?<![A-Za-z0-9.])(?P<sign>[+-]|m|neg|minus)|(?<![A-Za-z0-9.+-]))"
        r"(?P<value>\d{1,3}(?:\.\d+)?)"
        r"_?(?:deg|°)?_?c(?:(?![A-Za-z0-9])|(?<=\.\d\dc)(?=\d)|(?<=\.\dc)(?=\d))",
        re.IGNORECASE,
    ),
)
_UNITS = {"us": 1e-6, "ms": 1e-3, "s": 1.0, "sec": 1.0, "secs": 1.0, "second": 1.0, "seconds": 1.0}
_UNIT = r"(?P<unit>us|ms|secs?|seconds?|s)"
_EXPOSURES = (
    re.compile(
        rf"{_START}(?:t|exp(?:os(?:ure)?|time)?)[_=-]?(?P<value>{_NUMBER})_?{_UNIT}{_END}",
        re.IGNORECASE,
    ),
    re.compile(rf"{_START}(?P<value>{_NUMBER})_?{_UNIT}{_END}", re.IGNORECASE),
    re.compile(
        rf"{_START}exp(?:os(?:ure)?|time)[_=-]?(?P<value>{_NUMBER})(?P<unit>){_END}", re.IGNORECASE
    ),
)
_GAIN = re.compile(rf"{_START}gain[_=-]?(?P<value>{_NUMBER})_?(?P<unit>x|db)?{_END}", re.IGNORECASE)
_ISO = re.compile(rf"{_START}iso[_=-]?(?P<value>\d{{2,7}}){_END}", re.IGNORECASE)
_CHANNEL = re.compile(rf"{_START}(hcg|lcg|lofic|long|short){_END}(?![_ -]?exp)", re.IGNORECASE)
_COLDEST, _HOTTEST = -200.0, 300.0


def from_names(parts: Sequence[str]) -> Metadata:
    """What the names say; ``parts`` from the file's stem outwards through its folders.

    A hyphen between a word and a number ("dark-10C") may be a minus or a dash, and is not read;
    "dark_-10C", "T-10C" and "m10C" are.

    Examples
    --------
    >>> from_names(["dark_exp_0.05s_003", "T+065C"])
    Metadata(temperature_c=65.0, exposure_s=0.05, gain=None, channel=None, frame=None)
    """
    metadata = Metadata()
    for part in parts:
        metadata = metadata.or_else(
            Metadata(_temperature(part), _exposure(part), _gain(part), _channel(part))
        )
    return metadata


def from_regex(pattern: str, paths: Sequence[str]) -> list[Metadata]:
    """What the user's own expression finds in the path of each file.

    Raises
    ------
    InputError
        No regular expression, unknown groups, a group that should be a number and is not, or one
        out of its range.
    """
    groups, found = named_groups(pattern, paths)
    if not groups or groups - set(NAMED):
        raise InputError(f"name_regex: needs named groups out of: {', '.join(NAMED)}")
    return [_said(values, path) for values, path in zip(found, paths, strict=True)]


def _said(values: Mapping[str, str | None], path: str) -> Metadata:
    def number(name: str) -> float | None:
        text = values.get(name)
        if text is None:
            return None
        try:
            value = float(text)
        except ValueError as error:
            raise InputError(
                f"{path}: name_regex takes {name} from {text[:40]!r}, which is no number"
            ) from error
        if wrong := fault(name, value):
            raise InputError(f"{path}: name_regex: {wrong}")
        return value

    return Metadata(
        number("temperature_c"), number("exposure_s"), number("gain"), values.get("channel"),
        number("frame"),
    )  # fmt: skip


def _temperature(text: str) -> float | None:
    for pattern in _TEMPERATURES:
        for match in pattern.finditer(text):
            value = float(match["value"])
            if (match["sign"] or "").lower() in ("-", "m", "neg", "minus"):
                value = -value
            if _COLDEST <= value <= _HOTTEST:
                return value
    return None


def _exposure(text: str) -> float | None:
    for pattern in _EXPOSURES:
        match = pattern.search(text)
        if match:
            return _value(match) * _UNITS[match["unit"].lower() or "s"]
    return None


def _gain(text: str) -> float | None:
    match = _GAIN.search(text)
    if match:
        if (match["unit"] or "").lower() == "db":
            return 10.0 ** (_value(match) / 20.0)
        return _value(match)
    match = _ISO.search(text)
    return float(match["value"]) if match else None


def _channel(text: str) -> str | None:
    match = _CHANNEL.search(text)
    return match[1].lower() if match else None


def _value(match: re.Match[str]) -> float:
    return float(match["value"].lower().replace("p", "."))
