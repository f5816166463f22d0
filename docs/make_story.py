"""Draw docs/figures/story.png, the picture of the README: ``python docs/make_story.py``.

The sensor of ``dnanalyze demo``, its frame, its error step by step, and the spectrum that gives the
hidden effect away.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from dnanalyze.analyzers.statistics import Statistics
from dnanalyze.demo import draw_sensor, generate
from dnanalyze.diagnosis.refine import Refinement, refine
from dnanalyze.loaders.captures import CaptureSet
from dnanalyze.model.noise_model import NoiseModel

OUT = Path(__file__).resolve().parent / "figures" / "story.png"
HIDDEN, SEED, SHAPE, FRAMES = "column_fpn", 1, (256, 256), 6  # as `dnanalyze demo` has them


def main() -> None:
    """Refine the demo's sensor and draw what was found."""
    sensor = draw_sensor(np.random.default_rng(SEED))
    captures = generate(sensor, {HIDDEN: "middling"}, SHAPE, frames=FRAMES, seed=SEED)
    draw(captures, refine(captures))
    print(f"written: {OUT}")


def draw(captures: CaptureSet, found: Refinement) -> None:
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

        names = ["paper's model", *(f"+ {s.added}" for s in found.steps[1:])]
        errors = [s.error for s in found.steps]
        colours = [ACCENT if HIDDEN in n else QUIET for n in names]
        steps.barh(range(len(names)), errors, color=colours, height=0.62)
        for row, (name, error) in enumerate(zip(names, errors, strict=True)):
            steps.text(0.78, row, name + " ", ha="right", va="center", fontsize=8)
            steps.text(error * 1.06, row, f"{error:.3g}", va="center", fontsize=8)
        steps.axvline(1.0, color=INK, linewidth=0.9)
        steps.set(xscale="log", xlim=(0.8, max(errors) * 2), yticks=[], title="Error, step by step")
        steps.set_xlabel("1: as close as a second sensor of the same make")
        log_axis(steps.xaxis)
        steps.invert_yaxis()
        steps.grid(False)
        steps.spines["left"].set_visible(False)

        _spectra(spectrum, found, (INK, GAUSSIAN, MODEL))
        log_axis(spectrum.yaxis)
        fig.savefig(OUT, dpi=130, facecolor="white")


def _spectra(ax: Any, found: Refinement, colours: tuple[str, ...]) -> None:
    """Power that whole columns share: measured, without and with the hidden effect."""
    without, complete = found.model.without(HIDDEN), found.model
    drawn = (
        ([found.bench.measured], colours[0], "measured", 2.2),
        (_sensors(found, without), colours[1], f"model without {HIDDEN}", 1.2),
        (_sensors(found, complete), colours[2], f"model with {HIDDEN}", 1.2),
    )
    for sensors, colour, label, width in drawn:
        halves = [half.settings[0].curves for sensor in sensors for half in sensor]
        f = halves[0]["column_spectrum_f"]
        power = np.mean([c["pattern_column_spectrum"] for c in halves], axis=0)
        kept = len(f) // 8 * 8
        f, power = (np.asarray(x)[:kept].reshape(-1, 8).mean(axis=1) for x in (f, power))
        ax.plot(f, power, color=colour, label=label, linewidth=width)
    ax.set(yscale="log", xlabel="cycles/pixel", ylabel="DN²")
    ax.set_title("Power that whole columns share")
    ax.legend(loc="center right", bbox_to_anchor=(1.0, 0.4))


def _sensors(found: Refinement, model: NoiseModel, count: int = 8) -> list[list[Statistics]]:
    """Statistics of simulated sensors of one make: their mean is what the model expects."""
    makes = [replace(model, seed=model.seed + 1 + n) for n in range(count)]
    return [found.bench.statistics(make) for make in makes]


if __name__ == "__main__":
    main()
