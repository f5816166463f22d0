"""Calibration of stated confidences, against draws whose probability is known."""

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

from third_party.calibration import additions, at, curve, left_out, reliability


def drawn(bias, generator, count=4000, seed=0):
    """Additions whose odds of being right are those stated times exp(bias)."""
    rng = np.random.default_rng(seed)
    stated = rng.uniform(0.05, 0.95, count)
    odds = np.exp(bias) * stated / (1 - stated)
    right = rng.random(count) < odds / (1 + odds)
    return [(generator, float(c), bool(r)) for c, r in zip(stated, right, strict=True)]


@pytest.mark.parametrize("bias", [0.0, -1.0, 0.7])
def test_the_curve_is_that_of_the_odds(bias):
    _, stated, right = zip(*drawn(bias, "a"), strict=True)
    beta = curve(np.array(stated), np.array(right, float))
    # 4,000 draws: the intercept is good to 1 / sqrt(4000 / 5), three times that
    assert beta == pytest.approx([bias, 1.0], abs=0.12)
    for c in (0.5, 0.9):
        odds = np.exp(bias) * c / (1 - c)
        assert at(beta, c) == pytest.approx(odds / (1 + odds), abs=0.03)


def test_few_additions_that_are_all_right_have_a_finite_curve():
    beta = curve(np.full(5, 0.99), np.ones(5))
    assert np.isfinite(beta).all()
    assert 0.98 < at(beta, 0.99) < 1.0


def test_without_additions_the_stated_confidence_stands():
    assert curve(np.empty(0), np.empty(0)) == pytest.approx([0.0, 1.0])


def test_bins_count_what_is_right():
    found = [("a", 0.5, True), ("a", 0.5, False), ("b", 0.995, True)]
    lines = reliability(found)
    assert [line[0] for line in lines] == ["0.4-0.6", "0.99-1"]
    assert lines[0][2].startswith("1/2 (")
    assert lines[1][2].startswith("1/1 (")


def test_a_generator_on_which_confidences_are_wrong_stands_out():
    far = {line[0]: float(line[-1]) for line in left_out(
        drawn(0.0, "a", seed=1) + drawn(0.0, "b", seed=2) + drawn(-2.0, "c", 1000, seed=3)
    )}  # fmt: skip
    assert far["c"] > 0.3
    assert left_out(drawn(0.0, "a")) == []


def test_an_addition_is_right_where_it_is_hidden():
    row = {"generator": "plain", "hides": ["row_noise"], "named": ["row_noise", "rts"],
           "additions": [["row_noise", 0.9], ["rts", 0.7], ["x", None]]}  # fmt: skip
    ordinary = {**row, "hides": []}
    assert additions([row, {"failed": "late"}]) == [
        ("plain", 0.9, True), ("plain", 0.7, False),
    ]  # fmt: skip
    assert not any(right for _, _, right in additions([ordinary]))
