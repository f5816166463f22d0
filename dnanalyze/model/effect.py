"""What an effect is: parameters, its place in the signal chain, and one pure function.

An effect is a frozen dataclass derived from `Effect`. Its fields, made with `parameter`, carry
units, bounds and a default. ``apply`` takes the signal of a window of the frame and returns the
changed signal. Up to the ``PEDESTAL`` the signal is in DN above the black level, after it in DN as
recorded.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Collection
from dataclasses import dataclass, field
from enum import IntEnum
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import OperatingPoint, Window
from dnanalyze.model.hot_signal import HotSignal
from dnanalyze.model.laws import Law, law_from_plain, value_at
from dnanalyze.model.learned.field_map import FieldMap
from dnanalyze.model.site import Site as Site  # effects take it from here

if TYPE_CHECKING:
    from dnanalyze.model.clues import Clues, MeasuredLines


MOST_WHOLE = 1_000_000  # pixels, periods: no sensor has as many columns
# Factor of a spread over pixels that shares its variance with another cause. A spread enters as its
# square: at 0 it has no derivative, and a fit that begins there does not find it.
HALF_THE_VARIANCE = math.sqrt(0.5)


class Stage(IntEnum):
    """Places in the signal chain, in the order in which the signal passes them."""

    CHARGE = 10  # what is generated in the pixel during the exposure, mean values
    ARRIVAL = 20  # counting statistics of that charge
    COUPLING = 30  # charge or voltage shared between neighbours
    REGISTER = 35  # charge multiplied on its way to the output
    PIXEL_READ = 40  # noise and offsets of the pixel's own amplifier
    LINE_READ = 50  # columns, rows, taps, clocks
    PEDESTAL = 60  # the black level is added here
    CODE_WIDTHS = 65  # unequal steps of the converter, before its rounding
    CONVERTER = 70  # rounding, clipping
    DIGITAL = 80  # gains and replaced codes
    CORRECTION = 90  # defect pixels replaced
    SPATIAL_FILTER = 100  # smoothing within a frame
    TEMPORAL_FILTER = 110  # smoothing over frames


class Placing(IntEnum):
    """Where in the field an effect is, from what is the same all over to what is not."""

    EVERYWHERE = 1  # every band of rows over the whole width shows it alike
    ANYWHERE = 2  # by one law at all places, unshaded, but not alike: few pixels
    SOMEWHERE = 3  # at places of its own, or shaded, be it by rows, clouds or hum; or not known


@dataclass(frozen=True)
class ParameterInfo:
    """Unit, bounds and meaning of an effect's parameter.

    ``scale`` is "log" for positive amplitudes, "linear" for signed ones, "choice" for what is not
    fitted: a word or a whole number from ``choices`` (empty: any whole number; by default an empty
    tuple: a row of numbers read off the measurement), "held" for a number that the first guess
    finds exactly and that no fit moves: a statistic tells it better than the misfit, or frames do
    not depend on it smoothly. "signed" is "linear" for a number whose sign the first guess finds
    and the misfit hardly sees: a fit moves it on its side of 0.
    """

    unit: str
    lower: float
    upper: float
    doc: str
    scale: str
    choices: tuple[Any, ...] = ()


@dataclass(frozen=True)
class MeasuredParameter:
    """A number that a statistic tells, with its standard error."""

    value: float
    se: float


def parameter(
    default: Law, unit: str, lower: float, upper: float, doc: str, scale: str = "log"
) -> Any:
    """Declare a parameter that the fit may change; it may follow a law over temperature.

    Parameters
    ----------
    default : Law
        A number, or a law over temperature.
    unit : str
        Such as "DN".
    lower : float
        Least value, in that unit.
    upper : float
        Greatest value, in that unit.
    doc : str
        What it is, in a few words.
    scale : str
        See `ParameterInfo`.

    Returns
    -------
    dataclasses.Field
        The default of a dataclass field.

    Examples
    --------
    >>> from dnanalyze import parameter
    >>> parameter(1.0, "DN", 0.0, 1e3, "standard deviation").default
    1.0
    """
    info = ParameterInfo(unit, lower, upper, doc, scale)
    return field(default=default, metadata={"info": info})


def choice(default: Any, doc: str, *choices: Any) -> Any:
    """Declare a discrete setting of an effect, one of ``choices``.

    Parameters
    ----------
    default : object
        The choice without another.
    doc : str
        What it is, in a few words.
    *choices : object
        Valid values.

    Returns
    -------
    dataclasses.Field
        The default of a dataclass field.

    Examples
    --------
    >>> from dnanalyze import choice
    >>> choice("mean", "rule of the replacement", "mean", "median").default
    'mean'
    """
    info = ParameterInfo("", 0, 0, doc, "choice", choices)
    return field(default=default, metadata={"info": info})


@dataclass(frozen=True)
class Effect:
    """Base of all effects; see the module's text.

    Class attributes: ``name`` as in the catalogue; ``stage``; ``varies`` "fixed" or "temporal" or
    "both" or "digital"; ``summary`` one line; ``physics`` the paragraph for the user: what it is,
    its law, what to do about it; ``formula``; ``references``; ``fingerprint`` names of the
    statistics that it changes most; ``confused_with`` {effect: what distinguishes them}; ``reach``
    pixels around the window that it reads, unless `margin` states them; ``memory`` earlier frames
    that it reads; ``placing`` where in the field it is.
    """

    name: ClassVar[str] = ""
    stage: ClassVar[Stage] = Stage.CHARGE
    varies: ClassVar[str] = "fixed"
    summary: ClassVar[str] = ""
    physics: ClassVar[str] = ""
    formula: ClassVar[str] = ""
    references: ClassVar[tuple[str, ...]] = ()
    fingerprint: ClassVar[tuple[str, ...]] = ()
    confused_with: ClassVar[dict[str, str]] = {}
    reach: ClassVar[int] = 0
    memory: ClassVar[int] = 0
    placing: ClassVar[Placing] = Placing.SOMEWHERE

    def __post_init__(self) -> None:
        for item in dataclasses.fields(self):
            info: ParameterInfo = item.metadata["info"]
            value = getattr(self, item.name)
            where = f"{self.name}.{item.name}"
            if info.scale == "choice":
                if item.default == () and not _row_of_numbers(value):
                    raise InputError(f"{where}: {value!r} is no list of finite numbers")
                if info.choices and value not in info.choices:
                    raise InputError(f"{where}: {value!r} is not one of {list(info.choices)}")
                if isinstance(item.default, FieldMap):
                    if not isinstance(value, FieldMap):
                        raise InputError(f"{where}: valid: a map of the frame")
                    continue
                if not info.choices and item.default != () and not _whole(value):
                    raise InputError(f"{where}: {value!r} is no whole number of 0 to {MOST_WHOLE}")
                continue
            numbers = getattr(value, "values", None) or (getattr(value, "value", value),)
            unit = "" if info.unit == "1" else f" {info.unit}"
            for number in numbers:
                if not info.lower <= number <= info.upper:
                    raise InputError(
                        f"{where}: {number:g}{unit} is outside {info.lower:g} to {info.upper:g}"
                    )

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """The signal after this effect, float32, same shape; the input may be changed in place.

        With ``memory`` m the signal has shape (m + 1, rows, columns), the present frame last, and
        the result is the present frame alone.

        Parameters
        ----------
        signal : ndarray
            (rows, columns), float32, DN.
        site : Site
            Where and when, with the random numbers.

        Returns
        -------
        ndarray
            (rows, columns), float32, DN.
        """
        raise NotImplementedError

    def variance(self, point: OperatingPoint) -> float | None:
        """Variance that it adds to a pixel over the frame, DN^2, where a closed form exists.

        Parameters
        ----------
        point : OperatingPoint
            Where.

        Returns
        -------
        float or None
            DN^2; None without a closed form.
        """
        return None

    @classmethod
    def guess(cls, clues: Clues) -> list[Effect]:
        """First guesses of this effect from what the model leaves unexplained; empty: no sign.

        Several where the effect has kinds (each is tried). Those of the catalogue's effects are
        made in ``guesses``; another effect may have a ``guess`` of its own.

        Parameters
        ----------
        clues : Clues
            What the model leaves over.

        Returns
        -------
        list of Effect
            One a kind.
        """
        from dnanalyze.model.guesses import guess_of

        make = guess_of(cls)
        return [cls()] if make is None else make(cls, clues)

    def measured_parameters(self, measured: MeasuredLines) -> dict[str, MeasuredParameter]:
        """Return its "held" numbers as these captures state them, where a statistic does.

        A fit begins with them, leaves them alone and reports them with these errors.

        Parameters
        ----------
        measured : MeasuredLines
            What was read off the captures.

        Returns
        -------
        dict
            Parameter to its number and standard error.
        """
        return {}

    def nuisance_bias(self, name: str, unit: str, noise: float = math.inf) -> tuple[float, float]:
        """Factor and shift by which a number comes right again when this effect is put in.

        A fit without the effect bends it to make up for it. ``name`` as "effect.parameter" or
        "pedestal"; (1, 0) for what is not bent. ``noise``: of the quietest frames, DN.

        Parameters
        ----------
        name : str
            Parameter, as "effect.parameter" or "pedestal".
        unit : str
            Its unit.
        noise : float
            Of the quietest frames, DN.

        Returns
        -------
        tuple of float
            (factor, shift).
        """
        return 1.0, 0.0

    def margin(self) -> int:
        """Return how far around the window it looks, with its present choices.

        Returns
        -------
        int
            Pixels.
        """
        return self.reach

    def amplification(self, point: OperatingPoint, reference: OperatingPoint) -> float:
        """Factor of its numbers at the gain of an operating point.

        Parameters
        ----------
        point : OperatingPoint
            Where.
        reference : OperatingPoint
            Where the model's numbers are stated.

        Returns
        -------
        float
            The analog gain over that of the reference, by default.
        """
        return point.gain_over(reference)

    def adds(
        self, point: OperatingPoint, reference: OperatingPoint, shape: tuple[int, int]
    ) -> tuple[float, float] | None:
        """What it adds to the level and to the variance of the pattern, DN and DN^2.

        Where that is told, and much: a fit without it then has another sensor's dark current, noise
        and level, and is begun again with the rest of what the frames say at a glance.

        Parameters
        ----------
        point : OperatingPoint
            Where.
        reference : OperatingPoint
            Where the model's numbers are stated.
        shape : tuple of int
            Full frame, (rows, columns).

        Returns
        -------
        tuple of float or None
            (DN, DN^2); None where that is not known. Fixed offsets of the readout have their
            `variance`, and by default all others None.
        """
        offset = self.varies == "fixed" and Stage.PIXEL_READ <= self.stage <= Stage.LINE_READ
        variance = self.variance(point) if offset else None
        if variance is None:
            return None
        return 0.0, variance * self.amplification(point, reference) ** 2

    def black_shift(
        self, point: OperatingPoint, reference: OperatingPoint, shape: tuple[int, int]
    ) -> float:
        """Median of what it adds to a frame without exposure, DN.

        The black level that such frames show is the model's with these of all effects.

        Parameters
        ----------
        point : OperatingPoint
            Where.
        reference : OperatingPoint
            Where the model's numbers are stated.
        shape : tuple of int
            Full frame, (rows, columns).

        Returns
        -------
        float
            DN; 0 by default.
        """
        return 0.0

    @classmethod
    def odds(cls, others: Collection[str]) -> float:
        """Odds of it against another effect, before the data speak, beside these in the model.

        Parameters
        ----------
        others : collection of str
            Effects in the model.

        Returns
        -------
        float
            Odds; 1 is no preference.
        """
        return 1.0

    def lies_in(self, window: Window) -> bool:
        """Whether any of it lies in this part of the field; named places may say that none does.

        Parameters
        ----------
        window : Window
            Part of the field.

        Returns
        -------
        bool
            False where it surely does not.
        """
        return True

    def shows_in(self, frames: int, pixels: int) -> bool:
        """Whether captures of so many frames and pixels tell it from a simpler effect.

        Parameters
        ----------
        frames : int
            Most frames of one operating point.
        pixels : int
            Of a frame, as far as they are compared.

        Returns
        -------
        bool
            False where the simpler effect makes the same frames.
        """
        return True

    def relatives(self) -> list[Effect]:
        """Other forms that show nearly alike, with numbers to match; tried once this one fits.

        Returns
        -------
        list of Effect
            None by default.
        """
        return []

    @classmethod
    def of_hot_signal(cls, hot: HotSignal) -> list[Effect]:
        """This effect with such an extra dark signal; several where it has kinds.

        Parameters
        ----------
        hot : HotSignal
            What to describe.

        Returns
        -------
        list of Effect
            None by default.
        """
        return []

    def warm_up(self, point: OperatingPoint) -> int:
        """Return how many frames were taken alike before the first, of those ``memory`` looks at.

        For earlier ones stands the first of all.

        Parameters
        ----------
        point : OperatingPoint
            Where.

        Returns
        -------
        int
            Frames.
        """
        return 0

    def inactive_parameters(self) -> tuple[str, ...]:
        """Return the parameters that change nothing under the present choices.

        A fit leaves them alone.

        Returns
        -------
        tuple of str
            Names.
        """
        return ()

    def value(self, name: str, point: OperatingPoint) -> float:
        """A parameter's value at an operating point, whatever its law.

        Parameters
        ----------
        name : str
            Parameter.
        point : OperatingPoint
            Where.

        Returns
        -------
        float
            In the unit of the parameter.
        """
        return value_at(getattr(self, name), point)

    @classmethod
    def parameters(cls) -> dict[str, ParameterInfo]:
        """Name to unit, bounds and meaning, in order."""
        return {f.name: f.metadata["info"] for f in dataclasses.fields(cls)}

    @classmethod
    def within(cls, **values: Any) -> Self:
        """Build with numbers moved within the bounds of their parameters; choices as they are.

        Parameters
        ----------
        **values : Any
            Parameter to number or choice.

        Returns
        -------
        Effect
            The effect.
        """
        known = cls.parameters()
        return cls(
            **{
                name: value
                if known[name].scale == "choice"
                else min(max(float(value), known[name].lower), known[name].upper)
                for name, value in values.items()
            }
        )

    @classmethod
    def from_plain(cls, raw: dict[str, Any]) -> Effect:
        """Build from a mapping as written in YAML; unknown names are refused.

        Parameters
        ----------
        raw : dict
            Parameter to number or law.

        Returns
        -------
        Effect
            The effect.

        Raises
        ------
        InputError
            An unknown parameter, or a value outside its bounds.
        """
        known = cls.parameters()
        for key in raw:
            if key not in known:
                valid = ", ".join(known) or "none"
                raise InputError(f"{cls.name}: unknown parameter {key!r}; valid: {valid}")
        values = {
            k: _chosen(v) if known[k].scale == "choice" else law_from_plain(f"{cls.name}.{k}", v)
            for k, v in raw.items()
        }
        return cls(**values)

    def to_plain(self) -> dict[str, Any]:
        """Return the effect as it is written in YAML.

        Returns
        -------
        dict
            Parameter to number, law or choice.
        """
        plain = {}
        for key in self.parameters():
            value = getattr(self, key)
            value = list(value) if isinstance(value, tuple) else value
            plain[key] = value.to_plain() if hasattr(value, "to_plain") else value
        return plain


def _chosen(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value


def _whole(value: Any) -> bool:
    return type(value) is int and 0 <= value <= MOST_WHOLE


def _row_of_numbers(value: Any) -> bool:
    return isinstance(value, tuple) and all(
        isinstance(v, (int, float)) and math.isfinite(v) for v in value
    )
