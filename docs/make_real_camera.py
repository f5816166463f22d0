"""Draw docs/figures/real-camera.png, the real camera of the README.

    python docs/make_real_camera.py FOLDER MODEL.yaml

FOLDER holds the dark frames, MODEL.yaml is what ``dnanalyze refine FOLDER -o MODEL.yaml`` wrote.
Measured and simulated noise from frame to frame: its distribution over the pixels, and the spectrum
of its row means. Both are computed here with NumPy alone.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import dnanalyze

OUT = Path(__file__).resolve().parent / "figures" / "real-camera.png"


def residuals(captures: dnanalyze.CaptureSet) -> np.ndarray:
    """Frames of the first operating point minus their mean and their own level, DN.

    Returns
    -------
    ndarray
        (frames, rows, columns).
    """
    frames = np.stack([f.read().astype(np.float64) for f in captures.settings[0].frames])
    frames -= frames.mean(axis=(1, 2), keepdims=True)
    return (frames - frames.mean(axis=0)) / np.sqrt(1.0 - 1.0 / len(frames))


def spectrum(y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Frequency, cycles/row, and mean power of the row means, DN^2."""
    rows = y.mean(axis=2)
    power = np.mean(np.abs(np.fft.rfft(rows, axis=1)) ** 2, axis=0) / rows.shape[1]
    return np.fft.rfftfreq(rows.shape[1])[1:], power[1:]


def main(folder: str, model_file: str) -> None:
    """Simulate the sensor and draw both."""
    from matplotlib.figure import Figure

    from dnanalyze.report.figures.style import INK, MODEL, log_axis, styled

    captures = dnanalyze.load(folder)
    model = dnanalyze.NoiseModel.load(model_file)
    drawn = {
        "measured": (residuals(captures), INK, 1.8),
        "model": (residuals(dnanalyze.simulate(model, like=captures)), MODEL, 1.2),
    }
    edges = np.arange(-20.0, 20.5, 0.5)
    with styled():
        fig = Figure(figsize=(8.6, 3.0), layout="constrained")
        histogram, rows = fig.subplots(1, 2)
        for label, (y, colour, width) in drawn.items():
            density = np.histogram(y, edges)[0] / y.size / np.diff(edges)
            density[density == 0] = np.nan
            histogram.stairs(density, edges, color=colour, linewidth=width, label=label)
            rows.plot(*spectrum(y), color=colour, linewidth=width, label=label)
        histogram.set(yscale="log", xlabel="noise of a pixel from frame to frame [DN]")
        histogram.set_ylabel("probability density [1/DN]")
        histogram.set_title("Found: pixels with telegraph noise")
        rows.set(yscale="log", xscale="log", xlabel="spatial frequency [cycles/row]")
        rows.set_ylabel("power of the row means [DN²]")
        rows.set_title("Found: row banding, rows converted together")
        for ax in (histogram, rows):
            log_axis(ax.yaxis)
            ax.legend()
        log_axis(rows.xaxis)
        fig.savefig(OUT, dpi=130, facecolor="white")
    print(f"written: {OUT}")


if __name__ == "__main__":
    main(*sys.argv[1:])
