"""Captures of two analog gains: what is added before the amplifier, and after it."""

from __future__ import annotations

import numpy as np
import pytest

import dnanalyze
from dnanalyze import OperatingPoint
from dnanalyze.diagnosis.baseline import baseline_fitted
from dnanalyze.fitting.design import design
from dnanalyze.fitting.fit import baseline_model
from dnanalyze.fitting.problem import fit_problem
from dnanalyze.fitting.ties import TRANSFER, Direct, Known
from dnanalyze.loaders.captures import Window
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.simulator import Simulator

READ_E, AFTER_DN, OFFSET_E, BLACK = 3.0, 1.5, 1.0, 64.0
GAINS = {1.0: 0.3, 4.0: 1.2}  # DN/e-


def captures(seed: int, shape=(160, 200), gains=GAINS) -> dnanalyze.CaptureSet:
    """By NumPy: charge of 4, 40 and 160 e-, five frames each."""
    rng = np.random.default_rng(seed)
    charge = 40.0 * np.exp(0.4 * rng.standard_normal(shape) - 0.08)
    offset = OFFSET_E * rng.standard_normal(shape)
    frames = {}
    for setting, gain in gains.items():
        for exposure in (0.1, 1.0, 4.0):
            drawn = rng.poisson(charge * exposure, (5, *shape)) + offset
            drawn = drawn + READ_E * rng.standard_normal(drawn.shape)
            after = AFTER_DN * rng.standard_normal(drawn.shape)
            frames[OperatingPoint(25.0, exposure, setting)] = np.rint(BLACK + gain * drawn + after)
    return dnanalyze.from_arrays(frames, name="two gains")


@pytest.fixture(scope="module")
def problem():
    return fit_problem(design(captures(1)))


def test_moments_tell_noise_before_the_gain_from_that_after_it(problem):
    read = baseline_model(problem).get("read_noise")
    assert read.sigma == pytest.approx(READ_E * GAINS[1.0], rel=0.15)
    assert read.converter == pytest.approx(AFTER_DN, rel=0.1)


def test_fit_measures_both_sources_and_the_offsets(problem):
    model = baseline_fitted(problem, baseline_model(problem)).model
    read, offsets = model.get("read_noise"), model.get("pixel_fpn")
    assert read.sigma == pytest.approx(READ_E * GAINS[1.0], rel=0.1)
    assert read.converter == pytest.approx(AFTER_DN, rel=0.05)
    assert offsets.sigma == pytest.approx(OFFSET_E * GAINS[1.0], rel=0.2)
    assert offsets.converter < 0.3
    assert model.get("dark_shot_noise").dn_per_e == pytest.approx(GAINS[1.0], rel=0.05)


def test_one_gain_has_no_noise_after_it():
    alone = captures(1, (64, 80), {1.0: GAINS[1.0]})
    read = baseline_model(fit_problem(design(alone))).get("read_noise")
    assert read.converter == 0.0
    assert "converter" in read.inactive_parameters()


@pytest.mark.parametrize("name", ["read_noise", "pixel_fpn"])
def test_a_higher_gain_raises_one_source_alone(name):
    effect = dnanalyze.catalogue()[name](sigma=2.0, converter=3.0)
    reference = OperatingPoint(25.0, 1.0, 1.0)
    model = NoiseModel((effect,), 0.0, reference)
    assert effect.variance(reference) == pytest.approx(13.0)
    simulator = Simulator(model, (200, 200))
    for gain, variance in ((1.0, 13.0), (4.0, 73.0)):
        frame = simulator.frame(OperatingPoint(25.0, 1.0, gain), 0, Window.whole((200, 200)))
        assert np.var(frame) == pytest.approx(variance, rel=4 * np.sqrt(2 / 40000))


READOUT = (
    "column_fpn", "column_taps", "row_fpn", "row_noise", "column_noise", "periodic_pattern",
    "offset_gradient", "flicker_noise", "flicker_fpn",
)  # fmt: skip


@pytest.mark.parametrize("name", READOUT)
def test_what_is_added_after_the_gain_is_the_same_at_every_gain(name):
    kind = dnanalyze.catalogue()[name]
    size = next(n for n in ("sigma", "amplitude", "rms", "x") if n in kind.parameters())
    reference = OperatingPoint(25.0, 1.0, 1.0)
    ratios = {}
    for added in ("before", "after"):
        model = NoiseModel((kind(**{size: 2.0, "added": added}),), 0.0, reference)
        simulator = Simulator(model, (96, 96))
        one, four = (
            simulator.frame(OperatingPoint(25.0, 1.0, gain), 0, Window.whole((96, 96)))
            for gain in (1.0, 4.0)
        )
        ratios[added] = float(np.std(four) / np.std(one))
    # noise is drawn anew: of 96 lines the standard deviation is good to 7 %
    assert ratios == {"before": pytest.approx(4.0, rel=0.4), "after": pytest.approx(1.0, rel=0.4)}


@pytest.mark.long
@pytest.mark.parametrize(("size", "added"), [(2.0, "after"), (1.0, "before")])
def test_column_offsets_are_named_in_the_form_that_they_have(size, added):
    columns = size * np.random.default_rng(5).standard_normal(200)
    frames = {
        s.point: np.stack([f.read() for f in s.frames])
        + np.rint(columns * (s.point.gain if added == "before" else 1.0))
        for s in captures(5).settings
    }
    found = dnanalyze.diagnose(dnanalyze.from_arrays(frames))
    assert found.candidates[0].effect == "column_fpn"
    assert found.trials[0].state.model.get("column_fpn").added == added


def gains(*found: tuple[float, float, float]) -> Direct:
    return Direct(tuple((at, Known(value, error, TRANSFER)) for at, value, error in found))


def test_photon_transfers_at_other_gains_count_in_proportion():
    known = gains((1.0, 0.31, 0.03), (4.0, 1.2, 0.012)).gains_at(1.0)
    assert [k.value for k in known] == [pytest.approx(0.3001, abs=1e-3)]
    assert known[0].error == pytest.approx(0.03 * 0.3001, rel=0.01)  # nominal gains


def test_gains_that_disagree_stay_as_they_are():
    known = gains((1.0, 0.31, 0.01), (4.0, 2.0, 0.02)).gains_at(1.0)
    assert [k.value for k in known] == [0.31]
