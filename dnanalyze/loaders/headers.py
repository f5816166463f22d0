"""Key words under which headers of all formats keep temperature, exposure and gain."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import replace
from datetime import datetime
from typing import Any

from dnanalyze.loaders.gains import without_unit
from dnanalyze.loaders.physical import ABSOLUTE_ZERO
from dnanalyze.loaders.recording import Doubt, Metadata
from dnanalyze.loaders.units import DEGREES, SECONDS, Reading, read_number, unit_in

# First found wins; set points last, for they say what was asked and not what was. Compared without
# case and punctuation.
TEMPERATURE = (
    "CCD-TEMP", "SENSTEMP", "SENSORTEMP", "DET-TEMP", "TEMPERAT", "CHIPTEMP", "TEMPERATURE_C",
    "TEMPERATURE", "SENSORTEMPERATURE", "CAMERATEMPERATURE", "TEMPDET", "TEMP",
)  # fmt: skip
SET_POINT = ("SET-TEMP", "SETTEMPERATURE", "TARGETTEMPERATURE")
AMBIENT = ("AMBIENTTEMPERATURE",)  # Exif 2.31, of cameras that do not cool
# Names that a camera's driver puts before or behind its own: "Zyla-SensorTemperature",
# "ESO DET CHIP1 TEMP".
_OF_SENSOR = re.compile(
    r"(?:CCD|CMOS|CHIP|SENSOR|DETECTOR|DET|CAMERA|CAM|FPA|FOCALPLANE)\d*"
    r"(?:TEMP|TEMPERATURE|TEM)\d?[CK]?$|^TEMP(?:CCD|CHIP|SENSOR|DETECTOR|DET|CAM)\d?$"
)
_SENSOR = ("CCDTEMP", "SENSTEMP", "DETTEMP", "CHIPTEMP", "TEMPDET")
_NOT_OF_SENSOR = re.compile(
    r"ambient|air|outside|weather|focus|dome|mirror|tube|telescope|lens|board|electronic|housing"
    r"|heat ?sink|hot side|chiller|coolant|target|set ?point|setpoint|requested"
)
EXPOSURE = (
    "EXPTIME", "EXPOSURE", "XPOSURE", "EXPOSURE_S", "EXPOSURETIME", "INTEGRATIONTIME", "INTTIME",
    "ITIME", "IMGEXP", "EXPOINUS", "TELAPSE", "ELAPTIME", "ONTIME",
)  # fmt: skip
DARK_TIME = ("DARKTIME",)  # while charge collects, where EXPTIME is that of the shutter
GAIN = ("GAIN", "CCDGAIN", "ANALOGGAIN", "ANALOGUEGAIN", "ISO", "ISOSPEEDRATINGS", "ISOSPEED")
CHANNEL = ("CHANNEL", "READOUTCHANNEL", "HDRCHANNEL")
# The black level that was set; PEDESTAL is what a program added to the codes.
OFFSET = ("OFFSET", "BLKLEVEL", "CAMOFFSET", "PEDESTAL")
FRAME = ("FRAME", "FRAMENO", "FRAMENUMBER")
TYPE = (
    "IMAGETYP", "IMAGETYPE", "IMGTYPE", "FRAMETYP", "FRAMETYPE", "FRAME", "OBSTYPE", "EXPTYPE",
    "CCDTYPE", "ESODPRTYPE",
)  # fmt: skip

COLDEST, HOTTEST = -271.0, 200.0  # C: helium under vacuum; beyond, silicon holds no charge
# No sensor is specified above 150 C (grade 0 of AEC-Q100); 150 to 400 K is -123 to 127 C.
KELVIN_FROM, KELVIN_TO = 150.0, 400.0
WARM = 70.0  # C; cameras that write FITS are cooled, and 70 to 150 is as likely kelvin
OFF_SET_POINT = 5.0  # C; a regulated sensor keeps within 1
LONG = 1e4  # s; single dark frames are not longer, for cosmic rays cover them in an hour or two
ROUNDED_S = 1e-3
EXPOSURE_TOLERANCE = 0.01  # of two exposures in one header, as the tolerance of exposures
_PER_ELECTRON = re.compile(
    r"(?:\be-?|\belectrons?|\bel(?:ec)?\.?|\bph(?:otons?)?)\s*(?:/|per|p)\s*(?:adu|dn|count|lsb)"
    r"|\bepadu\b"
)
_PER_DN = re.compile(r"(?:adu|dn|counts?|lsb)\s*(?:/|per)\s*(?:e\b|electron)")
_TENTHS = re.compile(r"\bzwo\b|\basi ?\d{3,4}")  # cameras whose gain is in 0.1 dB by their manual
_FACTORS = ("gain", "AnalogueGain")  # our own attribute, and libcamera's: factors by definition
_LINEAR = re.compile(r"\bx\b|factor|linear|(?:adu|dn|counts?|lsb)\s*(?:/|per)\s*e")
_LINE = re.compile(
    r"^\s*([A-Za-z][\w \-]{0,40}?(?:[\[(][^\])\n]{1,20}[\])])?)\s*[=:]\s*(.{1,80})$", re.MULTILINE
)
_KEY_WITH_UNIT = re.compile(r"(?P<key>[^\[(]*\w)\s*(?P<unit>[\[(][^\])]{1,20}[\])])\s*")
_DECIBEL = re.compile(r"(?:(?P<part>0?[.,]\d+|1/\d+)\s*)?db\b")


def from_header(values: Mapping[str, Any], comments: Mapping[str, str] | None = None) -> Metadata:
    """What a header of keys and values says.

    Parameters
    ----------
    values : mapping
        Keys in any case; numbers, or text that begins with a number and may name its unit.
    comments : mapping, optional
        Key to a comment that may name the unit ("[K] detector", "exposure (ms)").

    Returns
    -------
    Metadata
        With what it was taken from, and what is doubtful about it.
    """
    header = _Header(values, comments)
    header.temperature()
    header.exposure()
    header.gain()
    for name in CHANNEL:
        text = header.values.get(_plain(name))
        if isinstance(text, str) and text.strip():
            header.take("channel", text.strip(), _plain(name))
            break
    for quantity, names in (("offset", OFFSET), ("frame", FRAME)):
        if (found := header.first(names)) is not None:
            header.take(quantity, found[1].value, found[0])
    return Metadata(**header.found, taken=header.taken, doubts=tuple(header.doubts))


def from_text(text: str) -> Metadata:
    """What free text says: JSON, or lines of ``key = value`` or ``key: value``."""
    if len(text) > 1 << 20:
        return Metadata()
    try:
        plain = json.loads(text)
    except (ValueError, RecursionError):
        return from_header(dict(reversed(lines_of(text))))
    return from_header(plain) if isinstance(plain, dict) else Metadata()


def lines_of(text: str) -> list[tuple[str, str]]:
    """Keys and values of lines ``key = value`` or ``key: value``."""
    return _LINE.findall(text)


def image_type(values: Mapping[str, Any]) -> str:
    """What IMAGETYP and its like say: "bias", "dark", "light", "flat" or ""."""
    plain = {_plain(k): v for k, v in values.items()}
    for key in TYPE:
        text = str(plain.get(key, "")).strip().lower()
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


class _Header:
    """One header, and what has been found in it."""

    def __init__(self, values: Mapping[str, Any], comments: Mapping[str, str] | None) -> None:
        self.keys: dict[str, str] = {}
        self.values: dict[str, Any] = {}
        self.comments = {_plain(k): v for k, v in (comments or {}).items()}
        for name, value in reversed(list(values.items())):
            match = _KEY_WITH_UNIT.fullmatch(str(name)[:80])  # "Exposure (ms)"
            key = _plain(match["key"] if match else name)
            self.keys[key], self.values[key] = str(name), value
            if match:
                self.comments[key] = match["unit"]
        self.cooled = comments is not None  # FITS
        self.found: dict[str, Any] = {}
        self.taken: dict[str, tuple[str, str]] = {}
        self.doubts: list[Doubt] = []

    def take(self, quantity: str, value: Any, key: str) -> None:
        """Keep a value and where it stands."""
        self.found[quantity] = value
        shown = _shown(self.values[key])
        comment = self.comments.get(key, "").strip()[:40]
        shown += f" / {comment}" if comment else ""
        self.taken[quantity] = (f"header {self.keys[key]}", shown)

    def doubt(self, about: str, key: str, text: str) -> None:
        """Keep a doubt; ``text`` follows ``KEY = value``."""
        shown = f"{self.keys[key]} = {_shown(self.values[key])}"
        self.doubts.append(Doubt(about, f"{key} {text.split(' ')[0]}", f"{shown} {text}"))

    def reading(self, key: str, about: str) -> Reading | None:
        """The number under a key; a doubt where it holds something else."""
        value = self.values.get(key)
        reading = read_number(value)
        if reading is None:
            if value is not None and not isinstance(value, bool) and str(value).strip():
                self.doubt(about, key, "is no number; taken as unknown")
            return None
        if reading.unsure:
            self.doubt(about, key, f"is taken as {reading.value:g} and may be {reading.unsure}")
        return reading

    def first(self, names: tuple[str, ...]) -> tuple[str, Reading] | None:
        """The first of the keys that holds a number."""
        for name in names:
            if (reading := read_number(self.values.get(_plain(name)))) is not None:
                return _plain(name), reading
        return None

    def temperature(self) -> None:
        """The sensor's temperature, C, or else its set point."""
        asked = self._temperature_of(SET_POINT)
        known = self._temperature_of((*TEMPERATURE, *filter(_of_sensor, self.values)))
        if known is None:
            around = asked or self._temperature_of(AMBIENT)
            if around is not None:
                key, value = around
                what = "the set point" if asked else "that of the air"
                self.take("temperature_c", value, key)
                self.doubt("temperature_c", key, f"is {what}; the sensor's is not measured")
            return
        key, value = known
        self.take("temperature_c", value, key)
        for other in (k for k in self.values if k != key and (k in _SENSOR or _of_sensor(k))):
            also = self._temperature_of((other,))
            if also is not None and abs(also[1] - value) > OFF_SET_POINT:
                self.doubt(
                    "temperature_c",
                    other,
                    f"contradicts {self.keys[key]}, which is used: {value:g} C",
                )
                break
        if asked is not None and abs(asked[1] - value) > OFF_SET_POINT:
            self.doubt(
                "temperature_c", key,
                f"is {abs(asked[1] - value):.3g} C off the set point {asked[1]:g} C; the cooler "
                "was off or had not settled",
            )  # fmt: skip

    def _temperature_of(self, names: tuple[str, ...]) -> tuple[str, float] | None:
        for key in dict.fromkeys(map(_plain, names)):
            if key not in self.values:
                continue
            comment = self.comments.get(key, "")
            other = names is not SET_POINT and _NOT_OF_SENSOR.search(comment.lower())
            if other and not re.search(r"ccd|cmos|sensor|detector|chip", comment.lower()):
                self.doubt(
                    "temperature_c", key,
                    f"is by its comment of something else ({comment[:40]}); not used",
                )  # fmt: skip
                continue
            reading = self.reading(key, "temperature_c")
            if reading is None:
                continue
            value = self._celsius(key, reading, comment)
            if value is not None:
                return key, value
        return None

    def _celsius(self, key: str, reading: Reading, comment: str) -> float | None:
        value = reading.value
        unit = DEGREES.get(reading.unit.lower().rstrip("."))
        if unit is None and (named := unit_in(comment, DEGREES)):
            unit = named[1]
        if unit is None and key.endswith(("TEMPK", "TEMPERATUREK")):
            unit = "K"
        if unit is None and KELVIN_FROM < value <= KELVIN_TO:
            unit = "K"
            self.doubt(
                "temperature_c", key,
                f"is taken as kelvin, {value + ABSOLUTE_ZERO:.5g} C; no sensor works at "
                f"{value:g} C",
            )  # fmt: skip
        elif unit is None and self.cooled and WARM <= value <= KELVIN_FROM:
            self.doubt(
                "temperature_c", key,
                f"has no unit; taken as C, in kelvin it would be {value + ABSOLUTE_ZERO:.5g} C: "
                "a manifest with temperature_c settles it",
            )  # fmt: skip
        if unit == "K":
            value += ABSOLUTE_ZERO
        elif unit == "F":
            value = (value - 32.0) / 1.8
        if COLDEST < value <= HOTTEST:
            return value
        self.doubt("temperature_c", key, "is no temperature of a sensor; taken as unknown")
        return None

    def exposure(self) -> None:
        """The exposure, s; that of the charge where the shutter's is 0 or unknown."""
        stated = self._seconds_of(EXPOSURE)
        dark = self._seconds_of(DARK_TIME)
        if dark is not None and dark[1] > 0 and (stated is None or stated[1] <= 0):
            self.take("exposure_s", dark[1], dark[0])
            if stated is not None:
                self.doubt(
                    "exposure_s", dark[0],
                    f"is the exposure, since {self.keys[stated[0]]} = {stated[1]:g}",
                )  # fmt: skip
            return
        if stated is None:
            return
        key, value = stated
        self.take("exposure_s", value, key)
        self._compare(key, value)
        if dark is not None and abs(dark[1] - value) > max(EXPOSURE_TOLERANCE * value, 1.0):
            self.doubt(
                "exposure_s", dark[0],
                f"differs from {self.keys[key]}, which is used: {value:g} s",
            )  # fmt: skip

    def _compare(self, key: str, seconds: float) -> None:
        """Doubt an exposure that another key word or the clock contradicts."""
        for other, scale in self._keys_with_unit(EXPOSURE):
            reading = read_number(self.values[other]) if other != key else None
            if reading is None or reading.value <= 0:
                continue
            stated = self._seconds(other, reading, scale)
            if abs(stated - seconds) > max(EXPOSURE_TOLERANCE * seconds, ROUNDED_S):
                self.doubt(
                    "exposure_s", other,
                    f"contradicts {self.keys[key]}, which is used: {seconds:g} s",
                )  # fmt: skip
                return
        begin, end = (_instant(self.values.get(k)) for k in ("DATEOBS", "DATEEND"))
        passed = (end - begin).total_seconds() if begin and end else 0.0
        if passed > 0 and seconds > 2.0 * passed + 1.0:  # of clocks that tell seconds
            self.doubt(
                "exposure_s", key,
                f"is more than the {passed:g} s from DATE-OBS to DATE-END; its unit may be smaller",
            )  # fmt: skip

    def _seconds_of(self, names: tuple[str, ...]) -> tuple[str, float] | None:
        for key, scale in self._keys_with_unit(names):
            reading = self.reading(key, "exposure_s")
            if reading is not None:
                return key, self._seconds(key, reading, scale)
        return None

    def _keys_with_unit(self, names: tuple[str, ...]) -> list[tuple[str, float | None]]:
        """Keys of these names, as they stand or with a unit behind: EXPOSURE_MS."""
        plain = [_plain(n) for n in names]
        found: list[tuple[str, float | None]] = [(n, None) for n in plain if n in self.values]
        for key in self.values:
            base = max((n for n in plain if key.startswith(n)), key=len, default="")
            scale = SECONDS.get(key.removeprefix(base).lower()) if base and base != key else None
            found += [(key, scale)] if scale is not None and key not in plain else []
        return found

    def _seconds(self, key: str, reading: Reading, scale: float | None) -> float:
        said = SECONDS.get(reading.unit.lower().rstrip("."))
        if said is None and (named := unit_in(self.comments.get(key, ""), SECONDS)):
            said = named[0] * named[1]
        scale = 1e-6 if key == "EXPOINUS" else scale
        said = scale if said is None else said
        common = SECONDS.get(str(self.values.get("TIMEUNIT", "")).strip().lower())
        if said is None and common is not None:
            said = common
            self.comments.setdefault(key, "")
            self.comments[key] += f" TIMEUNIT {self.values['TIMEUNIT']}"
        elif said is not None and common not in (None, 1.0, said):
            self.doubt(
                "exposure_s", key,
                f"is taken as {reading.value * said:g} s by its own unit; TIMEUNIT says another",
            )  # fmt: skip
        seconds = reading.value * (1.0 if said is None else said)
        if said is None and seconds >= LONG:
            self.doubt(
                "exposure_s", key,
                "has no unit; taken as s. If it is ms or us, a manifest with exposure_s settles it",
            )  # fmt: skip
        return seconds

    def gain(self) -> None:
        """The analogue gain, in proportion to DN per electron where the header says how."""
        found = self.first(GAIN)
        if found is None:
            text = self.values.get("GAIN")
            if isinstance(text, str) and text.strip():  # 'High', 'Low': two readouts
                self.take("channel", text.strip(), "GAIN")
            return
        key, reading = found
        value, said = reading.value, f"{reading.unit} {self.comments.get(key, '')}".lower()
        decibel = _DECIBEL.search(said)
        if _PER_ELECTRON.search(said) and value > 0:
            self.doubt(
                "gain", key,
                f"is in e-/DN by its comment; the gain is its inverse, {1.0 / value:.4g} DN/e-",
            )  # fmt: skip
            value = 1.0 / value
        elif decibel is not None and not _PER_DN.search(said):
            part = decibel["part"] or "1"
            step = 1.0 / float(part[2:]) if "/" in part else float(part.replace(",", "."))
            if abs(value * step) < 180.0:  # 1e9
                value = 10.0 ** (value * step / 20.0)
        elif _TENTHS.search(self._camera()) and 0 <= value < 1000.0:
            self.doubt("gain", key, "is in 0.1 dB, as ZWO cameras count")
            value = 10.0 ** (value / 200.0)
        elif key.endswith("GAIN") and self.keys[key] not in _FACTORS and not _LINEAR.search(said):
            self.doubts.append(without_unit(key))
        self.take("gain", value, key)

    def _camera(self) -> str:
        return " ".join(str(self.values.get(k, "")) for k in ("INSTRUME", "CAMERA")).lower()


def electrons_per_dn(values: Mapping[str, Any], comments: Mapping[str, str]) -> float | None:
    """The conversion factor, e-/DN, of EGAIN or of a GAIN that its comment says to be one."""
    for key, value in values.items():
        stated = _plain(key) == "EGAIN" or (
            _plain(key) == "GAIN" and _PER_ELECTRON.search(comments.get(key, "").lower())
        )
        reading = read_number(value) if stated else None
        if reading is not None and 0 < reading.value < 1e6:
            return reading.value
    return None


def as_bias(metadata: Metadata) -> Metadata:
    """The metadata of a bias frame: it has no exposure, whatever the header says."""
    taken = dict(metadata.taken) | {"exposure_s": ("header", "image type bias")}
    doubts = tuple(d for d in metadata.doubts if d.about != "exposure_s")
    return replace(metadata, exposure_s=0.0, taken=taken, doubts=doubts)


def _shown(value: Any) -> str:
    """A value for people; an EXIF rational as a fraction."""
    if isinstance(value, tuple) and len(value) == 2:
        return f"{value[0]}/{value[1]}"
    return str(value).strip()[:40]


def _instant(value: Any) -> datetime | None:
    """An ISO date with its time, as FITS has it, without a zone."""
    try:
        found = datetime.fromisoformat(str(value).strip()[:40])
    except ValueError:
        return None
    return found.replace(tzinfo=None)


def _of_sensor(key: str) -> bool:
    return bool(_OF_SENSOR.search(key)) and not re.search(r"SET|TARGET|COOL", key)


def _plain(key: Any) -> str:
    """A key without case and punctuation."""
    return re.sub(r"[^A-Z0-9]", "", str(key).upper())
