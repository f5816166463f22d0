"""What the statistics of neighbours are, and what a misfit of each says."""

from __future__ import annotations

from collections.abc import Iterator

from dnanalyze.analyzers.statistics import Scale, StatisticInfo

_FAMILY = "neighbours"
LAG_NAMES = ("10", "01", "11", "20", "02")  # dx, dy
_AWAY = {
    "10": "horizontally adjacent pixels",
    "01": "vertically adjacent pixels",
    "11": "diagonally adjacent pixels",
    "20": "pixels two columns apart",
    "02": "pixels two rows apart",
}
_OF = {
    "frame": "in single frames",
    "pattern": "in the DSNU",
    "temporal": "in the temporal noise",
}
_TITLE = {"frame": "single frame", "pattern": "DSNU", "temporal": "temporal noise"}


def _correlations(part: str) -> Iterator[StatisticInfo]:
    for name in LAG_NAMES:
        title = f"correlation of {_AWAY[name]}, {_TITLE[part]}"
        title += ", where there is only one" if part == "frame" else ""
        yield StatisticInfo(
            f"{part}_corr_{name}", _FAMILY, "1", title,
            high=f"{_AWAY[name]} are more correlated {_OF[part]} than in the model: "
            "crosstalk, denoise, or a coarser structure",
            low=f"{_AWAY[name]} are less correlated {_OF[part]} than in the model: "
            "sharpening, or too much crosstalk in the model",
        )  # fmt: skip


def _ranks(part: str) -> Iterator[StatisticInfo]:
    for name, word, end in (("pmax8", "above", "high"), ("pmin8", "below", "low")):
        place = f"{word} all 8 neighbours {_OF[part]}"
        yield StatisticInfo(
            f"{part}_{name}", _FAMILY, "1",
            f"9 × share of pixels {word} all 8 neighbours, {_TITLE[part]}",
            high=f"more pixels lie {place} than in the model",
            low=f"fewer pixels lie {place} than in the model: a spatial filter cuts "
            f"{end} pixels, or crosstalk",
        )  # fmt: skip


INFOS: tuple[StatisticInfo, ...] = (
    *_correlations("pattern"),
    *_correlations("temporal"),
    *_correlations("frame"),
    *_ranks("frame"),
    *_ranks("pattern"),
    *_ranks("temporal"),
    *(
        StatisticInfo(
            name, _FAMILY, "1", f"share of a hot pixel's signal {where}",
            high=f"a hot pixel has more signal {where} than in the model: crosstalk or blooming",
            low=f"a hot pixel has less signal {where} than in the model",
        )
        for name, where in (
            ("hot_halo", "in each of its 8 neighbours"),
            ("hot_halo_2", "in each pixel at distance two"),
        )
    ),
    *(
        StatisticInfo(
            f"excess_{k}", _FAMILY, "pixels", f"pixels {k} sigma above all neighbours",
            Scale.ROOT,
            high="more single pixels lie far above all neighbours than in the model: hot or RTS "
            "pixels, or cosmic rays",
            low="fewer single pixels lie far above all neighbours than in the model: a defect "
            "correction caps them, or they form clusters",
        )
        for k in (4, 8, 16)
    ),
    StatisticInfo(
        "ties_max8", _FAMILY, "1", "share of the brightest 1 % that equal their highest neighbour",
        high="too many of the brightest pixels equal their highest neighbour exactly: a defect "
        "correction copies neighbours",
        low="fewer of the brightest pixels equal their highest neighbour than in the model",
    ),
    StatisticInfo(
        "local_variance_cv", _FAMILY, "1", "CV² of the temporal variance of 4×4 tiles", Scale.LOG,
        high="the temporal noise is less uniform over the field than in the model, {ratio} times: "
        "RTS pixels, heavy tails, or an edge-preserving denoise",
        low="the temporal noise is more uniform over the field than in the model",
    ),
    *(
        StatisticInfo(
            f"noise_shared_{lines}", _FAMILY, "1",
            f"correlation of the temporal variance of pixels in {lines} 2n and 2n + 1, less "
            f"twice the size of that in {lines} 2n + 1 and 2n + 2",
            high=f"pixels in {lines} 2n and 2n + 1 are noisy together more often than in the "
            "model; above 0 they share an amplifier",
            low=f"pixels in {lines} 2n and 2n + 1 are noisy together less often than in the model",
        )
        for lines in ("columns", "rows")
    ),
    StatisticInfo(
        "hh_kurtosis", _FAMILY, "1", "excess kurtosis of the diagonal Haar band",
        high="the diagonal detail (finest Haar band) of the temporal noise has heavier tails "
        "than in the model: a wavelet denoise, RTS pixels or cosmic rays",
        low="the diagonal detail (finest Haar band) of the temporal noise has lighter tails than "
        "in the model",
    ),
)  # fmt: skip
