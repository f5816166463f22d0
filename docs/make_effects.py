"""Write docs/effects/: one page and one small figure an effect, from the registry.

``python docs/make_effects.py`` writes pages and figures, ``--pages`` the pages alone. A test holds
the pages against the registry.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from dnanalyze.analyzers.catalogue import catalogue as statistics
from dnanalyze.digits import is_number, number, symbol
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effect import Effect, ParameterInfo, Stage
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import BASE, BASELINE, built_in
from dnanalyze.model.simulate import simulate

HERE = Path(__file__).resolve().parent
POINT = OperatingPoint(65.0, 0.05, 1.0)
SHAPE, FRAMES, SHOWN, ZOOM = (256, 256), 24, 128, 48
DARK = {"mu": 3.0, "delta": 0.35, "phi": 0.0, "sigma": 1e-6}  # of an ordinary sensor's frame, DN
# Where the default would hardly show in a picture, or shows only from near.
STRENGTHS: dict[str, dict[str, Any]] = {
    "amp_glow": {"amplitude": 60.0},
    "black_clipping": {"level": 78.0},
    "cfa_mismatch": {"u": 2.0, "v": 2.0, "uv": 2.0},
    "column_fpn": {"sigma": 3.0},
    "column_gain": {"sigma": 0.1},
    "column_noise": {"sigma": 3.0},
    "column_taps": {"sigma": 4.0, "kind": "blocks", "taps": 4},
    "convolved_lognormal": {"mu": 3.0, "phi": 0.05},
    "cosmic_rays": {"rate": 4000.0, "energy": 600.0, "length": 6.0},
    "crosstalk": {"alpha": 0.08},
    "dark_current_fpn": {"rms": 0.3},
    "dark_gradient": {"x": 8.0, "y": 4.0, "xx": 3.0},
    "dark_shading": {"rms": 0.3},
    "dead_pixels": {"fraction": 5e-3},
    "defect_lines": {"fraction": 0.02, "sigma": 15.0},
    "denoise": {"kind": "bilateral", "range": 8.0, "space": 1.0},
    "dpc": {"threshold": 10.0},
    "electron_multiplication": {"excess": 2.0, "induced": 0.3},
    "flicker_fpn": {"rms": 5.0},
    "flicker_noise": {"rms": 5.0},
    "heavy_tailed_read_noise": {"sigma": 3.0, "tail": -0.25},
    "hot_clusters": {"density": 1e-3},
    "hot_pixels": {"fraction": 5e-3},
    "noisy_pixels": {"fraction": 0.03, "sigma": 20.0},
    "offset_drift": {"step": 3.0},
    "offset_gradient": {"x": 8.0, "y": 4.0, "xx": 3.0},
    "periodic_pattern": {"amplitude": 5.0},
    "persistence": {"amplitude": 0.1},
    "pixel_fpn": {"sigma": 4.0},
    "read_noise": {"sigma": 4.0},
    "row_fpn": {"sigma": 3.0},
    "row_noise": {"sigma": 3.0},
    "rts": {"fraction": 0.03, "amplitude": 40.0, "amplitudes": "fixed"},
    "scaled_lines": {"fraction": 0.03, "sigma": 1.0},
    "serial_noise": {"sigma": 4.0},
    "storage_dark_current": {"amplitude": 30.0},
    "stuck_pixels": {"fraction": 1e-3, "code": 140.0},
    "temporal_denoise": {"share": 0.6},
    "transfer_tails": {"loss": 0.3, "tau": 3.0},
    "quantization": {"step": 8},
}
WIDE = {
    "amp_glow",
    "cosmic_rays",
    "column_taps",
    "dark_gradient",
    "dark_shading",
    "defect_lines",
    "offset_gradient",
    "scaled_lines",
    "storage_dark_current",
}
CODES = {"digital_gain", "missing_codes", "quantization"}
NEAR = {
    "convolved_lognormal",
    "cfa_mismatch",
    "crosstalk",
    "denoise",
    "dpc",
    "hot_clusters",
    "transfer_tails",
}
OVER_TIME = {
    "offset_drift": "frame mean [DN]",
    "rts": "strongest RTS pixel [DN]",
    "persistence": "correlation of a pixel over time",
    "temporal_denoise": "correlation of a pixel over time",
}
# what the field calls it, for whoever searches by that name
ALSO = {
    "amp_glow": ("amplifier glow", "electroluminescence", "corner glow"),
    "black_clipping": ("black crush", "clipped black level", "zero clipping"),
    "cfa_mismatch": ("Bayer offset", "green imbalance"),
    "column_fpn": ("vertical stripes", "vertical fixed-pattern noise", "column offsets"),
    "column_gain": ("column PRNU", "column amplifier gain mismatch"),
    "column_noise": ("vertical banding", "temporal column noise"),
    "column_taps": ("odd-even columns", "channel mismatch", "tap mismatch", "quadrants"),
    "convolved_lognormal": ("Wang 2025 model",),
    "cosmic_rays": ("cosmics", "particle hits", "single-event transients"),
    "crosstalk": ("interpixel capacitance (IPC)", "charge diffusion", "blur"),
    "dark_current_fpn": ("dark signal nonuniformity (DSNU)", "dark current nonuniformity"),
    "dark_current_steps": ("dark current spectroscopy", "quantized dark current"),
    "dark_gradient": ("thermal gradient", "shading"),
    "dark_shading": ("shading", "nonuniform dark current"),
    "dark_shot_noise": ("Poisson noise of the dark current",),
    "dead_pixels": ("cold pixels", "dark pixels"),
    "defect_lines": ("bad columns", "dead rows", "bright columns"),
    "denoise": ("noise reduction (NR)", "smoothing", "spatial filter", "star eater"),
    "digital_gain": ("scaled codes", "histogram gaps", "comb histogram"),
    "dpc": ("bad-pixel correction (BPC)", "hot-pixel suppression", "defect concealment"),
    "electron_multiplication": ("EMCCD", "EM gain", "clock-induced charge (CIC)"),
    "flicker_fpn": ("fixed 1/f noise", "low-frequency fixed pattern"),
    "flicker_noise": ("1/f noise", "pink noise", "banding along the rows"),
    "heavy_tailed_read_noise": ("non-Gaussian read noise", "Student-t read noise"),
    "hot_clusters": ("clusters of hot pixels", "bright clusters"),
    "hot_pixels": ("warm pixels", "bright pixels", "white defects"),
    "missing_codes": ("differential nonlinearity (DNL)", "converter nonlinearity"),
    "noisy_pixels": ("blinkers", "flickering pixels"),
    "offset_drift": ("black-level drift", "bias drift", "frame-to-frame flicker"),
    "offset_gradient": ("bias gradient", "black-level shading"),
    "periodic_pattern": ("hum", "interference (EMI)", "herringbone", "ripple"),
    "persistence": ("image lag", "ghosting", "residual image"),
    "pixel_fpn": ("pixel offsets", "offset DSNU", "fixed-pattern noise (FPN)"),
    "quantization": ("ADC rounding", "analog-to-digital conversion"),
    "read_noise": ("readout noise", "noise floor"),
    "row_fpn": ("horizontal stripes", "horizontal fixed-pattern noise", "row offsets"),
    "row_noise": ("banding", "horizontal banding", "temporal row noise", "line noise"),
    "rts": ("random telegraph noise (RTN)", "blinking pixels", "popcorn noise"),
    "scaled_lines": ("columns of another gain", "hot columns"),
    "serial_noise": ("correlated read noise", "coloured read noise", "streaks", "band noise"),
    "storage_dark_current": ("storage-node leakage", "readout dark current", "dark ramp"),
    "stuck_pixels": ("dead pixels of a fixed code", "defective pixels"),
    "temporal_denoise": ("3D noise reduction (3DNR)", "temporal filter", "recursive filter"),
    "transfer_tails": ("charge-transfer inefficiency (CTI)", "deferred charge", "trailing"),
}
GROUPS = {
    "Base": (BASE,),
    "Baseline effects": BASELINE,
    "Charge": (Stage.CHARGE, Stage.COUPLING, Stage.REGISTER),
    "Readout": (Stage.PIXEL_READ, Stage.LINE_READ),
    "Digital": (
        Stage.CODE_WIDTHS, Stage.CONVERTER, Stage.DIGITAL, Stage.CORRECTION,
        Stage.SPATIAL_FILTER, Stage.TEMPORAL_FILTER,
    ),
}  # fmt: skip
TIMES = {
    "fixed": "the same in every frame",
    "temporal": "new in every frame",
    "both": "fixed or new in every frame, by its parameters",
    "digital": "acts on the codes",
}


def main() -> None:
    """Write the pages, and the figures unless told not to."""
    known = built_in()
    folder = HERE / "effects"
    folder.mkdir(exist_ok=True)
    for name, text in pages(known).items():
        (folder / name).write_text(text, encoding="utf-8")
    (HERE / "gallery.md").write_text(gallery(known), encoding="utf-8")
    if "--pages" not in sys.argv:
        wanted = [a for a in sys.argv[1:] if a in known] or list(known)
        for effect in wanted:
            draw(known[effect], folder / f"{effect}.png")


def pages(known: dict[str, type[Effect]]) -> dict[str, str]:
    """File name to Markdown: the index and one page an effect."""
    return {"index.md": index(known)} | {f"{n}.md": page(e, known) for n, e in known.items()}


def gallery(known: dict[str, type[Effect]]) -> str:
    """The figures of the site on one page."""
    parts = [
        "# Gallery\n",
        "Every figure is made by a program of the repository from virtual sensors. Figures of "
        "results (families, spectra, refinement steps) are in the notebooks "
        "[first comparison](notebooks/first-comparison.ipynb) and "
        "[hidden effect](notebooks/hidden-effect.ipynb), with the line that draws them. "
        "Generated by `docs/make_effects.py`.\n",
        "## Refinement\n",
        "`python docs/make_story.py`\n",
        "![Dark frame, model error at each refinement step, column spectrum](figures/story.png)\n",
        "## Distribution and spectrum with filters\n",
        "`python benchmarks/paper_figures.py 1 -o docs/figures`; see "
        "[figures of Wang 2025](paper.md).\n",
        "![Frames, distribution and spectrum with correction off, DPC on and denoise on]"
        "(figures/paper-1.png)\n",
        "![Spectra from 25 to 105 °C with correction off and DPC on](figures/paper-2.png)\n",
        "![Seed image, noise image, distribution and spectrum of the Wang 2025 model]"
        "(figures/paper-3.png)\n",
        "## Effects\n",
        "A frame without and with the effect, the distribution of the codes, and the radial power "
        "spectral density. `python docs/make_effects.py NAME`\n",
    ]
    for effect in known.values():
        name = effect.name
        parts.append(
            f"### [{name}](effects/{name}.md)\n\n{_sentence(effect.summary)}\n\n"
            f"![Frames without and with {name}, distribution and spectrum](effects/{name}.png)\n"
        )
    return "\n".join(parts)


def index(known: dict[str, type[Effect]]) -> str:
    """The catalogue by group."""
    parts = [
        "# Effects\n",
        "Generated from the code by `docs/make_effects.py`. "
        "`dnanalyze effects NAME` prints the same in the terminal.\n",
    ]
    left = dict(known)
    for title, members in GROUPS.items():
        chosen = [e for n, e in left.items() if n in members or e.stage in members]
        if title == "Charge":
            chosen += [e for n, e in left.items() if e.stage is Stage.ARRIVAL and e not in chosen]
        rows = [
            f"| [{e.name}]({e.name}.md) | {TIMES[e.varies]} | {_sentence(e.summary)} |"
            for e in chosen
        ]
        parts.append(f"## {title}\n\n| effect | over time | what it is |\n|---|---|---|")
        parts.append("\n".join(rows) + "\n")
        left = {n: e for n, e in left.items() if e not in chosen}
    return "\n".join(parts)


def page(effect: type[Effect], known: dict[str, type[Effect]]) -> str:
    """One effect: picture, physics, formula, parameters, fingerprint, confusions, references."""
    parts = [
        f"# {effect.name}\n",
        f"{_sentence(effect.summary)}\n",
        f"![Frames without and with {effect.name}, distribution and spectrum]({effect.name}.png)\n",
        f"*{caption(effect)}*\n",
        *([f"**Also called** {_also(effect.name)}.\n"] if effect.name in ALSO else []),
        f"{effect.physics}\n",
        f"**Formula.** `{effect.formula}`\n",
        f"**Place in the signal chain.** {effect.stage.name.lower().replace('_', ' ')}; "
        f"{TIMES[effect.varies]}.\n",
        "## Parameters\n",
        "| name | unit | default | bounds or choices | meaning |\n|---|---|---|---|---|",
        "\n".join(_parameters(effect)) + "\n",
    ]
    if effect.fingerprint:
        known_statistics = statistics()
        rows = [
            f"| `{n}` | {known_statistics[n].title if n in known_statistics else ''} |"
            for n in effect.fingerprint
        ]
        parts.append(
            "## Fingerprint\n\n[Statistics](../statistics.md) that the effect changes most.\n"
        )
        parts.append("| statistic | what it is |\n|---|---|\n" + "\n".join(rows) + "\n")
    if effect.confused_with:
        parts.append("## Confounded with\n\n| effect | distinguished by |\n|---|---|")
        rows = [
            f"| {f'[{n}]({n}.md)' if n in known else n} | {_cell(text)} |"
            for n, text in effect.confused_with.items()
        ]
        parts.append("\n".join(rows) + "\n")
    if effect.references:
        parts.append("## References\n\n" + _bullets(effect.references) + "\n")
    return "\n".join(parts)


def _also(name: str) -> str:
    return ", ".join(ALSO[name])


def _parameters(effect: type[Effect]) -> Iterable[str]:
    default = effect().to_plain()
    for name, info in effect.parameters().items():
        value = number(default[name]) if is_number(default[name]) else default[name]
        unit = symbol(info.unit)
        cells = (f"`{name}`", unit, value, _range(info, default[name]), _cell(info.doc))
        yield "| " + " | ".join(map(str, cells)) + " |"


def _range(info: ParameterInfo, default: object) -> str:
    if info.scale == "choice":
        any_ = "a list of numbers" if default == [] else "whole number"
        return ", ".join(map(str, info.choices)) or any_
    return f"{number(info.lower)} to {number(info.upper)}"


def _bullets(lines: Iterable[str]) -> str:
    return "\n".join(f"- {line}" for line in lines)


def _sentence(text: str) -> str:
    text = text[:1].upper() + text[1:]
    return text if text.endswith(".") else f"{text}."


def _cell(text: str) -> str:
    return text.replace("|", "\\|")


def models(effect: type[Effect]) -> tuple[NoiseModel, NoiseModel]:
    """An ordinary sensor without and with the effect."""
    known = built_in()
    base = known[BASE].from_plain(DARK)
    read = known["read_noise"].from_plain({"sigma": 1.5})
    hot = known["hot_pixels"].from_plain({"fraction": 2e-3, "scale": 60.0})
    rounding = known["quantization"]()
    quiet = replaced = [base, read, rounding]
    if effect.name in ("dpc", "denoise", "crosstalk", "temporal_denoise", "persistence"):
        quiet = replaced = [base, read, hot, rounding]
    if effect.name == BASE:
        quiet = [read, rounding]
    if effect.name in (e.name for e in quiet) and effect.name != BASE:
        quiet = [e for e in quiet if e.name != effect.name]
        replaced = quiet
    if effect.name == BASE:
        replaced = quiet
    own = effect.from_plain(STRENGTHS.get(effect.name, {}))
    before = NoiseModel(tuple(quiet), 64.0, POINT, 1)
    return before, NoiseModel((*replaced, own), 64.0, POINT, 1)


def caption(effect: type[Effect]) -> str:
    """What the figure shows."""
    given = ", ".join(f"{k} {number(v) if is_number(v) else v}"
                      for k, v in STRENGTHS.get(effect.name, {}).items())  # fmt: skip
    what = f"with {given}" if given else "at its defaults"
    last = OVER_TIME.get(effect.name, "radial spectrum")
    return (
        f"A frame of a simulated sensor at 65 °C without and with the effect ({what}; a crop), "
        f"then the distribution and the {last.split(' [')[0].removeprefix('the ')} of both."
    )


def draw(effect: type[Effect], path: Path) -> None:
    """Frames without and with the effect, distribution, spectrum."""
    from matplotlib.figure import Figure

    from dnanalyze.analyzers.analyze import analyze
    from dnanalyze.report.figures.style import MODEL, QUIET, log_axis, styled

    made = [simulate(m, SHAPE, [(POINT, FRAMES)]) for m in models(effect)]
    stacks = [np.stack([f.read() for f in m.frames()]) for m in made]
    side = ZOOM if effect.name in NEAR else SHAPE[0] if effect.name in WIDE else SHOWN
    crops = [s[2, :side, :side] for s in stacks]
    low, high = np.percentile(np.concatenate(crops), (0.5, 99.5))
    with styled():
        fig = Figure(figsize=(10.4, 2.5), layout="constrained")
        panels = fig.subplots(1, 4, width_ratios=(1, 1, 1.35, 1.35))
        for ax, crop, title in zip(panels, crops, ("without", "with"), strict=False):
            image = ax.imshow(crop, cmap="gray", vmin=low, vmax=high, interpolation="nearest")
            ax.set(xticks=[], yticks=[], title=title)
            ax.grid(False)
        fig.colorbar(image, ax=panels[:2], label="DN", shrink=0.8)
        last = OVER_TIME.get(effect.name)
        for stack, one, colour, label in zip(
            stacks, made, (QUIET, MODEL), ("without", "with"), strict=True
        ):
            _distribution(panels[2], effect.name, stack, colour, label)
            if last:
                panels[3].plot(*_over_time(effect.name, stack), "o-", color=colour, markersize=3)
                continue
            curves = analyze(one).settings[0].curves
            f, power = curves["frame_radial_f"], curves["frame_radial_full_s"]
            seen = (f > 0.008) & np.isfinite(power)
            panels[3].plot(f[seen], power[seen], color=colour)
        panels[2].set(xlabel="DN", title="Distribution")
        if panels[2].get_yscale() == "log":
            log_axis(panels[2].yaxis)
        panels[2].legend()
        if last:
            lag = "frames apart" if "correlation" in last else "frame"
            panels[3].set(xlabel=lag, title=last[:1].upper() + last[1:])
        else:
            panels[3].set(xscale="log", yscale="log", xlabel="cycles/pixel", title="Spectrum [DN²]")
            log_axis(panels[3].xaxis)
            log_axis(panels[3].yaxis)
        save(fig, path)


def save(figure: Any, path: Path) -> None:
    """Save on light paper and, as ``NAME-dark.png``, on dark."""
    from dark_figures import PAPER, darken

    _save(figure, path, "white")
    darken(figure)
    _save(figure, path.with_stem(f"{path.stem}-dark"), PAPER)


def _save(figure: Any, path: Path, paper: str) -> None:
    """As a PNG of 64 colours: grey noise does not need more, and the pages stay small."""
    from io import BytesIO

    from PIL import Image

    full = BytesIO()
    figure.savefig(full, dpi=80, facecolor=paper)
    Image.open(full).convert("RGB").quantize(64, dither=Image.Dither.NONE).save(path, optimize=True)


def _over_time(name: str, stack: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What the effect does from frame to frame."""
    if name == "offset_drift":
        return np.arange(len(stack)), stack.mean(axis=(1, 2))
    if name == "rts":
        row, column = np.unravel_index(np.argmax(stack.var(axis=0)), stack.shape[1:])
        return np.arange(len(stack)), stack[:, row, column]
    moving = stack - stack.mean(axis=0)
    own = np.mean(moving**2)
    lags = np.arange(1, 7)
    bias = 1.0 / len(stack)  # the mean of the same frames was taken off
    pairs = [np.mean(moving[:-lag] * moving[lag:]) / own + bias for lag in lags]
    return lags, np.array(pairs)


def _distribution(ax: Any, name: str, stack: np.ndarray, colour: str, label: str) -> None:
    """Share of each code; of effects that act on single codes, only the core."""
    share = np.bincount(np.rint(stack).astype(int).ravel()) / stack.size
    low, high = np.percentile(stack, (2, 75) if name in CODES else (0, 99.99)).astype(int)
    codes = np.arange(low, high + 1)
    drawn = share[low : high + 1]
    if name not in CODES:
        drawn = np.where(drawn > 0, drawn, np.nan)
        ax.set_yscale("log")
    ax.step(codes, drawn, where="mid", color=colour, label=label)


if __name__ == "__main__":
    main()
