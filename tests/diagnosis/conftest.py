"""A sensor of the independent generator with stripes, and what it is asked for."""

import pytest
from drawn_sensor import captures_with

from dnanalyze.diagnosis.refine import refine_on
from dnanalyze.diagnosis.search_path import SearchLimits
from dnanalyze.model.registry import BASE, BASELINE, built_in

FEW = (BASE, *BASELINE, "row_fpn", "row_noise", "column_fpn")


@pytest.fixture(scope="session")
def striped():
    """Captures of a sensor with strong row FPN."""
    return captures_with({"row_fpn": "strong"}, every=4, seed=4)


@pytest.fixture(scope="session")
def known():
    """Few effects, by name."""
    return {name: effect for name, effect in built_in().items() if name in FEW}


@pytest.fixture(scope="session")
def ordinary(striped, known):
    """The refinement of ``striped`` that stopped before it added anything."""
    return refine_on(striped, known=known, limits=SearchLimits(max_effects=0), classifier=False)
