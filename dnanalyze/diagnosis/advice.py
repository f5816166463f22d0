"""What these captures could not have shown, and what to capture next."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from dnanalyze.fitting.least_squares import State
from dnanalyze.fitting.predictor import Bench
from dnanalyze.model.effect import Effect

if TYPE_CHECKING:
    from dnanalyze.diagnosis.diagnose import Diagnosis


def detection_limits(
    bench: Bench, state: State, known: dict[str, type[Effect]]
) -> dict[str, str]:
    """Smallest strength of each effect that these captures would show."""
    return {}


def next_capture(bench: Bench, found: Diagnosis) -> list[str]:
    """Captures that would settle what is open."""
    return []
