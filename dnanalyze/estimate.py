"""A number with its standard error and unit, and tables of such numbers with units."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING, Any

from dnanalyze.digits import with_error

if TYPE_CHECKING:
    from astropy.table import QTable
    from astropy.units import Quantity, UnitBase

    from dnanalyze.loaders.captures import OperatingPoint

NORMAL_95 = 1.96  # standard errors of an interval of 95 %
# Units as dnanalyze writes them, as astropy reads them.
SPELLED = {
    "1": "", "%": "percent", "e-": "electron", "C": "deg_C", "c": "cycle", "px": "pix",
    "cycles": "cycle", "pixel": "pix", "pixels": "pix", "DN^2": "DN2",
}  # fmt: skip


class Estimated:
    """What every number with a standard error can do; `value`, `se` and `unit` are its own.

    A value of None, and a standard error of None or NaN, are not determined.
    """

    value: Any
    se: Any
    unit: Any

    @property
    def low(self) -> float:
        """Lower end of the interval of 95 %, in the unit of the value; NaN without an error."""
        return _number(self.value) - NORMAL_95 * _number(self.se)

    @property
    def high(self) -> float:
        """Upper end of the interval of 95 %, in the unit of the value; NaN without an error."""
        return _number(self.value) + NORMAL_95 * _number(self.se)

    @property
    def quantity(self) -> Quantity:
        """The value as an astropy quantity; dimensionless where astropy has no such unit."""
        from astropy.units import Quantity

        return Quantity(_number(self.value), astropy_unit(self.unit))

    def __str__(self) -> str:
        """Value and standard error to the digits that the error leaves, and the unit."""
        if self.value is None:
            return "not determined"
        return with_error(float(self.value), _number(self.se), self.unit)

    def _repr_html_(self) -> str:
        return escape(str(self))


@dataclass(frozen=True)
class Estimate(Estimated):
    """A number with its standard error and unit.

    Parameters
    ----------
    value : float
        In ``unit``.
    se : float
        Standard error, in the unit of the value; NaN where there is none.
    unit : str
        Such as "DN", "e-/s"; "1" of a ratio.
    interval : tuple of float, optional
        Ends of the interval of 95 % where it is not symmetric.

    Examples
    --------
    >>> noise = Estimate(3.0617, 0.0039, "DN")
    >>> print(noise)
    3.0617 ± 0.0039 DN
    >>> round(noise.high, 4)
    3.0693
    >>> noise.quantity.unit
    Unit("DN")
    """

    value: float
    se: float = math.nan
    unit: str = "1"
    interval: tuple[float, float] | None = None

    @property
    def low(self) -> float:
        """Lower end of the interval of 95 %, in the unit of the value."""
        return super().low if self.interval is None else self.interval[0]

    @property
    def high(self) -> float:
        """Upper end of the interval of 95 %, in the unit of the value."""
        return super().high if self.interval is None else self.interval[1]

    __str__ = Estimated.__str__


def astropy_unit(text: str) -> UnitBase:
    """The astropy unit of a unit as dnanalyze writes it.

    Parameters
    ----------
    text : str

    Returns
    -------
    astropy.units.UnitBase
        Dimensionless where astropy has none, such as of logarithms.

    Examples
    --------
    >>> astropy_unit("DN/e-").to_string()
    'DN / electron'
    >>> astropy_unit("cycles/pixel").to_string()
    'cycle / pix'
    >>> astropy_unit("ln DN").to_string()
    ''
    """
    from astropy.units import Unit

    over = [SPELLED.get(part, part) or "1" for part in text.split("/")]
    try:
        return Unit("/".join(over))
    except ValueError:
        return Unit("")


def qtable(rows: Sequence[Mapping[str, Any]]) -> QTable:
    """A table whose columns have units.

    Parameters
    ----------
    rows : sequence of mapping
        Column to text, a number, or an `Estimated`: that has a unit and, as ``name_se``, its
        standard error, if any row has one. What a row lacks is NaN, or "" of text.

    Returns
    -------
    astropy.table.QTable
    """
    from astropy.table import QTable
    from astropy.units import Quantity

    table = QTable()
    for name in dict.fromkeys(key for row in rows for key in row):
        cells = [row.get(name) for row in rows]
        known = next((c for c in cells if isinstance(c, Estimated)), None)
        if known is None:
            none = "" if any(isinstance(c, str) for c in cells) else math.nan
            table[name] = [none if c is None else c for c in cells]
            continue
        unit = astropy_unit(known.unit)
        value, error = (
            Quantity([_number(getattr(c, part, None)) for c in cells], unit)
            for part in ("value", "se")
        )
        table[name] = value
        if not all(map(math.isnan, error.value)):
            table[f"{name}_se"] = error
    return table


def place(point: OperatingPoint) -> dict[str, Any]:
    """The columns of an operating point, for `qtable`."""
    return {
        "temperature_c": Estimate(_number(point.temperature_c), unit="C"),
        "exposure_s": Estimate(_number(point.exposure_s), unit="s"),
        "gain": point.gain,
        "channel": point.channel or "",
    }


def _number(value: Any) -> float:
    return math.nan if value is None else float(value)
