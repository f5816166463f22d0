"""What frames show, by plain NumPy: the statistics that claims are made of.

Each takes a stack (frames, rows, columns) in DN. Variances of lines are cleared of the white
noise that is averaged into them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np


def _float(stack: np.ndarray) -> np.ndarray:
    return np.asarray(stack, float)


def _robust(values: np.ndarray) -> float:
    return float(1.4826 * np.median(np.abs(values - np.median(values))))


def _difference(stack: np.ndarray) -> np.ndarray:
    """Differences of successive frames over sqrt 2, each less its median: temporal noise."""
    d = np.diff(_float(stack), axis=0) / np.sqrt(2.0)
    return d - np.median(d, axis=(1, 2), keepdims=True)


def mean(stack: np.ndarray) -> float:
    """Median over the pixels of the mean frame, DN."""
    return float(np.median(_float(stack).mean(0)))


def _inner(values: np.ndarray) -> np.ndarray:
    """What lies within 5 robust deviations; whole numbers do no harm."""
    limit = 5.0 * max(_robust(values), 0.5)
    return values[np.abs(values - np.median(values)) <= limit]


def _inner_sd(values: np.ndarray) -> float:
    """Standard deviation without outliers."""
    return float(np.std(_inner(values)))


def pattern_skewness(stack: np.ndarray) -> float:
    """Skewness of the mean frame without its outliers; 0 for a normal distribution."""
    inner = _inner(_float(stack).mean(0))
    return float(np.mean((inner - inner.mean()) ** 3) / inner.std() ** 3)


def temporal_sd(stack: np.ndarray) -> float:
    """Standard deviation of the temporal noise without its outliers, DN."""
    return _inner_sd(_difference(stack))


def temporal_kurtosis(stack: np.ndarray) -> float:
    """Excess kurtosis of the differences of frames; 0 for a Gaussian."""
    d = _difference(stack)
    return float(np.mean(d**4) / np.mean(d**2) ** 2 - 3.0)


def noisy_share(stack: np.ndarray, times: float = 2.0) -> float:
    """Share of pixels whose temporal standard deviation exceeds ``times`` the median one."""
    sd = _float(stack).std(0, ddof=1)
    return float(np.mean(sd > times * np.median(sd)))


def _line_noise(stack: np.ndarray, axis: int) -> float:
    frames = _float(stack)
    frames = frames - frames.mean(axis=(1, 2), keepdims=True)
    away = frames - frames.mean(0)
    count = len(frames)
    lines = away.mean(axis=axis)
    white = np.mean((away - np.expand_dims(lines, axis)) ** 2) / (frames.shape[axis] - 1)
    return float(np.sqrt(max(0.0, (np.mean(lines**2) - white) * count / (count - 1))))


def row_noise_sd(stack: np.ndarray) -> float:
    """Standard deviation of offsets of rows that are new in every frame, DN."""
    return _line_noise(stack, 2)


def column_noise_sd(stack: np.ndarray) -> float:
    """The same of columns."""
    return _line_noise(stack, 1)


def _line_fpn(stack: np.ndarray, axis: int) -> float:
    """From the covariance of two halves of the pixels of every line: what they share is the line's.

    Medians, which hot pixels do not move.
    """
    image = np.moveaxis(_float(stack).mean(0), axis, 0)
    one, other = np.median(image[::2], axis=0), np.median(image[1::2], axis=0)
    return float(np.sqrt(max(0.0, np.mean((one - one.mean()) * (other - other.mean())))))


def row_fpn_sd(stack: np.ndarray) -> float:
    """Standard deviation of the row means of the mean frame, DN."""
    return _line_fpn(stack, 1)


def column_fpn_sd(stack: np.ndarray) -> float:
    """Standard deviation of the column means of the mean frame, DN."""
    return _line_fpn(stack, 0)


def frame_offset_sd(stack: np.ndarray) -> float:
    """Standard deviation of the medians of the frames, DN."""
    return float(np.std(_float(stack).mean(axis=(1, 2)), ddof=1))


def _hot(image: np.ndarray, sigmas: float) -> np.ndarray:
    return image > np.median(image) + sigmas * _robust(image)


def hot_share(stack: np.ndarray, sigmas: float = 6.0) -> float:
    """Share of pixels of the mean frame above its median by so many robust deviations."""
    return float(np.mean(_hot(_float(stack).mean(0), sigmas)))


def hot_height(stack: np.ndarray, sigmas: float = 6.0) -> float:
    """Median height of these over the median, DN."""
    image = _float(stack).mean(0)
    return float(np.median(image[_hot(image, sigmas)]) - np.median(image))


def hot_spread(stack: np.ndarray, sigmas: float = 6.0) -> float:
    """Robust relative standard deviation of their heights."""
    image = _float(stack).mean(0)
    heights = image[_hot(image, sigmas)] - np.median(image)
    return _robust(heights) / float(np.median(heights))


def low_share(stack: np.ndarray, sigmas: float = 5.0) -> float:
    """Share of pixels below the median of the mean frame by so many robust deviations."""
    image = _float(stack).mean(0)
    return float(np.mean(image < np.median(image) - sigmas * _robust(image)))


def dark_columns(stack: np.ndarray, below: float = 0.5) -> float:
    """Share of columns whose mean lacks ``below`` of the spread between median and minimum."""
    columns = np.median(_float(stack).mean(0), axis=0)
    middle = np.median(columns)
    return float(np.mean(columns < middle - below * (middle - columns.min()) - 1.0))


def transient_share(stack: np.ndarray, sigmas: float = 8.0) -> float:
    """Share of samples above the median of their pixel by so many deviations of the noise."""
    frames = _float(stack)
    away = frames - np.median(frames, axis=0)
    return float(np.mean(away > sigmas * temporal_sd(stack)))


def _smooth(image: np.ndarray, block: int) -> np.ndarray:
    rows, columns = (n // block for n in image.shape)
    tiles = image[: rows * block, : columns * block].reshape(rows, block, columns, block)
    return np.median(tiles, axis=(1, 3))


def smooth_rms(stack: np.ndarray, block: int = 16) -> float:
    """Standard deviation of the medians of blocks of the mean frame, DN."""
    return float(np.std(_smooth(_float(stack).mean(0), block)))


def plane_rms(stack: np.ndarray) -> float:
    """Standard deviation of the plane fitted to the blocks of the mean frame, DN."""
    tiles = _smooth(_float(stack).mean(0), 16)
    y, x = (np.linspace(-1, 1, n) for n in tiles.shape)
    slope_y, slope_x = tiles.mean(1) @ y / (y @ y), tiles.mean(0) @ x / (x @ x)
    return float(np.sqrt(slope_y**2 * np.mean(y**2) + slope_x**2 * np.mean(x**2)))


def edge_excess(stack: np.ndarray, width: int = 4) -> float:
    """Median of a frame of so many pixels at the four edges less that of the centre, DN."""
    image = _float(stack).mean(0)
    rows, columns = image.shape
    inner = np.zeros(image.shape, bool)
    inner[width:-width, width:-width] = True
    centre = image[rows // 4 : -rows // 4, columns // 4 : -columns // 4]
    return float(np.median(image[~inner]) - np.median(centre))


def corner_excess(stack: np.ndarray, size: int = 16) -> float:
    """Largest median of the four corners less the centre's, DN."""
    image = _float(stack).mean(0)
    rows, columns = image.shape
    centre = np.median(image[rows // 4 : -rows // 4, columns // 4 : -columns // 4])
    parts = (image[s, t] for s in _ends(size) for t in _ends(size))
    return float(max(np.median(p) for p in parts) - centre)


def _ends(size: int) -> tuple[slice, slice]:
    return slice(0, size), slice(-size, None)


def edge_noise_ratio(stack: np.ndarray, width: int = 4) -> float:
    """Temporal noise at the edges over that of the centre."""
    d = _difference(stack)
    ring = np.ones(d.shape[1:], bool)
    ring[width:-width, width:-width] = False
    rows, columns = ring.shape
    centre = d[:, rows // 4 : -rows // 4, columns // 4 : -columns // 4]
    return _inner_sd(d[:, ring]) / _inner_sd(centre)


def column_noise_spread(stack: np.ndarray) -> float:
    """Relative standard deviation over the columns of their temporal noise."""
    d = _difference(stack)
    sd = np.array([_inner_sd(d[:, :, j]) for j in range(d.shape[2])])
    return float(sd.std() / sd.mean())


def segment_sd(stack: np.ndarray, columns: Sequence[int] = (), rows: Sequence[int] = ()) -> float:
    """Standard deviation of the medians of the parts between these boundaries, DN."""
    image = _float(stack).mean(0)
    parts = [
        np.median(p)
        for strip in np.split(image, list(columns), axis=1)
        for p in np.split(strip, list(rows), axis=0)
    ]
    return float(np.std(parts))


def interleaved_sd(stack: np.ndarray, period: int = 2) -> float:
    """Standard deviation of the medians of every ``period``-th column, DN."""
    image = _float(stack).mean(0)
    return float(np.std([np.median(image[:, j::period]) for j in range(period)]))


def mosaic_sd(stack: np.ndarray) -> float:
    """Standard deviation of the medians of the four phases of a 2 x 2 mosaic, DN."""
    image = _float(stack).mean(0)
    return float(np.std([np.median(image[i::2, j::2]) for i in (0, 1) for j in (0, 1)]))


def raster_covariance(stack: np.ndarray, lag: int = 1) -> float:
    """Covariance of temporal noise along the rows at a lag, DN2."""
    d = _difference(stack)
    limit = 6.0 * _robust(d)
    d = np.clip(d, -limit, limit)
    return float(np.mean(d[:, :, lag:] * d[:, :, :-lag]))


def neighbour_correlation(stack: np.ndarray, rows: int = 0, columns: int = 1) -> float:
    """Correlation of the temporal noise of neighbours, white row and column noise taken out."""
    d = _difference(stack)
    limit = 5.0 * _robust(d)
    d = np.clip(d, -limit, limit)
    d = d - d.mean(2, keepdims=True)
    d = d - d.mean(1, keepdims=True)
    near = d[:, : d.shape[1] - rows, : d.shape[2] - columns]
    far = d[:, rows:, columns:]
    return float(np.mean(near * far) / np.mean(d * d))


def frame_correlation(stack: np.ndarray) -> float:
    """Correlation of a pixel's noise in successive frames, cleared of the mean's bias -1/n."""
    frames = _float(stack)
    frames = frames - np.median(frames, axis=(1, 2), keepdims=True)
    away = frames - frames.mean(0)
    limit = 5.0 * _robust(away)
    away = np.clip(away, -limit, limit)
    return float(np.mean(away[1:] * away[:-1]) / np.mean(away**2) + 1.0 / (len(frames) - 1))


def maxima_share(stack: np.ndarray) -> float:
    """Nine times the share of pixels above all 8 neighbours; 1 for exchangeable pixels."""
    rng = np.random.default_rng(0)
    frames = _float(stack) + rng.uniform(-0.5, 0.5, np.shape(stack))
    inner = frames[:, 1:-1, 1:-1]
    above = np.ones(inner.shape, bool)
    rows, columns = frames.shape[1:]
    for i in range(3):
        for j in range(3):
            if (i, j) != (1, 1):
                above &= inner > frames[:, i : rows - 2 + i, j : columns - 2 + j]
    return float(9.0 * above.mean())


def lowest_code_share(stack: np.ndarray) -> float:
    """Share of samples at the lowest code that occurs."""
    return float(np.mean(stack == np.min(stack)))


def empty_codes(stack: np.ndarray) -> float:
    """Share of the codes between the 2 and 98 % quantiles that never occur."""
    low, high = np.quantile(stack, [0.02, 0.98]).astype(int)
    counts = np.bincount(np.asarray(stack).ravel().astype(int), minlength=high + 1)[low : high + 1]
    return float(np.mean(counts == 0))


def code_roughness(stack: np.ndarray) -> float:
    """Relative rms of the histogram about its mean with the neighbouring codes."""
    low, high = np.quantile(stack, [0.1, 0.9]).astype(int)
    counts = np.bincount(np.asarray(stack).ravel().astype(int), minlength=high + 3).astype(float)
    c = counts[low - 1 : high + 2]
    inner = c[1:-1]
    smooth = (c[:-2] + 2.0 * inner + c[2:]) / 4.0
    return float(np.sqrt(np.mean((inner / np.maximum(smooth, 1.0) - 1.0) ** 2)))


def spectral_peak(stack: np.ndarray) -> float:
    """Largest bin of the power spectrum of the differences of frames over the median bin."""
    d = _difference(stack)
    power = np.mean(np.abs(np.fft.rfft2(d)) ** 2, axis=0)
    power[0, :], power[:, 0] = 0.0, 0.0
    return float(power.max() / np.median(power))


def trailing_share(stack: np.ndarray, axis: int = 0, sigmas: float = 30.0) -> float:
    """Median excess of the pixel after a hot one over the pixel before it, of the hot height."""
    image = _float(stack).mean(0)
    image = image - np.median(image)
    image = image if axis == 0 else image.T
    hot = image > sigmas * _robust(image)
    hot[:2], hot[-2:] = False, False
    i, j = np.nonzero(hot)
    return float(np.median((image[i + 1, j] - image[i - 1, j]) / image[i, j]))


def wandering_share(stack: np.ndarray, sigmas: float = 6.0) -> float:
    """Share of pixels whose range over the frames exceeds so many deviations of the noise."""
    return float(np.mean(np.ptp(_float(stack), axis=0) > sigmas * temporal_sd(stack)))


def ring_rms(stack: np.ndarray) -> float:
    """Standard deviation of the mean frame after a 3 x 3 mean, smooth shape taken out, DN."""
    image = _float(stack).mean(0)
    windows = np.lib.stride_tricks.sliding_window_view(image, (3, 3))
    return float(np.std(windows.mean(axis=(2, 3))))


STATISTICS: dict[str, Callable[..., float]] = {
    f.__name__: f
    for f in (
        mean, temporal_sd, temporal_kurtosis, noisy_share, row_noise_sd, column_noise_sd,
        row_fpn_sd, column_fpn_sd, frame_offset_sd, hot_share, hot_height, hot_spread, low_share,
        dark_columns, transient_share, smooth_rms, plane_rms, edge_excess, corner_excess,
        edge_noise_ratio, column_noise_spread, segment_sd, interleaved_sd, mosaic_sd,
        raster_covariance, neighbour_correlation, frame_correlation, maxima_share,
        lowest_code_share, empty_codes, code_roughness, spectral_peak, trailing_share,
        wandering_share, ring_rms, pattern_skewness,
    )
}  # fmt: skip


def charge_slope(stacks: Sequence[np.ndarray]) -> float:
    """Slope of the temporal variance over the mean from the coldest to the hottest point, DN.

    The gain where each electron counts alike; the gain times F^2 behind a multiplication.
    """
    cold, hot = stacks[0], stacks[-1]
    return (temporal_sd(hot) ** 2 - temporal_sd(cold) ** 2) / (mean(hot) - mean(cold))


def frame_growth(stacks: Sequence[np.ndarray]) -> float:
    """Offsets of whole frames at the hottest point over those at the coldest."""
    return frame_offset_sd(stacks[-1]) / frame_offset_sd(stacks[0])


OVER_POINTS: dict[str, Callable[..., float]] = {f.__name__: f for f in (charge_slope, frame_growth)}
