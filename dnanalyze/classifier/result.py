"""What a classifier two-sample test found."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from dnanalyze.classifier.words import sentence
from dnanalyze.loaders.captures import CaptureSet, OperatingPoint
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.result import Result

ABOVE = 0.05  # area above its control that counts: less is told by one patch in ten at most


@dataclass(frozen=True)
class Cell:
    """One operating point and kind of picture.

    Parameters
    ----------
    point : OperatingPoint or None
        None: all operating points together.
    view : str
        "frame", "pair", "mean", "tall" or "wide".
    name : str
        The same in words.
    auc, low, high : float
        Area under the ROC curve, with its limits, each of which holds at 95 % for all cells
        together.
    control : float
        The same of a second simulated sensor against the simulated one, or the mean of several.
    confirmed : bool
        Whether there were several controls, whose scatter is in the limits.
    """

    point: OperatingPoint | None
    view: str
    name: str
    auc: float
    low: float
    high: float
    control: float
    confirmed: bool = False

    @property
    def above(self) -> bool:
        """Whether the area lies above chance by its lower limit, and clearly above its control."""
        return self.low > max(0.5, self.control) and self.auc > self.control + ABOVE

    @property
    def reversed(self) -> bool:
        """Whether what tells the frames on one part of the field tells them wrongly on the other.

        The upper limit of the area lies below chance and the area clearly below its control: the
        two parts differ from the model in opposite ways.
        """
        return self.high < min(0.5, self.control) and self.auc < self.control - ABOVE

    @property
    def tells(self) -> bool:
        """Whether the measured frames can be told here: above, and several controls confirm it."""
        return self.above and self.confirmed


@dataclass(frozen=True)
class Told:
    """Patches that tell most, of one operating point.

    Parameters
    ----------
    point : OperatingPoint
    picture : str
        What they show, in words.
    measured, simulated : ndarray
        (patches, rows, columns), DN around the level of the frame.
    """

    point: OperatingPoint
    picture: str
    measured: np.ndarray
    simulated: np.ndarray


@dataclass(frozen=True, repr=False)
class Classification(Result):
    """Whether a trained classifier can tell simulated frames from measured ones.

    Parameters
    ----------
    captures : CaptureSet
        The measured frames.
    model : NoiseModel
        The model that was simulated.
    cells : list of Cell
        By operating point and kind of picture.
    together : list of Cell
        By kind of picture, the mean over all operating points; empty where there is one.
    telling : list of str
        The descriptors that tell most, in words; empty where nothing is told.
    patches : Told, optional
        The patches that tell most.
    reason : str
        Why nothing was judged; empty where it was.
    finished : bool
        Whether all operating points were judged before the time limit.
    """

    captures: CaptureSet = field(compare=False)
    model: NoiseModel
    cells: list[Cell]
    together: list[Cell] = field(default_factory=list)
    telling: list[str] = field(default_factory=list)
    patches: Told | None = None
    reason: str = ""
    finished: bool = True

    @property
    def best(self) -> Cell | None:
        """The cell that tells most: by its lower limit, those that tell first."""
        every = (*self.cells, *self.together)
        return max(every, key=lambda c: (c.tells, c.low), default=None)

    @property
    def auc(self) -> float | None:
        """Area under the ROC curve where the classifier tells most; None where nothing was judged.

        Its limits allow for the choice among all cells.
        """
        return None if self.best is None else self.best.auc

    @property
    def low(self) -> float | None:
        """Lower limit of the area at 95 % confidence."""
        return None if self.best is None else self.best.low

    @property
    def high(self) -> float | None:
        """Upper limit of the area at 95 % confidence."""
        return None if self.best is None else self.best.high

    @property
    def control(self) -> float | None:
        """Area of a second simulated sensor against the simulated one, in the same cell."""
        return None if self.best is None else self.best.control

    @property
    def tells(self) -> bool:
        """Whether simulated frames can be told: in any cell, above chance and above its control."""
        return any(c.tells for c in (*self.cells, *self.together))

    def sentence(self) -> str:
        """Return the verdict in words.

        Returns
        -------
        str
            Where and by what the frames are told, with the areas.
        """
        return sentence(self)

    def _brief(self) -> str:
        return f"{self.captures.name}, {'tells' if self.tells else 'cannot tell'}"
