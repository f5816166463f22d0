"""What holds for every everyday and charge effect: pure, documented, quiet when all is quiet."""

import numpy as np
import pytest
from charge_bench import HERE, LONG, MadeUpClues, flat, frames, same_from_a_window

from dnanalyze.errors import InputError
from dnanalyze.model.registry import built_in

EFFECTS = {
    "convolved_lognormal": {"mu": 3.0, "phi": 0.02},
    "dark_shot_noise": {"dn_per_e": 0.7},
    "read_noise": {"sigma": 2.0, "spread": 0.3, "serial": 0.2, "serial2": -0.1},
    "pixel_fpn": {"sigma": 2.0},
    "quantization": {},
    "hot_pixels": {"fraction": 0.05},
    "hot_clusters": {"density": 0.01},
    "dark_current_steps": {"mean_number": 0.7},
    "rts": {"fraction": 0.1, "dwell_frames": 2.0, "polarity": "both"},
    "amp_glow": {"location": "ne"},
    "dark_gradient": {"x": 1.0, "y": -2.0, "xx": 3.0, "yy": 1.0},
    "cosmic_rays": {"rate": 2e4, "length": 12.0},
    "persistence": {"amplitude": 0.1},
    "crosstalk": {"alpha": 0.02},
    "dark_shading": {"rms": 0.1},
    "dark_current_fpn": {"rms": 0.2, "law": "gamma"},
    "dead_pixels": {"fraction": 0.05},
    "transfer_tails": {"loss": 0.1},
    "electron_multiplication": {"induced": 0.5},
    "scaled_lines": {"fraction": 0.05, "sigma": 0.5},
    "storage_dark_current": {"before": 0.5},
}
TEMPORAL = {
    "convolved_lognormal",
    "dark_shot_noise",
    "read_noise",
    "rts",
    "cosmic_rays",
    "electron_multiplication",
}
OTHERS = {
    "column_fpn",
    "column_gain",
    "row_fpn",
    "row_noise",
    "column_noise",
    "flicker_fpn",
    "flicker_noise",
    "heavy_tailed_read_noise",
    "periodic_pattern",
    "offset_drift",
    "cfa_mismatch",
    "column_taps",
    "stuck_pixels",
    "defect_lines",
    "missing_codes",
    "digital_gain",
    "black_clipping",
    "dpc",
    "denoise",
    "temporal_denoise",
    "offset_gradient",
    "noisy_pixels",
    "serial_noise",
}


def make(name):
    return built_in()[name](**EFFECTS[name])


@pytest.mark.parametrize("name", EFFECTS)
def test_a_window_holds_the_pixels_of_the_whole_frame(name):
    effect = make(name)
    base = () if name == "convolved_lognormal" else (make("convolved_lognormal"),)
    same_from_a_window((*base, effect))


@pytest.mark.parametrize("name", EFFECTS)
def test_frames_repeat_or_not_as_the_effect_says(name):
    effect = make(name)
    alone = (effect,) if name == "convolved_lognormal" else (flat(20.0), effect)
    a, b = frames(alone, (64, 64), 2, first=5)
    if name in TEMPORAL:
        assert not np.array_equal(a, b)
    else:
        # the flat level itself moves by sigma = 1e-6 of a kernel tap
        np.testing.assert_allclose(a, b, atol=1e-3)
    again = frames(alone, (64, 64), 2, first=5)
    np.testing.assert_array_equal(again, [a, b])


@pytest.mark.parametrize("name", EFFECTS)
def test_is_documented_and_survives_yaml(name):
    effect = make(name)
    kind = type(effect)
    assert kind.from_plain(effect.to_plain()) == effect
    assert 20 < len(kind.summary) < 100
    assert len(kind.physics.split()) > 50
    assert kind.formula
    assert kind.references
    assert kind.fingerprint
    assert len(set(kind.fingerprint)) == len(kind.fingerprint)
    assert set(kind.confused_with) <= (set(EFFECTS) | OTHERS) - {name}
    assert kind.varies in ("fixed", "temporal", "both")
    for info in kind.parameters().values():
        assert info.doc
        if info.scale == "log":
            assert 0 < info.lower < info.upper
    for text in (kind.physics, kind.formula, kind.summary):
        assert "  " not in text


@pytest.mark.parametrize("name", EFFECTS)
def test_no_guess_where_nothing_stands_out(name):
    assert built_in()[name].guess(MadeUpClues()) == []


@pytest.mark.parametrize("name", EFFECTS)
def test_values_out_of_bounds_are_refused_by_name(name):
    kind = built_in()[name]
    for key, info in kind.parameters().items():
        if info.scale == "choice":
            continue
        with pytest.raises(InputError, match=rf"{name}\.{key}"):
            kind(**{key: info.upper * 2 + 1})


@pytest.mark.parametrize(
    "name", ["hot_pixels", "hot_clusters", "dark_current_steps", "amp_glow", "dark_gradient"]
)
def test_charge_patterns_grow_with_exposure_and_nothing_else_moves(name):
    effect = make(name)
    a = frames(effect, (64, 64))
    np.testing.assert_allclose(frames(effect, (64, 64), point=LONG), 3 * a, rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize("name", [n for n in EFFECTS if n not in ("quantization",)])
def test_frames_move_smoothly_with_each_parameter(name):
    """With the random numbers held, a thousandth more moves few pixels, or all but a little."""
    effect = make(name)
    kind = type(effect)
    base = () if name == "convolved_lognormal" else (flat(200.0),)
    here = frames((*base, effect), (96, 96), 2, HERE, first=4)
    for key, info in kind.parameters().items():
        if info.scale == "choice":
            continue
        plain = effect.to_plain()
        step = 1e-3 * abs(plain[key]) or 1e-3
        other = kind.from_plain({**plain, key: min(plain[key] + step, info.upper)})
        there = frames((*base, other), (96, 96), 2, HERE, first=4)
        size = np.std(here) + 1e-3 * np.abs(here).max()
        assert np.sqrt(np.mean((there - here) ** 2)) < 0.2 * size, key
