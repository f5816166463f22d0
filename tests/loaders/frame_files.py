"""Small frames and folders of them, for the tests of the loaders."""

from pathlib import Path

import numpy as np
import tifffile


def noise(seed: int = 0, shape: tuple[int, int] = (16, 20), dtype: str = "uint16") -> np.ndarray:
    """A frame of integers around 100 DN."""
    return np.random.default_rng(seed).integers(90, 110, shape).astype(dtype)


def tif(path: Path, seed: int = 0, **options) -> Path:
    """A TIFF of ``noise``."""
    path.parent.mkdir(parents=True, exist_ok=True)
    tifffile.imwrite(path, noise(seed), metadata=None, **options)
    return path
