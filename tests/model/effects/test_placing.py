"""What is said to be alike in every band of rows is, and what lies anywhere shades none."""

import numpy as np
import pytest
from scipy.fft import dctn
from scipy.stats import f

from dnanalyze.analyzers.analyze import analyze_windows
from dnanalyze.analyzers.catalogue import catalogue as infos
from dnanalyze.loaders.captures import OperatingPoint, Window
from dnanalyze.model.effect import Placing
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import BASE, BASELINE, built_in
from dnanalyze.model.simulate import simulate

KNOWN = built_in()
OTHERS = {n: e for n, e in KNOWN.items() if n not in (BASE, *BASELINE)}
EVERYWHERE = [n for n, effect in OTHERS.items() if effect.placing is Placing.EVERYWHERE]
ANYWHERE = [n for n, effect in OTHERS.items() if effect.placing is Placing.ANYWHERE]
PLAIN = {
    "persistence": {"amplitude": 0.1}, "dark_current_steps": {"mean_number": 0.5},
    "crosstalk": {"alpha": 0.05},
}  # fmt: skip
POINT = OperatingPoint(45.0, 0.1, 1.0)
LIKE = 1.3  # standard errors, root mean square; about 1 where two fields differ by chance
ROWS, COLUMNS, FRAMES = 256, 256, 6
HALVES = [
    Window(0, ROWS // 2, 0, COLUMNS),
    Window(ROWS // 2, ROWS, 0, COLUMNS),
]
STRONG = {
    "hot_pixels": {"fraction": 0.05}, "rts": {"fraction": 0.05}, "hot_clusters": {"density": 5e-3},
    "stuck_pixels": {"fraction": 5e-3}, "cosmic_rays": {"rate": 1.0}, "row_noise": {"sigma": 2.0},
    "column_noise": {"sigma": 2.0}, "offset_drift": {"step": 2.0}, "column_fpn": {"sigma": 2.0},
}  # fmt: skip
LOW, RARE = 3, 1e-4  # orders, and how seldom chance passes for shading
BANDS = [Window(top, top + ROWS // 4, 0, COLUMNS) for top in (0, 3 * ROWS // 4)]


def statistics(windows, *effects):
    """Those of parts of the field of an ordinary sensor with further effects."""
    everyday = (
        KNOWN[BASE](mu=3.0, delta=0.5, sigma=1e-6),
        KNOWN["dark_shot_noise"](dn_per_e=0.5),
        KNOWN["read_noise"](sigma=3.0),
        KNOWN["pixel_fpn"](sigma=1.0),
        KNOWN["quantization"](),
    )
    model = NoiseModel((*everyday, *effects), 100.0, POINT, seed=11)
    captures = simulate(model, (ROWS, COLUMNS), [(POINT, FRAMES)])
    return [s.settings[0] for s in analyze_windows(captures, windows)]


def off(*effects):
    """Differences of two bands of rows, in their standard errors."""
    one, other = statistics(BANDS, *effects)
    scales = {n: info.scale for n, info in infos().items() if info.compared}
    return np.array([
        (scales[n].coordinate(v.value) - scales[n].coordinate(other.values[n].value))
        / np.hypot(v.se, other.values[n].se)
        for n, v in one.values.items()
        if n in scales and n in other.values and v.se > 0
    ])  # fmt: skip


def size(z):
    """Root mean square, each difference cut where chance never reaches."""
    return float(np.sqrt(np.mean(np.minimum(np.abs(z[np.isfinite(z)]), 8.0) ** 2)))


@pytest.mark.parametrize("name", EVERYWHERE)
def test_bands_of_rows_differ_by_their_standard_errors(name):
    assert size(off(KNOWN[name](**PLAIN.get(name, {})))) < LIKE


@pytest.mark.parametrize(
    ("name", "numbers"),
    [("amp_glow", {"amplitude": 40.0}), ("dark_gradient", {"x": 5.0, "y": 5.0})],
)
def test_what_is_not_shows_it(name, numbers):
    assert KNOWN[name].placing is Placing.SOMEWHERE
    assert size(off(KNOWN[name](**numbers))) > 2 * LIKE


def unlike(name, effect):
    """Power of the low orders of a half of the field beside the other's mirror image, over that of
    the high ones; a ratio of mean squares, which chance leaves at 1.
    """
    upper, lower = (s.curves[name] for s in statistics(HALVES, effect))
    power = dctn(upper[::-1] - lower, norm="ortho") ** 2
    order = np.maximum(*np.indices(power.shape))
    low, high = power[(order > 0) & (order < LOW)], power[order >= LOW]
    return low.mean() / high.mean() / f.ppf(1.0 - RARE, low.size, high.size)


@pytest.mark.parametrize("blocks", ["block_means", "noise_blocks", "scatter_blocks"])
@pytest.mark.parametrize("name", ANYWHERE)
def test_a_half_stands_for_the_other_of_what_lies_anywhere(name, blocks):
    assert unlike(blocks, KNOWN[name](**STRONG.get(name, {}))) < 1.0


def test_it_does_not_of_what_lies_somewhere():
    assert unlike("block_means", KNOWN["dark_gradient"](x=0.0, y=5.0)) > 2.0
