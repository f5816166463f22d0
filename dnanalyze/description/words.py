"""A structure in one sentence."""

from __future__ import annotations

import math

from dnanalyze.description.found import Estimate
from dnanalyze.description.law import apparent_energy, follows
from dnanalyze.description.layers import Layers
from dnanalyze.digits import number, with_error
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.composite.effect import CompositeEffect

# Known causes of such a structure; a geometry alone proves no cause.
KNOWN = {
    ("level", "rings", "fixed"): "consistent with growth striations or thin-film interference",
    ("level", "block", "frame"): "consistent with pixels that share an amplifier",
    ("gain", "quadrants", "frame"): "consistent with exposure times that differ by quadrant",
    ("level", "column_segments", "frame"): "consistent with telegraph noise of column circuits",
}
MOST_GROUPS = 8  # of lines, that a sentence names
OPEN = "the geometry is determined, the cause is not"


def sentence(found: Estimate, seen: Layers, reference: OperatingPoint | None = None) -> str:
    """Time, geometry, size, law, and a known cause of such a structure.

    ``reference``: where the size of a thermal structure is stated.
    """
    e = found.effect
    size = _size(e, found.errors)
    if e.law == "thermal" and reference is not None:
        size += f" at {reference.label()}"
    text = ", ".join([_structure(e, found.errors), size, _law(found, seen)])
    cause = KNOWN.get((e.what, e.where, e.when), OPEN)
    return f"{text[0].upper()}{text[1:]}: {cause}."


def _structure(e: CompositeEffect, errors: dict[str, float]) -> str:
    """What, when and where."""
    where = _geometry(e, errors)
    if e.what == "noise":
        lines = e.where in ("row", "column")
        if lines:
            return f"additional noise, independent in each pixel, in {where}"
        return f"pixel noise modulated as a {where}"
    if (e.where == "blob" and e.when == "frame") or "segments" in e.where:
        return where + ", at a new position in every frame"
    when = {
        "fixed": "fixed",
        "frame": "new in every frame",
        "persisting": "persisting over some frames",
        "drifting": "drifting over the frames",
        "switching": "switching",
    }[e.when]
    if e.where == "row_before":
        return where
    whose = "relative changes of the dark signal: " if e.what == "gain" else ""
    return f"{whose}fixed {where}" if e.when == "fixed" else f"{whose}{where}, {when}"


def _stated(effect: CompositeEffect, name: str, errors: dict[str, float], digits: int = 3) -> str:
    value, error = float(getattr(effect, name)), errors.get(name)
    return with_error(value, error) if error and math.isfinite(error) else number(value, digits)


def _geometry(e: CompositeEffect, errors: dict[str, float]) -> str:
    if e.where == "rings":
        centre = f"({_stated(e, 'centre_y', errors)}, {_stated(e, 'centre_x', errors)})"
        apart = _stated(e, "period", errors)
        phase = f"phase {number(e.phase)} rad at the centre"
        return (
            f"sinusoidal rings, period {apart} px about row and column {centre}, {phase}{_grows(e)}"
        )
    if e.where == "wave":
        if abs(e.u) == abs(e.v) == 0.5:
            return f"checkerboard of single pixels{_grows(e)}"
        period = 1.0 / math.hypot(e.u, e.v)
        spread = math.hypot(errors.get("u", 0.0), errors.get("v", 0.0)) * period**2 / math.sqrt(2.0)
        way = _direction(e.u, e.v)
        phase = f"phase {number(e.phase)} rad at row 0, column 0"
        apart = with_error(period, spread)
        return f"sinusoidal plane wave, period {apart} px {way}, {phase}{_grows(e)}"
    if e.where == "block":
        pixels = {"all": "all their pixels", "diagonal": "the pixels of their falling diagonal",
                  "antidiagonal": "the pixels of their rising diagonal"}[e.mask]  # fmt: skip
        cut = ""
        if e.top or e.left:  # without the phase the blocks could not be drawn again
            cut = f" (the first {e.height - (e.top or 0)} × {e.width - (e.left or 0)} px)"
        return f"values of blocks of {e.height} × {e.width} px{cut}, shared by {pixels}"
    if e.where == "surface":
        terms = ("x", "y", "x²", "xy", "y²")
        parts = [
            t if c == 1 else f"{number(c)} {t}"
            for c, t in zip(e.coefficients, terms, strict=True)
            if c
        ]
        return f"surface {' + '.join(parts)} of random sign and amplitude"
    if e.where == "blob":
        place = ""
        if e.when != "frame":
            at = f"({_stated(e, 'centre_y', errors)}, {_stated(e, 'centre_x', errors)})"
            place = f" about row and column {at}"
        half = ", present in half of the frames" if e.distribution == "on_off" else ""
        size = f"standard deviation {_stated(e, 'radius', errors)} px"
        return f"Gaussian spot, {size}{place}{half}"
    if e.where == "diagonal":
        return (
            f"values of the diagonals that {'fall' if e.slant == 'down' else 'rise'} to the right"
        )
    if e.where in ("row_segments", "column_segments"):
        line = e.where.split("_")[0] + "s"
        return f"steps between two levels within {_percent(e, errors)} of the {line}"
    if e.where in ("row", "column"):
        if e.lines and len(e.lines) <= 2 * MOST_GROUPS:
            pairs = zip(e.lines[::2], e.lines[1::2], strict=True)
            runs = (f"{a:.0f}" if a == b else f"{a:.0f} to {b:.0f}" for a, b in pairs)
            return f"{e.where}s {', '.join(runs)}"
        few = f"{_percent(e, errors)} of the " if e.share < 1 else "values of the "
        return f"{few}{e.where}s"
    if e.coefficients and e.where in ("halves", "quadrants"):
        if e.where == "halves":
            return f"step between the two halves of the {e.axis}"
        return "levels of the four quadrants"
    names = {"quadrants": "values of the four quadrants", "pixel": "values of the pixels",
             "halves": f"values of the two halves of the {e.axis}",
             "smooth": "smooth random pattern",
             "row_before": "signal of the row before, added to every row"}  # fmt: skip
    return names[e.where]


def _percent(e: CompositeEffect, errors: dict[str, float]) -> str:
    return f"{with_error(100 * e.share, 100 * errors.get('share', 0.0))} %"


def _grows(e: CompositeEffect) -> str:
    side = {"down": "last row", "up": "first row", "right": "last column", "left": "first column"}
    return f" that grows from 0 towards the {side[e.envelope]}" if e.envelope in side else ""


def _direction(u: float, v: float) -> str:
    if abs(v) < 0.02 * abs(u):
        return "along the rows"
    if abs(u) < 0.02 * abs(v):
        return "along the columns"
    return f"at {number(math.degrees(math.atan2(v, u)))}° to the rows"


def _size(e: CompositeEffect, errors: dict[str, float]) -> str:
    if e.what == "gain":
        spread = 100.0 * errors.get("gain", 0.0)
        rms = "" if e.where == "row_before" else " rms"
        return f"{with_error(100.0 * e.gain, spread)} % of it{rms}"
    if e.where == "halves" and e.coefficients:
        return f"{_stated(e, 'amplitude', errors)} DN half the step"
    what = "height" if e.where == "blob" else "half the step" if "segments" in e.where else "rms"
    if e.what == "noise":
        what = "additional noise"
    return f"{_stated(e, 'amplitude', errors)} DN {what}"


def _law(found: Estimate, seen: Layers) -> str:
    e = found.effect
    if len(seen.points) < 2:
        return "at the only operating point"
    if e.what == "gain" and e.where != "row_before":
        return "in proportion to the dark signal"
    if e.law == "thermal":
        own = apparent_energy(seen.points, seen.dark)
        beside = f" (dark signal: {number(own, 2)} eV)" if own is not None else ""
        return f"with an activation energy of {_stated(e, 'ea_ev', found.errors)} eV{beside}"
    varied = [name for name, values in (
        ("temperature", [p.temperature_c for p in seen.points]),
        ("exposure", [p.exposure_s for p in seen.points]),
        ("gain", [p.gain for p in seen.points]),
    ) if len(set(values)) > 1]  # fmt: skip
    varied = varied or ["operating point"]
    if e.what == "gain" or follows(found):
        return f"the same at every {' and '.join(varied)}"
    sizes, errors = found.sizes.amplitudes
    shown = sizes[sizes > errors]
    return (
        f"{number(shown.min(), 2)} to {number(shown.max(), 2)} DN over the {'s and '.join(varied)}s"
    )
