"""Statistics of a simulation in parts, in other processes, and of one half alone."""

import os
import signal
from dataclasses import dataclass, replace

import numpy as np
import pytest

from dnanalyze.analyzers.statistics import Statistics
from dnanalyze.errors import InputError
from dnanalyze.fitting.design import design
from dnanalyze.fitting.helpers import MOST, WORTH, Helpers, worth
from dnanalyze.fitting.knobs import knobs_of
from dnanalyze.fitting.least_squares import derive, start
from dnanalyze.fitting.predictor import Bench, bench
from dnanalyze.fitting.simulated import Job, room
from dnanalyze.loaders.captures import OperatingPoint, Sensor, Window
from dnanalyze.model.effect import Effect, Stage
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import built_in
from dnanalyze.model.simulate import Memo, simulate

SHAPE = (96, 80)
POINTS = tuple(OperatingPoint(t, 0.1) for t in (25.0, 45.0, 65.0))
BAYER = (("R", "G"), ("G", "B"))
KNOWN = built_in()


def model(**more) -> NoiseModel:
    names = ("convolved_lognormal", "dark_shot_noise", "read_noise", "pixel_fpn", "quantization")
    return NoiseModel(tuple(KNOWN[n](**more.get(n, {})) for n in names), 64.0, POINTS[0], seed=4)


def on(cfa=None) -> Bench:
    sensor = Sensor(SHAPE, cfa=cfa)
    return bench(design(simulate(model(), SHAPE, [(p, 4) for p in POINTS], sensor=sensor)))


@pytest.fixture(scope="module")
def held():
    return on()


def values(made: list[Statistics]) -> list[tuple]:
    return [
        (s.point, s.plane, {n: v.value for n, v in s.values.items()})
        for half in made
        for s in half.settings
    ]


@pytest.mark.parametrize("cfa", [None, BAYER])
def test_the_fitted_half_alone_is_what_it_is_beside_the_other(cfa):
    here, other = on(cfa), model(read_noise={"sigma": 2.5})
    both, _ = here.coordinates(other)
    alone = here.fitted_coordinates(other)
    np.testing.assert_array_equal(alone, both)
    assert np.isfinite(alone).mean() > 0.9
    np.testing.assert_array_equal(here.fitted_z(other), here.z(other)[0])
    shaded = [k.name.startswith("shading_") for k in here.train.keys]
    assert np.isfinite(alone[shaded]).all()
    assert sum(shaded) > 0


@pytest.mark.parametrize("shares", [1, 2, 3, 7])
def test_shares_are_all_parts_once_and_nearly_alike(held, shares):
    job = Job(model(), Sensor(SHAPE), held.plan.windows, held.plan.settings)
    parts = [job.parts(n, shares) for n in range(shares)]
    assert sorted(p for share in parts for p in share) == job.parts()
    assert len(job.parts()) == 2 * len(POINTS)
    if shares == 2:
        assert [len(p) for p in parts] == [len(POINTS)] * 2
        for share in parts:  # either half of the field is in both shares
            assert {half for _, half in share} == {0, 1}


def test_helpers_find_what_this_process_would_and_may_end_at_any_time(held):
    helped = replace(held, helpers=Helpers(1))
    try:
        first, second = model(), model(read_noise={"sigma": 2.5})
        for other in (first, second):
            assert values(helped.statistics(other)) == values(held.statistics(other))
        (worker,) = helped.helpers.workers
        assert worker.is_alive()
        os.kill(worker.pid, signal.SIGKILL)
        worker.join(20)
        assert values(helped.statistics(first)) == values(held.statistics(first))
        assert values(helped.statistics(second)) == values(held.statistics(second))
    finally:
        helped.helpers.close()


@dataclass(frozen=True)
class Tilt(Effect):
    """An effect of a file that no other process has read."""

    name = "tilt"
    stage = Stage.PIXEL_READ

    def apply(self, signal, site):
        return signal + np.float32(3.0)


@dataclass(frozen=True)
class Broken(KNOWN["row_noise"]):
    """Fails where it is applied."""

    def apply(self, signal, site):
        raise ZeroDivisionError


def test_a_users_effect_is_simulated_here_and_an_error_is_told(held):
    helped = replace(held, helpers=Helpers(1))
    try:
        tilted = model().with_effect(Tilt())
        assert values(helped.statistics(tilted)) == values(held.statistics(tilted))
        (before, *_), (after, *_) = (
            values(held.statistics(model())),
            values(held.statistics(tilted)),
        )
        # the same draws, three DN higher, but for the rounding
        assert after[2]["mean"] - before[2]["mean"] == pytest.approx(3.0, abs=0.02)
        with pytest.raises(ZeroDivisionError):
            helped.statistics(model().with_effect(Broken()))
        job = Job(model(), Sensor((4, 4)), held.plan.windows, held.plan.settings)
        with pytest.raises(InputError):  # in both processes
            helped.helpers.statistics(job, Memo())
        assert values(helped.statistics(model())) == values(held.statistics(model()))
    finally:
        helped.helpers.close()


def test_helpers_are_started_only_where_there_is_much_to_do():
    assert not worth(WORTH - 1).workers
    many = worth(WORTH)
    try:
        assert len(many.workers) == min(MOST, len(os.sched_getaffinity(0)) - 1)
    finally:
        many.close()


def test_known_derivatives_size_the_steps_of_new_ones(held, monkeypatch):
    tried = []
    whole = Bench.fitted_z

    def counted(self, other):
        tried.append(other)
        return whole(self, other)

    monkeypatch.setattr(Bench, "fitted_z", counted)
    begun = start(held, model(), knobs_of(model()))
    first = derive(held, begun)
    groups, once = len({k.group for k in begun.knobs}), len(tried)
    assert once > groups  # some first steps were too short, or too long
    tried.clear()
    again = derive(held, first, anew=True)
    assert groups <= len(tried) < once
    old, new = (np.linalg.norm(s.jacobian, axis=0) for s in (first, again))
    assert np.all(
        np.sum(first.jacobian * again.jacobian, axis=0) > 0.6 * old * new
    )  # a step shows a dozen floors
    tried.clear()
    assert derive(held, first) is not None
    assert not tried


def test_what_is_read_out_differently_shares_its_charge():
    memo, made = room(), []
    apply = KNOWN["dark_shot_noise"].apply

    @dataclass(frozen=True)
    class Counted(KNOWN["dark_shot_noise"]):
        def apply(self, signal, site):
            made.append(site.frame)
            return apply(self, signal, site)

    def drawn(sigma, mu, memo):
        changes = {"read_noise": {"sigma": sigma}, "convolved_lognormal": {"mu": mu}}
        other = model(**changes).with_effect(Counted())
        frames = simulate(other, SHAPE, [(POINTS[0], 2)], memo=memo).frames()
        return np.array([f.read() for f in frames])

    for sigma, mu, counted in ((1.0, 2.0, 2), (2.0, 2.0, 0), (1.0, 2.0, 0), (1.0, 2.1, 2)):
        made.clear()
        with_room = drawn(sigma, mu, memo)
        assert len(made) == counted
        np.testing.assert_array_equal(with_room, drawn(sigma, mu, Memo()))


def test_charge_is_shared_by_like_sensors_settings_frames_and_windows_alone():
    memo = room()
    for seed in (1, 2):
        other = replace(model(), seed=seed)
        made = [
            simulate(other, SHAPE, [(p, 2) for p in POINTS], memo=kept) for kept in (memo, Memo())
        ]
        for one, plain in zip(*(m.frames() for m in made), strict=True):
            for window in (None, Window(8, 40, 0, 80), Window(8, 40, 8, 72)):
                np.testing.assert_array_equal(one.read(window), plain.read(window))
