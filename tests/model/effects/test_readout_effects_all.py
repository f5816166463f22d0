"""What every effect of the readout and of the digital end must keep to."""

import dataclasses

import numpy as np
import pytest
from readout_bench import POINT, Flat, frames

from dnanalyze.loaders.captures import Window
from dnanalyze.model.clues import Clues
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.noise_model import NoiseModel, dump_model, model_from_plain
from dnanalyze.model.registry import built_in

NAMES = (
    "column_fpn", "column_gain", "row_fpn", "row_noise", "column_noise", "flicker_fpn",
    "flicker_noise", "heavy_tailed_read_noise", "periodic_pattern", "offset_drift", "cfa_mismatch",
    "column_taps", "stuck_pixels", "defect_lines", "missing_codes", "digital_gain",
    "black_clipping", "dpc", "denoise", "temporal_denoise", "offset_gradient",
    "noisy_pixels", "serial_noise",
)  # fmt: skip
BASE = (Flat(20.0), ReadNoise(3.0))
SHAPE = (96, 130)


def variants():
    """Every effect with every value of every choice, one at a time."""
    for name in NAMES:
        cls = built_in()[name]
        yield cls()
        for key, info in cls.parameters().items():
            yield from (cls(**{key: value}) for value in info.choices[1:])


@pytest.mark.parametrize("effect", list(variants()), ids=repr)
def test_a_window_has_the_pixels_of_the_whole_frame(effect):
    window = Window(17, 61, 33, 94)
    model = (*BASE, effect)
    whole = frames(*model, shape=SHAPE)
    part = frames(*model, shape=SHAPE, window=window)
    np.testing.assert_array_equal(part, whole[:, 17:61, 33:94])
    np.testing.assert_array_equal(frames(*model, shape=SHAPE), whole)
    assert np.all(np.isfinite(whole))


def extremes():
    """Every effect with every parameter at both of its bounds, in every kind."""
    for name in NAMES:
        cls = built_in()[name]
        kinds = cls.parameters()["kind"].choices if "kind" in cls.parameters() else (None,)
        for kind in kinds:
            chosen = {} if kind is None else {"kind": kind}
            for key, info in cls.parameters().items():
                if info.scale != "choice":
                    for bound in (info.lower, info.upper):
                        yield cls(**chosen, **{key: bound})


@pytest.mark.parametrize("effect", list(extremes()), ids=repr)
def test_finite_at_the_bounds_of_every_parameter(effect):
    assert np.all(np.isfinite(frames(*BASE, effect, count=1, shape=(40, 48))))


@pytest.mark.parametrize("name", NAMES)
def test_the_catalogue_entry_is_complete(name):
    cls = built_in()[name]
    assert cls.name == name
    assert cls.varies in ("fixed", "temporal", "both", "digital")
    assert cls.summary.endswith(".")
    assert len(cls.physics) > 200
    assert cls.formula
    assert cls.fingerprint
    assert set(cls.confused_with) - {name} <= set(built_in())
    assert cls.confused_with
    for item in cls.parameters().values():
        assert item.doc
        if item.scale != "choice":
            assert item.unit
            assert item.lower < item.upper
            assert item.scale in ("linear", "signed", "held") or item.lower > 0


@pytest.mark.parametrize("effect", list(variants()), ids=repr)
def test_survives_a_model_file(effect):
    import yaml

    model = NoiseModel((*BASE[1:], effect), 64.0, POINT, 3)
    assert model_from_plain(yaml.safe_load(dump_model(model)), "test") == model
    assert set(effect.inactive_parameters()) <= {f.name for f in dataclasses.fields(effect)}


@pytest.mark.parametrize("name", NAMES)
def test_no_guess_where_nothing_is_unexplained(name):
    class Nothing:
        points = (POINT,)
        reference = POINT
        shape = SHAPE

        def measured(self, name):
            return np.array([1.0])

        def simulated(self, name):
            return np.array([1.0])

        def z(self, name):
            return np.array([0.5])

        def colours(self, name):
            return np.empty((0, 4, 2))

        def defects(self, axis):
            return np.empty((0, 4))

        def waves(self, part):
            return []

        def curve(self, name, setting):
            raise KeyError(name)

    clues: Clues = Nothing()
    assert built_in()[name].guess(clues) == []
