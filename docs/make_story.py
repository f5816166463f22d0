"""Draw docs/figures/story.png, the picture of the README: ``python docs/make_story.py``.

The sensor of ``dnanalyze demo``: a frame, the model error at each refinement step, and the column
spectrum with and without the hidden effect.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from dnanalyze.analyzers.analyze import analyze
from dnanalyze.demo import draw_sensor, generate
from dnanalyze.diagnosis.refine import Refinement, refine
from dnanalyze.loaders.captures import CaptureSet
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.simulate import simulate
from dnanalyze.report.refinement_stages import stages

OUT = Path(__file__).resolve().parent / "figures" / "story.png"
HIDDEN, SEED, SHAPE, FRAMES = "column_fpn", 1, (256, 256), 6  # as `dnanalyze demo` has them


def main() -> None:
    """Refine the model of the demo's sensor and draw the result."""
    sensor = draw_sensor(np.random.default_rng(SEED))
    captures = generate(sensor, {HIDDEN: "middling"}, SHAPE, frames=FRAMES, seed=SEED)
    draw(captures, refine(captures))
    print(f"written: {OUT}")


def draw(captures: CaptureSet, refined: Refinement) -> None:
    """Frame, error by step, column spectrum."""
    from matplotlib.figure import Figure

    from dnanalyze.report.figures.style import ACCENT, GAUSSIAN, INK, MODEL, QUIET, log_axis, styled

    with styled():
        fig = Figure(figsize=(10.4, 3.3), layout="constrained")
        image, steps, spectrum = fig.subplots(1, 3, width_ratios=(1, 1.25, 1.35))
        coldest = captures.settings[0]
        frame = np.mean([f.read()[:128, :128] for f in coldest.frames], axis=0)
        low, high = np.percentile(frame, (1, 99))
        image.imshow(frame, cmap="gray", vmin=low, vmax=high, interpolation="nearest")
        image.set(xticks=[], yticks=[], title=f"Dark frames, {coldest.point.temperature_c:g} °C")
        image.set_xlabel(f"mean of {len(coldest.frames)}, a crop")
        image.grid(False)

        shown = stages(refined.steps)
        names = ["Wang 2025 model", *(f"+ {s.name}" for s in shown[1:])]
        errors = [s.error for s in shown]
        colours = [ACCENT if HIDDEN in n else QUIET for n in names]
        steps.barh(range(len(names)), errors, color=colours, height=0.62)
        for row, error in enumerate(errors):
            steps.text(max(error, 1.0) * 1.06, row, f"{error:.3g}", va="center", fontsize=8)
        steps.axvline(1.0, color=INK, linewidth=0.9)
        steps.set(xscale="log", xlim=(0.5, max(errors) * 2), title="Model error at each step")
        steps.set_yticks(range(len(names)), names, fontsize=8)
        steps.tick_params(axis="y", length=0)
        steps.set_xlabel("1: as close as a second sensor of the same design")
        log_axis(steps.xaxis)
        steps.invert_yaxis()
        steps.grid(False)
        steps.spines["left"].set_visible(False)

        _spectra(spectrum, captures, refined.model, (INK, GAUSSIAN, MODEL))
        log_axis(spectrum.yaxis)
        fig.savefig(OUT, dpi=130, facecolor="white")


def _spectra(ax: Any, captures: CaptureSet, model: NoiseModel, colours: tuple[str, ...]) -> None:
    """Power that whole columns share at the lowest temperature, with and without the effect."""
    coldest = replace(captures, settings=captures.settings[:1])
    drawn = (
        ([coldest], colours[0], "measured", 2.2),
        (_sensors(model.without(HIDDEN), coldest), colours[1], f"model without {HIDDEN}", 1.2),
        (_sensors(model, coldest), colours[2], f"model with {HIDDEN}", 1.2),
    )
    for sensors, colour, label, width in drawn:
        curves = [analyze(sensor).settings[0].curves for sensor in sensors]
        f = curves[0]["column_spectrum_f"]
        power = np.mean([c["pattern_column_spectrum"] for c in curves], axis=0)
        kept = len(f) // 8 * 8
        f, power = (np.asarray(x)[:kept].reshape(-1, 8).mean(axis=1) for x in (f, power))
        ax.plot(f, power, color=colour, label=label, linewidth=width)
    ax.set(yscale="log", xlabel="spatial frequency [cycles/pixel]")
    ax.set_ylabel("power spectral density [DN²]")
    ax.set_title("Spectrum of the column means")
    ax.legend(loc="center right", bbox_to_anchor=(1.0, 0.4))


def _sensors(model: NoiseModel, like: CaptureSet, count: int = 8) -> list[CaptureSet]:
    """Simulated sensors of one design: the mean of their spectra is what the model expects."""
    settings = [(s.point, len(s.frames)) for s in like.settings]
    makes = [replace(model, seed=model.seed + 1 + n) for n in range(count)]
    return [simulate(make, like.sensor.shape, settings) for make in makes]


if __name__ == "__main__":
    main()
