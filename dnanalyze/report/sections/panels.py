"""The panel of each family: its figures, its worst statistics, all its numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from dnanalyze.analyzers.statistics import SettingStatistics
from dnanalyze.comparator.error import TOLERABLE
from dnanalyze.report.figures import (
    code_use,
    distribution,
    exceedance,
    frame_means,
    noise_and_dark_signal,
    over_operating_points,
    rows_and_columns,
    shading,
    spectrum,
    spectrum_2d,
)
from dnanalyze.report.figures.style import Layer, Picture
from dnanalyze.report.page import Section, Table
from dnanalyze.report.statistic_rows import info, worst
from dnanalyze.report.words import (
    FAMILIES,
    family_title,
    gap,
    is_number,
    number,
    point_label,
    varied,
    with_error,
)

Drawn = Sequence[Layer]
Rows = Sequence[Mapping[str, Any]]


def _some(names: Sequence[str], caption: str) -> Callable[[Drawn], Picture | None]:
    return lambda drawn: over_operating_points.statistics(drawn, names, caption)


Draw = Callable[[Drawn], Picture | Sequence[Picture | None] | None]
FIGURES: dict[str, tuple[Draw, ...]] = {
    "level": (
        noise_and_dark_signal.over_temperature,
        _some(
            ("temporal_noise_core", "pattern_noise_core", "frame_noise_core", "median"),
            "Standard deviations of the central 68 % of the pixels, which hot pixels do not "
            "affect, and the median dark signal.",
        ),
    ),
    "distribution": (
        distribution.histograms,
        _some(
            (
                "pattern_q0.001",
                "pattern_q0.99",
                "pattern_q0.999",
                "pattern_q0.9999",
                "frame_q0.001",
                "frame_q0.99",
                "frame_q0.999",
                "temporal_kurtosis",
                "temporal_skewness",
            ),
            "Quantiles of the mean frame and of single frames minus the median, and the excess "
            "kurtosis and the skewness of the temporal dark noise.",
        ),
    ),
    "tails": (
        exceedance.exceedance,
        _some(
            (
                "hot_count_8",
                "hot_count_32",
                "cold_count_8",
                "transient_high",
                "transient_adjacent",
                "hot_pairs",
                "hot_repeat",
                "dead_count",
            ),
            "Numbers of hot and cold pixels and of pixels that deviate in one frame only, and the "
            "share of hot pixels that repeat.",
        ),
    ),
    "spectrum": (spectrum.spectra, spectrum_2d.planes),
    "lines": (
        rows_and_columns.profiles,
        rows_and_columns.spectra,
        _some(
            (
                "column_outliers",
                "row_outliers",
                "column_periodic_2",
                "row_periodic_2",
                "column_taps_2",
                "temporal_row_lag1",
                "temporal_column_lag1",
                "column_extreme",
            ),
            "Column and row defects, periodic components and steps between readout taps.",
        ),
    ),
    "neighbours": (
        _some(
            (
                "pattern_corr_10",
                "pattern_corr_01",
                "pattern_corr_11",
                "hot_halo",
                "temporal_corr_10",
                "temporal_corr_01",
                "temporal_pmax8",
                "frame_pmax8",
            ),
            "Correlation of neighbouring pixels (along the row, along the column, diagonal), the "
            "halo of hot pixels, and how often a pixel exceeds all eight neighbours (1 by chance).",
        ),
    ),
    "time": (
        frame_means.frame_means,
        _some(
            (
                "noise_at_50",
                "noise_at_90",
                "noise_at_99",
                "noise_at_999",
                "temporal_variance_q0.9",
                "temporal_variance_q0.999",
                "temporal_r1",
                "blink_repeat",
            ),
            "Temporal variance of typical and of hot pixels, its distribution over the pixels, and "
            "the correlation from frame to frame.",
        ),
    ),
    "codes": (
        code_use.roughness,
        _some(
            ("lattice", "unused_codes", "code_roughness", "low_spike"),
            "Missing codes, roughness of the histogram, and clipping.",
        ),
    ),
    "shading": (shading.maps,),
}


def family_panels(
    drawn: Drawn,
    errors: Mapping[str, float] | None = None,
    rows: Rows = (),
) -> list[Section]:
    """A section for each family that has something to show.

    Parameters
    ----------
    drawn : sequence of Layer
        The measured first.
    errors : mapping, optional
        Error of each family.
    rows : sequence of mapping
        Rows of a comparison.
    """
    errors = errors or {}
    present = {info(n).family for s in drawn[0].statistics.settings for n in s.values}
    names = [*FAMILIES, *sorted(present - set(FAMILIES))]
    made = []
    for name in names:
        if name not in present:
            continue
        error = errors.get(name)
        known = is_number(error)
        table = compared(rows, name) if rows else measured(drawn[0], name)
        made.append(
            Section(
                f"family-{name}",
                family_title(name),
                pictures=pictures_of(drawn, name),
                tables=[*off_table(rows, name), *([] if table is None else [table])],
                badge=number(error) if known else "",
                calm=not known or error < TOLERABLE,  # type: ignore[operator]
            )
        )
    return made


def pictures_of(drawn: Drawn, family: str) -> list[Picture]:
    """Every figure of a family that has something to show."""
    made: list[Picture] = []
    for figure in FIGURES.get(family, ()):
        found = figure(drawn)
        some = [found] if found is None or isinstance(found, Picture) else found
        made += [p for p in some if p is not None]
    return made


def off_table(rows: Rows, family: str) -> list[Table]:
    """The statistics of a family that are off the most, where any is off by 3 sigma."""
    off = [r for r in worst(list(rows), family, 5) if abs(r["discrepancy"]) >= 3]
    return largest(rows, "largest differences", of=off)


def largest(rows: Rows, title: str, most: int = 8, of: Rows | None = None) -> list[Table]:
    """The largest differences, or these rows; nothing without any."""
    parts = varied(rows)
    cells = [
        (
            r["name"] if of is None else info(r["name"]).title,
            point_label(r, parts),
            number(r["measured"]),
            number(r["simulated"]),
            gap(r["measured"], r["simulated"], r.get("unit", ""), r.get("scale", "")),
            number(r["discrepancy"], 2),
        )
        for r in (worst(list(rows), most=most) if of is None else of)
    ]
    note = "sigma: difference over the reproducibility standard deviation."
    columns = (title, "at", "measured", "model", "difference", "sigma")
    return [Table(columns, cells, words=2, note=note if of is None else "")] if cells else []


def compared(rows: Rows, family: str) -> Table | None:
    """Every row of a family, folded."""
    own = [r for r in rows if r["family"] == family]
    if not own:
        return None
    parts = varied(rows)
    cells = [
        (
            r["name"],
            point_label(r, parts),
            number(r["measured"]),
            number(r["simulated"]),
            r.get("unit", ""),
            gap(r["measured"], r["simulated"], r.get("unit", ""), r.get("scale", "")),
            number(r["floor"], 2),
            number(r["discrepancy"], 2),
        )
        for r in own
    ]
    columns = (
        "statistic", "operating point", "measured", "model", "unit", "difference",
        "sigma", "discrepancy",
    )  # fmt: skip
    return Table(columns, cells, words=2, title=f"All {len(cells)} numbers", folded=True)


def measured(layer: Layer, family: str) -> Table | None:
    """Every measured value of a family, folded: a row a statistic, a column a setting."""
    settings = layer.statistics.settings
    names = list(dict.fromkeys(n for s in settings for n in s.values if info(n).family == family))
    if not names:
        return None
    if len(settings) <= 6:
        heads = [f"{s.point.label()} {s.plane}".strip() for s in settings]
        cells = [(n, info(n).unit, *(_value(s, n) for s in settings)) for n in names]
        return Table(
            ("statistic", "unit", *heads),
            cells,
            words=2,
            title=f"All {len(names)} statistics",
            folded=len(settings) > 1,
        )
    long = [
        (n, f"{s.point.label()} {s.plane}".strip(), _value(s, n), info(n).unit)
        for n in names
        for s in settings
        if n in s.values
    ]
    return Table(
        ("statistic", "operating point", "value", "unit"),
        long,
        words=2,
        title=f"All {len(long)} numbers",
        folded=True,
    )


def _value(setting: SettingStatistics, name: str) -> str:
    found = setting.values.get(name)
    if found is None:
        return "–"
    return with_error(found.value, info(name).scale.plain_error(found.value, found.se))
