"""EMVA 1288 quantities as rows of tables, the same in the terminal and on the page."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence

from dnanalyze.analyzers.catalogue import catalogue
from dnanalyze.analyzers.statistics import Statistics
from dnanalyze.digits import minus, symbol
from dnanalyze.emva import kinds
from dnanalyze.emva.quantity import Emva, Group, Kind, PointQuantities, Quantity
from dnanalyze.report.words import family_title, listing, number, point_label, varied, with_error

NONE = "–"
LAWS = ("activation_energy_ev", "doubling_step_c")  # of the median; here they are of the mean
Row = tuple[str, ...]


def cell(quantity: Quantity) -> str:
    """``3.06 ± 0.01``; a dash where it is not determined."""
    if quantity.value is None or quantity.se is None:
        return NONE
    if quantity.se == 0:
        return number(quantity.value, 4)
    return with_error(quantity.value, quantity.se)


def brief(quantity: Quantity) -> str:
    """As `cell` with one digit of the error, for narrow columns."""
    value, se = quantity.value, quantity.se
    if value is None or se is None or se == 0:
        return cell(quantity)
    decimals = -math.floor(math.log10(se))
    if not 0 <= decimals <= 6:
        return cell(quantity)
    return f"{minus(f'{value:.{decimals}f}')} ± {se:.{decimals}f}"


def unit(kind: Kind) -> str:
    """With symbols: °C, e⁻."""
    return symbol(kind.unit)


def title(kind: Kind) -> str:
    """``temporal dark noise [DN]``."""
    return f"{kind.name} [{unit(kind)}]" if unit(kind) else kind.name


def sensor_rows(group: Group) -> list[Row]:
    """Symbol, quantity, where or how, value: system gain, dark currents, doubling interval.

    The dark current is given at the lowest and the highest temperature.
    """
    rows: list[Row] = []
    for quantity in group.quantities:
        if quantity.determined or quantity.kind != kinds.TRANSFER:
            name = kinds.GAIN if quantity.kind == kinds.TRANSFER else quantity.kind
            text = kinds.TRANSFER.name if _checks(group, quantity) else name.name
            shown = f"{text} [{unit(quantity.kind)}]"
            rows.append((name.symbol, shown, quantity.note, cell(quantity)))
    ends = group.dark_currents if len(group.dark_currents) < 3 else (
        group.dark_currents[0], group.dark_currents[-1],
    )  # fmt: skip
    for current in ends:
        at = "" if current.temperature_c is None else f"{number(current.temperature_c)} °C"
        for quantity in current.quantities:
            if quantity.determined and quantity.kind != kinds.OFFSET:
                where = "; ".join(t for t in (at, quantity.note) if t)
                rows.append((quantity.kind.symbol, title(quantity.kind), where, cell(quantity)))
    return rows


def _checks(group: Group, quantity: Quantity) -> bool:
    """Whether it is the photon transfer beside a gain that is known otherwise."""
    return quantity.kind == kinds.TRANSFER and any(q.kind == kinds.GAIN for q in group.quantities)


def ends(group: Group) -> list[PointQuantities]:
    """The operating points of the lowest and of the highest mean dark signal.

    Of those with most quantities determined; one where there is no other.
    """
    best = max(_count(p) for p in group.points)
    full = [p for p in group.points if _count(p) >= 0.7 * best] or list(group.points)
    full.sort(key=lambda p: p.quantities[kinds.MEAN.key].value or 0.0)
    return [full[0]] if len(full) == 1 else [full[0], full[-1]]


def _count(point: PointQuantities) -> int:
    return sum(q.determined for q in point.quantities)


def point_rows(
    points: Sequence[PointQuantities], form: Callable[[Quantity], str] = cell
) -> list[Row]:
    """Symbol, quantity, and its value at each of these points; without rows that none has."""
    rows: list[Row] = []
    for quantity in points[0].quantities:
        own = [p.quantities[quantity.kind.key] for p in points]
        if any(q.determined for q in own):
            rows.append((quantity.kind.symbol, title(quantity.kind), *(form(q) for q in own)))
    return rows


LEVELS = (kinds.MEAN, kinds.NOISE, kinds.DSNU)
SPLIT = (kinds.ROW, kinds.COLUMN, kinds.PIXEL, kinds.HOT_5)
SHORT = {kinds.ROW: "row", kinds.COLUMN: "col", kinds.PIXEL: "pixel", kinds.HOT_5: "hot > 5 σ"}


def labels(points: Sequence[PointQuantities]) -> list[str]:
    """Operating points by what differs between them."""
    only = varied(vars(p.point) | {"plane": p.plane} for p in points)
    return [point_label(vars(p.point) | {"plane": p.plane}, only) for p in points]


def every_point(found: Emva) -> list[PointQuantities]:
    """The operating points of all groups."""
    return [p for group in found.groups for p in group.points]


def table(
    points: Sequence[PointQuantities],
    shown: Iterable[Kind],
    first: str = "operating point",
    short: Mapping[Kind, str] = SHORT,
) -> tuple[Row, list[Row]]:
    """Column names and rows of these quantities by operating point; empty columns are left out.

    ``first`` names the column of the operating points, ``short`` quantities by less than a symbol.
    """
    own = [k for k in shown if any(p.quantities[k.key].determined for p in points)]
    rows = [
        (name, *(brief(p.quantities[k.key]) for k in own))
        for name, p in zip(labels(points), points, strict=True)
    ]
    heads = tuple(f"{short.get(k) or k.symbol or k.name} [{unit(k) or '1'}]" for k in own)
    return (first, *heads), rows if own else []


def current_table(group: Group) -> tuple[Row, list[Row]]:
    """Dark current by temperature."""
    shown = [kinds.CURRENT, kinds.CURRENT_E, kinds.CURRENT_VARIANCE, kinds.OFFSET]
    currents = group.dark_currents
    own = [k for k in shown if any(c.quantities[k.key].determined for c in currents)]
    rows = [
        (
            NONE if c.temperature_c is None else f"{number(c.temperature_c)} °C",
            str(len(c.exposures_s)),
            *(cell(c.quantities[k.key]) for k in own),
        )
        for c in currents
    ]
    heads = tuple(f"{k.symbol} [{unit(k)}]" for k in own)
    return ("temperature", "exposures", *heads), rows if own else []


def _some(names: Sequence[str], most: int = 4) -> str:
    """The first few names; between names with commas of their own stand semicolons."""
    between = "; " if any("," in n for n in names) else ", "
    more = [f"{len(names) - most} more"] if len(names) > most else []
    return listing([*names[:most], *more], between)


def missing_statistics(measured: Statistics) -> list[str]:
    """A sentence for each reason why statistics are not determined, with their titles."""
    known = catalogue()
    why: dict[str, dict[str, None]] = {}
    for setting in measured.settings:
        for name, reason in setting.missing.items():
            title = known[name].title if name in known else family_title(name).lower()
            why.setdefault(reason, {})[title] = None
    return [f"{_some(list(names), 2)}: {reason}" for reason, names in why.items()]


def undetermined(found: Emva) -> list[str]:
    """A sentence for each reason, with the quantities that it holds for."""
    why: dict[str, dict[str, None]] = {}
    missed: dict[str, set[str]] = {}
    for group in found.groups:
        items = [(q, "") for q in group.quantities]
        items += [(q, "") for c in group.dark_currents for q in c.quantities]
        items += [
            (q, label)
            for p, label in zip(group.points, labels(group.points), strict=True)
            for q in p.quantities
        ]
        for quantity, label in items:
            if quantity.reason:
                why.setdefault(quantity.reason, {})[quantity.kind.symbol or quantity.kind.name] = (
                    None
                )
                missed.setdefault(quantity.reason, set()).add(label)
    total = len(every_point(found))
    out = []
    for reason, names in why.items():
        count = len(missed[reason] - {""})
        where = f" at {count} of {total} operating points" if 0 < count < total else ""
        shown = list(names)
        out.append(f"{_some(shown)}{where}: {reason}")
    return out
