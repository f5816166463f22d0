"""What the statistics of columns and rows are, and what a misfit of each says."""

from __future__ import annotations

from dnanalyze.analyzers.statistics import Scale, StatisticInfo

_FAMILY = "lines"


def _outliers(kind: str) -> tuple[StatisticInfo, ...]:
    return (
        StatisticInfo(
            f"{kind}_outliers", _FAMILY, f"{kind}s", f"{kind}s 6 sigma off their neighbours",
            Scale.ROOT,
            high=f"there are more defect {kind}s than in the model",
            low=f"there are fewer defect {kind}s than in the model",
        ),
        StatisticInfo(
            f"{kind}_extreme", _FAMILY, "sigma", f"largest deviation of a {kind}",
            Scale.LOG,
            high=f"the largest deviation of a {kind} is {{ratio}} times the model's: a defect "
            f"{kind}",
            low=f"the largest deviation of a {kind} is smaller than in the model",
        ),
    )  # fmt: skip


def _share(name: str, title: str, why: str) -> StatisticInfo:
    return StatisticInfo(
        name, _FAMILY, "1", title,
        high=f"the {title} is larger than in the model: {why}",
        low=f"the {title} is smaller than in the model",
    )  # fmt: skip


def _lag(kind: str, why: str) -> StatisticInfo:
    return StatisticInfo(
        f"temporal_{kind}_lag1", _FAMILY, "1", f"correlation of neighbouring {kind} means in time",
        high=f"neighbouring {kind}s are more correlated in time than in the model: {why}",
        low=f"neighbouring {kind}s are anticorrelated in time, unlike in the model",
    )  # fmt: skip


def _told(name: str, unit: str, title: str, scale: Scale = Scale.LINEAR) -> StatisticInfo:
    """A value for information alone."""
    return StatisticInfo(name, _FAMILY, unit, title, scale, compared=False)


def _noise(prefix: str, of: str) -> tuple[StatisticInfo, ...]:
    return tuple(
        info
        for kind in ("column", "row")
        for info in (
            _told(
                f"{prefix}{kind}_noise",
                "1",
                f"{kind} noise {of} over that expected from the pixels",
                Scale.LOG,
            ),
            _told(
                f"{prefix}{kind}_mean_explained",
                "DN",
                f"standard deviation of the {kind} means expected from the pixels",
                Scale.LOG,
            ),
            _told(
                f"{prefix}{kind}_mean_sd",
                "DN",
                f"standard deviation of the {kind} means {of}",
                Scale.LOG,
            ),
        )
    )


INFOS: tuple[StatisticInfo, ...] = (
    *_outliers("column"),
    *_outliers("row"),
    *(
        _share(
            f"column_periodic_{p}",
            f"share of column variance with period {p}",
            "readout chains or a clock repeat every so many columns",
        )
        for p in (2, 3, 4, 8)
    ),
    _share("row_periodic_2", "share of row variance with period 2", "odd and even rows differ"),
    *(
        _share(
            f"column_taps_{p}",
            f"share of column variance that is steps between {p} equal taps",
            "the readout taps have different offsets",
        )
        for p in (2, 4, 8)
    ),
    _lag("row", "slow noise of the readout, 1/f noise along the scan"),
    _lag("column", "noise shared by groups of columns"),
    *_noise("", "of the single frame"),
    *_noise("temporal_", "of the temporal noise"),
    _told("column_kurtosis", "1", "excess kurtosis of the column means"),
    _told("row_kurtosis", "1", "excess kurtosis of the row means"),
)
