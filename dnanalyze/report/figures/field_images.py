"""The field of the sensor: measured, simulated, and what is left, on one robust scale."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np

from dnanalyze.report.fields import TEMPORAL, Fields, side_of
from dnanalyze.report.figures.colour_bar import bar_below
from dnanalyze.report.figures.style import Cell, Picture, panels
from dnanalyze.report.words import point_label, sentence, varied
from dnanalyze.robust import robust_deviation

CELLS = 400  # a side of a panel: about its pixels on the screen
SMALL_PANEL = 260  # the same of more than three panels
COLOUR_DEVIATIONS = 4.0  # robust standard deviations about the median that the colours span
TONES = 24  # colours of an image: fewer tones make a lighter page
MEASURED, LEFT = "cividis", "RdBu_r"
SCALE = f"Colours: the median and {COLOUR_DEVIATIONS:g} robust standard deviations to either side."


def block_means(image: np.ndarray, most: int = CELLS, squares: bool = False) -> np.ndarray:
    """An image of at most ``most`` cells a side: means of blocks of k x k pixels, k odd.

    A pattern of two pixels, such as odd and even columns, is lost in the mean of an even number of
    pixels; of an odd number it stays as plain against the noise as it was. What is left over at the
    far edges, less than a block, is cut off.

    Parameters
    ----------
    image : ndarray
        (rows, columns).
    most : int
        Cells a side.
    squares : bool
        Root of the mean square, for an image of standard deviations.

    Examples
    --------
    >>> import numpy as np
    >>> block_means(np.arange(36.0).reshape(6, 6), 2)
    array([[ 7., 10.],
           [25., 28.]])
    """
    k = side_of(image.shape, most)
    tall, wide = min(k, image.shape[0]), min(k, image.shape[1])
    rows, columns = image.shape[0] // tall, image.shape[1] // wide
    cut = image[: rows * tall, : columns * wide].astype(np.float64)
    blocks = np.square(cut) if squares else cut
    mean = blocks.reshape(rows, tall, columns, wide).mean(axis=(1, 3))
    return np.sqrt(mean) if squares else np.asarray(mean)


def robust_range(*images: np.ndarray, reach: float = COLOUR_DEVIATIONS) -> tuple[float, float]:
    """Ends of a colour scale: robust standard deviations about the median of all images, not empty.

    Examples
    --------
    >>> import numpy as np
    >>> low, high = robust_range(np.array([[9.0, 10.0, 11.0, 5000.0]]), reach=1.0)
    >>> low < 10 < high < 20
    True
    """
    values = np.concatenate([x[np.isfinite(x)].ravel() for x in images])
    if not values.size:
        return 0.0, 1.0
    middle = float(np.median(values))
    spread = robust_deviation(values, middle) or float(np.std(values))
    half = max(reach * spread, 1e-6 * max(abs(middle), 1.0))
    return middle - half, middle + half


def draw_field(
    ax: Any, image: np.ndarray, ends: tuple[float, float], colours: str, size: tuple[int, int]
) -> Any:
    """One image with its colour bar in DN.

    Parameters
    ----------
    ax : matplotlib axes
    image : ndarray
        Cells.
    ends : tuple of float
        Of the colour scale, DN.
    colours : str
    size : tuple of int
        (rows, columns) in pixels.
    """
    from matplotlib import colormaps

    tones = colormaps[colours].resampled(TONES)
    shown = ax.imshow(
        image, cmap=tones, vmin=ends[0], vmax=ends[1], interpolation="none", aspect="equal",
        extent=(0, size[1], size[0], 0),
    )  # fmt: skip
    bar_below(ax, shown, ends, aspect=24, margin=0.05)
    return ax


def _most(found: Fields, count: int) -> int:
    """Cells a side of one of ``count`` panels; a standard deviation of few frames is averaged."""
    most = CELLS if count <= 3 else SMALL_PANEL
    return most // 2 if found.place.kind == TEMPORAL else most


def _cells(found: Fields, count: int) -> dict[str, np.ndarray]:
    squares, most = found.place.kind == TEMPORAL, _most(found, count)
    return {name: block_means(image, most, squares) for name, image in found.images.items()}


def _panel(
    title: str,
    image: np.ndarray,
    ends: tuple[float, float],
    colours: str,
    size: tuple[int, int],
    count: int,
) -> Cell:
    """One of ``count`` panels side by side."""
    wide = min(3.35, 10.3 / max(count, 3) - 0.1)
    tall = 0.75 + min(max(wide * size[0] / size[1], 0.9), 3.4)
    draw = partial(draw_field, image=image, ends=ends, colours=colours, size=size)
    return Cell(draw, wide, tall, title=title)


def field_row(found: Fields | None) -> Picture | None:
    """Measured, each model, and the difference of measured and the last, side by side."""
    if found is None:
        return None
    size = next(iter(found.images.values())).shape
    count = len(found.images) + (len(found.images) > 1)
    cells = _cells(found, count)
    ends = robust_range(*cells.values())
    made = [
        _panel(name, image, ends, MEASURED, (size[0], size[1]), count)
        for name, image in cells.items()
    ]
    more = ""
    if len(cells) > 1:
        *_, last = cells
        left = cells["measured"] - cells[last]
        half = max(abs(v) for v in robust_range(left - np.nanmedian(left)))
        made.append(_panel("difference", left, (-half, half), LEFT, (size[0], size[1]), count))
        more = (
            f" Difference: measured − {last}. The model draws another sensor of the same design: "
            "compare stripes, gradients and spots, not single pixels."
        )
    return panels(
        made,
        f"{_where(found)}: {_what(found, count)}. {SCALE}{more}",
        "Images of the sensor: " + ", ".join([*cells, "difference"][:count]),
    )


def field_series(found: Sequence[Fields]) -> Picture | None:
    """The measured image of several operating points, each on its own scale."""
    if not found:
        return None
    made = []
    apart = varied(vars(f.place.point) for f in found)
    for one in found:
        image = _cells(one, len(found))["measured"]
        rows, columns = one.images["measured"].shape
        title = point_label(one.place.point, apart)
        ends = robust_range(image)
        made.append(_panel(title, image, ends, MEASURED, (rows, columns), len(found)))
    plane = f" Colour plane {found[0].place.plane}." if found[0].place.plane else ""
    return panels(
        made,
        f"{sentence(_what(found[0], len(found)))} {SCALE}{plane}",
        f"Images of the sensor at {len(found)} operating points.",
    )


def _what(found: Fields, count: int) -> str:
    rows, columns = next(iter(found.images.values())).shape
    k = side_of((rows, columns), _most(found, count))
    text = f"{found.place.kind} of {found.frames} frames" if found.frames > 1 else found.place.kind
    return f"{text}, {rows} × {columns} pixels" + (f", means of {k} × {k} pixels" if k > 1 else "")


def _where(found: Fields) -> str:
    place = found.place
    return point_label(place.point) + (f", plane {place.plane}" if place.plane else "")
