"""Gamma deviates from standard normal ones."""

from __future__ import annotations

import numpy as np

LARGEST_DEVIATE = 6.0  # standard normal deviates: 2e-9 of the pixels lie beyond
NODES = 1537  # of the table of gamma deviates: 2e-5 of their standard deviation for rms to 2


def gamma_deviates(normal: np.ndarray, rms: float) -> np.ndarray:
    """Standard normal deviates to gamma deviates of mean 1, by way of their probability, float32.

    ``rms``: standard deviation of the result.
    """
    from scipy.special import gammaincinv, ndtr

    shape = 1.0 / rms**2
    nodes = np.linspace(-LARGEST_DEVIATE, LARGEST_DEVIATE, NODES)
    table = gammaincinv(shape, ndtr(nodes)) / shape
    found: np.ndarray = np.interp(normal, nodes, table).astype(np.float32)
    return found
