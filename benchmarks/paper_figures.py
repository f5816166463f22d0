"""The paper's three figures from our own data: ``python benchmarks/paper_figures.py 1 -o DIR``.

The sensor is the electron-level virtual sensor of ``dnanalyze.demo``, which shares no code with the
model; figure 3 alone is the model. The numbers that docs/paper.md quotes are printed.

The paper: S. Wang, E. Funatsu, B. Fowler, A simple model for characterizing and simulating dark
noise in CMOS sensors, Electronic Imaging 2025, ISS-276, doi 10.2352/EI.2025.37.7.ISS-276.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import dnanalyze
from dnanalyze.demo import VirtualSensor, generate
from dnanalyze.loaders.captures import CaptureSet, OperatingPoint
from dnanalyze.model.effects.convolved_lognormal import ConvolvedLognormal
from dnanalyze.report.figures.style import ACCENT, GAUSSIAN, INK, MODEL, QUIET, log_axis, styled

SHAPE, FRAMES, SEED = (512, 512), 4, 3
TEMPERATURES = (25.0, 45.0, 65.0, 85.0, 105.0)
SENSOR = VirtualSensor(
    gain_dn_e=0.5, read_noise_e=3.0, dark_e_s=12.0, dark_spread=0.7, temperatures_c=TEMPERATURES
)
HOT = {"hot_pixels": {"fraction": 3e-3, "e": 1500.0, "activation_ev": 0.55}}
DPC = {"dpc": {"mode": "median", "threshold_dn": 12.0}}
DENOISE = {"denoise": {"kind": "gaussian", "sigma_px": 0.5}}
KINDS = {"correction off": ({}, INK), "DPC on": (DPC, GAUSSIAN), "denoise on": (DENOISE, MODEL)}
MID, HIGH = (0.03, 0.12), (0.45, 0.71)  # cycles/pixel
CROP = (slice(0, 64), slice(0, 96))  # pixels shown
FEWEST_MODES = 24  # in a drawn point of a spectrum: power scatters as 1 / sqrt(modes)

Curve = tuple[np.ndarray, np.ndarray]


def main() -> None:
    """Make the figure that is asked for."""
    makers: dict[int, Callable[[], Any]] = {1: correction, 2: over_temperature, 3: model}
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("figure", type=int, choices=makers)
    parser.add_argument("-o", "--out", type=Path, default=Path(), metavar="DIR")
    parser.add_argument("--format", choices=("png", "svg", "pdf"), default="png")
    chosen = parser.parse_args()
    chosen.out.mkdir(parents=True, exist_ok=True)
    with styled():
        figure = makers[chosen.figure]()
        path = chosen.out / f"paper-{chosen.figure}.{chosen.format}"
        figure.savefig(path, dpi=130, facecolor="white")
    print(f"written: {path}")


def correction() -> Any:
    """Figure 1: frames, distribution and spectrum with correction off, DPC on, denoise on."""
    figure, axes = _canvas("AABBCC/DDDEEE", 6.3, (1.0, 1.45))
    low, high = 60, 140
    print("at 85 C: sd [DN], pixels above 5 robust sigma [%], high-to-mid ratio")
    for panel, (label, (filtered, colour)) in zip("ABC", KINDS.items(), strict=True):
        made = generate(SENSOR, HOT | filtered, SHAPE, (85.0,), FRAMES, SEED)
        frames = np.stack([f.read() for f in made.frames()])
        image = axes[panel].imshow(
            frames[0][CROP], cmap="gray", vmin=low, vmax=high, interpolation="nearest"
        )
        axes[panel].set_title(label, color=colour)
        _bare(axes[panel])
        axes["D"].plot(*_density(frames), color=colour, label=label)
        f, s = _radial(made)[0]
        axes["E"].plot(f, s, color=colour, label=label)
        print(f"  {label}: {frames.std():.2f}  {_tail(frames):.3f}  {_ratio((f, s)):.3f}")
    figure.colorbar(image, ax=[axes[p] for p in "ABC"], label="DN", pad=0.01)
    axes["D"].set(
        yscale="log", xlim=(50, 500), ylim=(5e-7, 0.1), xlabel="DN", ylabel="density [1/DN]",
        title="Distribution",
    )  # fmt: skip
    log_axis(axes["D"].yaxis)
    axes["D"].legend()
    _spectral(axes["E"], "Spectrum of a frame, axes masked")
    _band(axes["E"], MID, "mid")
    _band(axes["E"], HIGH, "high")
    return figure


def over_temperature() -> Any:
    """Figure 2: spectra over 25-105 C with and without DPC, and their high-to-mid ratio."""
    import matplotlib as mpl

    figure, axes = _canvas("ABC", 3.7, (1.0,))
    colours = mpl.colormaps["plasma"](np.linspace(0.05, 0.85, len(TEMPERATURES)))
    print("high-to-mid ratio at " + ", ".join(f"{t:g}" for t in TEMPERATURES) + " C")
    for panel, label in (("A", "correction off"), ("B", "DPC on")):
        filtered, colour = KINDS[label]
        made = generate(SENSOR, HOT | filtered, SHAPE, TEMPERATURES, FRAMES, SEED)
        curves = _radial(made)
        for curve, shade in zip(curves, colours, strict=True):
            axes[panel].plot(*curve, color=shade)
        _spectral(axes[panel], label)
        ratios = [_ratio(c) for c in curves]
        axes["C"].plot(TEMPERATURES, ratios, "o-", color=colour, label=label, markersize=4)
        print(f"  {label}: " + "  ".join(f"{r:.3f}" for r in ratios))
    axes["B"].sharey(axes["A"])
    axes["B"].set_ylabel("")
    for (f, power), celsius in zip(curves, TEMPERATURES, strict=True):
        axes["B"].annotate(f"{celsius:g} °C", (f[0], power[0]), (-4, 8), textcoords="offset points")
    axes["C"].axhline(1.0, color=QUIET, linewidth=0.8)
    axes["C"].set(
        xlabel="°C", ylim=(0, 1.15), title="High-to-mid ratio", xticks=TEMPERATURES,
        ylabel=f"power {HIGH[0]:g}-{HIGH[1]:g} over {MID[0]:g}-{MID[1]:g} c/px",
    )  # fmt: skip
    axes["C"].legend(loc="lower left")
    return figure


def model() -> Any:
    """Figure 3: seed image, noise image, distribution and spectrum of the paper's model."""
    mu, delta, phi, sigma = 3.0, 0.5, 0.05, 0.01
    point = OperatingPoint(25.0, 1.0)
    kind = ConvolvedLognormal(mu=mu, delta=delta, phi=phi, sigma=sigma)
    made = _frames_of(kind, point)
    seeds = _frames_of(ConvolvedLognormal(mu=mu, delta=delta, phi=0.0, sigma=1e-6), point)
    noise, seed = (np.stack([f.read() for f in s.frames()]) for s in (made, seeds))

    figure, axes = _canvas("AABB/CCDD", 7.2, (1.0, 1.0))
    for panel, image, title in (
        ("A", seed[0], "Seed L = exp f"),
        ("B", noise[0], "Noise h = Σ (K + ε) L"),
    ):
        drawn = axes[panel].imshow(
            image[CROP], cmap="gray", vmin=5, vmax=60, interpolation="nearest"
        )
        axes[panel].set_title(title)
        _bare(axes[panel])
        figure.colorbar(drawn, ax=axes[panel], label="DN", pad=0.02)

    for image, colour, label in ((seed, QUIET, "seed"), (noise, INK, "noise")):
        axes["C"].plot(*_density(np.rint(4 * image).astype(int), 0.25), color=colour, label=label)
    middle = np.linspace(0, 130, 261)
    mean, variance = float(noise.mean()), kind.variance(point)
    normal = np.exp(-((middle - mean) ** 2) / (2 * variance)) / math.sqrt(2 * math.pi * variance)
    axes["C"].plot(
        middle,
        normal,
        color=GAUSSIAN,
        linestyle="--",
        linewidth=1.0,
        label="normal distribution of the same mean and standard deviation",
    )
    axes["C"].set(
        yscale="log",
        xlim=(0, 130),
        ylim=(1e-6, 0.2),
        xlabel="DN",
        ylabel="density [1/DN]",
        title="Distribution",
    )
    log_axis(axes["C"].yaxis)
    axes["C"].legend()

    f, s = _radial(made)[0]
    axes["D"].plot(f, s, color=INK, linewidth=2.2, label="simulated")
    exact = _closed_form(mu, delta, phi, sigma, f)
    axes["D"].plot(f, exact, color=MODEL, linewidth=1.2, label="closed form")
    axes["D"].plot(
        f, exact[0] * (0.02 / f), color=ACCENT, linestyle=":", label="1/f, for its slope"
    )
    axes["D"].set_ylim(20, 400)
    _spectral(axes["D"], "Spectrum: a plateau, not 1/f, at low frequency")
    axes["D"].legend(loc="lower left")
    _say_moments(kind, point, noise, (f, s), exact)
    return figure


def _frames_of(effect: ConvolvedLognormal, point: OperatingPoint) -> CaptureSet:
    """Frames of the model alone, with a fresh seed each, so that they are independent."""
    from dataclasses import replace

    redrawn = replace(effect, seed="redrawn")
    noise = dnanalyze.NoiseModel((redrawn,), pedestal=0.0, reference=point, seed=SEED)
    return dnanalyze.simulate(noise, SHAPE, [(point, 2 * FRAMES)])


def _say_moments(
    kind: ConvolvedLognormal,
    point: OperatingPoint,
    noise: np.ndarray,
    seen: Curve,
    exact: np.ndarray,
) -> None:
    """Moments against their closed forms, and the slopes of the spectrum."""
    variance = kind.variance(point)
    mean = math.exp(float(kind.mu) + float(kind.delta) ** 2 / 2)  # type: ignore[arg-type]
    print(f"mean {noise.mean():.3f} DN, exact {mean:.3f}")
    print(f"variance {noise.var():.2f} DN^2, exact {variance:.2f}")
    f, s = seen
    print("log-log slope, simulated and exact")
    for low, high in ((0.01, 0.05), (0.05, 0.2), (0.2, 0.5)):
        here = (f >= low) & (f <= high)
        measured, closed = (
            np.polyfit(np.log(f[here]), np.log(y[here]), 1, w=np.sqrt(f[here]))[0]
            for y in (s, exact)
        )
        print(f"  {low:g}-{high:g} c/px: {measured:+.2f}  {closed:+.2f}")


def _closed_form(mu: float, delta: float, phi: float, sigma: float, f: np.ndarray) -> np.ndarray:
    """V |K|^2 + 9 sigma^2 m2 averaged over rings of radius f, DN^2; K of the 3x3 kernel."""
    q, square = math.exp(delta**2), math.exp(2 * mu + delta**2)
    angle = np.linspace(0, np.pi / 2, 721)[None, :]
    u, v = f[:, None] * np.cos(angle), f[:, None] * np.sin(angle)
    kernel = 1 - 9 * phi + phi * (1 + 2 * np.cos(2 * np.pi * u)) * (1 + 2 * np.cos(2 * np.pi * v))
    inside = (u <= 0.5) & (v <= 0.5)
    ring = np.sum(kernel**2 * inside, axis=1) / inside.sum(axis=1)
    return square * (q - 1) * ring + 9 * sigma**2 * square * q


def _radial(captures: CaptureSet) -> list[Curve]:
    """Axis-masked radial spectrum of the single frame at each setting: c/px, DN^2."""
    measured = dnanalyze.analyze(captures).settings
    curves = [(s.curves["frame_radial_f"], s.curves["frame_radial_s"]) for s in measured]
    return [_pooled(f, s) for f, s in curves]


def _pooled(f: np.ndarray, s: np.ndarray) -> Curve:
    """Neighbouring rings taken together until each holds enough modes (pi f df of them a pixel)."""
    usable = (f > 0) & np.isfinite(s)
    f, s = f[usable], s[usable]
    modes = np.pi * f * np.gradient(f) * SHAPE[0] * SHAPE[1]
    slot = (np.cumsum(modes) - modes) // FEWEST_MODES
    slot = np.unique(slot, return_inverse=True)[1]
    total = np.bincount(slot, modes)
    return np.bincount(slot, f * modes) / total, np.bincount(slot, s * modes) / total


def _density(codes: np.ndarray, step: float = 1.0) -> Curve:
    """Density over whole codes, in bins that widen to a tenth of the distance to the mode."""
    counts = np.bincount(codes.ravel())
    mode, edges = int(counts.argmax()), [int(counts.nonzero()[0][0])]
    while edges[-1] < counts.size:
        edges.append(edges[-1] + max(1, (edges[-1] - mode) // 10))
    width = np.diff(edges)
    share = np.add.reduceat(counts, edges[:-1]) / counts.sum() / (width * step)
    middle = (np.array(edges[:-1]) + (width - 1) / 2) * step
    return middle[share > 0], share[share > 0]


def _ratio(curve: Curve) -> float:
    """Power at high over power at middle frequency; rings weigh as their number of modes, f df."""
    f, s = curve
    weight = f * np.gradient(f)
    high, mid = ((f >= a) & (f <= b) for a, b in (HIGH, MID))
    return float(
        np.average(s[high], weights=weight[high]) / np.average(s[mid], weights=weight[mid])
    )


def _tail(frames: np.ndarray) -> float:
    """Share of pixels above the median by 5 robust sigmas, %."""
    low, middle, high = np.percentile(frames, (25, 50, 75))
    return 100.0 * float(np.mean(frames > middle + 5 * (high - low) / 1.349))


def _canvas(mosaic: str, height: float, ratios: tuple[float, ...]) -> tuple[Any, dict[str, Any]]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.4, height), layout="constrained")
    rows = [list(row) for row in mosaic.split("/")]
    return figure, figure.subplot_mosaic(rows, height_ratios=ratios)


def _bare(axes: Any) -> None:
    axes.set(xticks=[], yticks=[])
    axes.grid(False)
    axes.spines[:].set_visible(False)


def _spectral(axes: Any, title: str) -> None:
    axes.set(xscale="log", yscale="log", xlabel="cycles/pixel", ylabel="DN²", title=title)
    axes.set_xlim(0.005, 0.75)
    log_axis(axes.xaxis)
    log_axis(axes.yaxis)


def _band(axes: Any, band: tuple[float, float], label: str) -> None:
    axes.axvspan(*band, color=QUIET, alpha=0.12, linewidth=0)
    axes.text(math.sqrt(band[0] * band[1]), 0.02, label, color=QUIET, ha="center",
              transform=axes.get_xaxis_transform())  # fmt: skip


if __name__ == "__main__":
    main()
