"""What is not stated where masked pixels stand among the others."""

from __future__ import annotations

from dataclasses import replace

from dnanalyze.analyzers.catalogue import FAMILIES
from dnanalyze.analyzers.statistics import SettingStatistics
from dnanalyze.loaders.masks import LEAST_PLACED

PLACED = ("neighbours", "lines", "spectrum", "shading")
ALSO = ("dsnu_1288_row", "dsnu_1288_col")


def abstained(setting: SettingStatistics, filled: float) -> SettingStatistics:
    """The statistics without those that the place of the pixels enters.

    Parameters
    ----------
    setting : SettingStatistics
    filled : float
        Share of masked pixels that repeat others, `Sensor.filled`.
    """
    if filled <= LEAST_PLACED:
        return setting
    names = {
        info.name for family in FAMILIES for info in family.INFOS if info.family in PLACED
    } | set(ALSO)
    reason = f"{100 * filled:.2g} % of the pixels are masked here and there"
    gone = {n: reason for n in names if n in setting.values}
    values = {n: v for n, v in setting.values.items() if n not in gone}
    curves = {n: c for n, c in setting.curves.items() if "spectrum" not in n and "psd" not in n}
    return replace(setting, values=values, curves=curves, missing=setting.missing | gone)
