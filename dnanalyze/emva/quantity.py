"""A quantity of EMVA 1288 with its standard error, or with the reason why it is not determined."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from dnanalyze.analyzers.statistics import Value
from dnanalyze.estimate import Estimated, place, qtable
from dnanalyze.loaders.captures import OperatingPoint

if TYPE_CHECKING:
    import pandas as pd
    from astropy.table import QTable


@dataclass(frozen=True)
class Kind:
    """What a quantity is.

    Parameters
    ----------
    key : str
        Name in JSON and tables, such as "temporal_dark_noise_dn".
    symbol : str
        Of EMVA 1288 Release 4.0; empty where the standard has none.
    name : str
        In words.
    unit : str
        "DN", "DN/s", "e-", "e-/s", "DN/e-", "C", "%", or "1".
    """

    key: str
    symbol: str
    name: str
    unit: str


@dataclass(frozen=True)
class Quantity(Estimated):
    """A determined quantity, or the reason why it is not determined.

    Parameters
    ----------
    kind : Kind
    value, se : float, optional
        In ``kind.unit``; ``se`` is the standard error. None: not determined.
    reason : str
        Why ``value`` is None; empty where it is known.
    note : str
        How the value was obtained, or over which range it holds.
    """

    kind: Kind
    value: float | None = None
    se: float | None = None
    reason: str = ""
    note: str = ""

    @property
    def unit(self) -> str:
        """Of the value."""
        return self.kind.unit

    @property
    def determined(self) -> bool:
        """Whether there is a value."""
        return self.value is not None

    def scaled(self, kind: Kind, factor: Quantity) -> Quantity:
        """This quantity divided by ``factor``, such as a noise in DN by the gain in DN/e-."""
        if self.value is None or self.se is None:
            return Quantity(kind, reason=self.reason)
        if factor.value is None or factor.se is None:
            return Quantity(kind, reason=f"{factor.kind.symbol} is not determined")
        value = self.value / factor.value
        se = math.hypot(self.se / factor.value, value * factor.se / factor.value)
        return known(kind, Value(value, se), self.note)


def known(kind: Kind, value: Value, note: str = "") -> Quantity:
    """A quantity with this value and standard error, in its unit."""
    if not (math.isfinite(value.value) and math.isfinite(value.se)):
        return Quantity(kind, reason="its value is not finite")
    return Quantity(kind, float(value.value), float(value.se), note=note)


def unknown(kind: Kind, reason: str) -> Quantity:
    """A quantity that is not determined."""
    return Quantity(kind, reason=reason)


@dataclass(frozen=True)
class Quantities:
    """Quantities by key, in order."""

    items: tuple[Quantity, ...] = ()

    def __iter__(self) -> Iterator[Quantity]:
        return iter(self.items)

    def __contains__(self, key: object) -> bool:
        return any(item.kind.key == key for item in self.items)

    def __getitem__(self, key: str) -> Quantity:
        for item in self.items:
            if item.kind.key == key:
                return item
        raise KeyError(key)


@dataclass(frozen=True)
class Line:
    """A straight line fitted to values over an abscissa.

    Parameters
    ----------
    x, y, error : tuple of float
        What was fitted; standard errors of ``y``.
    intercept, slope : Value
    """

    x: tuple[float, ...]
    y: tuple[float, ...]
    error: tuple[float, ...]
    intercept: Value
    slope: Value


@dataclass(frozen=True)
class PointQuantities:
    """The quantities of one operating point and colour plane.

    Parameters
    ----------
    point : OperatingPoint
    plane : str
        "" for the whole frame.
    frames : int
    quantities : Quantities
    """

    point: OperatingPoint
    plane: str
    frames: int
    quantities: Quantities


@dataclass(frozen=True)
class DarkCurrent:
    """The dark current at one temperature.

    Parameters
    ----------
    temperature_c : float, optional
        Mean of the operating points; None where it is unknown.
    exposures_s : tuple of float
        The different exposures, rising.
    quantities : Quantities
    mean_line, variance_line : Line, optional
        Mean dark signal (DN) and temporal variance (DN^2) over exposure (s).
    """

    temperature_c: float | None
    exposures_s: tuple[float, ...]
    quantities: Quantities
    mean_line: Line | None = None
    variance_line: Line | None = None


@dataclass(frozen=True)
class Group:
    """What holds for operating points of one gain, channel and colour plane.

    Parameters
    ----------
    gain, channel, plane
        None or "" where the captures name none.
    quantities : Quantities
        System gain, photon transfer gain, doubling temperature interval.
    dark_currents : tuple of DarkCurrent
        By temperature, rising.
    points : tuple of PointQuantities
        Of this group, by operating point.
    transfer : Line, optional
        Temporal variance (DN^2) over mean dark signal (DN), the photon transfer.
    """

    gain: float | None
    channel: str | None
    plane: str
    quantities: Quantities
    dark_currents: tuple[DarkCurrent, ...]
    points: tuple[PointQuantities, ...]
    transfer: Line | None = None

    @property
    def label(self) -> str:
        """``hcg, gain 4, Gr``; empty where nothing is named."""
        parts = [self.channel or "", f"gain {self.gain:g}" if self.gain is not None else ""]
        return ", ".join(p for p in (*parts, self.plane) if p)


@dataclass(frozen=True)
class Emva:
    """The EMVA 1288 dark quantities of a capture set.

    Parameters
    ----------
    groups : tuple of Group
        By gain, channel and colour plane.
    """

    groups: tuple[Group, ...]

    def to_dataframe(self) -> pd.DataFrame:
        """Return all quantities as a table.

        Returns
        -------
        pandas.DataFrame
            One row a quantity: of the sensor (no temperature), of a temperature, or of an operating
            point; value, standard error, ends of the interval of 95 %, unit, and how it was
            obtained or why it is not determined.

        Examples
        --------
        >>> import dnanalyze
        >>> from dnanalyze.demo import tiny
        >>> table = dnanalyze.analyze(tiny()).emva.to_dataframe()
        >>> bool((table["quantity"] == "temporal_dark_noise_dn").sum() == 3)
        True
        """
        import pandas as pd

        return pd.DataFrame(
            [_row(point, g.plane, q) for g in self.groups for point, q in _placed(g)]
        )

    def to_qtable(self) -> QTable:
        """Return all determined quantities as a table with units.

        Returns
        -------
        astropy.table.QTable
            One row for each gain, channel and colour plane, for each of their temperatures, and for
            each operating point; a quantity and, as ``name_se``, its standard error.

        Examples
        --------
        >>> import dnanalyze
        >>> from dnanalyze.demo import tiny
        >>> table = dnanalyze.analyze(tiny()).emva.to_qtable()
        >>> table["temporal_dark_noise_dn"].unit
        Unit("DN")
        """
        found: dict[tuple[OperatingPoint, str], dict[str, Any]] = {}
        for group in self.groups:
            for point, quantity in _placed(group):
                cells = {**place(point), "plane": group.plane}
                own = found.setdefault((point, group.plane), cells)
                if quantity.determined:
                    own[quantity.kind.key] = quantity
        return qtable(list(found.values()))

    def _repr_html_(self) -> str:
        """The table, for a notebook."""
        return self.to_dataframe().to_html(index=False, na_rep="")


def _placed(group: Group) -> Iterator[tuple[OperatingPoint, Quantity]]:
    """The quantities of a group with where they hold."""
    of_sensor = OperatingPoint(gain=group.gain, channel=group.channel)
    for quantity in group.quantities:
        yield of_sensor, quantity
    for current in group.dark_currents:
        at = replace(of_sensor, temperature_c=current.temperature_c)
        yield from ((at, quantity) for quantity in current.quantities)
    for point in group.points:
        yield from ((point.point, quantity) for quantity in point.quantities)


def _row(point: OperatingPoint, plane: str, found: Quantity) -> dict[str, Any]:
    kind, told = found.kind, found.value is not None and found.se is not None
    return {
        **vars(point),
        "plane": plane,
        "quantity": kind.key,
        "symbol": kind.symbol,
        "name": kind.name,
        "value": found.value,
        "se": found.se,
        "low": found.low if told else None,
        "high": found.high if told else None,
        "unit": kind.unit,
        "note": found.reason or found.note,
    }
