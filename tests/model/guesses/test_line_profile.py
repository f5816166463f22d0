import numpy as np
import pytest

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.guesses.line_profile import line_profile, strip_profile

POINTS = (OperatingPoint(25.0, 1.0, 1.0), OperatingPoint(85.0, 1.0, 2.0))
OFFSETS = np.random.default_rng(1).standard_normal(200)
SCATTER = 20.0 * np.random.default_rng(2).standard_normal(200)


class Clues:
    """A quiet setting, and one at twice the gain whose dark current scatters."""

    points = POINTS
    reference = POINTS[0]

    def lines(self, axis, setting):
        means = OFFSETS if setting == 0 else 2.0 * OFFSETS + SCATTER
        return np.arange(7, 207), means

    def curve(self, name, setting):
        return 64.0 + np.tile(self.lines("columns", setting)[1], (3, 1))


def test_the_quiet_setting_weighs_more_and_offsets_follow_the_gain():
    places, offsets = line_profile(Clues(), "columns")
    assert places[0] == 7
    # of the inverse variances 1 and 1/(1 + 10^2) the noisy setting, of deviation 10, has 1 %
    assert np.std(offsets - OFFSETS) == pytest.approx(0.1, rel=0.5)


def test_strips_are_the_columns_of_the_blocks_less_their_level():
    offsets = strip_profile(Clues())
    assert abs(offsets.mean()) < 1e-9
    assert np.std(offsets - (OFFSETS - OFFSETS.mean())) < 0.2
