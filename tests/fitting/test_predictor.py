"""What is predicted of one half and of both."""

import numpy as np
import pytest
import small_series as small

BAYER = (("R", "G"), ("G", "B"))


@pytest.mark.parametrize("cfa", [None, BAYER])
def test_either_half_alone_is_what_it_is_beside_the_other(cfa):
    here, other = small.bench_of(cfa), small.model(read_noise={"sigma": 2.5})
    both = here.coordinates(other)
    np.testing.assert_array_equal(here.fitted_coordinates(other), both[0])
    np.testing.assert_array_equal(here.fitted_z(other), here.train.z(both[0]))
    np.testing.assert_array_equal(here.judged_z(other), here.test.z(both[1]))
    for half, seen in zip((here.train, here.test), both, strict=True):
        assert np.isfinite(seen).mean() > 0.9
        shaded = [k.name.startswith("shading_") for k in half.keys]
        assert np.isfinite(seen[shaded]).all()
        assert sum(shaded) > 0
