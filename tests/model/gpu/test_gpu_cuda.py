"""What only a GPU can show; the frames' own tests run on it too, with `pytest -m gpu`."""

import numpy as np
import pytest

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import built_in
from dnanalyze.model.simulate import simulate_frames

pytestmark = pytest.mark.gpu
POINT = OperatingPoint(45.0, 0.1, 1.0)
SHAPE = (1080, 1920)


@pytest.fixture
def model(cuda_device):
    effects = ("convolved_lognormal", "dark_shot_noise", "crosstalk", "read_noise", "rts")
    known = built_in()
    return NoiseModel(tuple(known[name]() for name in effects), 64.0, seed=3)


def test_large_frames_are_those_of_the_cpu(model):
    drawn = simulate_frames(model, SHAPE, POINT, range(6), device="cuda", batch=4)
    for frame, expected in zip(drawn, simulate_frames(model, SHAPE, POINT, range(6)), strict=True):
        difference = np.abs(frame.get().astype(int) - expected)
        assert difference.max() <= 1
        assert np.mean(difference > 0) <= 1e-5


def test_torch_takes_the_frames_as_they_lie(model):
    torch = pytest.importorskip("torch", reason="PyTorch is not installed")
    if not hasattr(torch, "uint16"):
        pytest.skip("this PyTorch has no uint16; 2.3 has")
    (frame,) = simulate_frames(model, SHAPE, POINT, [2], device="cuda")
    tensor = torch.from_dlpack(frame)
    assert tensor.data_ptr() == frame.data.ptr
    assert tensor.is_cuda
    assert np.array_equal(tensor.cpu().numpy(), frame.get())


def test_batches_do_not_overwrite_one_another(model):
    frames = list(simulate_frames(model, SHAPE, POINT, range(12), device="cuda", batch=2))
    again = list(simulate_frames(model, SHAPE, POINT, range(12), device="cuda", batch=5))
    for one, other in zip(frames, again, strict=True):
        assert np.array_equal(one.get(), other.get())
