"""Frames of the plain sensor, filtered by the libraries that people filter with.

Frame by frame, as a camera's processor would: what comes out is rounded to codes again. Truth is
the share of pixels that the filter changed and the noise that it took away, both measured.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import asdict

import numpy as np

from third_party.case import Claim, Drawn, Recipe
from third_party.generators.plain import Effect, draw_sensor, expose, hot_pixels
from third_party.measures import STATISTICS

Filter = Callable[[np.ndarray, float, float], np.ndarray]  # frame, its noise (DN), amount


def bilateral_skimage(frame: np.ndarray, noise: float, amount: float) -> np.ndarray:
    from skimage.restoration import denoise_bilateral

    top = frame.max()
    return top * denoise_bilateral(
        frame / top, win_size=5, sigma_color=amount * noise / top, sigma_spatial=1.5
    )


def nlm_skimage(frame: np.ndarray, noise: float, amount: float) -> np.ndarray:
    from skimage.restoration import denoise_nl_means

    return denoise_nl_means(
        frame, patch_size=3, patch_distance=4, h=amount * noise, sigma=noise, fast_mode=True
    )


def wavelet_skimage(frame: np.ndarray, noise: float, amount: float) -> np.ndarray:
    from skimage.restoration import denoise_wavelet

    low, high = frame.min(), frame.max()
    scaled = (frame - low) / (high - low)
    out = denoise_wavelet(scaled, sigma=amount * noise / (high - low), rescale_sigma=False)
    return out * (high - low) + low


def tv_skimage(frame: np.ndarray, noise: float, amount: float) -> np.ndarray:
    from skimage.restoration import denoise_tv_chambolle

    return denoise_tv_chambolle(frame, weight=amount * noise)


def gaussian_skimage(frame: np.ndarray, noise: float, amount: float) -> np.ndarray:
    from skimage.filters import gaussian

    return gaussian(frame, sigma=amount, mode="nearest", preserve_range=True)


def median_opencv(frame: np.ndarray, noise: float, amount: float) -> np.ndarray:
    import cv2

    middle = cv2.medianBlur(frame.astype(np.uint16), 3)
    return (1 - amount) * frame + amount * middle


def bilateral_opencv(frame: np.ndarray, noise: float, amount: float) -> np.ndarray:
    import cv2

    return cv2.bilateralFilter(frame.astype(np.float32), 5, amount * noise, 1.5)


def gaussian_opencv(frame: np.ndarray, noise: float, amount: float) -> np.ndarray:
    import cv2

    return cv2.GaussianBlur(frame, (3, 3), amount)


def nlm_opencv(frame: np.ndarray, noise: float, amount: float) -> np.ndarray:
    import cv2

    return cv2.fastNlMeansDenoising(
        frame.astype(np.uint16), h=[float(amount * noise)], templateWindowSize=3,
        searchWindowSize=9, normType=cv2.NORM_L1,
    ).astype(float)  # fmt: skip


def lacosmic_astroscrappy(frame: np.ndarray, noise: float, amount: float) -> np.ndarray:
    from astroscrappy import detect_cosmics

    _, clean = detect_cosmics(
        frame.astype(np.float32), sigclip=amount, sigfrac=0.3, objlim=1.0, gain=1.0,
        readnoise=noise, satlevel=1e6, sepmed=False,
    )  # fmt: skip
    return clean


def lacosmic_ccdproc(frame: np.ndarray, noise: float, amount: float) -> np.ndarray:
    from ccdproc import cosmicray_lacosmic

    clean, _ = cosmicray_lacosmic(
        frame.astype(float), sigclip=amount, objlim=1.0, readnoise=noise, satlevel=1e6,
        gain_apply=False,
    )  # fmt: skip
    return np.asarray(clean)


def median_ccdproc(frame: np.ndarray, noise: float, amount: float) -> np.ndarray:
    from ccdproc import cosmicray_median

    clean, _ = cosmicray_median(
        frame.astype(float), error_image=noise, thresh=amount, mbox=3, rbox=3
    )
    return np.asarray(clean)


# name: (kind, filter, moderate, strong); thresholds in deviations of the noise
EFFECTS: dict[str, tuple[str, Filter, float, float]] = {
    "bilateral_skimage": ("denoise", bilateral_skimage, 1.5, 3.0),
    "nlm_skimage": ("denoise", nlm_skimage, 0.5, 1.0),
    "wavelet_skimage": ("denoise", wavelet_skimage, 0.7, 1.4),
    "tv_skimage": ("denoise", tv_skimage, 0.3, 1.0),
    "gaussian_skimage": ("denoise", gaussian_skimage, 0.4, 0.7),
    "median_opencv": ("denoise", median_opencv, 0.4, 1.0),
    "bilateral_opencv": ("denoise", bilateral_opencv, 1.5, 3.0),
    "gaussian_opencv": ("denoise", gaussian_opencv, 0.45, 0.8),
    "nlm_opencv": ("denoise", nlm_opencv, 1.0, 2.5),
    "lacosmic_astroscrappy": ("dpc", lacosmic_astroscrappy, 8.0, 4.5),
    "lacosmic_ccdproc": ("dpc", lacosmic_ccdproc, 8.0, 4.5),
    "median_ccdproc": ("dpc", median_ccdproc, 8.0, 4.5),
}


def drawn(kind: str, filtering: Filter, amount: float, seed: int) -> Drawn:
    """A plain sensor, with hot pixels where a defect correction shall find some."""
    sensor = draw_sensor(np.random.default_rng([seed, 0]))
    effects: tuple[Effect, ...] = ()
    if kind == "dpc":
        effects = (hot_pixels(sensor, np.random.default_rng([seed, 3, 0]), 0.004),)
    stacks, changed = {}, []
    raw = expose(sensor, effects, seed)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for point, stack in raw.items():
            noise = STATISTICS["temporal_sd"](stack)
            filtered = np.stack([filtering(f.astype(float), noise, amount) for f in stack])
            stacks[point] = np.clip(np.rint(filtered), 0, 65535).astype(np.uint16)
            changed.append(float(np.mean(stacks[point] != stack)))
    parameters = asdict(sensor) | {"amount": amount, "changed": changed}
    return Drawn(stacks, _claims(kind, raw, stacks), parameters)


def _claims(kind: str, raw: dict, filtered: dict) -> tuple[Claim, ...]:
    """Denoised: less temporal noise when cold, where pixels are alike; corrected: fewer hot."""
    if kind == "denoise":
        before = STATISTICS["temporal_sd"](raw[min(raw)])
        return (Claim("temporal_sd", 0.0, 0.95 * before, 0),)
    before = STATISTICS["hot_share"](raw[max(raw)], sigmas=10.0)
    return (Claim("hot_share", 0.0, 0.9 * before, -1, {"sigmas": 10.0}),)


def _single(name: str) -> Recipe:
    kind, filtering, *amounts = EFFECTS[name]
    hides = (kind, "hot_pixels") if kind == "dpc" else (kind,)
    return Recipe(hides, lambda a, seed: drawn(kind, filtering, a, seed), tuple(amounts))


RECIPES: dict[str, Recipe] = {name: _single(name) for name in EFFECTS}
