"""What is said to be alike in every part of the field is."""

import numpy as np
import pytest

from dnanalyze.analyzers.analyze import analyze_windows
from dnanalyze.analyzers.catalogue import catalogue as infos
from dnanalyze.loaders.captures import OperatingPoint, Window
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import BASE, EVERYDAY, built_in
from dnanalyze.model.simulate import simulate

KNOWN = built_in()
EVEN = [n for n, effect in KNOWN.items() if effect.even and n not in (BASE, *EVERYDAY)]
PLAIN = {
    "persistence": {"amplitude": 0.1}, "dark_current_steps": {"mean_number": 0.5},
    "crosstalk": {"alpha": 0.05},
}  # fmt: skip
POINT = OperatingPoint(45.0, 0.1, 1.0)
LIKE = 1.3  # standard errors, root mean square; about 1 where two fields differ by chance
ROWS, COLUMNS, FRAMES = 256, 256, 6
CORNERS = [
    Window(top, top + ROWS // 2, left, left + COLUMNS // 2)
    for top, left in ((0, 0), (ROWS // 2, COLUMNS // 2))
]


def off(*effects):
    """Differences of two corners of the field, in their standard errors."""
    everyday = (
        KNOWN[BASE](mu=3.0, delta=0.5, sigma=1e-6),
        KNOWN["dark_shot_noise"](dn_per_e=0.5),
        KNOWN["read_noise"](sigma=3.0),
        KNOWN["pixel_fpn"](sigma=1.0),
        KNOWN["quantization"](),
    )
    model = NoiseModel((*everyday, *effects), 100.0, POINT, seed=11)
    (one,), (other,) = (
        s.settings
        for s in analyze_windows(simulate(model, (ROWS, COLUMNS), [(POINT, FRAMES)]), CORNERS)
    )
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


@pytest.mark.parametrize("name", EVEN)
def test_corners_differ_by_their_standard_errors(name):
    assert size(off(KNOWN[name](**PLAIN.get(name, {})))) < LIKE


@pytest.mark.parametrize(
    ("name", "numbers"),
    [("amp_glow", {"amplitude": 40.0}), ("dark_gradient", {"x": 5.0, "y": 5.0})],
)
def test_what_is_not_shows_it(name, numbers):
    assert not KNOWN[name].even
    assert size(off(KNOWN[name](**numbers))) > 2 * LIKE
