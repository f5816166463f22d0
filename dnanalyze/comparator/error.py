"""The model error: misfits in units of the reproducibility standard deviation."""

from __future__ import annotations

import numpy as np

# The error of one sensor's simulations scatters by .06 of it over simulated sensors of its design
# (.13 where tracks of particles cross it): by less it neither falls nor rises.
ERROR_SCATTER = 0.06
TOLERABLE = 1.3  # model error up to which no residual is called unexplained by itself
SATURATION = 1e4  # standard deviations; so that the error stays finite


def family_errors(z: np.ndarray, families: np.ndarray) -> dict[str, float]:
    """Root mean square of the differences of each family.

    Parameters
    ----------
    z : ndarray
        Differences in reproducibility SDs.
    families : ndarray of str
        Family of each.
    """
    z = np.clip(z, -SATURATION, SATURATION)
    return {str(f): float(np.sqrt(np.mean(z[families == f] ** 2))) for f in np.unique(families)}


def pooled(z: np.ndarray, families: np.ndarray) -> float:
    """Mean of the family errors: 1 is as close as a second sensor of the same design would be."""
    errors = family_errors(z, families)
    return float(np.mean(list(errors.values()))) if errors else 0.0


def way(before: float, after: float) -> str:
    """Direction of a change: "falls", "rises", or "stays" where it is within its scatter."""
    if abs(after - before) <= ERROR_SCATTER * before:
        return "stays"
    return "falls" if after < before else "rises"
