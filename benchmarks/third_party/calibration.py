"""Is a stated confidence the share that is right? By bins, and with one generator left out.

An added effect is right where it is hidden, whatever was added before it. The curve is a logistic
regression of being right on the logarithm of the stated odds (Platt 2000), with a normal prior of
standard deviation 1 about the line on which the stated confidence is right: where all of few
cases are right, the likelihood alone has no maximum.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from third_party.score import accepted, wilson

Row = Mapping[str, Any]
BINS = (0.0, 0.4, 0.6, 0.9, 0.99, 1.0 + 1e-9)
AT = (0.5, 0.9, 0.99)
EDGE = 1e-4  # nearest to 0 and to 1 that a confidence counts as


def additions(rows: Sequence[Row]) -> list[tuple[str, float, bool]]:
    """Generator, stated confidence and whether it is right, of every effect that was added."""
    found = []
    for row in rows:
        if row.get("failed"):
            continue
        true = set().union(*accepted(row)) if row["hides"] else set()
        for name, confidence in row["additions"]:
            if confidence is not None:
                found.append((row["generator"], float(confidence), name in true))
    return found


def curve(stated: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Intercept and slope of the log odds of being right over the stated log odds."""
    x = _log_odds(stated)
    design = np.stack([np.ones_like(x), x], axis=1)
    prior = np.array([0.0, 1.0])
    beta = prior.copy()
    for _ in range(50):
        p = 1.0 / (1.0 + np.exp(-design @ beta))
        slope = design.T @ (right - p) - (beta - prior)
        curvature = design.T @ (design * (p * (1.0 - p))[:, None]) + np.eye(2)
        step = np.linalg.solve(curvature, slope)
        beta = beta + np.clip(step, -1.0, 1.0)
        if np.abs(step).max() < 1e-9:
            break
    return beta


def at(beta: np.ndarray, stated: float) -> float:
    """Probability of being right at a stated confidence."""
    return float(1.0 / (1.0 + np.exp(-beta[0] - beta[1] * _log_odds(np.array(stated)))))


def _log_odds(p: np.ndarray) -> np.ndarray:
    p = np.clip(p, EDGE, 1.0 - EDGE)
    return np.log(p / (1.0 - p))


def reliability(found: Sequence[tuple[str, float, bool]]) -> list[list[str]]:
    """Right and stated share of each bin of confidence."""
    lines = []
    for low, high in pairwise(BINS):
        here = [(c, r) for _, c, r in found if low <= c < high]
        if here:
            count = sum(r for _, r in here)
            a, b = wilson(count, len(here))
            mean = np.mean([c for c, _ in here])
            share = f"{count}/{len(here)} ({100 * a:.0f}-{100 * b:.0f} %)"
            lines.append([f"{low:g}-{min(high, 1.0):g}", f"{mean:.3f}", share])
    return lines


RELIABILITY_HEAD = ("confidence", "mean stated", "right")


def left_out(found: Sequence[tuple[str, float, bool]]) -> list[list[str]]:
    """The curve of each generator's own additions, and that of all others, at `AT`."""
    lines = []
    for generator in dict.fromkeys(g for g, _, _ in found):
        mine, others = (
            [(c, r) for g, c, r in found if (g == generator) == own] for own in (True, False)
        )
        if not others:
            continue
        curves = [curve(*np.array(part, float).T) for part in (mine, others)]
        values = [[at(beta, c) for c in AT] for beta in curves]
        far = max(abs(a - b) for a, b in zip(*values, strict=True))
        cells = [f"{a:.3f}, {b:.3f}" for a, b in zip(*values, strict=True)]
        lines.append([generator, str(len(mine)), *cells, f"{far:.3f}"])
    return lines


LEFT_OUT_HEAD = ("generator", "additions", *(f"at {c:g}: own, others" for c in AT), "largest")
