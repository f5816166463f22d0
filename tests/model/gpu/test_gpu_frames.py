"""Frames of the kernels are the CPU's, on every device at hand."""

import numpy as np
import pytest

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import OperatingPoint, Window
from dnanalyze.model.effect import Effect, Stage
from dnanalyze.model.gpu.render import Renderer
from dnanalyze.model.memo import Memo
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import built_in
from dnanalyze.model.simulate import simulate, simulate_frames
from dnanalyze.model.simulator import Simulator

SHAPE = (37, 61)
POINT = OperatingPoint(45.0, 0.1, 1.0)
ON_HOST = {
    "denoise", "dpc", "electron_multiplication", "missing_codes", "persistence",
    "temporal_denoise", "transfer_tails",
}  # fmt: skip
TEN = (
    "convolved_lognormal", "dark_shot_noise", "hot_pixels", "pixel_fpn", "crosstalk",
    "read_noise", "row_noise", "column_fpn", "rts", "quantization",
)  # fmt: skip
PAPER = {"convolved_lognormal": {"mu": 3.0, "sigma": 0.1}}
MODELS = {
    "paper": PAPER,
    "benchmark": {name: {} for name in TEN},
    "spread that falls as it warms": {
        "convolved_lognormal": {
            "mu": 3.0, "delta": {"value": 0.5, "at_c": 25.0, "ea_ev": -0.3}, "seed": "redrawn"
        }
    },
    "redrawn": {"convolved_lognormal": {"mu": 3.0, "phi": 0.05, "sigma": 0.1, "seed": "redrawn"}},
    "everything with a kernel": {
        name: {} for name in built_in() if name not in ON_HOST
    } | PAPER | {
        "rts": {"fraction": 0.2, "dwell_frames": 3.0},
        "crosstalk": {"alpha": 0.04},
        "read_noise": {"spread": 0.3},
        "column_fpn": {"rho": 0.4},
        "quantization": {"bits": 12, "step": 2},
        "stuck_pixels": {"fraction": 0.02, "code": 90.0, "codes": "any"},
    },
    "blinks about the mean": {
        "rts": {"fraction": 0.3, "polarity": "centred", "occupancies": "spread"}
    },
    "blinks on three levels": {"rts": {"fraction": 0.3, "polarity": "three"}, "read_noise": {}},
    "filtered on the host": PAPER | {
        "read_noise": {}, "dpc": {}, "temporal_denoise": {}, "digital_gain": {"gain": 1.5}
    },
    "serial noise, scaled gradient, gain with a top": PAPER | {
        "read_noise": {"serial": -0.2, "spread": 0.2},
        "dark_gradient": {"x": 0.1, "form": "scaled"},
        "digital_gain": {"gain": 1.25, "offset": 64.0, "top": 110.0},
    },
    "settling columns, waiting rows, slipping taps, shares of the signal": PAPER | {
        "column_fpn": {"settle": 9.0, "length": 12.0, "first": "right"},
        "row_fpn": {},
        "column_taps": {"taps": 3, "levels": (2.0, -1.0, -1.0), "slip": 1.0},
        "dark_gradient": {"x": 2.0, "xy": 3.0, "wait": 6.0},
        "flicker_fpn": {"rms": 0.1, "form": "scaled"},
        "offset_drift": {"step": 0.02, "form": "scaled"},
    },
    "Student's t": {"heavy_tailed_read_noise": {"form": "student", "freedom": 3.0}},
    "hot pixels of a power law": PAPER | {"hot_pixels": {"law": "power", "tail": 0.8}},
    "hot pixels alike": PAPER | {"hot_pixels": {"law": "narrow", "width": 0.2}},
    "white offsets": PAPER | {"offset_drift": {"white": 2.0}},
    "two chains of 1/f noise": PAPER | {"flicker_noise": {"chains": 2, "cutoff": 0.02}},
    "settling strips of rows": PAPER | {
        "column_taps": {
            "kind": "blocks", "levels": (2.0, -1.0, 0.0), "begins": (9.0, 20.0), "axis": "rows",
            "settle": 0.5, "side": "both",
        },
    },
    "fades on the host": PAPER | {"persistence": {}, "dark_shot_noise": {}},
    "codes on the host": PAPER | {"missing_codes": {}, "black_clipping": {}},
}  # fmt: skip


def model_of(effects, pedestal=64.0):
    known = built_in()
    return NoiseModel(
        tuple(known[name].from_plain(values) for name, values in effects.items()), pedestal, seed=7
    )


def on_cpu(model, numbers, bits=16):
    return np.stack(list(simulate_frames(model, SHAPE, POINT, numbers, threads=1, bits=bits)))


def off_by(frames, expected):
    """Share of the pixels that differ; none may by more than one code."""
    assert frames.dtype == expected.dtype
    assert frames.shape == expected.shape
    difference = np.abs(frames.astype(np.int64) - expected)
    assert difference.max() <= 1
    return np.mean(difference > 0)


@pytest.mark.parametrize("name", MODELS)
def test_frames_are_those_of_the_cpu(device, name):
    model = model_of(MODELS[name])
    numbers = [0, 1, 2, 11, 5]
    renderer = Renderer(model, SHAPE, device, 16)
    frames = device.host(renderer.frames(POINT, numbers))
    expected = on_cpu(model, numbers)
    assert off_by(frames, expected) == 0
    assert len(np.unique(expected)) > 3
    assert bool(renderer._on_host) == ("on the host" in name)
    assert (expected[0] != expected[-1]).any()
    # again, with what the first batch left behind
    assert off_by(device.host(renderer.frames(POINT, [3, 4])), on_cpu(model, [3, 4])) == 0


@pytest.mark.parametrize("bits", [8, 12])
def test_codes_have_the_bits_asked_for(device, bits):
    model = model_of({"read_noise": {"sigma": 300.0}}, pedestal=100.0)
    frames = device.host(Renderer(model, SHAPE, device, bits).frames(POINT, range(2)))
    expected = on_cpu(model, range(2), bits)
    assert off_by(frames, expected) == 0
    assert frames.min() == 0
    assert frames.max() == min(2**bits - 1, expected.max())


def test_values_before_rounding_are_the_same(device):
    model = model_of(MODELS["everything with a kernel"])
    values = Renderer(model, SHAPE, device).host(POINT, 3)
    expected = Simulator(model, SHAPE, Memo()).frame(POINT, 3)
    assert values.dtype == np.float32
    assert np.array_equal(values, expected)


def test_frames_of_one_model_share_a_kernel(host_device):
    model = model_of(MODELS["everything with a kernel"])
    renderer = Renderer(model, SHAPE, host_device, 16)
    renderer.frames(POINT, range(3))
    renderer.frames(OperatingPoint(65.0, 0.2, 2.0), range(3))
    assert len(host_device.programs) == 1


def test_fixed_fields_go_to_the_device_once(host_device, monkeypatch):
    monkeypatch.setattr("dnanalyze.model.gpu.render.BATCHED_BYTES", 1024)
    sent = []
    upload = host_device.upload
    monkeypatch.setattr(host_device, "upload", lambda a: sent.append(a.nbytes) or upload(a))
    fixed = ("hot_pixels", "pixel_fpn", "dark_gradient", "stuck_pixels", "flicker_fpn", "amp_glow")
    model = model_of(PAPER | {name: {} for name in fixed})
    renderer = Renderer(model, SHAPE, host_device, 16)
    renderer.frames(POINT, range(4))
    # mean and norm of the seed, a map of each effect
    assert [n for n in sent if n >= 4 * SHAPE[0] * SHAPE[1]] == 8 * [4 * SHAPE[0] * SHAPE[1]]
    sent.clear()
    renderer.frames(POINT, range(4, 8))
    assert max(sent) < SHAPE[0] * SHAPE[1]


def test_a_stream_is_drawn_by_batches_in_order(device):
    model = model_of(PAPER)
    renderer = Renderer(model, SHAPE, device, 16)
    frames = np.stack([device.host(f) for f in renderer.stream(POINT, range(7), 3)])
    assert off_by(frames, on_cpu(model, range(7))) == 0
    assert list(renderer.stream(POINT, [], 3)) == []


@pytest.fixture
def as_cuda(host_device, monkeypatch):
    monkeypatch.setattr("dnanalyze.model.gpu.device.cuda", lambda: host_device)
    return host_device


def test_a_capture_set_is_drawn_on_the_device(as_cuda):
    model = model_of(PAPER | {"read_noise": {}})
    settings = [(POINT, 2), (OperatingPoint(65.0, 0.1, 1.0), 1)]
    drawn = simulate(model, SHAPE, settings, device="cuda")
    expected = simulate(model, SHAPE, settings)
    assert as_cuda.programs == []
    for one, other in zip(drawn.settings, expected.settings, strict=True):
        for a, b in zip(one.frames, other.frames, strict=True):
            assert np.array_equal(a.read(), b.read())
    assert len(as_cuda.programs) == 1
    frame = drawn.settings[0].frames[0]
    whole = frame.read()
    part = frame.read(Window(3, 20, 5, 40))
    assert np.array_equal(part, whole[3:20, 5:40])
    part[:] = 0
    assert np.array_equal(frame.read(), whole)


def test_simulate_frames_leaves_them_on_the_device(as_cuda):
    model = model_of(PAPER)
    frames = list(simulate_frames(model, SHAPE, POINT, range(3), device="cuda", batch=2))
    assert off_by(np.stack(frames), on_cpu(model, range(3))) == 0
    assert len(as_cuda.programs) == 1


class Wild(Effect):
    """Does what no tape can note, after what one can."""

    name, stage = "wild", Stage.PIXEL_READ

    def apply(self, signal, site):
        signal += site.normal()
        signal[::2] *= 2
        return signal


class Broken(Effect):
    """Fails wherever it runs."""

    name, stage = "broken", Stage.PIXEL_READ

    def apply(self, signal, site):
        raise InputError("broken: by design")


def test_a_users_effect_needs_no_kernel(device):
    model = model_of({"read_noise": {}, "row_noise": {}, "black_clipping": {"level": 63.0}})
    model = model.with_effect(Wild())
    frames = device.host(Renderer(model, SHAPE, device, 16).frames(POINT, range(3)))
    assert off_by(frames, on_cpu(model, range(3))) == 0


def test_what_an_effect_raises_is_seen(host_device):
    model = model_of({"read_noise": {}}).with_effect(Broken())
    with pytest.raises(InputError, match="by design"):
        Renderer(model, SHAPE, host_device, 16).frames(POINT, [0])
