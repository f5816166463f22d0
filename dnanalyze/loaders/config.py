"""The sidecar ``dnanalyze.yaml``: what the files do not say of themselves."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Annotated, Any, Literal

import yaml
from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator, model_validator

from dnanalyze.errors import InputError
from dnanalyze.loaders.files import SIDECARS, unreadable
from dnanalyze.loaders.recording import Cfa, Metadata

MAX_BYTES = 8 << 20  # of a sidecar or a manifest
NAMED = ("temperature_c", "exposure_s", "gain", "channel", "frame")

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
        Headerless raw: "plain" (one pixel in one or two bytes), "mipi" (CSI-2 RAW10/12/14) or
        "lsb" (a little-endian bit stream, lowest bit first).
    byte_order : str
        Headerless plain raw: "little" or "big".
    header_offset, row_bytes : int
        Headerless raw: bytes before the first pixel; bytes from row to row where rows are padded.
    cfa : str
        Colours of the top-left block of the readout, rows joined ("RGGB"; 4 or 16 letters).
    black_level, white_level, pixel_pitch_um : float
        DN, DN, micrometres.
    active_rows, active_columns : [int, int]
        First and one past the last row, column on which light falls.
    optical_black_rows, optical_black_columns : [int, int]
        The masked area, likewise; one of them alone spans the other direction.
    name_regex : str
        Python regular expression, searched in each file's path below the folder; named groups
        temperature_c, exposure_s, gain, channel, frame.
    temperature_c, exposure_s, gain, channel
        For frames of which no other source says it.
    tolerance_c : float
        Span of the temperatures of one operating point, C.
    skip : list of str
        Globs of bad frames, relative to the folder.
    region : str
        "active", "masked" or "all", where the caller does not say.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    width: int | None = Field(default=None, gt=0)
    height: int | None = Field(default=None, gt=0)
    bits: int | None = Field(default=None, ge=1, le=32)
    packing: Literal["plain", "mipi", "lsb"] = "plain"
    byte_order: Literal["little", "big"] = "little"
    header_offset: int = Field(default=0, ge=0)
    row_bytes: int | None = Field(default=None, gt=0)
    cfa: str | None = None
    black_level: float | None = None
    white_level: float | None = None
    pixel_pitch_um: float | None = Field(default=None, gt=0)
    active_rows: Span | None = None
    active_columns: Span | None = None
    optical_black_rows: Span | None = None
    optical_black_columns: Span | None = None
    name_regex: str | None = None
    temperature_c: float | None = None
    exposure_s: float | None = Field(default=None, ge=0)
    gain: float | None = None
    channel: str | None = None
    tolerance_c: float | None = Field(default=None, ge=0)
    skip: tuple[str, ...] = ()
    region: Literal["active", "masked", "all"] | None = None

    @field_validator("cfa")
    @classmethod
    def _square(cls, value: str | None) -> str | None:
        if value is not None and not re.fullmatch(r"[A-Za-z]{4}|[A-Za-z]{16}", value):
            raise ValueError("must be 4 letters (2 x 2) or 16 letters (4 x 4), such as RGGB")
        return value and value.upper()

    @field_validator("name_regex")
    @classmethod
    def _compiles(cls, value: str | None) -> str | None:
        if value is None:
            return None
        try:
            groups = re.compile(value).groupindex
        except re.error as error:
            raise ValueError(f"is no regular expression: {error}") from error
        if not groups or set(groups) - set(NAMED):
            raise ValueError(f"needs named groups out of: {', '.join(NAMED)}")
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

    def colour_filter(self) -> Cfa | None:
        """``cfa`` as rows."""
        return None if self.cfa is None else cfa_rows(self.cfa)

    def metadata(self) -> Metadata:
        """What holds for frames of which nothing else is known."""
        return Metadata(self.temperature_c, self.exposure_s, self.gain, self.channel)


def cfa_rows(text: str) -> Cfa:
    """Text "RGGB" as (("R","G"),("G","B")); 4 or 16 letters."""
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


def read_text(path: Path) -> str:
    """A small text file.

    Raises
    ------
    InputError
        Absent, a folder, unreadable, no text, or over ``MAX_BYTES``.
    """
    try:
        if path.is_dir():
            raise InputError(f"{path}: is a folder; give a file")
        with path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)
    except FileNotFoundError as error:
        raise InputError(f"{path}: no such file") from error
    except OSError as error:
        raise unreadable(str(path), error) from error
    if len(data) > MAX_BYTES:
        raise InputError(f"{path}: larger than {MAX_BYTES >> 20} MB; this is no table of frames")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: is not UTF-8 text; save it as UTF-8") from error


def read_yaml(path: Path) -> Any:
    """Plain data of a YAML file; tags and aliases that could expand are refused.

    Raises
    ------
    InputError
        Not YAML.
    """
    text = read_text(path)
    try:
        if any(isinstance(t, yaml.AliasToken) for t in yaml.scan(text, yaml.SafeLoader)):
            raise InputError(f"{path}: YAML aliases (*name) are not accepted; write the value out")
        return yaml.safe_load(text)
    except (yaml.YAMLError, RecursionError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        mark = getattr(error, "problem_mark", None)
        place = f" (line {mark.line + 1})" if mark else ""
        problem = getattr(error, "problem", None) or type(error).__name__
        raise InputError(f"{path}: is not YAML{place}: {problem}") from error


def _keys() -> str:
    return ", ".join(Config.model_fields)
