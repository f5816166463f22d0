"""Statistics to the dark quantities of EMVA 1288."""

from __future__ import annotations

from collections.abc import Sequence

from dnanalyze.analyzers.statistics import SettingStatistics, Statistics
from dnanalyze.emva import dark_current as currents
from dnanalyze.emva.doubling import doubling
from dnanalyze.emva.operating_point import quantities
from dnanalyze.emva.quantity import Emva, Group, Quantities
from dnanalyze.emva.reading import biased
from dnanalyze.emva.system_gain import photon_transfer, system_gain
from dnanalyze.errors import InputError


def evaluate(measured: Statistics, system_gain_dn_e: float | None = None) -> Emva:
    """The dark quantities of EMVA 1288 Release 4.0, per operating point and over them.

    Parameters
    ----------
    measured : Statistics
        From ``analyze``.
    system_gain_dn_e : float, optional
        Overall system gain K, DN/e-, where the user knows it; else the one recorded in the files,
        else the one that photon transfer in the dark tells.

    Returns
    -------
    Emva
        By gain, channel and colour plane. Every quantity has a value with its standard error, or
        the reason why it is not determined.

    Raises
    ------
    InputError
        A gain that is not above 0.

    Examples
    --------
    >>> from dnanalyze.demo.sensor import VirtualSensor
    >>> from dnanalyze.demo.virtual_sensor import generate
    >>> from dnanalyze.analyzers.analyze import analyze
    >>> frames = generate(VirtualSensor(), shape=(64, 64), frames=4)
    >>> found = evaluate(analyze(frames, workers=1), system_gain_dn_e=1.0)
    >>> noise = found.groups[0].points[0].quantities["temporal_dark_noise_e"]
    >>> noise.kind.symbol, round(noise.value)
    ('σ_d', 2)
    """
    if system_gain_dn_e is not None and not 0 < system_gain_dn_e < float("inf"):
        raise InputError(f"system gain {system_gain_dn_e:g}: it must be above 0 DN/e-")
    keys = dict.fromkeys((s.point.channel, s.point.gain, s.plane) for s in measured.settings)
    alone = len({key[:2] for key in keys}) == 1
    return Emva(
        tuple(
            _group(
                [s for s in measured.settings if (s.point.channel, s.point.gain, s.plane) == key],
                system_gain_dn_e,
                measured.sensor.system_gain_dn_e,
                alone,
                measured.sensor.black_level_at(
                    s.point for s in measured.settings if (s.point.channel, s.point.gain) == key[:2]
                ),
            )
            for key in keys
        )
    )


def _group(
    settings: Sequence[SettingStatistics],
    given: float | None,
    recorded: float | None,
    alone: bool,
    black_level: float | None,
) -> Group:
    first = settings[0]
    good = [s for s in settings if not biased(s)]
    error = currents.frame_error(good)
    temperatures = currents.by_temperature(good)
    transfer, line = photon_transfer(temperatures, error)
    exposures = {s.point.exposure_s for s in good}
    black = black_level is not None or len(exposures) > 1
    gain = system_gain(given, recorded, alone, transfer)
    dark = tuple(
        currents.dark_current(celsius, own, error, gain, black) for celsius, own in temperatures
    )
    return Group(
        first.point.gain,
        first.point.channel,
        first.plane,
        Quantities((gain, *((transfer,) if gain.kind != transfer.kind else ()), *doubling(dark))),
        dark,
        tuple(quantities(s, gain) for s in settings),
        line,
    )
