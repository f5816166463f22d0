"""Numbers that describe a patch: moments, quantiles, neighbours, profiles, filter responses.

None of them knows where the patch lies, in which frame or at which operating point.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dnanalyze.classifier.words import OF

FILTERS = 4  # random 3 x 3 filters: with the products of neighbours they see any short correlation
# Quantiles of a patch: those of a normal distribution at 2, 1 and 0 sigma
ORDERS = (0.02, 0.16, 0.5, 0.84, 0.98)
# Neighbours whose products are taken, (rows, columns)
LAGS = (
    (0, 1, "along the row"),
    (1, 0, "along the column"),
    (1, 1, "diagonal"),
    (0, 2, "along the row"),
    (2, 0, "along the column"),
)


@dataclass(frozen=True)
class Described:
    """Descriptors of patches.

    Parameters
    ----------
    values : ndarray
        (patches, descriptors).
    words : tuple of str
        What each descriptor measures, in words; several share them.
    """

    values: np.ndarray
    words: tuple[str, ...]

    def beside(self, other: Described) -> Described:
        """The descriptors of both, of the same patches."""
        values = np.concatenate((self.values, other.values), axis=1)
        return Described(values, self.words + other.words)

    def of(self, picture: str) -> Described:
        """With the name of the picture in the words."""
        return Described(self.values, tuple(f"{w}{OF}{picture}" for w in self.words))


Named = list[tuple[str, np.ndarray]]


def random_filters(rng: np.random.Generator) -> np.ndarray:
    """Filters without response to a constant, unit norm: (9, filters)."""
    made = rng.standard_normal((9, FILTERS))
    made -= made.mean(axis=0)
    return (made / np.linalg.norm(made, axis=0)).astype(np.float32)


def of_pixels(patches: np.ndarray, filters: np.ndarray) -> Described:
    """Descriptors of pixels in their surroundings, with nothing of their rows and columns.

    Parameters
    ----------
    patches : ndarray
        (patches, rows, columns), DN. Each row and column loses its mean first: what is drawn once
        per row or column of a sensor is too rare to learn from, and would hide the rest.
    filters : ndarray
        (9, filters), see `random_filters`.
    """
    x = np.asarray(patches, np.float32)
    x = x - x.mean(axis=1, keepdims=True)
    x -= x.mean(axis=2, keepdims=True)
    spread = np.sqrt(np.maximum((x * x).mean(axis=(1, 2)), 1e-12))
    return _described(
        [
            ("standard deviation", spread),
            *_shape(x, spread),
            *_neighbours(x, spread),
            *_filtered(x, spread, filters),
        ]
    )


def of_shading(patches: np.ndarray) -> Described:
    """Level of a patch over that of the field, and its slopes, DN."""
    x = np.asarray(patches, np.float32)
    made: Named = [("shading", x.mean(axis=(1, 2)))]
    for axis in (2, 1):
        means = x.mean(axis=axis)
        tilt = np.linspace(-1.0, 1.0, means.shape[1], dtype=np.float32)
        made.append(("shading", np.abs(means @ tilt) / len(tilt)))
    return _described(made)


def of_lines(patches: np.ndarray) -> Described:
    """Descriptors of the means of rows and of columns, and of the pixels' spread beside them."""
    x = np.asarray(patches, np.float32)
    level = x.mean(axis=(1, 2))
    x = x - level[:, None, None]
    spread = np.sqrt(np.maximum((x * x).mean(axis=(1, 2)), 1e-12))
    made: Named = [("standard deviation", spread), ("level of the strips", level)]
    for axis, name in ((2, "row"), (1, "column")):
        means = x.mean(axis=axis)
        steps = np.diff(means, axis=1)
        count = means.shape[1]
        sign = np.where(np.arange(count) % 2, 1.0, -1.0).astype(np.float32)
        power = np.abs(np.fft.rfft(means, axis=1)) ** 2
        deviation = means.std(axis=1)
        made += [
            (f"{name} profile", deviation),
            (f"{name} profile", np.abs(steps).max(axis=1)),
            (f"{name} profile", np.sqrt((steps**2).mean(axis=1))),
            (f"period of two {name}s", np.abs(means @ sign) / count),
            (f"periodic noise over the {name}s", power.max(axis=1) / (count * spread) ** 2),
        ]
    return _described(made)


def _described(named: Named) -> Described:
    values = np.stack([v for _, v in named], axis=1)
    return Described(np.nan_to_num(values), tuple(w for w, _ in named))


def _shape(x: np.ndarray, spread: np.ndarray) -> Named:
    """Form of the distribution of the values."""
    flat = np.sort(x.reshape(len(x), -1), axis=1)
    places = [round(q * (flat.shape[1] - 1)) for q in ORDERS]
    low, below, middle, above, high = flat[:, places].T
    unit = flat / spread[:, None]
    cube = unit * unit * unit
    return [
        ("lower tail", flat[:, 0]),
        ("lower tail", low),
        ("robust standard deviation", (above - below) / 2.0),
        ("skewness", middle / spread),
        ("skewness", (above + below - 2.0 * middle) / spread),
        ("skewness", cube.mean(axis=1)),
        ("upper tail", high),
        ("upper tail", flat[:, -1]),
        ("upper tail", (flat[:, -1] - flat[:, -2]) / spread),
        ("excess kurtosis", (cube * unit).mean(axis=1)),
    ]


def _neighbours(x: np.ndarray, spread: np.ndarray) -> Named:
    """Products of neighbours, and the most isolated pixels."""
    power = spread**2
    made: Named = []
    for down, right, where in LAGS:
        products = x[:, down:, right:] * x[:, : x.shape[1] - down, : x.shape[2] - right]
        name = f"correlation of neighbouring pixels ({where})"
        made.append((name, products.mean(axis=(1, 2)) / power))
    around = x[:, :-2, 1:-1] + x[:, 2:, 1:-1] + x[:, 1:-1, :-2] + x[:, 1:-1, 2:]
    alone = x[:, 1:-1, 1:-1] - around / 4.0
    squares = x * x
    pairs = (squares[:, :, 1:] * squares[:, :, :-1]).mean(axis=(1, 2))
    return [
        *made,
        ("isolated pixels", alone.max(axis=(1, 2)) / spread),
        ("isolated pixels", alone.min(axis=(1, 2)) / spread),
        ("clusters of deviating pixels", pairs / power**2),
    ]


def _filtered(x: np.ndarray, spread: np.ndarray, filters: np.ndarray) -> Named:
    """Responses of the random filters, and the strongest component of the spectrum."""
    views = np.lib.stride_tricks.sliding_window_view(x, (3, 3), axis=(1, 2))
    responses = (views.reshape(-1, 9) @ filters).reshape(len(x), -1, filters.shape[1])
    texture = np.einsum("pxf,pxf->fp", responses, responses) / responses.shape[1] / spread**2
    power = np.abs(np.fft.rfft2(x)) ** 2
    peak = power.reshape(len(x), -1).max(axis=1) / (spread**2 * x.shape[1] * x.shape[2])
    return [*(("texture", t) for t in texture), ("periodic noise", peak)]
