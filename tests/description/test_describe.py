"""From frames to a model with the structure: words, numbers, error, and nothing where none is."""

import pytest

import dnanalyze
from dnanalyze.demo import VirtualSensor, generate

SENSOR = VirtualSensor(temperatures_c=(25.0, 45.0, 65.0))


@pytest.mark.slow
def test_rings_are_described_and_added():
    captures = generate(SENSOR, {"concentric_rings": "strong"}, (192, 192), frames=6, seed=3)
    found = dnanalyze.describe(captures)
    assert found.verdict == "described"
    assert found.effect.where == "rings"
    assert found.confidence > 0.9
    assert found.error_after < 0.7 * found.error_before
    assert "composite" in found.model.names


@pytest.mark.slow
def test_of_an_ordinary_sensor_nothing_is_described():
    found = dnanalyze.describe(generate(SENSOR, {}, (192, 192), frames=6, seed=3))
    assert found.verdict in ("adequate", "nothing")
    assert "composite" not in found.model.names


@pytest.mark.slow
@pytest.mark.parametrize("effect", ["column_fpn", "row_noise"])
def test_an_effect_of_the_catalogue_that_explains_as_much_is_preferred(effect):
    """Random columns have one largest wave among them, which no effect of its own left there."""
    found = dnanalyze.describe(generate(SENSOR, {effect: "middling"}, (192, 192), frames=6, seed=3))
    assert found.verdict != "described"
    assert "composite" not in found.model.names
    assert effect in [n.effect for n in found.nearest]
    assert effect in found.text
