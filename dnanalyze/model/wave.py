"""A line of the spectrum as measured: where it lies, how well that is known, which are the same."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

SAME = 5.0  # standard errors that two measurements of one line are apart by once in 2e6


@dataclass(frozen=True)
class Wave:
    """A sine over the field that more than chance made.

    Parameters
    ----------
    u, v : float
        Horizontal and vertical frequency, cycles/pixel. (u, v) and (-u, -v) are one wave, and so
        are frequencies that differ by whole cycles a pixel.
    u_error, v_error : float
        Standard errors, cycles/pixel.
    amplitude : float
        DN at the reference gain.
    ratio : float
        Power of its mode over that of the modes around.
    shared : str
        "rows" or "columns" where whole ones share it; of any other it is empty.
    """

    u: float
    v: float
    u_error: float
    v_error: float
    amplitude: float
    ratio: float
    shared: str = ""

    def turned(self, u: float, v: float) -> Wave:
        """The form of this wave that lies next to a frequency."""
        forms = [
            (s * self.u + round(u - s * self.u), s * self.v + round(v - s * self.v))
            for s in (1.0, -1.0)
        ]
        a, b = min(forms, key=lambda f: math.hypot(f[0] - u, f[1] - v))
        return replace(self, u=a, v=b)

    @property
    def folded(self) -> Wave:
        """The form of this wave whose frequencies lie within 1/2."""
        u, v = (f if abs(f) <= 0.5 else f - round(f) for f in (self.u, self.v))
        return replace(self, u=u, v=v)

    def is_same(self, other: Wave) -> bool:
        """Whether two measurements are of one wave, as far as their errors tell."""
        near = other.turned(self.u, self.v)
        apart = math.hypot(
            (near.u - self.u) / max(math.hypot(self.u_error, other.u_error), 1e-12),
            (near.v - self.v) / max(math.hypot(self.v_error, other.v_error), 1e-12),
        )
        return apart < SAME


def strongest_wave(waves: Sequence[Wave]) -> Wave | None:
    """The wave that stands highest over its floor, with what all measurements of it say together.

    None of none.
    """
    best = max(waves, key=lambda w: w.ratio, default=None)
    return None if best is None else together(best, waves).folded


def together(wave: Wave, waves: Sequence[Wave]) -> Wave:
    """A wave at the mean of all measurements of it, each by its error.

    Measurements that scatter by more than their errors make the mean's larger (Birge).
    """
    same = [w.turned(wave.u, wave.v) for w in waves if w is wave or w.is_same(wave)]
    u, u_error = _mean([w.u for w in same], [w.u_error for w in same])
    v, v_error = _mean([w.v for w in same], [w.v_error for w in same])
    return replace(wave, u=u, v=v, u_error=u_error, v_error=v_error)


def _mean(values: Sequence[float], errors: Sequence[float]) -> tuple[float, float]:
    weights = [1.0 / max(e, 1e-12) ** 2 for e in errors]
    whole = sum(weights)
    mean = sum(w * x for w, x in zip(weights, values, strict=True)) / whole
    square = sum(w * (x - mean) ** 2 for w, x in zip(weights, values, strict=True))
    birge = max(1.0, math.sqrt(square / (len(values) - 1))) if len(values) > 1 else 1.0
    return mean, birge / math.sqrt(whole)
