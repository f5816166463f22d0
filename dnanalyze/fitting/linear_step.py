"""Several simulated sensors of one design, each fitted to the captures by one linear step."""

from __future__ import annotations

import numpy as np

from dnanalyze.fitting.least_squares import DAMPING
from dnanalyze.fitting.state import State, root_weights
from dnanalyze.fitting.vectors import Target


def linear_step(
    state: State, fitted: Target, held_out: Target, train: np.ndarray, test: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Misfits after the step of the parameters that lowers those on the fitted half.

    The derivatives are those of the state: all sensors of one design share them.

    Parameters
    ----------
    state : State
    fitted, held_out : Target
        The two halves.
    train, test : ndarray
        Misfits on either, in reproducibility SDs, (sensors, statistics).
    """
    jacobian = np.nan_to_num(state.jacobian)  # what no fit has moved yet absorbs nothing
    weights = [root_weights(z, state.weight) for z in train]
    steps = [_step(jacobian * w[:, None], z * w) for z, w in zip(train, weights, strict=True)]
    taken = np.reshape(steps, (len(train), jacobian.shape[1]))
    unseen = fitted.derivatives_of(held_out, jacobian)
    return train + taken @ jacobian.T, test + taken @ unseen.T


def _step(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The first step of a fit that lowers a step + b (Levenberg and Marquardt)."""
    size = np.sqrt(np.sum(a**2, axis=0))
    usable = size > 0.0
    scaled = a[:, usable] / size[usable]
    normal = scaled.T @ scaled + DAMPING * np.eye(scaled.shape[1])
    step = np.zeros(size.size)
    step[usable] = np.linalg.solve(normal, -scaled.T @ b) / size[usable]
    return step
