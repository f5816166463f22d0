"""NoiseModel: a pedestal and an ordered list of effects, with its YAML form."""

from __future__ import annotations

from dataclasses import dataclass, replace
from html import escape
from os import PathLike
from pathlib import Path
from typing import Any

import yaml

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.loaders.text import read_yaml
from dnanalyze.model.effect import Effect, Placing
from dnanalyze.model.laws import Law, count, law_from_plain
from dnanalyze.model.registry import catalogue, described, find

SCHEMA = "dnanalyze/model/1"
PATTERN = "pattern_map"  # the effect whose map is a file beside the model
_AT_25_C = {"temperature_c": 25.0, "exposure_s": 1.0}
KEYS = {"schema", "pedestal", "reference", "channel_references", "seed", "effects", "fit", "unit"}


@dataclass(frozen=True)
class NoiseModel:
    """A dark-noise model.

    Parameters
    ----------
    effects : tuple of Effect
        At most one of a name; applied by stage, then in this order.
    pedestal : Law
        Black level, DN.
    reference : OperatingPoint
        Operating point at which the amplitudes are stated.
    seed : int
        Seed of the virtual sensor: it fixes all random numbers.
    channel_references : tuple of OperatingPoint
        Where those of a readout channel are stated that has a reference of its own (a short
        exposure).
    unit : float
        Value in the files of one DN of the model: 16 for 12-bit codes in 16-bit files.
    """

    effects: tuple[Effect, ...]
    pedestal: Law = 0.0
    reference: OperatingPoint = OperatingPoint(25.0, 1.0, 1.0)
    seed: int = 0
    channel_references: tuple[OperatingPoint, ...] = ()
    unit: float = 1.0

    def __post_init__(self) -> None:
        names = self.names
        for name in names:
            if names.count(name) > 1:
                raise InputError(f"model: effect {name!r} is listed twice; each may be listed once")

    @property
    def names(self) -> list[str]:
        """Effect names in the order given."""
        return [e.name for e in self.effects]

    @property
    def placing(self) -> Placing:
        """Where in the field it is, that of its effects which is least the same all over."""
        return max((e.placing for e in self.effects), default=Placing.EVERYWHERE)

    def black_shift(self, point: OperatingPoint, shape: tuple[int, int]) -> float:
        """Median that the fixed offsets of all effects add to a frame without exposure, DN.

        Parameters
        ----------
        point : OperatingPoint
            Where.
        shape : tuple of int
            Full frame, (rows, columns).

        Returns
        -------
        float
            DN.

        Examples
        --------
        Strips of a quarter and three quarters of the columns, 8 DN apart, have the mean 0:

        >>> import dnanalyze
        >>> from dnanalyze.model.effects.column_taps import ColumnTaps
        >>> taps = ColumnTaps(sigma=12**0.5, kind="blocks", levels=(1.0, 0.0), begins=(24,))
        >>> model = dnanalyze.NoiseModel((taps,), 100.0)
        >>> round(model.black_shift(dnanalyze.OperatingPoint(), (96, 96)), 6)
        -2.0
        """
        reference = self.reference_of(point.channel)
        return sum(e.black_shift(point, reference, shape) for e in self.effects)

    def reference_of(self, channel: str | None) -> OperatingPoint:
        """Return the operating point at which the amplitudes of a channel are stated.

        Parameters
        ----------
        channel : str or None
            HDR readout channel.

        Returns
        -------
        OperatingPoint
            The reference.
        """
        return next((r for r in self.channel_references if r.channel == channel), self.reference)

    @property
    def chain(self) -> list[Effect]:
        """Effects in the order in which the signal passes them."""
        return sorted(self.effects, key=lambda e: e.stage)

    @property
    def in_codes(self) -> NoiseModel:
        """The same model, whose frames are in its own DN whatever the unit of files."""
        return replace(self, unit=1.0)

    def get(self, name: str) -> Effect | None:
        """Return the effect of that name.

        Parameters
        ----------
        name : str
            Name of the effect.

        Returns
        -------
        Effect or None
            None where the model has none of that name.
        """
        return next((e for e in self.effects if e.name == name), None)

    def with_effect(self, effect: Effect) -> NoiseModel:
        """Return the model with this effect added, or replaced where it is present.

        Parameters
        ----------
        effect : Effect
            The effect with its parameters.

        Returns
        -------
        NoiseModel
            A new model.
        """
        if self.get(effect.name) is None:
            return replace(self, effects=(*self.effects, effect))
        new = tuple(effect if e.name == effect.name else e for e in self.effects)
        return replace(self, effects=new)

    def without(self, name: str) -> NoiseModel:
        """Return the model without the effect of that name.

        Parameters
        ----------
        name : str
            Name of the effect.

        Returns
        -------
        NoiseModel
            A new model.
        """
        return replace(self, effects=tuple(e for e in self.effects if e.name != name))

    def save(self, path: str | PathLike[str]) -> None:
        """Write the model file (YAML); an existing one is replaced.

        Parameters
        ----------
        path : str or PathLike
            The file, ``.yaml``.

        Raises
        ------
        InputError
            The file cannot be written.

        Examples
        --------
        >>> import pathlib, tempfile
        >>> from dnanalyze import NoiseModel
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     file = pathlib.Path(folder) / "model.yaml"
        ...     NoiseModel((), 64.0).save(file)
        ...     NoiseModel.load(file).pedestal
        64.0
        """
        from dnanalyze.loaders.writers import atomic_write

        atomic_write(Path(path), dump_model(self))

    @classmethod
    def load(cls, path: str | PathLike[str]) -> NoiseModel:
        """Read a model file; the same as `load_model`.

        Parameters
        ----------
        path : str or PathLike
            The file.

        Returns
        -------
        NoiseModel
            The model.

        Raises
        ------
        InputError
            The file cannot be read, or holds no model.
        """
        return load_model(path)

    def __repr__(self) -> str:
        """The effects, and how many numbers state them and the black level."""
        numbers = count(self.pedestal) + sum(
            count(getattr(effect, name))
            for effect in self.effects
            for name, about in effect.parameters().items()
            if about.scale != "choice"
        )
        said = "1 parameter" if numbers == 1 else f"{numbers} parameters"
        return f"<NoiseModel: {', '.join(self.names) or 'no effects'}; {said}>"

    def _repr_html_(self) -> str:
        """The model file, for a notebook."""
        return f"<pre>{escape(dump_model(self))}</pre>"

    def to_plain(self) -> dict[str, Any]:
        """Return the model as it is written in YAML.

        Returns
        -------
        dict
            By key; see ``load_model``.
        """
        own = self.channel_references
        unit = {} if self.unit == 1.0 else {"unit": self.unit}
        more = {"channel_references": [_plain_point(r) for r in own]} if own else {}
        return {
            "schema": SCHEMA,
            "pedestal": self.pedestal.to_plain()
            if hasattr(self.pedestal, "to_plain")
            else self.pedestal,
            "reference": _plain_point(self.reference),
            **more,
            **unit,
            "seed": self.seed,
            "effects": [{e.name: e.to_plain()} for e in self.effects],
        }


def _plain_point(point: OperatingPoint) -> dict[str, Any]:
    return {k: v for k, v in vars(point).items() if v is not None}


def model_from_plain(
    raw: Any, where: str, known: dict[str, type[Effect]] | None = None
) -> NoiseModel:
    """Build a model from what a YAML file holds.

    Parameters
    ----------
    raw : mapping
        See ``NoiseModel.to_plain``.
    where : str
        File name for messages.
    known : dict, optional
        Effects by name; the built-in catalogue by default.

    Raises
    ------
    InputError
        Unknown keys, effects or parameters, values out of bounds.
    """
    known = catalogue() if known is None else known
    made = {name: kind for name, kind in described().items() if name not in known}
    if not isinstance(raw, dict) or not isinstance(raw.get("effects"), list):
        raise InputError(f"{where}: not a model file; it needs 'effects', a list")
    extra = set(raw) - KEYS
    if extra:
        raise InputError(f"{where}: unknown key {min(map(str, extra))!r} in a model file")
    try:
        effects = []
        for item in raw["effects"]:
            if isinstance(item, str):
                item = {item: {}}
            ((name, values),) = item.items()
            kind = made.get(name) or find(name, known)
            effects.append(kind.from_plain(values or {}))
        reference = _point("reference", raw.get("reference", _AT_25_C))
        pedestal = law_from_plain("pedestal", raw.get("pedestal", 0.0))
        own = tuple(_point("channel_references", r) for r in raw.get("channel_references", ()))
        unit = _unit(raw.get("unit", 1.0))
        return NoiseModel(tuple(effects), pedestal, reference, _seed(raw.get("seed", 0)), own, unit)
    except InputError as error:
        raise InputError(f"{where}: {error}") from None
    except (TypeError, ValueError, AttributeError, OverflowError, KeyError):
        raise InputError(
            f"{where}: malformed model file; each effect is a name with a mapping of parameters"
        ) from None


def _point(key: str, raw: Any) -> OperatingPoint:
    try:
        return OperatingPoint(**raw)
    except InputError as error:
        raise InputError(f"{key}: {error}") from None


def _unit(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0 < value < 1e9:
        raise InputError(f"unit {value!r}: valid: a number above 0, the value of one DN in files")
    return float(value)


def _seed(raw: Any) -> int:
    if type(raw) is not int or not 0 <= raw < 1 << 63:
        raise InputError(f"seed {str(raw)[:40]!r} is no whole number of 0 to 2^63 - 1")
    return raw


def load_model(
    path: str | PathLike[str], known: dict[str, type[Effect]] | None = None
) -> NoiseModel:
    """Read a model file (YAML).

    Parameters
    ----------
    path : str or PathLike
        The file.
    known : dict, optional
        Effects by name; the built-in catalogue by default.

    Returns
    -------
    NoiseModel
        The model.

    Raises
    ------
    InputError
        The file cannot be read, or holds no model; one line names the key.

    Examples
    --------
    >>> import dnanalyze
    >>> dnanalyze.load_model("sample_configs/model.yaml").names[:2]
    ['convolved_lognormal', 'dark_shot_noise']
    """
    raw = read_yaml(Path(path))
    return model_from_plain(_with_files(raw, Path(path).parent), str(path), known)


def _with_files(raw: Any, folder: Path) -> Any:
    """The same with the paths of maps, which are stated from the model file, from here."""
    if not isinstance(raw, dict) or not isinstance(raw.get("effects"), list):
        return raw
    return raw | {"effects": [_with_file(item, folder) for item in raw["effects"]]}


def _with_file(item: Any, folder: Path) -> Any:
    values = item.get(PATTERN) if isinstance(item, dict) else None
    held = values.get("map") if isinstance(values, dict) else None
    if not isinstance(held, dict) or not isinstance(held.get("file"), str):
        return item
    assert isinstance(values, dict)
    return item | {PATTERN: values | {"map": held | {"file": str(folder / held["file"])}}}


def dump_model(model: NoiseModel) -> str:
    """Return a model as YAML text, which `load_model` reads.

    Parameters
    ----------
    model : NoiseModel
        The model.

    Returns
    -------
    str
        YAML.

    Examples
    --------
    >>> import dnanalyze
    >>> print(dnanalyze.dump_model(dnanalyze.NoiseModel((), 64.0)).splitlines()[1])
    pedestal: 64.0
    """
    return yaml.safe_dump(model.to_plain(), sort_keys=False)
