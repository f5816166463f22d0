"""The figures of the families of statistics, measured alone or beside a model."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache, partial

from dnanalyze.channels.refinement import ChannelRefinement
from dnanalyze.diagnosis.results import Refinement
from dnanalyze.fitting.fit import Fit
from dnanalyze.report.figures import (
    code_use,
    distribution,
    exceedance,
    frame_means,
    noise_and_dark_signal,
    rows_and_columns,
    shading,
    spectrum,
    spectrum_2d,
)
from dnanalyze.report.figures.pictures import Draw
from dnanalyze.report.figures.style import Layer, layers

Figure = Callable[[Sequence[Layer]], object]
KINDS: dict[str, Figure] = {
    "temperature": noise_and_dark_signal.over_temperature,
    "distribution": distribution.histograms,
    "tails": exceedance.exceedance,
    "spectrum": spectrum.spectra,
    "spectrum_2d": spectrum_2d.planes,
    "profiles": rows_and_columns.profiles,
    "line_spectra": rows_and_columns.spectra,
    "time": frame_means.frame_means,
    "codes": code_use.roughness,
    "shading": shading.maps,
}


def family_plots(drawn: Callable[[], Sequence[Layer]]) -> dict[str, Draw]:
    """The figures by kind.

    Parameters
    ----------
    drawn : callable
        Gives the layers, the measured first; called once, when the first figure is drawn.
    """
    once = cache(drawn)
    return {kind: partial(_one, figure, once) for kind, figure in KINDS.items()}


def _one(figure: Figure, drawn: Callable[[], Sequence[Layer]]) -> object:
    return figure(drawn())


def simulated(result: Fit | Refinement | ChannelRefinement) -> Sequence[Layer]:
    """The held-out data beside a simulation of the model, of a result that has both."""
    return layers(
        result.problem.measured[1], result.problem.statistics(result.model, errors=True)[1]
    )
