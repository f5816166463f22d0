"""What a user without CuPy or a GPU is told; what CUDA's own compiler says of the source."""

import re
import shutil
import subprocess
import sys
import types
from pathlib import Path

import pytest
from dnanalyze_cli.main import main

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.gpu import device as gpu
from dnanalyze.model.gpu.render import Renderer
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import built_in
from dnanalyze.model.simulate import simulate, simulate_frames

PAGE = Path(__file__).resolve().parents[3] / "docs" / "gpu.md"
POINT = OperatingPoint(45.0, 0.1, 1.0)


@pytest.fixture
def without_cupy(monkeypatch):
    monkeypatch.setitem(sys.modules, "cupy", None)  # as where it is not installed
    gpu.cuda.cache_clear()
    yield
    gpu.cuda.cache_clear()


def model(*names):
    known = built_in()
    return NoiseModel(tuple(known[n]() for n in names), 64.0)


def test_without_cupy_the_remedy_is_named(without_cupy):
    with pytest.raises(InputError, match="pip install cupy-cuda12x"):
        simulate(model("read_noise"), (4, 4), [(POINT, 1)], device="cuda")
    with pytest.raises(InputError, match="use device cpu"):
        simulate_frames(model("read_noise"), (4, 4), POINT, range(2), device="cuda")


def test_other_devices_are_unknown():
    with pytest.raises(InputError, match="'tpu': unknown; valid: cpu, cuda"):
        simulate(model("read_noise"), (4, 4), [(POINT, 1)], device="tpu")


@pytest.mark.parametrize(
    ("count", "said"),
    [(lambda: 0, "finds no CUDA device"), (lambda: 1 / 0, "division by zero; use device cpu")],
)
def test_without_a_gpu_the_reason_is_given(without_cupy, monkeypatch, count, said):
    cupy = types.ModuleType("cupy")
    runtime = types.SimpleNamespace(getDeviceCount=count)
    nvrtc = types.SimpleNamespace(getVersion=lambda: (12, 0))
    cupy.cuda = types.SimpleNamespace(runtime=runtime, nvrtc=nvrtc)
    monkeypatch.setitem(sys.modules, "cupy", cupy)
    with pytest.raises(InputError, match=said):
        gpu.named("cuda")


def test_the_command_exits_with_2_and_makes_nothing(without_cupy, tmp_path, capsys):
    path, out = tmp_path / "m.yaml", tmp_path / "out"
    path.write_text("effects: [read_noise]\n")
    assert main(["simulate", str(out), "--model", str(path), "--device", "cuda", "-q"]) == 2
    told = capsys.readouterr().err.strip()
    assert len(told.splitlines()) == 1
    assert "device cuda: CuPy is not installed" in told
    assert not out.exists()


def test_cudas_compiler_takes_the_source(host_device, tmp_path):
    nvcc = shutil.which("nvcc")
    if nvcc is None:
        pytest.skip("no nvcc on this machine")
    names = [n for n in built_in() if n not in host_effects()]
    Renderer(model(*names), (8, 12), host_device, 16).frames(POINT, [0])
    code = tmp_path / "pass.cu"
    code.write_text(host_device.programs[0])
    asked = ["-arch=sm_90", "-cubin", "-Xptxas", "-v", "-o", "pass.cubin"]
    done = subprocess.run(
        [nvcc, *gpu.OPTIONS, *asked, str(code)], cwd=tmp_path, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    spills = re.findall(r"(\d+) bytes spill", done.stderr)
    assert spills
    assert set(spills) == {"0"}


def host_effects():
    """Effects that the page says are drawn on the host, with all before them."""
    return listed("On the host, with all effects before it")


def listed(row):
    (line,) = [x for x in PAGE.read_text().splitlines() if x.startswith(f"| {row} |")]
    return set(re.findall(r"`(\w+)`", line))


def test_the_page_says_where_each_effect_is_drawn(host_device, monkeypatch):
    monkeypatch.setattr("dnanalyze.model.gpu.render.BATCHED_BYTES", 0)
    monkeypatch.setattr(host_device, "program", lambda source: None)
    monkeypatch.setattr(host_device, "launch", lambda *arguments: None)
    shape, on_host, by_field = (64, 96), set(), set()
    for name in built_in():
        sent = []
        monkeypatch.setattr(host_device, "upload", lambda a, sent=sent: sent.append(a) or a.copy())
        renderer = Renderer(model(name), shape, host_device, 16)
        renderer.frames(POINT, [0])
        sent.clear()
        renderer.frames(POINT, [1])
        if renderer._on_host:
            on_host.add(name)
        elif any(a.nbytes >= shape[0] * shape[1] for a in sent):
            by_field.add(name)
    assert on_host == host_effects()
    assert by_field == listed("On the host, one field per frame")
