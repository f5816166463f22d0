"""Where in the picture a statistic comes from: pixels, rows or columns."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

import numpy as np
from scipy.ndimage import median_filter

from dnanalyze.robust import robust_deviation
from dnanalyze.workbench.frames import Kind

MOST_PIXELS = 300
MOST_LINES = 40
NEIGHBOURS = 9  # lines of which a line's median neighbour is taken
OFF = 4.0  # robust standard deviations from which a line is marked
PERIOD = re.compile(r"(column|row)_periodic_(\d+)$")
TAPS = re.compile(r"column_taps_(\d+)$")
LINES = re.compile(r"(?:pattern_)?(column|row)(?:s?_|$)|dsnu_1288_(col|row)")
NOISY = re.compile(r"temporal_(variance_)?q0\.9|temporal_kurtosis|blink|local_variance|noise_at_")
HIGH = re.compile(
    r"hot_(?!repeat_settings)|excess_|frame_above|tail_index|(pattern|frame)_q0\.99|"
    r"(pattern|frame)_(robust_)?(kurtosis|skewness)|(pattern|frame)_pmax8|transient_high"
)
LOW = re.compile(r"cold_|dead_|(pattern|frame)_q0\.0|(pattern|frame)_pmin8|transient_low")


@dataclass(frozen=True)
class Places:
    """Parts of an image that a statistic comes from.

    Parameters
    ----------
    kind : {"frame", "mean", "temporal noise"}
        The image that shows them.
    text : str
        What is marked.
    columns, rows : ndarray of int
        Whole lines.
    pixels : ndarray of int, (n, 2)
        Row and column of single pixels.
    """

    kind: Kind
    text: str
    columns: np.ndarray = field(default_factory=lambda: np.zeros(0, int))
    rows: np.ndarray = field(default_factory=lambda: np.zeros(0, int))
    pixels: np.ndarray = field(default_factory=lambda: np.zeros((0, 2), int))


def kind_of(name: str) -> Kind | None:
    """The image in which a statistic's places are sought; None where it has no place."""
    if name.startswith("temporal_") and not NOISY.match(name):
        return None
    if NOISY.match(name):
        return "temporal noise"
    if any(found.match(name) for found in (PERIOD, TAPS, LINES, HIGH, LOW)):
        return "mean"
    return None


def places(name: str, image: np.ndarray) -> Places | None:
    """What of an image a statistic comes from; None where it has no place.

    Parameters
    ----------
    name : str
        Of the statistic.
    image : ndarray
        As `kind_of` says, (rows, columns).

    Examples
    --------
    >>> import numpy as np
    >>> from dnanalyze.workbench.places import places
    >>> image = np.random.default_rng(1).normal(size=(40, 50))
    >>> image[:, 20] += 9.0
    >>> places("column_outliers", image).columns.tolist()
    [20]
    """
    kind = kind_of(name)
    if kind is None:
        return None
    if found := PERIOD.match(name):
        return _periodic(found[1], int(found[2]), image)
    if found := TAPS.match(name):
        ends = np.arange(1, int(found[1])) * image.shape[1] // int(found[1])
        return Places(kind, f"ends of {found[1]} equal taps", columns=ends)
    if found := LINES.match(name):
        return _lines(found[1] or found[2], image)
    return _pixels(image, LOW.match(name) is not None, kind)


def _means(lines: str, image: np.ndarray) -> np.ndarray:
    return np.asarray(np.nanmean(image, axis=0 if lines.startswith("col") else 1), float)


def _placed(lines: str, text: str, at: np.ndarray) -> Places:
    if lines.startswith("col"):
        return Places("mean", text.format("columns"), columns=at)
    return Places("mean", text.format("rows"), rows=at)


def _lines(lines: str, image: np.ndarray) -> Places:
    """The lines that are farthest from their neighbours."""
    means = _means(lines, image)
    off = means - median_filter(means, NEIGHBOURS, mode="nearest")
    noise = robust_deviation(off, 0.0) or float(off.std()) or 1.0
    order = np.argsort(-np.abs(off), kind="stable")[:MOST_LINES]
    at = np.sort(order[np.abs(off[order]) > OFF * noise])
    return _placed(lines, f"{len(at)} {{}} more than {OFF:g} robust σ off their neighbours", at)


def _periodic(lines: str, period: int, image: np.ndarray) -> Places:
    """The lines of that phase which is farthest from the others."""
    means = _means(lines, image)
    whole = len(means) // period * period
    if not whole:
        return _placed(lines, "{}", np.zeros(0, int))
    phases = means[:whole].reshape(-1, period).mean(axis=0)
    phase = int(np.argmax(np.abs(phases - np.median(phases))))
    every = np.arange(phase, len(means), period)
    text = f"every {period}th of the {{}}, from {phase}"
    return _placed(lines, text, every[:: -(-len(every) // MOST_LINES)])


def _pixels(image: np.ndarray, low: bool, kind: Kind) -> Places:
    """The farthest pixels of one side."""
    count = min(MOST_PIXELS, max(1, image.size // 1000))
    values = np.where(np.isfinite(image), image if low else -image, np.inf).ravel()
    at = np.argpartition(values, count - 1)[:count]
    rows, columns = np.unravel_index(at, image.shape)
    word = "darkest" if low else "noisiest" if kind == "temporal noise" else "brightest"
    pixels = np.column_stack([rows, columns])
    return Places(kind, f"the {count} {word} pixels", pixels=pixels)
