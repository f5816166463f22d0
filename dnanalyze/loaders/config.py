"""The sidecar ``dnanalyze.yaml``: what the files do not say of themselves."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    ValidationError,
    ValidationInfo,
    field_validator,
    model_validator,
)

from dnanalyze.errors import InputError
from dnanalyze.loaders.checks import MAX_PIXELS
from dnanalyze.loaders.files import SIDECARS
from dnanalyze.loaders.physical import fault
from dnanalyze.loaders.recording import Cfa, Metadata
from dnanalyze.loaders.text import read_yaml

Number = Annotated[float, Field(allow_inf_nan=False)]
Span = tuple[Annotated[int, Field(ge=0)], Annotated[int, Field(gt=0)]]


class Config(BaseModel):
    """Content of a sidecar; every key is optional.

    Parameters
    ----------
    width, height : int
        Headerless raw: pixels of the whole readout.
    bits : int
        Bits of a pixel (8, 10, 12, 14 or 16 in headerless raw).
    packing : str
        Headerless raw: "plain" (one pixel in one or two bytes), "mipi" (CSI-2 RAW10/12/14),
        "lsb" (a little-endian bit stream, lowest bit first; Mono12p), "msb" (a big-endian one) or
        "genicam" (Mono10Packed, Mono12Packed).
    byte_order : str
        Headerless plain raw: "little" or "big".
    header_offset, footer_bytes, row_bytes : int
        Headerless raw: bytes before the first pixel and behind the last; bytes from row to row
        where rows are padded.
    cfa : str
        Colours of the top-left block of the readout, rows joined ("RGGB"; 4, 16 or 36 letters).
    black_level, white_level, pixel_pitch_um, system_gain_dn_e : float
        DN, DN, micrometres, DN/e-.
    active_rows, active_columns : [int, int]
        First and one past the last row, column on which light falls.
    optical_black_rows, optical_black_columns : [int, int]
        The masked area, likewise; one of them alone spans the other direction.
    name_regex : str
        Python regular expression, searched in each file's path below the folder; named groups
        temperature_c, exposure_s, gain, channel, frame.
    temperature_c, exposure_s, gain, channel
        For frames of which no other source says it.
    frame_axis : str
        Stacks of NumPy and HDF5: "first" or "last", which axis counts the frames.
    tolerance_c : float
        Span of the temperatures of one operating point, C.
    tolerance_s : float
        Span of the exposures of one operating point, s.
    skip : list of str
        Globs of bad frames, relative to the folder.
    region : str
        "active", "masked" or "all", where the caller does not say.
    image_type : str
        "dark": every file is a dark frame, whatever its header says.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    width: int | None = Field(default=None, gt=0, le=MAX_PIXELS)
    height: int | None = Field(default=None, gt=0, le=MAX_PIXELS)
    bits: int | None = Field(default=None, ge=1, le=32)
    packing: Literal["plain", "mipi", "lsb", "msb", "genicam"] = "plain"
    byte_order: Literal["little", "big"] = "little"
    header_offset: int = Field(default=0, ge=0, le=1 << 60)
    footer_bytes: int = Field(default=0, ge=0, le=1 << 60)
    row_bytes: int | None = Field(default=None, gt=0, le=8 * MAX_PIXELS)
    cfa: str | None = None
    black_level: Number | None = None
    white_level: Number | None = None
    pixel_pitch_um: Number | None = Field(default=None, gt=0)
    system_gain_dn_e: Number | None = Field(default=None, gt=0)
    active_rows: Span | None = None
    active_columns: Span | None = None
    optical_black_rows: Span | None = None
    optical_black_columns: Span | None = None
    name_regex: str | None = Field(default=None, max_length=1000)
    temperature_c: float | None = None
    exposure_s: float | None = None
    gain: float | None = None
    channel: str | None = None
    frame_axis: Literal["first", "last"] | None = None
    tolerance_c: Number | None = Field(default=None, ge=0)
    tolerance_s: Number | None = Field(default=None, ge=0)
    skip: tuple[str, ...] = ()
    region: Literal["active", "masked", "all"] | None = None
    image_type: Literal["dark"] | None = None

    @field_validator("cfa", mode="before")
    @classmethod
    def _in_one(cls, value: Any) -> Any:
        """Rows, such as [RG, GB] or [[R, G], [G, B]], as one text."""
        if not isinstance(value, (list, tuple)):
            return value
        rows = [row if isinstance(row, (list, tuple)) else [row] for row in value]
        return "".join(str(letter) for row in rows for letter in row)

    @field_validator("cfa")
    @classmethod
    def _square(cls, value: str | None) -> str | None:
        if value is not None and not re.fullmatch(r"[A-Za-z]{4}|[A-Za-z]{16}|[A-Za-z]{36}", value):
            raise ValueError("must be 4, 16 or 36 letters (2 x 2, 4 x 4, 6 x 6), such as RGGB")
        return value and value.upper()

    @field_validator("temperature_c", "exposure_s", "gain")
    @classmethod
    def _physical(cls, value: float | None, info: ValidationInfo) -> float | None:
        if text := fault(str(info.field_name), value):
            raise ValueError(text)
        return value

    @model_validator(mode="after")
    def _spans_rise(self) -> Config:
        for name in (
            "active_rows", "active_columns", "optical_black_rows", "optical_black_columns",
        ):  # fmt: skip
            span = getattr(self, name)
            if span is not None and span[0] >= span[1]:
                raise ValueError(f"{name} must be [first, one past the last], such as [0, 16]")
        return self

    @property
    def names_active(self) -> bool:
        """Whether it says where light falls."""
        return bool(self.active_rows or self.active_columns)

    def colour_filter(self) -> Cfa | None:
        """``cfa`` as rows."""
        return None if self.cfa is None else cfa_rows(self.cfa)

    def metadata(self) -> Metadata:
        """What holds for frames of which nothing else is known."""
        return Metadata(self.temperature_c, self.exposure_s, self.gain, self.channel)


def cfa_rows(text: str) -> Cfa:
    """Text "RGGB" as (("R","G"),("G","B")); 4, 16 or 36 letters."""
    side = int(len(text) ** 0.5)
    return tuple(tuple(text[r * side : (r + 1) * side]) for r in range(side))


def read_config(path: str | os.PathLike[str]) -> Config:
    """A sidecar from disk.

    Raises
    ------
    InputError
        Absent, not YAML, or with a key or value that is not known; the message names the key.
    """
    plain = read_yaml(Path(path))
    if plain is None:
        return Config()
    if not isinstance(plain, dict):
        raise InputError(f"{path}: must be 'key: value' lines; valid keys: {_keys()}")
    return checked_config(plain, str(path))


def checked_config(plain: dict[str, Any], name: str) -> Config:
    """A sidecar's content, checked; ``name`` is for messages."""
    try:
        return Config(**{str(k): v for k, v in plain.items()})
    except ValidationError as error:
        first = error.errors()[0]
        key = ".".join(map(str, first["loc"])) or "content"
        if first["type"] == "extra_forbidden":
            raise InputError(f"{name}: unknown key {key!r}; valid keys: {_keys()}") from error
        text = first["msg"].removeprefix("Value error, ")
        raise InputError(f"{name}: {key}: {text} (given: {str(first['input'])[:60]})") from error


def sidecar_of(folder: Path) -> Config:
    """The sidecar that lies in the folder, or an empty one."""
    for name in SIDECARS:
        if (folder / name).is_file():
            return read_config(folder / name)
    return Config()


def _keys() -> str:
    return ", ".join(Config.model_fields)
