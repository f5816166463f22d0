"""Learn the fixed pattern of one sensor, and judge it on frames and points that it has not seen."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from scipy.stats import chi2

from dnanalyze.comparator.error import ERROR_SCATTER, pooled
from dnanalyze.description.law import grown
from dnanalyze.description.layers import CLIP, robust
from dnanalyze.description.shrinkage import factors, filtered
from dnanalyze.digits import number
from dnanalyze.errors import InputError
from dnanalyze.fitting.design import design
from dnanalyze.fitting.problem import fit_problem
from dnanalyze.loaders.captures import CaptureSet, OperatingPoint
from dnanalyze.model.composite.effect import CompositeEffect
from dnanalyze.model.learned.field_map import FieldMap
from dnanalyze.model.learned.pattern_map import PatternMap
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.simulate import simulate
from dnanalyze.progress import Progress, reporter
from dnanalyze.result import Result
from dnanalyze.significance import RARE
from dnanalyze.thermal import least_energy

REPLICATES = 4  # simulated sensors: the power of a band of n modes is known to 1 / sqrt(4 n)
# Of bands, law and weights: on four sensors of benchmarks/describe_new_sensors.py (halves, rings,
# gain of blocks, wave) the second changes the rms of the map by up to a factor of 2, the third by
# 4 % at most, a fourth and further ones by nothing.
ROUNDS = 3
Learned = tuple[PatternMap, np.ndarray, np.ndarray]
# eV: slopes outside .2 to 1.5 eV are no generation of charge; .01 is less than the usual error
ENERGIES = np.arange(0.05, 1.505, 0.01)


@dataclass(frozen=True, repr=False)
class LearnedPattern(Result):
    """The fixed pattern of one sensor and how well it predicts.

    Parameters
    ----------
    captures : CaptureSet
        The measured frames.
    effect : PatternMap
        The pattern, from all frames.
    model : NoiseModel
        The model with it.
    rms : float
        Of the map at the reference operating point, DN.
    sizes, errors : ndarray
        Size of the pattern at each operating point relative to the reference, with standard errors.
    points : list of OperatingPoint
        Operating points with two frames or more.
    frames_share : float
        Share of the variance of the fixed pattern that the map of the even frames predicts in the
        odd frames; NaN for single frames.
    points_share : float
        The same of the map of all operating points but one in that one, mean over all.
    error_before, error_after : float
        Model error on the odd frames, without and with the map of the even frames; NaN where an
        operating point has fewer than four frames.
    """

    captures: CaptureSet = field(compare=False)
    effect: PatternMap
    model: NoiseModel
    rms: float
    sizes: np.ndarray
    errors: np.ndarray
    points: list[OperatingPoint]
    frames_share: float
    points_share: float
    error_before: float
    error_after: float

    def _brief(self) -> str:
        return f"{self.captures.name}, {number(self.rms)} DN rms, {self.effect.law}"

    @property
    def supported(self) -> bool:
        """Whether it predicts frames that it was not learned from, at no cost to the model error.

        The error may rise by what it varies between simulated sensors.
        """
        return self.rms > 0 and self.frames_share > 0 and not self._harmful

    @property
    def _harmful(self) -> bool:
        return self.error_after > self.error_before * (1.0 + ERROR_SCATTER)

    def kept(self, model: NoiseModel) -> NoiseModel:
        """Return the model with the pattern, or another where the pattern is not supported.

        Parameters
        ----------
        model : NoiseModel
            The other.

        Returns
        -------
        NoiseModel
            One of the two.
        """
        return self.model if self.supported else model

    def sentence(self) -> str:
        """Return what was learned, in a sentence.

        Returns
        -------
        str
            Size and law of the pattern, and what it predicts; or why there is none.
        """
        if self._harmful:
            before, after = number(self.error_before), number(self.error_after)
            return (
                "A fixed pattern is not added: with it the model error on frames that it was not "
                f"learned from rises from {before} to {after}."
            )
        if not self.supported:
            return (
                "No fixed pattern exceeds that of the model and chance, or none predicts frames "
                "that it was not learned from."
            )
        law = "the same at every operating point"
        if self.effect.law == "thermal":
            law = f"thermal, {number(self.effect.ea_ev)} eV"
        text = (
            f"Pattern of this sensor: {number(self.rms)} DN rms, {law}. It predicts "
            f"{100 * self.frames_share:.0f} % of the variance of the fixed pattern in frames that "
            "it was not learned from"
        )
        if math.isfinite(self.points_share):
            text += f" and {100 * self.points_share:.0f} % at operating points left out"
        if math.isfinite(self.error_after):
            before, after = number(self.error_before), number(self.error_after)
            text += f"; model error on unseen frames {before} to {after}"
        return f"{text}."


def learn_pattern(
    captures: CaptureSet,
    model: NoiseModel,
    *,
    progress: Progress | None = None,
) -> LearnedPattern:
    """Learn the fixed pattern that a sensor has beside its model.

    The mean frames of all operating points are combined with the weights of a common law, and every
    frequency band is shrunk by what simulated sensors of the model show there: the model's own
    fixed pattern and chance. So the map and the model together have the sensor's power. Hot pixels
    are cut at 4 standard deviations; the model's effects draw them. A fixed composite structure,
    which has the values of another sensor, is taken out of the model: the map has its own.

    Parameters
    ----------
    captures : CaptureSet
        Dark frames; operating points of a single frame are left out.
    model : NoiseModel
        The model to which the pattern is added.
    progress : callable, optional
        Called with (steps done, None, what is under way); see `dnanalyze.progress.Progress`.

    Returns
    -------
    LearnedPattern
        The map with its law, the model with it, and what it predicts.

    Raises
    ------
    InputError
        Single frames alone, or a model that has a pattern already.

    Examples
    --------
    >>> import dnanalyze
    >>> from dnanalyze.demo import tiny
    >>> captures = tiny()
    >>> model = dnanalyze.fit(captures, replicates=0).model
    >>> dnanalyze.learn_pattern(captures, model).effect.map.shape
    (64, 64)
    """
    check_pattern(captures, model)
    on_progress = reporter(progress)
    captures, model = _repeated(captures), _without_structure(model)
    on_progress("mean frames")
    seen = halves(captures)
    on_progress("simulated sensors")
    chance = [halves(_other(captures, model, r)) for r in range(REPLICATES)]

    def learned(part: str, without: Half | None = None) -> Learned:
        """Of a part of the frames, without an operating point."""
        those = [n for n, h in enumerate(seen) if h is not without]
        used = [seen[n] for n in those]
        maps = [[getattr(of[n], part) for n in those] for of in (seen, *chance)]
        return _learned(maps, used, model.reference)

    on_progress("the map")
    whole, sizes, errors = learned("mean")
    even, _, _ = learned("even")
    others = [
        _predicted(learned("mean", h)[0], [h], model.reference) for h in seen if len(seen) > 2
    ]
    on_progress("unseen frames")
    before, after = _unseen_error(captures, model, even)
    return LearnedPattern(
        captures,
        effect=whole,
        model=model.with_effect(whole),
        rms=float(whole.map.array.std()),
        sizes=sizes,
        errors=errors,
        points=[h.point for h in seen],
        frames_share=_predicted(even, seen, model.reference),
        points_share=float(np.mean(others)) if others else float("nan"),
        error_before=before,
        error_after=after,
    )


def check_pattern(captures: CaptureSet, model: NoiseModel | None = None) -> None:
    """Refuse captures and models of which no pattern can be learned, before the long work.

    Raises
    ------
    InputError
        Single frames alone, or a model that has a pattern already.
    """
    if model is not None and model.get(PatternMap.name) is not None:
        raise InputError("model: it already has the effect 'pattern_map'; learn it without")
    if not _repeated(captures).settings:
        raise InputError(
            f"{captures.name}: one frame at each operating point; a pattern needs two at one"
        )


def _without_structure(model: NoiseModel) -> NoiseModel:
    """The model without a composite effect of fixed levels or gains."""
    made = model.get(CompositeEffect.name)
    fixed = isinstance(made, CompositeEffect) and made.when == "fixed" and made.what != "noise"
    return model.without(CompositeEffect.name) if fixed else model


def _repeated(captures: CaptureSet) -> CaptureSet:
    """The operating points with two frames or more."""
    return replace(captures, settings=tuple(s for s in captures.settings if len(s.frames) > 1))


@dataclass(frozen=True)
class Half:
    """Mean of the even and of the odd frames of an operating point, less their medians, DN."""

    point: OperatingPoint
    even: np.ndarray
    odd: np.ndarray
    count: int

    @property
    def _evens(self) -> int:
        return (self.count + 1) // 2

    @cached_property
    def mean(self) -> np.ndarray:
        """Mean of all frames."""
        return (self._evens * self.even + (self.count - self._evens) * self.odd) / self.count

    @cached_property
    def noise(self) -> float:
        """Variance of chance in the mean of all frames, DN^2."""
        parts = 1.0 / self._evens + 1.0 / (self.count - self._evens)
        return max(robust(self.even - self.odd) ** 2 / parts / self.count, 1e-12)


def halves(captures: CaptureSet) -> list[Half]:
    """Mean frames of each operating point, hot pixels cut."""
    found = []
    for setting in captures.settings:
        even, odd = (
            np.mean([f.read() for f in setting.frames[n::2]], axis=0, dtype=float) for n in (0, 1)
        )
        middle = (even + odd) / 2
        limit = CLIP * robust(middle)
        hot = np.abs(middle - np.median(middle)) > limit
        made = [
            np.clip(np.where(hot, 0.0, side - np.median(side)), -limit, limit)
            for side in (even, odd)
        ]
        found.append(Half(setting.point, made[0], made[1], len(setting.frames)))
    return found


def _other(captures: CaptureSet, model: NoiseModel, replicate: int) -> CaptureSet:
    """Another sensor of the same design and layout."""
    layout = [(s.point, len(s.frames)) for s in captures.settings]
    other = replace(model, seed=model.seed + 1 + replicate)
    return simulate(other.in_codes, captures.sensor.shape, layout, sensor=captures.sensor)


def _learned(
    maps: Sequence[Sequence[np.ndarray]], seen: Sequence[Half], reference: OperatingPoint
) -> Learned:
    """The pattern, its size at each operating point relative to the reference, and their errors.

    ``maps``: of the sensor and of simulated ones, of every operating point. The bands that hold
    structure are found with one size everywhere; the structure in them tells the law, and the law
    the weights of the final map.
    """
    weight = np.array([1.0 / h.noise for h in seen])
    points = [h.point for h in seen]
    energy: float | None = None
    for _ in range(ROUNDS):
        growth = _growth(energy, points, reference)
        shares = weight * growth / float(np.sum(weight * growth**2))
        joined, *chance = (np.tensordot(shares, of, 1) for of in maps)
        kept = factors(joined, chance)
        sizes, errors = _sizes(seen, weight * growth, kept)
        energy = _energy(sizes, errors, points, reference)
    law, ea_ev = ("constant", 0.6) if energy is None else ("thermal", energy)
    made = PatternMap(law=law, ea_ev=ea_ev, map=FieldMap(filtered(joined, kept)))
    known = errors**-2.0  # 0 of infinite errors
    total = float(known @ growth**2)
    scale = float(known @ (growth * sizes)) / total if total > 0 else 0.0
    scale = scale if scale > 0 else 1.0
    return made, sizes / scale, errors / scale


def _sizes(
    seen: Sequence[Half], weight: np.ndarray, kept: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Relative size of the structure at each operating point, with standard errors.

    The structure in the even frames of the other operating points is regressed on the odd frames
    of each: no chance is common to both.
    """
    total = sum(w * h.even for w, h in zip(weight, seen, strict=True))
    found = []
    for w, half in zip(weight, seen, strict=True):
        others = filtered(total - w * half.even if len(seen) > 1 else half.even, kept)
        power = float(np.sum(others.astype(float) ** 2))
        if power <= 0:
            found.append((0.0, math.inf))
            continue
        slope = float(np.sum(half.odd * others)) / power
        rest = max(float(np.mean((half.odd - slope * others) ** 2)), 1e-24)
        found.append((slope * math.sqrt(power), math.sqrt(rest)))
    sizes, errors = np.array(found).T
    return sizes, errors


def _energy(
    sizes: np.ndarray,
    errors: np.ndarray,
    points: Sequence[OperatingPoint],
    reference: OperatingPoint,
) -> float | None:
    """Activation energy of the sizes, eV, where that is clearly better than a constant."""
    usable = np.isfinite(errors)
    if len({p.temperature_c for p in points} - {None}) < 2 or not usable.any():
        return None

    def misfit(energy: float | None) -> float:
        growth = _growth(energy, points, reference)[usable]
        y, w = sizes[usable], 1.0 / errors[usable] ** 2
        level = max(float(np.sum(w * growth * y) / np.sum(w * growth**2)), 0.0)
        return float(np.sum(w * (y - level * growth) ** 2))

    best = least_energy(misfit, ENERGIES)
    return best if misfit(None) - misfit(best) > chi2.isf(RARE, 1) else None


def _growth(
    energy: float | None, points: Sequence[OperatingPoint], reference: OperatingPoint
) -> np.ndarray:
    """Size at each operating point relative to the reference; without an energy the same."""
    if energy is None or reference.temperature_c is None:
        return np.ones(len(points))
    return grown(points, reference, energy)


def _predicted(effect: PatternMap, seen: Sequence[Half], reference: OperatingPoint) -> float:
    """Share of the variance of the fixed pattern in the odd frames that a map predicts.

    The variance is the covariance of two halves of the frames, in which no chance is common.
    """
    energy = effect.ea_ev if effect.law == "thermal" else None
    growth = _growth(energy, [h.point for h in seen], reference)
    explained = whole = 0.0
    for g, h in zip(growth, seen, strict=True):
        predicted = g * effect.map.array
        noise = max(float(np.var(h.odd - h.even)), 1e-12)
        explained += float(np.mean(2.0 * h.odd * predicted - predicted**2)) / noise
        whole += max(float(np.mean(h.odd * h.even)), 0.0) / noise
    return explained / whole if whole > 0 else float("nan")


def _unseen_error(captures: CaptureSet, model: NoiseModel, even: PatternMap) -> tuple[float, float]:
    """Model error on the odd frames without and with the pattern of the even ones."""
    if min(len(s.frames) for s in captures.settings) < 4:
        return float("nan"), float("nan")
    odd = tuple(replace(s, frames=s.frames[1::2]) for s in captures.settings)
    problem = fit_problem(design(replace(captures, settings=odd)))
    found = [problem.held_out_z(m) for m in (model, model.with_effect(even))]
    before, after = (pooled(z, problem.test.families) for z in found)
    return before, after
