"""The devices that frames are drawn on in these tests: the CPU always, a GPU where there is one."""

import pytest
from host_device import COMPILER, HostDevice

from dnanalyze.errors import InputError
from dnanalyze.model.gpu.device import cuda


@pytest.fixture
def host_device():
    """The kernels as a C++ compiler makes them for this CPU."""
    if COMPILER is None:
        pytest.skip("no C++ compiler on this machine")
    return HostDevice()


@pytest.fixture
def cuda_device():
    """The GPU."""
    try:
        return cuda()
    except InputError as error:
        pytest.skip(str(error))


@pytest.fixture(params=["host", pytest.param("cuda", marks=pytest.mark.gpu)])
def device(request):
    """Either."""
    return request.getfixturevalue(f"{request.param}_device")
