"""Draw docs/figures/camera.png, for the README: ``python docs/make_camera.py FOLDER``.

The mean frame of the operating point with most frames, the measured and the simulated spectrum of
its rows, and the histogram. The captures themselves are not part of the project.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import dnanalyze
from dnanalyze import CaptureSet, NoiseModel

OUT = Path(__file__).resolve().parent / "figures" / "camera.png"


def main() -> None:
    """Refine the model of the captures and draw the result."""
    captures = dnanalyze.load(sys.argv[1])
    found = dnanalyze.refine(captures, budget=float(sys.argv[2]) if len(sys.argv) > 2 else None)
    print(found.summary())
    draw(captures, found.model)
    print(f"written: {OUT}")


def draw(captures: CaptureSet, model: NoiseModel) -> None:
    """Mean frames measured and simulated, columns' spectrum, histogram of a frame."""
    from matplotlib.figure import Figure

    from dnanalyze.report.figures.style import INK, MODEL, styled

    simulated = dnanalyze.simulate(model, like=captures)
    at = max(range(len(captures.settings)), key=lambda n: len(captures.settings[n].frames))
    stacks = [np.stack([f.read() for f in c.settings[at].frames]).astype(float)
              for c in (captures, simulated)]  # fmt: skip
    with styled():
        fig = Figure(figsize=(10.4, 3.0), layout="constrained")
        one, two, lines, values = fig.subplots(1, 4, width_ratios=(1, 1, 1.3, 1.3))
        means = [s.mean(axis=0)[:160, :160] for s in stacks]
        low, high = np.percentile(means[0], (1, 99))
        for ax, mean, name in zip((one, two), means, ("measured", "simulated"), strict=True):
            ax.imshow(mean, cmap="gray", vmin=low, vmax=high, interpolation="nearest")
            ax.set(xticks=[], yticks=[], title=f"mean frame, {name}")
            ax.grid(False)
        for stack, colour, name in zip(
            stacks, (INK, MODEL), ("measured", "simulated"), strict=True
        ):
            profile = np.clip(stack.mean(axis=0), low, high).mean(axis=0)
            power = np.abs(np.fft.rfft(profile - profile.mean()))[1:] ** 2 / profile.size
            bands = np.array_split(power, 60)
            x = np.linspace(0, 0.5, len(bands))
            lines.plot(x, [b.mean() for b in bands], color=colour, label=name)
            edges = np.arange(np.floor(stack.min()), np.ceil(stack.max()) + 2)
            counts = np.histogram(stack[0], edges)[0]
            values.stairs(np.maximum(counts, 0.5), edges, color=colour)
        lines.set(yscale="log", title="power of the column means", xlabel="cycles/pixel")
        lines.legend(frameon=False, fontsize=8)
        values.set(yscale="log", title="values of one frame", xlabel="DN", ylim=(0.7, None))
        fig.savefig(OUT, dpi=110)


if __name__ == "__main__":
    main()
