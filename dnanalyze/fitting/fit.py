"""Fit a model to a capture set, with uncertainties and correlations of all its parameters."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np

from dnanalyze.analyzers.estimators.arrhenius import USUAL_EV, unusual
from dnanalyze.digits import minus
from dnanalyze.errors import InputError
from dnanalyze.estimate import Estimated, qtable
from dnanalyze.fitting.agreement import Agreement, agreements
from dnanalyze.fitting.derivatives import derive
from dnanalyze.fitting.free_parameters import (
    PEDESTAL,
    FreeParameter,
    free_parameters,
    positions,
    with_values,
)
from dnanalyze.fitting.from_part import converge
from dnanalyze.fitting.least_squares import longest, tied
from dnanalyze.fitting.measured_parameters import at_measured_parameters, measured_parameters
from dnanalyze.fitting.moments import (
    Moments,
    converter_bits,
    less,
    moments,
    serial_correlation,
    shared_pixels,
    with_faint,
)
from dnanalyze.fitting.problem import FitProblem, problem_of
from dnanalyze.fitting.readings import Readings
from dnanalyze.fitting.simulated import room
from dnanalyze.fitting.start import baseline_by_moments, paper_models
from dnanalyze.fitting.state import State, loss, root_weights, start, unseen
from dnanalyze.fitting.ties import TRANSFER, misfits
from dnanalyze.fitting.yardstick import REPLICATES as QUICK_REPLICATES
from dnanalyze.fitting.yardstick import fitted_by_design, misfit_share
from dnanalyze.loaders.captures import CaptureSet
from dnanalyze.model.channel_models import require
from dnanalyze.model.effect import Effect
from dnanalyze.model.laws import TableLaw
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import built_in
from dnanalyze.progress import Progress, ignored, reporter
from dnanalyze.result import Result

if TYPE_CHECKING:
    from astropy.table import QTable

REPLICATES = 24  # a standard error is then good to 1 / sqrt(2 x 23), 15 %
WHOLE_CODES = 0.95  # `lattice` of whole codes, 1, less its error
CONFOUNDED_CORRELATION = 0.97  # correlation from which two parameters are called indistinguishable
DERIVATIVES = 40  # simulations for the last derivatives of few groups; many take 6 each
# Sensors whose derivatives give the errors of a fit that they do not move. Those of twelve
# parameters of a virtual sensor are .85 to .99 of what 16 sensors give, .86 to 1.15 with 2 sensors
# and .93 to 1.02 with 6, in twice the time.
QUICK_DERIVATIVES = 3
# Share of noise in derivatives that is taken off at most. By three sensors noise alone has 1, good
# to .06 with 900 numbers and to .26 with 50; those twelve parameters have .31 to .55, and any bound
# from .5 to .99 gives the same errors within 2 %.
MOST_NOISE = 0.9
STEP_SIZE = 15.0  # wanted size of their steps, in reproducibility SDs: counts move by jumps
LEAST_SCATTER = 0.2  # reproducibility SD of a number that hardly scatters, over the measured one
STEPS, SMALL = 4, 0.05  # last steps at most; size at which they end, in standard errors
ONE_SIDED = 1.645  # standard errors that a normal deviate exceeds in 5 % of cases
VAGUE = 1.0  # standard error on a log scale from which a parameter is called undetermined
VERY_VAGUE = math.log(1e3)  # from which its size says nothing


@dataclass(frozen=True)
class Parameter(Estimated):
    """A fitted or directly measured parameter with its standard error, in plain units.

    Parameters
    ----------
    name : str
    value, se : float
    unit : str
    determined : bool
        Whether the captures determine it: not where they do not depend on it, or where an amplitude
        is known to no better than a factor e.
    upper : float, optional
        Of an amplitude that is not determined: its upper limit at 95 %.
    """

    name: str
    value: float
    se: float
    unit: str
    determined: bool = True
    upper: float | None = None


class Parameters(tuple[Parameter, ...]):
    """Parameters in order; one of them also by its name: ``parameters["read_noise.sigma"]``."""

    __slots__ = ()

    def __getitem__(self, key: Any) -> Any:
        """By position, or by name."""
        if not isinstance(key, str):
            return super().__getitem__(key)
        for one in self:
            if one.name == key:
                return one
        raise KeyError(f"{key}; valid: {', '.join(one.name for one in self)}")

    def to_qtable(self) -> QTable:
        """All parameters and, as ``name_se``, their standard errors in one row with units."""
        return qtable([{one.name: one for one in self}])


@dataclass(frozen=True, repr=False)
class Fit(Result):
    """A fitted model.

    Parameters
    ----------
    model : NoiseModel
        The model with the fitted parameters.
    parameters : Parameters
        Name, value, standard error and unit of each, in order; also by name, such as
        ``parameters["read_noise.sigma"]``.
    correlations : ndarray
        Between the parameters, on their scales; 0 for those that one statistic determines.
    undetermined : list of str
        Sentences on parameters that are not determined or confounded in these captures.
    problem : FitProblem
        The statistics that were fitted, and the simulations of it.
    state : State
        The last step of the fit.
    captures : CaptureSet
        The measured frames.
    """

    model: NoiseModel
    parameters: Parameters
    correlations: np.ndarray
    undetermined: list[str]
    problem: FitProblem
    state: State
    captures: CaptureSet = field(compare=False)

    @cached_property
    def direct(self) -> list[Agreement]:
        """Quantities that the frames determine without a model, beside the model's."""
        return agreements(self.problem, self.state)

    def _brief(self) -> str:
        effects, count = ", ".join(self.model.names), len(self.parameters)
        return f"{self.captures.name}, {effects}, {count} parameters"


def fit(
    captures: CaptureSet,
    model: NoiseModel | None = None,
    *,
    frozen: Sequence[str] = (),
    replicates: int = REPLICATES,
    seed: int | None = None,
    progress: Progress | None = None,
    executor: Executor | None = None,
) -> Fit:
    """Fit a model to dark frames.

    Parameters
    ----------
    captures : CaptureSet
        Dark frames.
    model : NoiseModel, optional
        Starting model, with its effects and laws; the Wang 2025 model by default.
    frozen : sequence of str
        Parameters that keep their value, as ``effect.parameter`` or ``pedestal``.
    replicates : int
        Number of simulated sensors for the standard errors; with 0 these are NaN.
    seed : int, optional
        Seed of the simulated sensor; by default the model's.
    progress : callable, optional
        Called with (steps done, None, what is under way); see `dnanalyze.progress.Progress`.
    executor : concurrent.futures.Executor, optional
        Takes the simulations that do not depend on each other: processes, or those of a Dask client
        (``client.get_executor()``). By default threads of this process. Results are the same to the
        last bit.

    Returns
    -------
    Fit
        The fitted model, its parameters with standard errors, and what is not determined.

    Raises
    ------
    InputError
        Captures too small to halve, or of a channel that the model does not know.

    Examples
    --------
    >>> import dnanalyze
    >>> from dnanalyze.demo import tiny
    >>> captures = tiny()
    >>> found = dnanalyze.fit(captures, replicates=0)
    >>> found.model.names
    ['convolved_lognormal', 'quantization']
    >>> found.parameters[0].name, found.parameters[0].unit
    ('pedestal', 'DN')
    """
    return fit_on(
        captures,
        model,
        frozen=frozen,
        replicates=replicates,
        seed=seed,
        on_state=reporter(progress),
        executor=executor,
    )


def fit_on(
    captures: CaptureSet,
    model: NoiseModel | None = None,
    *,
    frozen: Sequence[str] = (),
    replicates: int = REPLICATES,
    seed: int | None = None,
    problem: FitProblem | None = None,
    executor: Executor | None = None,
    on_state: Callable[[State], None] = ignored,
) -> Fit:
    """`fit` on statistics taken earlier; ``on_state`` is called with every better state."""
    problem = problem or problem_of(captures, model, executor)
    model = with_seed(problem, model, seed) or paper_start(problem)
    _check(frozen, model)
    model = at_measured_parameters(problem, model, frozen)
    begun = start(problem, model, free_parameters(model, frozen))
    state = fitted_by_design(problem, begun, partial(converge, on_state=on_state))
    return replace(with_uncertainties(problem, state, replicates), captures=captures)


def with_seed(problem: FitProblem, model: NoiseModel | None, seed: int | None) -> NoiseModel | None:
    """The model with this seed; without a model that in which a fit begins; as given without one.

    Raises
    ------
    InputError
        Captures of a readout channel that the model does not know, or of another unit than its.
    """
    if model is not None:
        require(model, problem.plan.captures.channels)
        if not math.isclose(model.unit, problem.plan.unit):
            raise InputError(
                f"model: one DN of it is {model.unit:g} in files, one code of these captures "
                f"{problem.plan.unit:g}; `dnanalyze fit` without --model fits one in their codes"
            )
    if seed is None:
        return model
    return replace(model or paper_start(problem), seed=seed)


def starting_model(
    problem: FitProblem, model: NoiseModel | None, seed: int | None, exclude: Sequence[str] = ()
) -> NoiseModel:
    """The model with which a search begins, directly measured parameters at their values.

    As given, or that of `paper_start`.
    """
    begun = with_seed(problem, model, seed) or paper_start(problem, exclude)
    return at_measured_parameters(problem, begun)


def _check(frozen: Sequence[str], model: NoiseModel) -> None:
    """Every name is one of the model's."""
    valid = [PEDESTAL, *(f"{e.name}.{name}" for e in model.effects for name in e.parameters())]
    for name in frozen:
        if name not in valid:
            raise InputError(f"--frozen (frozen): no parameter {name!r}; valid: {', '.join(valid)}")


def paper_start(problem: FitProblem, exclude: Sequence[str] = ()) -> NoiseModel:
    """The Wang 2025 model by the method of moments, at the pedestal that fits best.

    Rounded to codes where the captures are, unless ``exclude`` has the quantization: the paper says
    nothing of the converter, and a model of continuous values has no pixel that never changes.
    """
    seen = problem.part or problem
    models = paper_models(at_a_glance(problem))
    if "quantization" not in exclude:
        models = [as_captured(problem, model) for model in models]
    losses = [loss(seen.train.z(found), seen.train.weight) for found in seen.several(models)]
    return replace(models[int(np.argmin(losses))], unit=problem.plan.unit)


def as_captured(problem: FitProblem, model: NoiseModel) -> NoiseModel:
    """A model with quantization, where the measured values are whole codes."""
    seen = Readings(problem.measured[0])
    if not (seen.value("lattice") > WHOLE_CODES).all():
        return model
    bits = converter_bits(seen, problem.plan.captures.sensor.bits)
    return model.with_effect(built_in()["quantization"](bits=bits))  # type: ignore[call-arg]


def baseline_model(problem: FitProblem, beside: Effect | None = None) -> NoiseModel:
    """The baseline model by the method of moments.

    ``beside``: an effect whose share of them, where it tells one, is not the sensor's.
    """
    seen, sensor = Readings(problem.measured[0]), problem.plan.captures.sensor
    serial, serial2 = serial_correlation(seen)
    shared = shared_pixels([Readings(half) for half in problem.measured])
    read = {"serial": serial, "serial2": serial2, "shared": shared}
    found = at_a_glance(problem)
    known = problem.direct.gains_at(found.reference.gain)
    gain = next((k.value for k in known if k.source == TRANSFER), None)
    if beside is not None:
        found = less(found, beside, problem.plan.shape)
    bits = converter_bits(seen, sensor.bits)
    models = [baseline_by_moments(m, bits, read, gain) for m in with_faint(found)]
    if len(models) > 1:
        part = problem.part or problem
        losses = [loss(part.train.z(z), part.train.weight) for z in part.several(models)]
        models = [models[int(np.argmin(losses))]]
    return replace(models[0], unit=problem.plan.unit)


def at_a_glance(problem: FitProblem) -> Moments:
    """Moments of the fitted half."""
    # of points that are not simulated, no row is fitted
    black = problem.direct.black_at([point for point, _ in problem.plan.settings])
    return moments(Readings(problem.measured[0]), problem.plan.captures.sensor.black_level, black)


def with_uncertainties(
    problem: FitProblem,
    state: State,
    replicates: int = REPLICATES,
    derived: int | None = None,
) -> Fit:
    """Correct the estimate for the sampling error of the simulation; standard errors by bootstrap.

    A simulated sensor scatters as much as the measured one, and so do its derivatives. How far the
    one of the fit lies from the mean of itself and ``replicates`` others is taken off, and the
    estimate moves to where G z = 0, G = (J'WJ)^-1 J'W. J is the mean over several sensors; what its
    noise adds to J'WJ, which would shorten both the step and the errors, is taken off (`_gain`).
    What scatters is one measured sensor and the mean of replicates + 1 simulated ones: the
    covariance is 1 + 1 / (replicates + 1) times that of G (replicate - mean).

    ``derived``: sensors over which J is the mean; by default as many as their cost allows.
    """
    free = state.free
    covariance = np.full((len(free), len(free)), np.nan)
    if replicates < 2 or not free:
        return _described(problem, state, covariance, None)
    drawn, jacobians = _redrawn(problem, state, replicates, derived)
    seen = np.linalg.norm(jacobians.mean(axis=0), axis=0) > 1e-3
    if not seen.any():
        return _described(problem, state, covariance, seen)
    count = np.sum(np.isfinite(drawn), axis=0)
    mean = np.where(count > 0, np.nansum(drawn, axis=0) / np.maximum(count, 1), np.nan)
    share = 1.0 / (replicates + 1)
    own = np.nan_to_num((1.0 - share) * (problem.fitted_coordinates(state.model) - mean))
    scatter = np.nan_to_num(drawn - mean)
    # The measured errors grow with the measured tails: weights by them would pull the tails down.
    spread = np.sqrt(2.0 * np.sum(scatter**2, axis=0) / np.maximum(count - 1, 1))
    reproducibility_sd = np.maximum(spread, LEAST_SCATTER * problem.train.reproducibility_sd)
    fair = replace(
        problem,
        train=replace(
            problem.train,
            coordinates=problem.train.coordinates + own,
            stated=reproducibility_sd,
            scale=None,
        ),
    )
    fair = fair.weighted(misfit_share(fair.fitted_z(state.model)))
    jacobians *= (problem.train.reproducibility_sd / reproducibility_sd)[:, None]
    jacobian = jacobians.mean(axis=0)
    here = replace(start(fair, state.model, free), jacobian=jacobian)
    numbers = len(here.train)
    gain = np.zeros((len(free), numbers + len(here.ties)))
    gain[seen] = _gain(here, jacobians, seen)
    moved = (scatter / reproducibility_sd) @ gain[seen, :numbers].T
    by_ties = gain[seen, numbers:]
    covariance[np.ix_(seen, seen)] = (1.0 + share) * moved.T @ moved / (replicates - 1)
    covariance[np.ix_(seen, seen)] += by_ties @ by_ties.T
    found = _at_root(fair, here, gain, np.sqrt(np.diag(covariance)))
    found = replace(
        found,
        train=(found.train * reproducibility_sd - own) / problem.train.reproducibility_sd,
        jacobian=jacobian * (reproducibility_sd / problem.train.reproducibility_sd)[:, None],
    )
    return _described(problem, found, covariance, seen)


def _redrawn(
    problem: FitProblem, state: State, replicates: int, derived: int | None
) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates of other sensors of the same design, (sensors, numbers), and derivatives of some.

    These have the shape (sensors, numbers, free parameters).
    """
    groups = len({k.group for k in state.free})
    several = min(replicates, derived or max(6, round(DERIVATIVES / groups)))
    drawn = [problem.replicate(state.model, r)[0] for r in range(several, replicates)]
    jacobians = []
    for number in range(several):
        other = problem.with_memo(room())
        model = replace(state.model, seed=state.model.seed + 1 + number)
        train = other.fitted_coordinates(model)
        drawn.append(train)
        begun = replace(state, model=model, train=problem.train.z(train))
        jacobians.append(derive(other, begun, smallest=STEP_SIZE, anew=True).jacobian)
    return np.array(drawn), np.array(jacobians)


def _at_root(fair: FitProblem, state: State, gain: np.ndarray, spread: np.ndarray) -> State:
    """Newton steps with constant gain, until they are small relative to the standard errors.

    They end where the loss rises by more than the sampling error of one sensor's derivatives,
    about 1 per parameter.
    """
    most = state.merit + len(state.free)
    for _ in range(STEPS):
        here = positions(state.model, state.free)
        off = np.concatenate([state.train, misfits(state.ties, here)])
        step = np.clip(-gain @ off, *longest(state.free, here))
        if np.nanmax(np.abs(step) / spread) < SMALL:
            break
        there = [k.inside(x) for k, x in zip(state.free, here + step, strict=True)]
        model = with_values(state.model, state.free, np.array(there))
        train = fair.fitted_z(model)
        moved = replace(state, model=model, train=train, unseen=unseen(fair, model))
        if moved.merit > most:
            break
        state = moved
    return state


def _gain(state: State, jacobians: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """d parameter / d number of weighted least squares, (seen parameters, numbers and ties).

    The derivatives of the state are the mean of ``jacobians``. Their noise adds its covariance to
    the normal equations (errors in variables; Fuller, Measurement Error Models, Wiley 1987, sec.
    2.2). Along the directions in which it is independent, those are reduced by its share; the gain
    is such that numbers that scatter by 1 give the covariance of derivatives without noise.
    """
    w = np.concatenate([root_weights(state.train, state.weight), np.ones(len(state.ties))])
    a = np.vstack([state.jacobian, tied(state)[0]])[:, seen] * w[:, None]
    size = np.linalg.norm(a, axis=0)  # the free parameters' scales differ by orders of magnitude
    _, singular, right = np.linalg.svd(a / size, full_matrices=False)
    kept = singular > 1e-6 * singular[0]
    white = right[kept].T / singular[kept]
    count, numbers = len(jacobians), len(state.train)
    apart = (jacobians - jacobians.mean(axis=0))[..., seen] * w[:numbers, None] / size
    apart = (apart @ white).reshape(-1, white.shape[1])
    share, turn = np.linalg.eigh(apart.T @ apart / (count * max(count - 1, 1)))
    white = white @ turn / (1.0 - np.clip(share, 0.0, MOST_NOISE)) ** 0.25
    return white @ white.T @ (a / size).T / size[:, None] * w


def _described(
    problem: FitProblem, state: State, covariance: np.ndarray, seen: np.ndarray | None
) -> Fit:
    """The fit in plain units; ``seen``: which parameters move any number, None where not known."""
    free, here = state.free, positions(state.model, state.free)
    spread = np.sqrt(np.diag(covariance)) if free else np.empty(0)
    known = np.ones(len(free), bool) if seen is None else seen
    parameters = [
        _parameter(k, x, s, bool(determined))
        for k, x, s, determined in zip(free, here, spread, known, strict=True)
    ]
    with np.errstate(invalid="ignore", divide="ignore"):
        correlations = covariance / np.outer(spread, spread)
    doubts = [] if seen is None else _doubts(free, spread, correlations, seen)
    doubts += [
        f"{p.name}: {p.value:.3g} +- {p.se:.2g} eV is not the activation energy of a dark current, "
        f"{USUAL_EV[0]:g} to {USUAL_EV[1]:g} eV"
        for k, p in zip(free, parameters, strict=True)
        if _of_dark_current(state.model, k) and unusual(p.value, p.se)
    ]
    doubts += _moved_sessions(problem, state.model)
    exact = _read_off(problem, state.model)
    whole = np.eye(len(free) + len(exact))  # their errors are none of the fit's
    whole[: len(free), : len(free)] = correlations
    every = Parameters([*parameters, *exact])
    return Fit(state.model, every, whole, doubts, problem, state, problem.plan.captures)


def _moved_sessions(problem: FitProblem, model: NoiseModel) -> list[str]:
    """Operating points with a black level of their own, in a sentence."""
    own = problem.direct.sessions
    if own is None or not isinstance(model.pedestal, TableLaw):
        return []
    usual = float(np.median(own.law.values))
    return [
        f"not determined: dark signal at {point.label()}; the black level there differs by "
        f"{minus(f'{own.law.at(point) - usual:+.3g}')} DN from that of the other operating points"
        for point in own.moved
        if point in model.pedestal.points
    ]


def _read_off(problem: FitProblem, model: NoiseModel) -> list[Parameter]:
    """Parameters that are measured and not fitted, with the errors of their statistics."""
    found = []
    for name, number in measured_parameters(problem, model).items():
        effect, _, parameter = name.partition(".")
        bearer = model.get(effect)
        assert bearer is not None
        value = bearer.value(parameter, model.reference)
        if abs(value - number.value) <= number.se:  # else it was held at a number of the user's
            found.append(Parameter(name, value, number.se, bearer.parameters()[parameter].unit))
    return found


def uncertain(problem: FitProblem, state: State, simulate: bool = True) -> Fit:
    """A fitted model with its standard errors, and what the captures do not determine.

    The estimate was made with one simulated sensor, which scatters as much as the measured one: the
    variance is twice that of one sensor, where `fit`, which averages over 1 + n simulated sensors,
    has 1 + 1 / (1 + n) times it.

    Parameters
    ----------
    problem : FitProblem
    state : State
    simulate : bool
        Whether replicates are simulated for the errors; else these are NaN.
    """
    here = with_uncertainties(problem, state, 0)
    if not simulate:
        return here
    freed = with_uncertainties(problem, state, QUICK_REPLICATES, QUICK_DERIVATIVES)
    times = math.sqrt(2.0 / (1.0 + 1.0 / (1.0 + QUICK_REPLICATES)))
    by_name = {p.name: p for p in freed.parameters}
    parameters = []
    for own in here.parameters:
        other = by_name[own.name]
        upper = None if other.upper is None else own.value + ONE_SIDED * times * other.se
        parameters.append(
            replace(own, se=times * other.se, determined=other.determined, upper=upper)
        )
    return replace(freed, model=state.model, parameters=Parameters(parameters), state=state)


def _of_dark_current(model: NoiseModel, parameter: FreeParameter) -> bool:
    """Whether it is the activation energy of a dark current; that of a glow is not."""
    effect = model.get(parameter.effect) if parameter.energy and parameter.part != "ea_ev" else None
    usual = getattr(type(effect), parameter.parameter, None)
    return effect is not None and isinstance(usual, float) and not unusual(usual, 0.0)


def _parameter(parameter: FreeParameter, position: float, spread: float, seen: bool) -> Parameter:
    value = parameter.plain(position)
    se = float(value * spread if parameter.log else spread)
    vague = parameter.log and spread > VAGUE
    upper = value + ONE_SIDED * se if vague and seen and math.isfinite(se) else None
    return Parameter(parameter.name, value, se, parameter.unit, seen and not vague, upper)


def _doubts(
    free: Sequence[FreeParameter], spread: np.ndarray, correlations: np.ndarray, seen: np.ndarray
) -> list[str]:
    sentences = []
    for i, parameter in enumerate(free):
        if parameter.energy and not seen[i]:
            sentences.append(
                f"not determined: {parameter.name}, kept; these captures give no activation energy"
            )
        elif not seen[i]:
            sentences.append(
                f"not determined: {parameter.name}; nothing in these captures depends on it"
            )
        elif parameter.log and spread[i] > VAGUE:
            factor = f"{math.exp(spread[i]):.3g}" if spread[i] < VERY_VAGUE else "more than 1,000"
            sentences.append(f"not determined: {parameter.name}, within a factor of {factor}")
    for i in range(len(free)):
        for j in range(i):
            if abs(correlations[i, j]) > CONFOUNDED_CORRELATION:
                sentences.append(
                    f"confounded in these captures: {free[j].name} and {free[i].name} "
                    f"(correlation {correlations[i, j]:+.3f})"
                )
    return sentences
