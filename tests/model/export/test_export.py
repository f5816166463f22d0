"""A model given away: tables that read back, a NumPy file that draws the same frames."""

from __future__ import annotations

import importlib
import importlib.util
import subprocess
import sys
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import OperatingPoint, Window
from dnanalyze.model import draws
from dnanalyze.model.export import numpy_draws
from dnanalyze.model.export.numpy_code import numpy_source, read_source, torch_source
from dnanalyze.model.export.table import read_table, rows, to_csv, to_json
from dnanalyze.model.laws import ArrheniusLaw, TableLaw
from dnanalyze.model.noise_model import NoiseModel, dump_model
from dnanalyze.model.registry import built_in
from dnanalyze.model.simulator import Simulator

P = OperatingPoint
EFFECTS = built_in()
POINTS = (P(25.0, channel="hcg"), P(65.0, channel="hcg"), P(25.0, channel="lcg"))
MODEL = NoiseModel(
    (
        EFFECTS["convolved_lognormal"](
            mu=TableLaw((P(25.0), P(45.0), P(65.0)), (1.0, 2.5, 4.2)),
            delta=ArrheniusLaw(0.4, 45.0, -0.3),
        ),
        EFFECTS["dark_shot_noise"](dn_per_e=TableLaw(POINTS, (0.8, 0.8, 0.2))),
        EFFECTS["read_noise"](sigma=1.4),
        EFFECTS["hot_pixels"](scale=ArrheniusLaw(20.0, 45.0, 0.55)),
        EFFECTS["column_fpn"](sigma=0.6, rho=0.3),
        EFFECTS["quantization"](),
    ),
    64.25,
    P(45.0, 0.05, 1.0),
    seed=11,
)
SLOW = {"denoise", "dpc"}


def loaded(source: str) -> ModuleType:
    module = ModuleType("exported")
    sys.modules["exported"] = module
    exec(compile(source, "exported.py", "exec"), module.__dict__)
    return module


@pytest.mark.parametrize(("ending", "write"), [("csv", to_csv), ("json", to_json)])
@pytest.mark.parametrize("temperatures", [(), (10.0, 30.0)])
def test_a_table_reads_back_as_the_same_model(ending, write, temperatures, tmp_path):
    path = tmp_path / f"M.{ending}"
    path.write_text(write(MODEL, temperatures))
    assert read_table(path) == MODEL


def test_a_table_states_each_parameter_at_each_point():
    made = {(r["parameter"], r["temperature_c"], r["channel"]): r["value"] for r in rows(MODEL)}
    assert made["mu", 65.0, "hcg"] == 4.2
    assert made["dn_per_e", 25.0, "lcg"] == 0.2
    hot = {
        r["temperature_c"]: r["value"]
        for r in rows(MODEL, [45.0, 65.0])
        if r["parameter"] == "scale"
    }
    assert hot[45.0] == pytest.approx(20.0)
    # exp(-.55 / k (1/338.15 - 1/318.15)), k = 8.617333e-5 eV/K
    assert hot[65.0] == pytest.approx(
        20.0 * np.exp(-0.55 / 8.617333e-5 * (1 / 338.15 - 1 / 318.15))
    )


def test_bad_tables_are_refused_in_one_line(tmp_path):
    for name, text, words in (
        ("a.csv", "x,y\n1,2\n", "its columns are effect, parameter"),
        ("a.json", "{}", "not a table of parameters"),
        ("b.json", "no", "not JSON"),
        (
            "b.csv",
            to_csv(MODEL).replace('"order"', '"ordr"').replace(",order,", ",ordr,"),
            "was the table cut",
        ),
    ):
        (tmp_path / name).write_text(text)
        with pytest.raises(InputError, match=words):
            read_table(tmp_path / name)


def test_numpy_draws_are_those_of_the_kernels():
    window = Window(3, 67, 5, 69)
    assert np.array_equal(numpy_draws.words(7, window, 100), draws.bits(7, window, 100))
    assert np.array_equal(numpy_draws.uniform(7, window, 100), draws.uniform(7, window, 100))
    # float32 polynomial against float64: 2e-6 is what the kernel promises
    gap = numpy_draws.normal(7, window, 100) - draws.normal(7, window, 100)
    assert np.abs(gap).max() < 4e-6
    for level in (0.3, 4.0, 9.9, 10.1, 300.0):
        signal = np.full(window.shape, level, np.float32)
        ours = numpy_draws.counts(signal.copy(), 1.0, 9, window, 100)
        theirs = draws.counts(signal.copy(), 1.0, 9, window, 100)
        assert np.mean(ours != theirs) < 2e-3  # a quantile at a rounding edge
        assert np.abs(ours - theirs).max() <= 1
    ours = numpy_draws.lognormal(7, 1.0, 0.5, 0.01, window, 100)
    theirs = draws.lognormal(7, 1.0, 0.5, 0.01, window, 100)
    for a, b in zip(ours, theirs, strict=True):
        assert np.allclose(a, b, rtol=2e-5)


def test_the_exported_function_draws_the_frames_of_simulate():
    exported = loaded(numpy_source(MODEL))
    for point in (P(45.0, 0.05, 1.0, "hcg"), P(65.0, 0.2, 2.0, "lcg")):
        frames = exported.dark_frames(*vars(point).values(), shape=(96, 80), frames=2, seed=5)
        simulator = Simulator(
            NoiseModel(MODEL.effects, MODEL.pedestal, MODEL.reference, 5), (96, 80)
        )
        own = np.stack([simulator.frame(point, n) for n in range(2)])
        # codes; a pixel at a rounding edge may fall to the other side
        assert np.mean(frames != own) < 5e-3
        assert frames.mean() == pytest.approx(own.mean(), rel=1e-4)
        assert frames.std() == pytest.approx(own.std(), rel=1e-3)


def test_equal_points_have_equal_noise_however_they_are_typed():
    draw = loaded(numpy_source(MODEL)).dark_frames
    np.testing.assert_array_equal(
        draw(45, 1, 1, "hcg", shape=(24, 32), frames=2),
        draw(45.0, 1.0, 1.0, "hcg", shape=(24, 32), frames=2),
    )


def test_numpy_has_every_function_that_an_effect_calls():
    for name in EFFECTS:
        compile(numpy_source(NoiseModel((EFFECTS[name](),), 64.0)), name, "exec")  # or it raises


@pytest.mark.long
@pytest.mark.parametrize("name", sorted(EFFECTS))
def test_every_effect_has_a_numpy_form(name):
    others = [EFFECTS[n]() for n in ("convolved_lognormal", "read_noise") if n != name]
    model = NoiseModel((*others, EFFECTS[name]()), 64.0, P(25.0, 1.0, 1.0), 3)
    exported = loaded(numpy_source(model))
    shape = (24, 32) if name in SLOW else (48, 40)
    frames = exported.dark_frames(45.0, 1.0, 1.0, shape=shape, frames=2)
    simulator = Simulator(model, shape)
    own = np.stack([simulator.frame(P(45.0, 1.0, 1.0), n) for n in range(2)])
    assert np.mean(np.abs(frames - own) > 2e-3 * np.abs(own)) < 5e-3


@pytest.mark.parametrize("write", [numpy_source, torch_source])
def test_exported_code_reads_back_as_the_same_model(write, tmp_path):
    path = tmp_path / "sensor.py"
    path.write_text(write(MODEL))
    assert read_source(path) == MODEL
    for text in ("import os\n", '"""The model:\n\n    a: [\n"""\n', "def (", "\0"):
        path.write_text(text)
        with pytest.raises(InputError, match=r"sensor\.py: not a Python file that"):
            read_source(path)


def test_the_file_needs_numpy_alone(tmp_path):
    (tmp_path / "sensor.py").write_text(numpy_source(MODEL))
    code = (
        "import sys\n"
        "for name in ('dnanalyze', 'scipy', 'numba', 'torch'): sys.modules[name] = None\n"
        "import sensor, numpy\n"
        "a = sensor.dark_frames(65.0, shape=(32, 32), frames=2)\n"
        "assert a.shape == (2, 32, 32) and numpy.isfinite(a).all() and (a[0] != a[1]).any()\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr


class FakeTensor:
    """As much of a torch tensor as the transform uses."""

    def __init__(self, values):
        self.values, self.shape = np.asarray(values), np.asarray(values).shape
        self.device, self.dtype = "cpu", np.float32

    def to(self, *_):
        return self

    def reshape(self, shape):
        return FakeTensor(self.values.reshape(shape))

    def __array__(self, dtype=None, copy=None):
        return self.values

    def is_floating_point(self):
        return True

    def __add__(self, other):
        return FakeTensor(self.values + other.values)


def test_the_torch_transform_adds_noise_of_the_sensor(monkeypatch):
    exported = loaded(torch_source(MODEL))
    values = np.full((2, 3, 48, 48), 100.0, np.float32)
    if importlib.util.find_spec("torch"):
        image = importlib.import_module("torch").from_numpy(values)
    else:
        rng = np.random.default_rng(1)
        torch = SimpleNamespace(
            randint=lambda high, size: rng.integers(high),
            rand=lambda n: rng.random(),
            from_numpy=FakeTensor,
        )
        monkeypatch.setitem(sys.modules, "torch", torch)
        image = FakeTensor(values)
    noisy = exported.DarkNoise(45.0)(image)
    assert noisy.shape == (2, 3, 48, 48)
    dark = exported.dark_frames(45.0, shape=(48, 48), frames=4)
    added = np.asarray(noisy) - 100.0
    # mean and spread of the sensor; patterns of 48 x 48 pixels differ by a few percent
    assert added.mean() == pytest.approx(dark.mean() - 64.25, rel=0.1)
    assert added.std() == pytest.approx(dark.std(), rel=0.25)
    again = exported.DarkNoise((25.0, 65.0))(image)
    assert (np.asarray(again) != np.asarray(noisy)).any()


def test_an_effect_without_source_is_named():
    class Own(EFFECTS["read_noise"]):
        name = "own"

    Own.__module__ = "dnanalyze_user_nowhere"
    with pytest.raises(InputError, match=r"effect own: .*simulate"):
        numpy_source(NoiseModel((Own(),), 64.0))


def test_the_command(tmp_path, capsys):
    from dnanalyze_cli.main import main

    (tmp_path / "M.yaml").write_text(dump_model(MODEL))
    for form, ending in (("csv", "csv"), ("json", "json"), ("numpy", "py"), ("torch", "py")):
        out = tmp_path / f"{form}.{ending}"
        assert (
            main(["export", str(tmp_path / "M.yaml"), "--format", form, "-o", str(out), "-q"]) == 0
        )
        assert out.stat().st_size > 500
    back = tmp_path / "back.yaml"
    for name in ("csv.csv", "json.json", "numpy.py", "torch.py"):
        again = ["export", str(tmp_path / name), "--format", "yaml", "-o", str(back), "-q"]
        assert main(again) == 0
        assert back.read_text() == (tmp_path / "M.yaml").read_text()
    assert main(["export", str(back), "--format", "xlsx", "-o", str(tmp_path / "x")]) == 2
    assert "valid: csv, getframes, json, numpy, pyxel, torch, yaml" in capsys.readouterr().err


@pytest.mark.parametrize("shape", [0.25, 1.0, 25.0, 1e4, 1e6])
def test_quantiles_of_the_gamma_distribution_are_those_of_scipy(shape):
    from scipy import special

    from dnanalyze.model.export.numpy_special import gammaincinv

    p = special.ndtr(np.linspace(-4.0, 4.0, 41))
    expected = special.gammaincinv(shape, p)
    np.testing.assert_allclose(gammaincinv(shape, p), expected, rtol=1e-5, atol=1e-5 * shape**0.5)
