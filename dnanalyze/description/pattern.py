"""Learn the fixed pattern of one sensor, and judge it on frames and points that it has not seen."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial

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
    points = [s.point for s in captures.settings]
    make = partial(_learned, points=points, reference=model.reference)
    on_progress("the map")
    whole, sizes, errors = make([h.mean for h in seen], [[h.mean for h in c] for c in chance], seen)
    even, _, _ = make([h.even for h in seen], [[h.even for h in c] for c in chance], seen)
    left_out = [
        _predicted(
            make(
                [h.mean for k, h in enumerate(seen) if k != n],
                [[h.mean for k, h in enumerate(c) if k != n] for c in chance],
                [h for k, h in enumerate(seen) if k != n],
                points=[p for k, p in enumerate(points) if k != n],
            )[0],
            [seen[n].odd],
            [seen[n].even],
            [points[n]],
            model.reference,
        )
        for n in range(len(seen))
        if len(seen) > 2
    ]
    on_progress("unseen frames")
    before, after = _unseen_error(captures, model, even)
    return LearnedPattern(
        captures,
        whole,
        model.with_effect(whole),
        float(whole.map.array.std()),
        sizes,
        errors,
        points,
        _predicted(even, [h.odd for h in seen], [h.even for h in seen], points, model.reference),
        float(np.mean(left_out)) if left_out else float("nan"),
        before,
        after,
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
class Halves:
    """Mean of the even and of the odd frames of an operating point, less their medians, DN."""

    even: np.ndarray
    odd: np.ndarray
    count: int

    @property
    def mean(self) -> np.ndarray:
        """Mean of all frames."""
        evens = (self.count + 1) // 2
        return (evens * self.even + (self.count - evens) * self.odd) / self.count

    @property
    def noise(self) -> float:
        """Variance of chance in the mean of all frames, DN^2."""
        evens = (self.count + 1) // 2
        parts = 1.0 / evens + 1.0 / (self.count - evens)
        return robust(self.even - self.odd) ** 2 / parts / self.count


def halves(captures: CaptureSet) -> list[Halves]:
    """Mean frames of each operating point, hot pixels cut."""
    found = []
    for setting in captures.settings:
        sums = np.zeros((2, *captures.sensor.shape))
        for n, frame in enumerate(setting.frames):
            sums[n % 2] += frame.read()
        count = len(setting.frames)
        even, odd = sums[0] / ((count + 1) // 2), sums[1] / max(count // 2, 1)
        middle = (even + odd) / 2
        low, spread = float(np.median(middle)), robust(middle)
        limit = CLIP * spread
        hot = np.abs(middle - low) > limit
        made = []
        for side in (even, odd):
            rest = side - np.median(side)
            rest[hot] = 0.0
            made.append(np.clip(rest, -limit, limit))
        found.append(Halves(made[0], made[1], count))
    return found


def _other(captures: CaptureSet, model: NoiseModel, replicate: int) -> CaptureSet:
    """Another sensor of the same design and layout."""
    layout = [(s.point, len(s.frames)) for s in captures.settings]
    other = replace(model, seed=model.seed + 1 + replicate)
    return simulate(other.in_codes, captures.sensor.shape, layout, sensor=captures.sensor)


def _learned(
    maps: Sequence[np.ndarray],
    chance: Sequence[Sequence[np.ndarray]],
    seen: Sequence[Halves],
    *,
    points: Sequence[OperatingPoint],
    reference: OperatingPoint,
) -> tuple[PatternMap, np.ndarray, np.ndarray]:
    """The pattern, its size at each operating point relative to the reference, and their errors.

    The bands that hold structure are found with one size everywhere; the structure in them tells
    the law, and the law the weights of the final map.
    """
    weight = np.array([1.0 / max(h.noise, 1e-12) for h in seen])
    law, energy = "constant", 0.0
    for _ in range(ROUNDS):
        growth = _growth(law, energy, points, reference)
        norm = float(np.sum(weight * growth**2))
        joined = [
            sum(w * g * m for w, g, m in zip(weight, growth, of, strict=True)) / norm
            for of in (maps, *chance)
        ]
        kept = factors(joined[0], joined[1:])
        sizes, errors = _sizes(seen, weight * growth, kept)
        law, energy = _law(sizes, errors, points, reference)
    array = filtered(joined[0], kept)
    made = PatternMap(law=law, ea_ev=energy if law == "thermal" else 0.6, map=FieldMap(array))
    known = np.where(np.isfinite(errors), 1.0 / np.maximum(errors, 1e-12) ** 2, 0.0)
    total = float(np.sum(known * growth**2))
    scale = float(np.sum(known * growth * sizes)) / total if total > 0 else 0.0
    scale = scale if scale > 0 else 1.0
    return made, sizes / scale, errors / scale


def _sizes(
    seen: Sequence[Halves], weight: np.ndarray, kept: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Relative size of the structure at each operating point, with standard errors.

    The structure in the even frames of the other operating points is regressed on the odd frames
    of each: no chance is common to both.
    """
    total = sum(w * h.even for w, h in zip(weight, seen, strict=True))
    sizes, errors = [], []
    for w, half in zip(weight, seen, strict=True):
        others = filtered(total - w * half.even if len(seen) > 1 else half.even, kept)
        power = float(np.sum(others.astype(float) ** 2))
        if power <= 0:
            sizes.append(0.0)
            errors.append(math.inf)
            continue
        slope = float(np.sum(half.odd * others)) / power
        rest = half.odd - slope * others
        sizes.append(slope * math.sqrt(power))
        errors.append(math.sqrt(float(np.mean(rest**2))))
    return np.array(sizes), np.array(errors)


def _law(
    sizes: np.ndarray,
    errors: np.ndarray,
    points: Sequence[OperatingPoint],
    reference: OperatingPoint,
) -> tuple[str, float]:
    """Constant, or thermal with its energy where that is clearly better."""
    temperatures = {p.temperature_c for p in points} - {None}
    usable = np.isfinite(errors)
    if len(temperatures) < 2 or not usable.any():
        return "constant", 0.0

    def misfit(law: str, energy: float) -> float:
        growth = _growth(law, energy, points, reference)[usable]
        y, w = sizes[usable], 1.0 / errors[usable] ** 2
        level = max(float(np.sum(w * growth * y) / np.sum(w * growth**2)), 0.0)
        return float(np.sum(w * (y - level * growth) ** 2))

    best = least_energy(partial(misfit, "thermal"), ENERGIES)
    if misfit("constant", 0.0) - misfit("thermal", best) > chi2.isf(RARE, 1):
        return "thermal", best
    return "constant", 0.0


def _growth(
    law: str, energy: float, points: Sequence[OperatingPoint], reference: OperatingPoint
) -> np.ndarray:
    """Size at each operating point relative to the reference."""
    if law == "constant" or reference.temperature_c is None:
        return np.ones(len(points))
    return grown(points, reference, energy)


def _predicted(
    effect: PatternMap,
    unseen: Sequence[np.ndarray],
    seen: Sequence[np.ndarray],
    points: Sequence[OperatingPoint],
    reference: OperatingPoint,
) -> float:
    """Share of the variance of the fixed pattern that a map predicts.

    The variance is the covariance of two halves of the frames, in which no chance is common.
    """
    growth = _growth(effect.law, effect.ea_ev, points, reference)
    explained = whole = 0.0
    for g, odd, even in zip(growth, unseen, seen, strict=True):
        predicted = g * effect.map.array
        noise = max(float(np.var(odd - even)), 1e-12)
        explained += float(np.mean(2.0 * odd * predicted - predicted**2)) / noise
        whole += max(float(np.mean(odd * even)), 0.0) / noise
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
