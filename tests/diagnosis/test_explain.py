"""Evidence in words: never empty, never without its place, no ratio to nothing."""

from types import SimpleNamespace

import numpy as np
import pytest

from dnanalyze.analyzers.catalogue import catalogue
from dnanalyze.diagnosis.explain import evidence_for
from dnanalyze.fitting.vectors import Key, Target
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.registry import built_in

RTS = built_in()["rts"]
POINTS = [(OperatingPoint(t, 0.1), 4) for t in (25.0, 65.0)]


def half(name, measured, floor=1.0):
    """One statistic at two operating points."""
    info = catalogue()[name]
    coordinates = np.array([info.scale.coordinate(v) for v in measured])
    keys = tuple(Key(setting, "", name) for setting in range(2))
    families = np.array([info.family] * 2)
    return Target(keys, np.array(measured, float), coordinates, np.full(2, floor), families)


def told(name, measured, train, test, after=0.0):
    side = half(name, measured)
    problem = SimpleNamespace(train=side, test=side, plan=SimpleNamespace(settings=POINTS))
    before = SimpleNamespace(train=np.array(train, float), test=np.array(test, float))
    ended = SimpleNamespace(train=before.train * after, test=before.test * after)
    return evidence_for(problem, before, ended, RTS)


def test_a_misfit_of_the_judged_half_alone_has_its_place_too():
    words = told("temporal_noise", (3.0, 3.0), (0.1, 2.0), (9.0, 9.0))
    assert "at 65 °C" in words[0]
    assert "at )" not in " ".join(words)


def test_many_small_reliefs_are_evidence_and_said_to_be():
    words = told("temporal_noise", (3.0, 3.0), (2.0, 2.0), (2.0, 2.0), 0.5)
    assert "from 2 to 1 sigma" in words[0]
    assert "small differences" in words[0]
    assert told("temporal_noise", (3.0, 3.0), (2.0, 2.0), (2.0, 2.0), 1.5)[0].startswith("no stat")


@pytest.mark.parametrize("count", [0.0, 0.3])
def test_no_ratio_to_nothing(count):
    name = "hot_count_8"
    scale = catalogue()[name].scale
    z = scale.coordinate(40.0) - scale.coordinate(count)
    (said, _) = told(name, (40.0, 40.0), (z, z), (z, z))
    assert "40 pixels measured, none in the model (at every operating point)" in said
    assert "e-" not in said


def test_thousands_are_written_without_an_exponent():
    (said, _) = told("hot_count_8", (4321.0, 1234.0), (40.0, 3.0), (40.0, 3.0))
    assert "measured 4,320, model" in said
    assert "e+" not in said
