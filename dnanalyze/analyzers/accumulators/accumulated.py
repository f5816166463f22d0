"""What accumulators are, and all of them together: what the families work on."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, Protocol, Self

import numpy as np

from dnanalyze.analyzers.estimators.quantiles import Counted, Ordered
from dnanalyze.analyzers.plan import CLIP, FrameView, Plan

if TYPE_CHECKING:
    from dnanalyze.analyzers.accumulators.histograms import Histograms
    from dnanalyze.analyzers.accumulators.neighbour_sums import Neighbours
    from dnanalyze.analyzers.accumulators.pixel_maps import Maps
    from dnanalyze.analyzers.spectra.spectral_sums import Spectra


class Accumulator(Protocol):
    """Sums over the frames of one setting that merge to what one pass gives."""

    def __init__(self, plan: Plan) -> None: ...

    def add(self, view: FrameView) -> None:
        """Take in the next frame, and its difference to the one before where there is one."""

    def merge(self, later: Self, seam: FrameView) -> None:
        """Take in the frames that follow mine.

        ``seam`` is the view of the first frame of ``later`` with its difference to my last frame:
        ``later`` counted that frame, but not that difference.
        """


@dataclass(frozen=True)
class Accumulated:
    """All accumulators of one setting, and what several families derive from them.

    Parameters
    ----------
    plan : Plan
    frames : int
        Number of frames, K.
    frame_means : ndarray
        Mean of each winsorised frame minus the plan's centre, DN; (K,).
    maps : Maps
    histograms, spectra, neighbours
        The accumulators of those names.
    """

    plan: Plan
    frames: int
    frame_means: np.ndarray
    maps: Maps
    histograms: Histograms
    spectra: Spectra
    neighbours: Neighbours

    def prepare(self, run: Callable[..., Iterable[Any]] = map) -> None:
        """Derive now what families share, before they run side by side; ``run`` is a pool's map."""
        shared = ("clipped_pattern", "end_differences", "temporal_mean", "difference_sigma")
        for _ in run(partial(getattr, self), shared):
            pass

    @property
    def pattern(self) -> np.ndarray:
        """F, the mean over the frames, DN; float32. It still holds 1/K of the temporal variance."""
        return self.maps.mean

    @cached_property
    def pattern_ordered(self) -> Ordered:
        """The pixels of F in order."""
        return Ordered(self.pattern, self.pattern_step)

    @cached_property
    def pattern_step(self) -> float:
        """Spacing of the lattice on which F lies, DN; 0 for continuous data."""
        return 1.0 / self.frames if self.plan.integer else 0.0

    @cached_property
    def pattern_centre(self) -> float:
        """Median of F, DN."""
        return float(self.pattern_ordered.quantile(0.5))

    @cached_property
    def pattern_sigma(self) -> float:
        """Robust sigma (interquartile range / 1.349) of F, DN; never 0."""
        return self.pattern_ordered.robust_sigma()

    @cached_property
    def clipped_pattern(self) -> np.ndarray:
        """F minus its median, clipped to +-6 of its robust sigmas, DN; float32."""
        reach = np.float32(CLIP * self.pattern_sigma)
        out = self.pattern - np.float32(self.pattern_centre)
        return np.clip(out, -reach, reach, out=out)

    @cached_property
    def end_frames(self) -> tuple[np.ndarray, ...]:
        """The first frame and the last, or the only one, DN, float32."""
        head, tail = self.maps.head, self.maps.tail
        return (head[0], tail[-1]) if self.frames > 1 else (head[0],)

    @cached_property
    def end_differences(self) -> tuple[np.ndarray, ...]:
        """The first difference (y_1 - y_0) / sqrt 2 and the last; fewer for few frames."""
        head, tail = self.maps.head, self.maps.tail
        if self.frames < 2:
            return ()
        half = np.float32(np.sqrt(0.5))
        pairs = [head] if self.frames == 2 else [head, tail]
        return tuple((b - a) * half for a, b in pairs)

    @property
    def difference_repeats(self) -> float:
        """Independent differences that tell as much of a variance as these successive ones.

        Squares of Gaussian differences that share a frame are correlated by 1/4.
        """
        n = self.frames - 1
        return n / (1 + 0.5 * (n - 1) / n) if n else 0.0

    @cached_property
    def drift_variance(self) -> float:
        """Variance of the frame means, DN^2; 0 for one frame."""
        return float(np.var(self.frame_means, ddof=1)) if self.frames > 1 else 0.0

    @cached_property
    def still_variance(self) -> float:
        """Mean temporal variance of the pixels without that of the frame means, DN^2.

        Of the means of all values: with these the two variances add up to `temporal_mean` exactly,
        however far the level moves.
        """
        means = self.maps.scalars[:, 6] / self.plan.pixels + self.maps.shifts
        moved = float(np.var(means, ddof=1)) if self.frames > 1 else 0.0
        return max(self.temporal_mean - moved, 0.0)

    @property
    def level_variance(self) -> float:
        """Variance of the mean of all frames because their means scatter, DN^2.

        That of independent frames over their number K. Where the level wanders, so that successive
        frames differ by less than any two (von Neumann's ratio), K frames tell little more than
        one; the mean of K steps of a walk scatters (2 K + 1) / K times as much about its beginning
        as the steps about their mean.
        """
        spread = self.drift_variance
        if spread == 0.0:
            return 0.0
        together = 1.0 - float(np.mean(np.diff(self.frame_means) ** 2)) / (2.0 * spread)
        return spread * max(1.0, together * (2 * self.frames + 1)) / self.frames

    def drift_error(self, variance: float) -> float:
        """Relative error of a temporal variance because frame means scatter and are few."""
        if self.frames < 2:
            return 0.0
        return min(self.drift_variance / variance, 1.0) * float(np.sqrt(2 / (self.frames - 1)))

    @property
    def temporal_variance(self) -> np.ndarray | None:
        """Unbiased variance of each pixel over the frames, DN^2, float32; None for one frame."""
        return self.maps.variance if self.frames > 1 else None

    @cached_property
    def temporal_mean(self) -> float:
        """Mean of `temporal_variance`, DN^2; 0 for one frame."""
        variance = self.temporal_variance
        return 0.0 if variance is None else float(variance.mean(dtype=np.float64))

    @cached_property
    def values(self) -> Counted:
        """Histogram of the values over all frames."""
        return self.histograms.values()

    @cached_property
    def differences(self) -> Counted:
        """Histogram of the differences over all frames; empty for one frame."""
        return self.histograms.differences()

    @cached_property
    def difference_sigma(self) -> float:
        """Robust sigma of all differences, DN; that of the plan where there is one frame."""
        if self.frames < 2:
            return self.plan.difference_sigma
        return self.differences.robust_sigma()
