"""The symbols of EMVA 1288 with their subscripts, on pages; text has them after an underscore."""

from __future__ import annotations

import re

from markupsafe import Markup, escape

from dnanalyze.emva import kinds
from dnanalyze.emva.quantity import Kind

MEDIAN_CURRENT = "μ_c"
SYMBOLS = sorted(
    {k.symbol for k in vars(kinds).values() if isinstance(k, Kind) and "_" in k.symbol}
    | {k.symbol for k in kinds.IN_ELECTRONS.values()}
    | {MEDIAN_CURRENT},
    key=len,
    reverse=True,
)
FOUND = re.compile(rf"(?<![\w.])({'|'.join(map(re.escape, SYMBOLS))})(?![\w.]*\w)")


def subscripts(text: object) -> Markup:
    """HTML of a text: escaped, the symbols set with subscripts.

    Examples
    --------
    >>> str(subscripts("σ_y.dark < DSNU1288"))
    'σ<sub>y.dark</sub> &lt; DSNU<sub>1288</sub>'
    """
    return Markup(FOUND.sub(_set, str(escape(text))))


def _set(found: re.Match[str]) -> str:
    symbol = found[1]
    if "_" in symbol:
        letter, _, below = symbol.partition("_")
    else:
        letter, below = symbol[:4], symbol[4:]
    return f"{letter}<sub>{below}</sub>"
