"""Everything that the tests need of one group of frames, gathered in one reading."""

from __future__ import annotations

import math
import operator
from dataclasses import dataclass, replace
from functools import reduce

import numpy as np

from dnanalyze.analyzers.estimators.saturation import MAJORITY, Saturation, saturation
from dnanalyze.detection.correlation import LagCorrelation, lag_correlation
from dnanalyze.detection.excess import StandingOut, standing_out
from dnanalyze.detection.extremes import Exceedance, RowPhase, exceedance, row_phase
from dnanalyze.detection.flatten import (
    pair_differences,
    robust_sd,
    without_lines,
    without_shading,
    without_tones,
    without_transients,
)
from dnanalyze.detection.memory import Autocorrelation, mean_memory
from dnanalyze.detection.replaced import Replaced, replaced
from dnanalyze.detection.sample import SMALLEST, Group, Plane, planes
from dnanalyze.detection.spectrum import OctaveSpectrum, octave_spectrum
from dnanalyze.detection.texture import Texture, equal_neighbours, texture
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effects.quantization import ROUNDING_VARIANCE

VIEWS = {"frame": 1, "planes": 2}  # pixels between the neighbours of a view
SATURATED = 0.1  # share of clipped and saturated pixels above which noise tells nothing
ROUNDING = math.sqrt(ROUNDING_VARIANCE)  # noise of the codes alone, over their step
LEVELS = np.linspace(0, 1, 101)  # quantiles of a frame, for the figure


@dataclass(frozen=True)
class ViewEvidence:
    """What the tests found in one view (the frame, or the planes of a 2x2 mosaic) of one group."""

    view: str
    point: OperatingPoint
    frames: int
    # Robust sd of the temporal noise (of the single frame, where there is but one), DN.
    noise: float
    step: float  # spacing of the recorded values, DN
    temporal: bool  # noise statistics are of differences of frames; False: of one flattened frame
    clipped: float  # share of pixels at the highest or lowest code, or on a plateau
    saturation: Saturation  # from where pixels are clipped or saturated
    levels: np.ndarray  # (101,), percentiles of the frames, DN
    usable: bool  # noise statistics mean something: few pixels are clipped
    # Of single frames, fixed pattern and all: asymmetric for a correction of hot pixels.
    recorded: Exceedance
    # Of the noise.
    extremes: Exceedance
    spectrum: OctaveSpectrum
    correlation: LagCorrelation
    texture: Texture
    # Above the largest of 8, of 24 neighbours.
    above8: StandingOut
    above24: StandingOut
    replaced: Replaced | None  # for 3 frames or more
    listed: Replaced | None  # the same over frames of all settings; with the first of the settings
    memory: Autocorrelation | None  # for 4 repeats or more
    # Equality with the right neighbour, with one farther away, pixels.
    equal: tuple[float, float, int]
    rows: RowPhase | None  # of the whole frame only

    def above(self, neighbours: int) -> StandingOut:
        """Above the largest of 8, or 24, neighbours."""
        return self.above8 if neighbours == 8 else self.above24

    @property
    def fine(self) -> bool:
        """The noise spans a code or more: rounding does not hide a filter."""
        return self.noise >= self.step

    @property
    def full(self) -> bool:
        """Most pixels are clipped or saturated: no test applies."""
        return self.clipped > MAJORITY

    def beyond(self, well: float) -> ViewEvidence:
        """With a full well that shows at other settings of the gain, DN."""
        share = float(np.mean(self.levels >= well))
        if not share > self.clipped:
            return self
        seen = replace(self.saturation, high=well, high_share=share, plateau=True)
        usable = self.usable and share < SATURATED
        return replace(self, saturation=seen, clipped=share, usable=usable)


def gather(
    group: Group, stack: np.ndarray, view: str, ends: Saturation | None = None
) -> ViewEvidence | None:
    """Evidence of one view; None where the planes are too small.

    ``ends`` spares finding them anew for each view.
    """
    parts = _parts(stack, view)
    if not parts:
        return None
    temporal = stack.shape[0] >= 2
    noise_images = [_noise_images(p, temporal) for p in parts]
    noise = _noise(noise_images, parts[0].step)
    images = np.concatenate(noise_images)
    ends = ends or saturation(stack)
    clipped = max(_clipped_share(stack), ends.share)
    ceiling = ends.high if ends.plateau else _ceiling(stack)
    clean = [without_transients(p.raw, noise) for p in parts]
    found = _replaced(parts, noise, ends) if stack.shape[0] >= 3 else []
    sites = [of.sites[:, 1:] for of in found]

    return ViewEvidence(
        view=view,
        point=group.point,
        frames=stack.shape[0],
        noise=noise,
        step=parts[0].step,
        temporal=temporal,
        clipped=clipped,
        saturation=ends,
        levels=np.quantile(stack[:, ::3, ::3], LEVELS),
        usable=clipped < SATURATED and noise > ROUNDING * parts[0].step,
        recorded=exceedance(np.stack([without_lines(p.dithered()[0]) for p in parts])),
        extremes=exceedance(images),
        spectrum=octave_spectrum(images),
        correlation=lag_correlation(np.stack([without_tones(image) for image in images])),
        texture=texture(images),
        above8=standing_out(clean, 1, noise, ceiling, sites),
        above24=standing_out(clean, 2, noise, ceiling, sites),
        replaced=reduce(operator.add, found) if found else None,
        listed=None,
        memory=mean_memory([p.raw for p in parts]) if group.repeats else None,
        equal=equal_neighbours(parts[0].raw),
        rows=row_phase(images) if view == "frame" else None,
    )


def listed(stack: np.ndarray, view: str) -> Replaced | None:
    """Replaced sites over frames of several settings; None where too few frames are fit."""
    stack = stack[[_clipped_share(frame[None]) < SATURATED for frame in stack]]
    parts = _parts(stack, view)
    if len(stack) < 3 or not parts:
        return None
    noise = _noise([without_shading(p.dithered()[0])[None] for p in parts], parts[0].step)
    return reduce(operator.add, _replaced(parts, noise, saturation(stack[:1])))


def _parts(stack: np.ndarray, view: str) -> list[Plane]:
    """The planes of a view, of one size; none where they are too small."""
    parts = list(planes(stack, VIEWS[view]))
    h, w = np.min([p.raw.shape[1:] for p in parts], axis=0)
    if min(h, w) < SMALLEST:
        return []
    return [Plane(p.raw[:, :h, :w], p.step) for p in parts]


def _noise(images: list[np.ndarray], step: float) -> float:
    return max(float(np.median([robust_sd(n) for n in images])), step * ROUNDING, 1e-9)


def _noise_images(plane: Plane, temporal: bool) -> np.ndarray:
    smooth = plane.dithered()
    if temporal:
        return pair_differences(smooth)
    return without_shading(smooth[0])[None]


def _ceiling(stack: np.ndarray) -> float:
    top = stack.max()
    return float(top) if np.count_nonzero(stack == top) > 20 else np.inf


def _clipped_share(stack: np.ndarray) -> float:
    sample = stack[:, ::2, ::2]
    ends = (sample == stack.max()) | (sample == stack.min())
    return float(ends.mean()) if np.ptp(sample) > 8 else 0.0


def _replaced(parts: list[Plane], noise: float, ends: Saturation) -> list[Replaced]:
    return [replaced(p.raw, p.step, noise, ends.low, ends.high) for p in parts]
