"""What folder and file names say: ``T+065C/dark_exp_0.05s_gain4.tif``.

The patterns ask for a delimiter before and after, and for a unit or a key word, so that serial
numbers, dates and binning factors (``2x2``) are not read as measurements.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from dnanalyze.errors import InputError
from dnanalyze.loaders.matching import named_groups
from dnanalyze.loaders.physical import ABSOLUTE_ZERO, fault
from dnanalyze.loaders.recording import Doubt, Metadata
from dnanalyze.loaders.units import plain_minus

NAMED = ("temperature_c", "exposure_s", "gain", "channel", "frame")

_START = r"(?<![A-Za-z0-9.])(?<!\d,)"  # a number or key word begins here
_END = r"(?![A-Za-z0-9])"
_NUMBER = r"\d{1,6}(?:[.,p]\d+)?(?:e[+-]?\d{1,2})?"
_SIGN = r"(?P<sign>[+-]|m|neg)?"
_DEGREES = r"\d{1,3}(?:[.,p]\d+)?"
_C = r"(?P<gap>[_ ]?)(?P<degree>deg|°)?[_ ]?c"

_TEMPERATURES = (
    # T+065C, temp_25C, T=-7.5C
    re.compile(
        rf"{_START}(?P<key>t(?:emp(?:erature)?)?)[_=]?{_SIGN}(?P<value>{_DEGREES}){_C}{_END}",
        re.IGNORECASE,
    ),
    re.compile(
        rf"{_START}(?P<key>temp(?:erature)?)[_=]?{_SIGN}(?P<value>{_DEGREES})(?:deg|°)?{_END}",
        re.IGNORECASE,
    ),
    # 65C, m10C, -7.00C; digits may follow only a decimal fraction (-7.00C00003216)
    re.compile(
        rf"(?:{_START}(?P<sign>[+-]|m|neg|minus)|(?<![A-Za-z0-9.+-])(?<!\d,))"
        rf"(?P<value>{_DEGREES}){_C}(?:(?![A-Za-z0-9])|(?<=\.\d\dc)(?=\d)|(?<=\.\dc)(?=\d))",
        re.IGNORECASE,
    ),
    # t025, without a unit: two digits at least, for t1 and t2 count frames
    re.compile(
        rf"{_START}(?P<bare>t){_SIGN}(?P<value>\d{{2,3}}(?:[.,]\d+)?)(?:deg|°)?{_END}(?!\.\d)",
        re.IGNORECASE,
    ),
)
_KELVIN = re.compile(rf"{_START}(?P<value>\d{{2,3}}(?:[.,]\d+)?)_?K{_END}")  # 4K is a frame size
_KELVIN_FROM, _KELVIN_TO = 20.0, 400.0
# "1_30s" may be 1/30 s, "exp1_5s" 1.5 s, or the number ahead an index
_AHEAD = re.compile(r"(?:(?<![A-Za-z0-9.,-])|(?<=exp)|(?<=exposure))([1-9]\d?)_$", re.IGNORECASE)
_MAYBE_TEMPERATURE = re.compile(r"c|k|t(?:[+-]|m|neg)?\d|temp", re.IGNORECASE)
_MINUS_OR_DASH = re.compile(rf"(?<=[A-Za-z0-9])-{_DEGREES}(?:deg|°)?c{_END}", re.IGNORECASE)
_UNITS = {
    "us": 1e-6, "µs": 1e-6, "usec": 1e-6, "ms": 1e-3, "msec": 1e-3, "s": 1.0, "sec": 1.0,
    "secs": 1.0, "second": 1.0, "seconds": 1.0, "min": 60.0, "mins": 60.0, "minutes": 60.0,
    "h": 3600.0, "hour": 3600.0, "hours": 3600.0,
}  # fmt: skip
_UNIT = r"(?P<gap>[_ ]?)(?P<unit>[uµ]s|[um]sec|ms|secs?|seconds?|s|min(?:ute)?s?|h(?:ours?)?)"
_EXPOSURES = (
    re.compile(
        rf"{_START}(?P<key>t|exp(?:os(?:ure)?|time)?)[_=-]?(?P<value>{_NUMBER}){_UNIT}{_END}",
        re.IGNORECASE,
    ),
    re.compile(rf"{_START}(?P<value>{_NUMBER}){_UNIT}{_END}", re.IGNORECASE),
    re.compile(
        rf"{_START}(?P<key>exp(?:os(?:ure)?|time))[_=-]?(?P<value>{_NUMBER})(?P<unit>){_END}",
        re.IGNORECASE,
    ),
)
_TO = r"(?:[-~]|\.\.|_?to_?)"
_RANGES = {  # ends before and behind a value of the same kind: 20-25C, 1s..5s
    kind: (
        re.compile(rf"(?<![\d.-])([1-9]\d*|0?[.,]\d+|0)(?:{unit})?{_TO}$", re.IGNORECASE),
        re.compile(rf"{_TO}[-+]?\d{{1,6}}(?:[.,p]\d+)?[_ ]?(?:{unit}){_END}", re.IGNORECASE),
    )
    for kind, unit in (("C", "(?:deg|°)?c"), ("s", r"[um]?s|secs?|min"))
}
_GAIN = re.compile(rf"{_START}gain[_=-]?(?P<value>{_NUMBER})_?(?P<unit>x|db)?{_END}", re.IGNORECASE)
_ISO = re.compile(rf"{_START}iso[_=-]?(?P<value>\d{{2,7}}){_END}", re.IGNORECASE)
_CHANNEL = re.compile(rf"{_START}(hcg|lcg|lofic|long|short){_END}(?![_ -]?exp)", re.IGNORECASE)
_COLDEST, _HOTTEST = -271.0, 300.0


def from_names(parts: Sequence[str]) -> Metadata:
    """What the names say; ``parts`` from the file's stem outwards through its folders.

    A hyphen between a word and a number ("dark-10C") may be a minus or a dash, and is not read;
    "dark_-10C", "T-10C" and "m10C" are.

    Examples
    --------
    >>> from_names(["dark_exp_0.05s_003", "T+065C"])
    Metadata(temperature_c=65.0, exposure_s=0.05, gain=None, channel=None, frame=None)
    """
    return from_folder([parts])[0]


def from_folder(files: Sequence[Sequence[str]]) -> list[Metadata]:
    """What the names of all files say, each with the others in view.

    A number that may be an index ("t003", "003_c") is a temperature or an exposure only where no
    name says one plainly, and where it does not count up by one from file to file.

    Parameters
    ----------
    files : sequence of sequence of str
        For each file its stem and its folders, outwards.

    Returns
    -------
    list of Metadata
        One for each file; ``frame`` is the index where one counts.
    """
    known: dict[str, _Name] = {}
    for text in (text for parts in files for text in parts):
        if text not in known:
            known[text] = _Name.of(text)
    named = [[known[text] for text in parts] for parts in files]
    counting = _counting(named)
    before = _numbers_ahead(known.values())
    return [_metadata(parts, counting, before) for parts in named]


@dataclass(frozen=True)
class _Said:
    """One value that a name says.

    ``index`` where it may count frames; ``doubt`` is what is doubtful about it; ``ahead`` is a
    number before it that belongs to it, unless it counts files.
    """

    value: float | None
    text: str
    index: bool = False
    doubt: str = ""
    ahead: str = ""


@dataclass(frozen=True)
class _Name:
    """One part of a path, and what it says plainly or perhaps."""

    text: str
    said: Mapping[str, tuple[_Said, ...]]

    @classmethod
    def of(cls, text: str) -> _Name:
        plain = plain_minus(text[:500]).replace("\u2103", "°C").replace("\u03bc", "µ")
        return cls(text, {"temperature_c": _temperatures(plain), "exposure_s": _exposures(plain)})

    @property
    def shape(self) -> str:
        """The name without its digits."""
        return re.sub(r"\d+", "#", self.text)


def _counting(files: Sequence[Sequence[_Name]]) -> set[tuple[str, str]]:
    """(quantity, shape of the name) whose possible indices count up by one."""
    values: dict[tuple[str, str], set[float]] = {}
    for parts in files:
        for part in parts:
            for quantity, found in part.said.items():
                for said in found:
                    if said.index and said.value is not None:
                        values.setdefault((quantity, part.shape), set()).add(said.value)
    return {
        key
        for key, own in values.items()
        if len(own) > 1 and all(v == int(v) for v in own) and max(own) - min(own) == len(own) - 1
    }


def _numbers_ahead(names: Iterable[_Name]) -> set[str]:
    """Shapes of names in which the number ahead of a value is always the same."""
    ahead: dict[str, set[str]] = {}
    for name in names:
        for said in name.said["exposure_s"]:
            if said.ahead:
                ahead.setdefault(name.shape, set()).add(said.ahead)
    return {shape for shape, own in ahead.items() if len(own) == 1}


def _metadata(parts: Sequence[_Name], counting: set[tuple[str, str]], before: set[str]) -> Metadata:
    found: dict[str, Any] = {}
    taken: dict[str, tuple[str, str]] = {}
    doubts: list[Doubt] = []
    unread: list[Doubt] = []

    def take(quantity: str, value: Any, text: str) -> None:
        if quantity not in found and value is not None:
            found[quantity] = value
            taken[quantity] = ("name", text)

    for perhaps in (False, True):
        for part in parts:
            for quantity, choices in part.said.items():
                counts = (quantity, part.shape) in counting
                for said in (s for s in choices if s.index == perhaps):
                    if perhaps and counts:
                        take("frame", said.value, said.text)
                        continue
                    if said.doubt and quantity not in found:
                        text = f"{said.text!r} in the name {said.doubt}"
                        doubt = Doubt(quantity, f"{quantity} {said.doubt}", text)
                        (unread if said.value is None else doubts).append(doubt)
                    if said.ahead and said.value and part.shape in before and quantity not in found:
                        text = (
                            f"{said.text!r} in the name, behind {said.ahead!r}, is taken as "
                            f"{said.value:g} s; where both are one number, a manifest settles it"
                        )
                        doubts.append(Doubt(quantity, "ahead", text))
                    take(quantity, said.value, said.text)
    for part in parts:
        gain, text = _gain(part.text)
        take("gain", gain, text)
        channel = _CHANNEL.search(part.text)
        take("channel", channel and channel[1].lower(), channel[1] if channel else "")
    doubts += [d for d in unread if d.about not in found]
    return Metadata(**found, taken=taken, doubts=tuple(doubts))


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


def _temperatures(text: str) -> tuple[_Said, ...]:
    """What may be temperatures, C, by how plainly it is one."""
    if not _MAYBE_TEMPERATURE.search(text):  # most names; the patterns take 50 us
        return ()
    found = []
    for pattern in _TEMPERATURES:
        for match in pattern.finditer(text):
            groups = match.groupdict()
            value = _value(match)
            if (groups["sign"] or "").lower() in ("-", "m", "neg", "minus"):
                value = -value
            if not _COLDEST <= value <= _HOTTEST:
                continue
            bare = bool(groups.get("bare"))
            apart = bool(groups.get("gap")) and not groups.get("degree")
            counted = groups["value"].startswith("0") and not groups["sign"]
            index = bare or ((apart or counted) and not (groups.get("key") or "x")[1:])
            doubt = ""
            if bare:
                doubt = (
                    "has no unit; taken as a temperature, C (a manifest or name_regex settles it)"
                )
            elif apart and index:
                doubt = "may be an index; taken as a temperature, C"
            elif groups["sign"] == "m" and match[0].endswith("c"):
                doubt = f"is read as {value:g} C; where it is a name, a manifest settles it"
            found.append(_ranged("C", text, match, _Said(value, match[0], index, doubt)))
    for match in _KELVIN.finditer(text):
        value = float(match["value"].replace(",", "."))
        if _KELVIN_FROM <= value <= _KELVIN_TO:
            celsius = round(value + ABSOLUTE_ZERO, 6)
            doubt = f"is taken as kelvin, {celsius:g} C"
            found.append(_Said(celsius, match[0], doubt=doubt))
    found += [
        _Said(None, m[0], doubt="may begin with a minus or a dash; not used")
        for m in _MINUS_OR_DASH.finditer(text)
    ]
    return tuple(found)


def _exposures(text: str) -> tuple[_Said, ...]:
    """What may be exposures, s, by how plainly it is one."""
    found = []
    for pattern in _EXPOSURES:
        for match in pattern.finditer(text):
            groups = match.groupdict()
            value = _value(match) * _UNITS[groups["unit"].lower() or "s"]
            index = (
                groups.get("gap") == "_"
                and groups["unit"].lower() == "s"
                and (not groups.get("key"))
            )
            doubt = "may be an index; taken as an exposure, s" if index else ""
            before = _AHEAD.search(text, max(0, match.start() - 12), match.start())
            whole = groups["value"].isdigit() and groups["unit"] and not groups.get("key")
            ahead = before[1] if before and whole else ""
            found.append(_ranged("s", text, match, _Said(value, match[0], index, doubt, ahead)))
    return tuple(found)


def _ranged(kind: str, text: str, match: re.Match[str], said: _Said) -> _Said:
    """The same, or no value where the number is an end of a range: 20-25C, 1s..5s."""
    ahead, behind = _RANGES[kind]
    before = ahead.search(text, max(0, match.start() - 20), match.start())
    after = behind.match(text, match.end())
    low = before and float(before[1].replace(",", "."))
    if (low is not None and low < _value(match)) or after:
        return replace(said, value=None, index=False, doubt="is part of a range; not used")
    return said


def _gain(text: str) -> tuple[float | None, str]:
    match = _GAIN.search(text)
    if match:
        if (match["unit"] or "").lower() == "db":
            return 10.0 ** (_value(match) / 20.0), match[0]
        return _value(match), match[0]
    match = _ISO.search(text)
    return (float(match["value"]), match[0]) if match else (None, "")


def _value(match: re.Match[str]) -> float:
    return float(re.sub("[,p]", ".", match["value"].lower()))
