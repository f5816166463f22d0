"""Residual of a model, from which effects estimate their initial values."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from dnanalyze.analyzers.catalogue import catalogue as infos
from dnanalyze.fitting.line_defects import defects_of, line_defects
from dnanalyze.fitting.measured_parameters import Measured
from dnanalyze.fitting.problem import FitProblem
from dnanalyze.fitting.readings import MOSAIC, SINGLE, Readings
from dnanalyze.fitting.simulated import BLOCKS
from dnanalyze.fitting.state import State
from dnanalyze.loaders.captures import OperatingPoint, Window
from dnanalyze.model.guesses.hints import gains
from dnanalyze.model.guesses.line_profile import line_profile
from dnanalyze.model.wave import Wave


@dataclass(frozen=True)
class Residual:
    """Measured against simulated statistics of the train half (implements ``Clues``).

    Parameters
    ----------
    problem : FitProblem
    state : State
    """

    problem: FitProblem
    state: State

    @property
    def points(self) -> Sequence[OperatingPoint]:
        """Operating points."""
        return [p for p, _ in self.problem.plan.settings]

    @property
    def reference(self) -> OperatingPoint:
        """Where the model's numbers are stated."""
        return self.state.model.reference

    @property
    def shape(self) -> tuple[int, int]:
        """The part of the frame that the statistics cover."""
        return self.problem.plan.train.shape

    @property
    def field(self) -> tuple[int, int]:
        """Full frame."""
        return self.problem.plan.shape

    @property
    def area(self) -> Window:
        """The window of the frame that both halves make up."""
        return self.problem.plan.window

    def waves(self, part: str) -> Sequence[Wave]:
        """Lines of a spectrum, of both halves and all settings."""
        return Measured(self.problem, self.reference).waves(part)

    @cached_property
    def _readings(self) -> tuple[Readings, Readings]:
        return Readings(self.problem.measured[0]), Readings(self.problem.measured[1])

    def _known_as(self, name: str) -> str:
        """The name of a statistic; of single frames alone that of the frame.

        Its DSNU and its temporal noise are then one: an effect of either may explain it.
        """
        part, _, what = name.partition("_")
        alone = part in ("pattern", "temporal") and all(
            n == 1 for _, n in self.problem.plan.settings
        )
        return f"{SINGLE}_{what}" if alone and f"{SINGLE}_{what}" in infos() else name

    def measured(self, name: str) -> np.ndarray:
        """Measured value, one per setting; values that are given for information alone too."""
        name = self._known_as(name)
        held = self._over_settings(name, self.problem.train.values)
        return held if np.isfinite(held).any() else self._readings[0].value(name)

    def simulated(self, name: str) -> np.ndarray:
        """Model value, one per setting."""
        name = self._known_as(name)
        found = self._over_settings(name, self.problem.train.predicted(self.state.train))
        info = infos().get(name)
        return found if info is None else np.array([info.scale.plain(c) for c in found])

    def z(self, name: str) -> np.ndarray:
        """Misfit z, one per setting."""
        return self._over_settings(self._known_as(name), self.state.train)

    def colours(self, name: str) -> np.ndarray:
        """Values and standard errors of the colours of a mosaic, of the fitted half."""
        planes = self._readings[0].planes
        if any(len(p) != MOSAIC**2 or any(name not in c.values for c in p) for p in planes):
            return np.empty((0, MOSAIC**2, 2))
        return np.array([[(c.values[name].value, c.values[name].se) for c in p] for p in planes])

    def curve(self, name: str, setting: int) -> np.ndarray:
        """A measured curve; means of blocks are of both halves (`area`)."""
        upper, lower = (r.curve(name, setting) for r in self._readings)
        if name in BLOCKS and upper.ndim == 2 and lower.ndim == 2:
            return np.concatenate([upper, lower])
        return upper

    @cached_property
    def _simulated(self) -> Readings:
        """Statistics of the model, of the fitted half, with their curves."""
        return Readings(self.problem.statistics(self.state.model, half=0)[0])

    def modelled_curve(self, name: str, setting: int) -> np.ndarray:
        """A curve of the model, of the fitted half; empty where it has none."""
        return self._simulated.curve(name, setting)

    def lines(self, axis: str, setting: int) -> tuple[np.ndarray, np.ndarray]:
        """Rows of both halves one after the other; columns as their mean over both."""
        plan = self.problem.plan
        parts = [r.lines(axis, setting) for r in self._readings]
        if not all(p.size for p in parts):
            return np.empty(0, int), np.empty(0)
        if axis == "columns":
            return np.arange(plan.train.left, plan.train.right), np.mean(parts, axis=0)
        places = [np.arange(w.top, w.bottom) for w in plan.windows]
        return np.concatenate(places), np.concatenate(parts)

    def defects(self, axis: str) -> np.ndarray:
        """Lines that deviate, each over the length that most settings show."""
        plan = self.problem.plan
        seen = [
            defects_of(self._readings, plan.windows, plan.shape, axis, s)
            for s in range(len(self.points))
        ]
        return line_defects(line_profile(self, axis), seen, gains(self), axis, plan.shape)

    def _over_settings(self, name: str, values: np.ndarray) -> np.ndarray:
        train = self.problem.train
        here = train.names == name
        out = np.full(len(self.points), np.nan)
        for s in np.unique(train.setting[here]):
            out[s] = np.mean(values[here & (train.setting == s)])
        return out
