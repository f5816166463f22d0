"""Changes of the predictions with the model, on the smallest part of the field that shows them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from dnanalyze.fitting.problem import FitProblem
from dnanalyze.fitting.vectors import Target
from dnanalyze.model.effect import Placing
from dnanalyze.model.noise_model import NoiseModel


def part_for(problem: FitProblem, model: NoiseModel) -> FitProblem | None:
    """The part of the field on which a model may be fitted first; None where it may not."""
    return problem.part if model.placing is Placing.EVERYWHERE else None


def screening_part(problem: FitProblem, model: NoiseModel) -> FitProblem | None:
    """The part of the field on which a model may be ruled out; None of a model that has a place.

    By the reproducibility SDs of the whole. Effects in few pixels are not named there, but a model
    that is far from the captures is far from a quarter of them.
    """
    if problem.part is None or model.placing is Placing.SOMEWHERE:
        return None
    return problem.part.scaled_as(problem)


@dataclass(frozen=True)
class Changes:
    """Change of the predictions of the fitted half with the model.

    ``problem``: where both models are simulated. ``base``: predictions of the unchanged model.
    ``wanted``: numbers of the whole field; a change is in units of their reproducibility SD.
    """

    problem: FitProblem
    base: np.ndarray
    wanted: Target

    @classmethod
    def of(cls, problem: FitProblem, model: NoiseModel, placing: Placing) -> Changes:
        """For effects of one placing: on the part of the field, or on a half, where that shows them
        as the whole does.

        What is everywhere does the same to a part of a field that is shaded, or has rows of its
        own, as to the rest of it.
        """
        near = problem.part if placing is Placing.EVERYWHERE else None
        if near is None:
            near = problem.evened(model) if placing < Placing.SOMEWHERE else problem
        return cls(near, near.fitted_coordinates(model), problem.train)

    def by(self, models: Sequence[NoiseModel]) -> Iterator[np.ndarray]:
        """Change of each number by each model, in reproducibility SDs; 0 where one lacks it."""
        rows = self.problem.train.rows_of(self.wanted)
        known = rows >= 0
        for moved in self.problem.several(models):
            change = np.zeros(len(self.wanted.keys))
            change[known] = np.nan_to_num(moved - self.base)[rows[known]]
            yield change / self.wanted.reproducibility_sd
