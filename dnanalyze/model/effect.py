"""What an effect is: parameters, its place in the signal chain, and one pure function.

An effect is a frozen dataclass derived from `Effect`. Its fields, made with `parameter`, carry
units, bounds and a default. ``apply`` takes the signal of a window of the frame and returns the
changed signal. Up to the ``PEDESTAL`` the signal is in DN above the black level, after it in DN as
recorded.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Collection
from dataclasses import dataclass, field
from enum import IntEnum
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import OperatingPoint, Window
from dnanalyze.model.hot_signal import HotSignal
from dnanalyze.model.laws import Law, arrhenius, law_from_plain, value_at
from dnanalyze.model.streams import Stream

if TYPE_CHECKING:
    from dnanalyze.model.clues import Clues, Located


MOST_WHOLE = 1_000_000  # pixels, periods: no sensor has as many columns


class Stage(IntEnum):
    """Places in the signal chain, in the order in which the signal passes them."""

    CHARGE = 10  # what is generated in the pixel during the exposure, mean values
    ARRIVAL = 20  # counting statistics of that charge
    COUPLING = 30  # charge or voltage shared between neighbours
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

    EVERYWHERE = 1  # every part of the field shows it alike
    ANYWHERE = 2  # by one law at all places, unshaded, but not alike: few pixels, columns
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
class Told:
    """A number that a statistic tells, with its standard error."""

    value: float
    se: float


def parameter(
    default: Law, unit: str, lower: float, upper: float, doc: str, scale: str = "log"
) -> Any:
    """Declare a parameter that the fit may move; it may follow a law over temperature."""
    info = ParameterInfo(unit, lower, upper, doc, scale)
    return field(default=default, metadata={"info": info})


def choice(default: Any, doc: str, *choices: Any) -> Any:
    """Declare a discrete setting of an effect, one of ``choices``."""
    info = ParameterInfo("", 0, 0, doc, "choice", choices)
    return field(default=default, metadata={"info": info})


def _not_kept(name: str, make: Callable[[], Any]) -> Any:
    return make()


def _no_calibration(number: int, warmer: float = 0.0) -> np.ndarray:
    raise NotImplementedError("this site has no frames before the effect")


@dataclass(frozen=True)
class Site:
    """Where and when an effect acts, and its random numbers.

    Parameters
    ----------
    shape : tuple of int
        Full frame, (rows, columns).
    window : Window
        The part of it that the signal covers.
    point, reference : OperatingPoint
        Here, and where the model's numbers are stated.
    frame : int
        Number of the frame in its setting, from 0.
    silicon, moment : Stream
        Random numbers of this effect: the same in every frame of every setting, and new in each
        frame.
    keep : callable
        ``keep(name, make)`` returns ``make()`` and remembers it for the frames of this setting.
    share : callable
        As ``keep``, for what does not depend on the window: all parts of the frame get the same.
    field : callable
        ``field(stream, kind)`` draws "normal" or "uniform" over ``window``.
    calibration : callable
        ``calibration(n, warmer)`` is frame n, whole, so many C warmer than the reference point, as
        it is before this effect: what a factory would have seen of this silicon. Negative n are
        frames of no capture.
    """

    shape: tuple[int, int]
    window: Window
    point: OperatingPoint
    reference: OperatingPoint
    frame: int
    silicon: Stream
    moment: Stream
    keep: Callable[[str, Callable[[], Any]], Any]
    field: Callable[[Stream, str], np.ndarray]
    calibration: Callable[[int, float], np.ndarray] = _no_calibration
    share: Callable[[str, Callable[[], Any]], Any] = _not_kept

    def fixed_normal(self, name: str = "") -> np.ndarray:
        """Standard normal field of the silicon over the window, float32."""
        return self.field(self.silicon.child(name), "normal")

    def fixed_uniform(self, name: str = "") -> np.ndarray:
        """Uniform field of the silicon over the window, float32."""
        return self.field(self.silicon.child(name), "uniform")

    def normal(self, name: str = "") -> np.ndarray:
        """Standard normal field of this frame over the window, float32."""
        return self.field(self.moment.child(name), "normal")

    def uniform(self, name: str = "") -> np.ndarray:
        """Uniform field of this frame over the window, float32."""
        return self.field(self.moment.child(name), "uniform")

    def columns(self, stream: Stream) -> np.ndarray:
        """One standard normal a column of the window, float32."""
        line = Window(0, 1, self.window.left, self.window.right)
        return stream.normal(line, self.shape[1])[0]

    def rows(self, stream: Stream) -> np.ndarray:
        """One standard normal a row of the window, float32."""
        line = Window(0, 1, self.window.top, self.window.bottom)
        return stream.normal(line, self.shape[0])[0]

    @property
    def row_index(self) -> np.ndarray:
        """Row number in the full frame of each row of the window."""
        return np.arange(self.window.top, self.window.bottom)

    @property
    def column_index(self) -> np.ndarray:
        """Column number in the full frame of each column of the window."""
        return np.arange(self.window.left, self.window.right)

    @property
    def exposure_ratio(self) -> float:
        """Exposure over the reference exposure; 1 where either is unknown."""
        return self.point.exposure_over(self.reference)

    @property
    def gain_ratio(self) -> float:
        """Analogue gain over the reference gain; 1 where either is unknown."""
        return self.point.gain_over(self.reference)

    def thermal(self, ea_ev: float) -> float:
        """Arrhenius growth from the reference temperature to here."""
        if self.reference.temperature_c is None:
            return 1.0
        return arrhenius(self.point.temperature_c, self.reference.temperature_c, ea_ev)


@dataclass(frozen=True)
class Effect:
    """Base of all effects; see the module's text.

    Class attributes: ``name`` as in the catalogue; ``stage``; ``varies`` "fixed" or "temporal" or
    "both" or "digital"; ``summary`` one line; ``physics`` the paragraph for the user: what it is,
    its law, what to do about it; ``formula``; ``references``; ``fingerprint`` names of the
    statistics that it moves most; ``confused_with`` {effect: what tells them apart}; ``reach``
    pixels around the window that it looks at, unless `margin` tells; ``memory`` earlier frames that
    it looks at; ``placing`` where in the field it is.
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
                if not info.choices and item.default != () and not _whole(value):
                    raise InputError(f"{where}: {value!r} is no whole number of 0 to {MOST_WHOLE}")
                continue
            numbers = getattr(value, "values", None) or (getattr(value, "value", value),)
            for number in numbers:
                if not info.lower <= number <= info.upper:
                    raise InputError(
                        f"{where}: {number:g} {info.unit} is outside "
                        f"{info.lower:g} to {info.upper:g}"
                    )

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """The signal after this effect, float32, same shape; the input may be changed in place.

        With ``memory`` m the signal has shape (m + 1, rows, columns), the present frame last, and
        the result is the present frame alone.
        """
        raise NotImplementedError

    def variance(self, point: OperatingPoint) -> float | None:
        """Variance that it adds to a pixel over the frame, DN^2, where a closed form exists."""
        return None

    @classmethod
    def guess(cls, clues: Clues) -> list[Effect]:
        """First guesses of this effect from what the model leaves unexplained; empty: no sign.

        Several where the effect has kinds (each is tried). Those of the catalogue's effects are
        made in ``guesses``; another effect may have a ``guess`` of its own.
        """
        from dnanalyze.model.guesses import guess_of

        make = guess_of(cls)
        return [cls()] if make is None else make(cls, clues)

    def told(self, measured: Located) -> dict[str, Told]:
        """Its "held" numbers as these captures tell them, where a statistic does, by name.

        A fit begins with them, leaves them alone and reports them with these errors.
        """
        return {}

    def bent(self, name: str, unit: str, noise: float = math.inf) -> tuple[float, float]:
        """Factor and shift by which a number comes right again when this effect is put in.

        A fit without the effect bends it to make up for it. ``name`` as "effect.parameter" or
        "pedestal"; (1, 0) for what is not bent. ``noise``: of the quietest frames, DN.
        """
        return 1.0, 0.0

    def margin(self) -> int:
        """Pixels around the window that it looks at, with its present choices."""
        return self.reach

    def adds(self, point: OperatingPoint, reference: OperatingPoint) -> tuple[float, float] | None:
        """What it adds to the level and to the variance of the pattern, DN and DN^2.

        Where that is told, and much: a fit without it then has another sensor's dark current, noise
        and level, and is begun again with the rest of what the frames say at a glance.
        """
        return None

    @classmethod
    def odds(cls, others: Collection[str]) -> float:
        """Odds of it against another effect, before the data speak, beside these in the model."""
        return 1.0

    def lies_in(self, window: Window) -> bool:
        """Whether any of it lies in this part of the field; named places may say that none does."""
        return True

    def relatives(self) -> list[Effect]:
        """Other forms that show nearly alike, with numbers to match; tried once this one fits."""
        return []

    def hot_signal(self, reference: OperatingPoint) -> HotSignal | None:
        """Where it is extra dark signal in few pixels, what all effects of that kind have."""
        return None

    @classmethod
    def of_hot_signal(cls, hot: HotSignal) -> list[Effect]:
        """This effect with such an extra dark signal; several where it has kinds."""
        return []

    def warm_up(self, point: OperatingPoint) -> int:
        """Frames before the first that were taken alike, of those that ``memory`` looks at.

        For earlier ones stands the first of all.
        """
        return 0

    def idle(self) -> tuple[str, ...]:
        """Parameters that change nothing under the present choices; a fit leaves them alone."""
        return ()

    def value(self, name: str, point: OperatingPoint) -> float:
        """A parameter's value at an operating point, whatever its law."""
        return value_at(getattr(self, name), point)

    @classmethod
    def parameters(cls) -> dict[str, ParameterInfo]:
        """Name to unit, bounds and meaning, in order."""
        return {f.name: f.metadata["info"] for f in dataclasses.fields(cls)}

    @classmethod
    def from_plain(cls, raw: dict[str, Any]) -> Effect:
        """Build from a mapping as written in YAML; unknown names are refused."""
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
        """As written in YAML."""
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
