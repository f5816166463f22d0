"""Shared by all tests: where the sample captures lie, when they are there."""

import os
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

# no test depends on how busy the machine is
settings.register_profile("untimed", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("untimed")

# pytest-xdist runs one process a core: a linear algebra library of its own threads in each of them
# would only wait for the others. NumPy, imported after this file, reads it.
for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(variable, "1")


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """Each process takes neighbouring tests, so that few fixtures of a module are made twice."""
    if config.getoption("dist") != "load":  # another one was asked for
        return None
    from xdist.scheduler import WorkStealingScheduling

    return WorkStealingScheduling(config, log)


CAPTURES = Path(__file__).resolve().parents[2] / "shared" / "captures"


@pytest.fixture(autouse=True, scope="session")
def own_cache(tmp_path_factory):
    """Tests keep statistics in a folder of their own."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("DNANALYZE_CACHE", str(tmp_path_factory.mktemp("cache")))
        yield


@pytest.fixture(scope="session")
def captures_root() -> Path:
    """Folder of the sample captures; skips where it is absent."""
    if not CAPTURES.is_dir():
        pytest.skip("the sample captures are not on this machine")
    return CAPTURES
