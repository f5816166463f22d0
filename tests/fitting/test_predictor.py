"""What is predicted of one half and of both."""

import numpy as np
import pytest
import small_series as small

BAYER = (("R", "G"), ("G", "B"))


@pytest.mark.parametrize("cfa", [None, BAYER])
def test_the_fitted_half_alone_is_what_it_is_beside_the_other(cfa):
    here, other = small.bench_of(cfa), small.model(read_noise={"sigma": 2.5})
    both, _ = here.coordinates(other)
    alone = here.fitted_coordinates(other)
    np.testing.assert_array_equal(alone, both)
    assert np.isfinite(alone).mean() > 0.9
    np.testing.assert_array_equal(here.fitted_z(other), here.z(other)[0])
    shaded = [k.name.startswith("shading_") for k in here.train.keys]
    assert np.isfinite(alone[shaded]).all()
    assert sum(shaded) > 0
