"""Doubling temperature interval of the dark current (EMVA 1288, 7.2), where the span carries it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dnanalyze.analyzers.estimators.arrhenius import USUAL_EV, arrhenius_laws, unusual
from dnanalyze.analyzers.families.trends import HEADROOM, RELATIVE_ERROR
from dnanalyze.emva import kinds
from dnanalyze.emva.quantity import DarkCurrent, Quantity, known, unknown
from dnanalyze.loaders.thermometer import SLOPE_SPAN_C, tells_slope
from dnanalyze.thermal import KELVIN


def doubling(currents: Sequence[DarkCurrent]) -> tuple[Quantity, Quantity]:
    """Doubling temperature interval and activation energy, of a law fitted to mu_c.mean.

    T_d = k T^2 ln 2 / Ea at the middle temperature of an Arrhenius law.

    Parameters
    ----------
    currents : sequence of DarkCurrent
        By temperature, of one gain, channel and colour plane.

    Returns
    -------
    tuple of Quantity
        C, eV. Not determined for dark currents that stand out from their errors over less than 3 C,
        and for an activation energy that is none of a dark current.
    """
    told = []
    for current in currents:
        rate = current.quantities[kinds.CURRENT.key]
        if current.temperature_c is None or rate.value is None or rate.se is None:
            continue
        if rate.value > HEADROOM * rate.se:
            told.append((current.temperature_c, rate.value, rate.se))
    if len(told) < 2:
        return _neither("needs a significant dark current at two temperatures")
    celsius, rates, errors = np.array(told).T
    low, high = float(celsius.min()), float(celsius.max())
    if not tells_slope(celsius):
        return _neither(f"{low:.3g} to {high:.3g} °C: a span below {SLOPE_SPAN_C:g} °C")
    laws = arrhenius_laws(celsius + KELVIN, rates, np.hypot(errors / rates, RELATIVE_ERROR))
    energy, step = laws["activation_energy_ev"], laws.get("doubling_step_c")
    if step is None:
        return _neither("the dark current does not grow clearly with temperature")
    if unusual(energy.value, energy.se):
        low_ev, high_ev = USUAL_EV
        text = (
            f"an activation energy of {energy.value:.2g} ± {energy.se:.1g} eV is not that of a "
            f"dark current, {low_ev:g} to {high_ev:g} eV"
        )
        return _neither(text)
    span = f"{low:.3g} to {high:.3g} °C"
    return known(kinds.DOUBLING, step, span), known(kinds.ENERGY, energy, span)


def _neither(reason: str) -> tuple[Quantity, Quantity]:
    return unknown(kinds.DOUBLING, reason), unknown(kinds.ENERGY, reason)
