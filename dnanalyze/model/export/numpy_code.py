"""A model as one Python file that needs NumPy alone: ``dark_frames(...)`` to paste in."""

from __future__ import annotations

from pathlib import Path

from dnanalyze.errors import InputError
from dnanalyze.model.channel_models import channels_of
from dnanalyze.model.effect import Effect
from dnanalyze.model.export.bundle import Bundle
from dnanalyze.model.learned.field_map import FieldMap
from dnanalyze.model.noise_model import NoiseModel, dump_model, model_from_plain

_MARK = "The model:\n"
_HEAD = '''\
"""Dark frames of a sensor, from a noise model fitted by dnanalyze {version}.

Needs NumPy alone. A frame is a pure function of its arguments: the same seed is the same sensor,
its fixed pattern the same at every temperature; another seed is another sensor of this make.

    frames = dark_frames(temperature_c=45.0, exposure_s=0.05, shape=(1080, 1920), frames=4, seed=1)

{mark}
{model}"""

from __future__ import annotations

'''
_TAIL = '''

MODEL = {model}


def dark_frames(
    temperature_c={temperature_c!r},
    exposure_s={exposure_s!r},
    gain={gain!r},
    channel={channel!r},
    *,
    shape=(512, 512),
    frames=1,
    first=0,
    seed=MODEL.seed,
):
    """Dark frames in DN, float32, of shape (frames, rows, columns).

    temperature_c in C, exposure_s in s, gain as a factor; ``seed`` names the virtual sensor,
    ``first`` is the number of the first frame: other frames of the same sensor have other noise.
    """
    from dataclasses import replace

    model = replace(MODEL, seed=seed)
    simulator = Simulator(model, tuple(shape))
    numbers = (None if v is None else float(v) + 0.0 for v in (temperature_c, exposure_s, gain))
    point = OperatingPoint(*numbers, channel)
    return np.stack([simulator.frame(point, first + n) for n in range(frames)])
'''


def numpy_source(model: NoiseModel) -> str:
    """Source of a module with ``dark_frames``, without dnanalyze and without SciPy.

    Draws the same frames as `simulate`, to float32 rounding. The filters of DPC and denoise are
    compiled by Numba where that is installed, and run as slow loops where it is not.

    Raises
    ------
    InputError
        An effect whose source is not at hand, or that leans on another package.
    """
    import dnanalyze

    bundle = Bundle()
    bundle.imports["import numpy as np"] = None
    for module, name in (
        ("dnanalyze.loaders.captures", "OperatingPoint"),
        ("dnanalyze.model.laws", "ArrheniusLaw"),
        ("dnanalyze.model.laws", "TableLaw"),
        ("dnanalyze.model.effect", "Effect"),
        ("dnanalyze.model.noise_model", "NoiseModel"),
        ("dnanalyze.model.simulator", "Simulator"),
    ):
        bundle.add(module, name)
    for effect in model.effects:
        if any(isinstance(getattr(effect, name), FieldMap) for name in effect.parameters()):
            raise InputError(
                f"effect {effect.name}: an exported function holds no map; simulate the frames, or "
                "export a model without it"
            )
        try:
            bundle.add(type(effect).__module__, type(effect).__name__)
        except InputError as error:
            raise InputError(f"effect {effect.name}: {error}") from None
    tail = _TAIL.format(model=_model(model), **_home(model))
    indented = "".join(f"    {line}\n" for line in dump_model(model).splitlines())
    head = _HEAD.format(version=dnanalyze.__version__, mark=_MARK, model=indented)
    return head + bundle.text() + tail


def read_source(path: Path, known: dict[str, type[Effect]] | None = None) -> NoiseModel:
    """The model that such a file was written from; nothing of it is run.

    Raises
    ------
    InputError
        Not a file of `numpy_source` or `torch_source`.
    """
    import ast
    import textwrap

    import yaml

    try:
        head = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
        _, mark, text = head.partition(_MARK)
        raw = yaml.safe_load(textwrap.dedent(text))
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from None
    except (SyntaxError, ValueError, yaml.YAMLError):
        mark, raw = "", None
    if not mark:
        raise InputError(f"{path}: not a Python file that `dnanalyze export` wrote")
    return model_from_plain(raw, str(path), known)


_TORCH = '''

class DarkNoise:
    """Adds dark noise of this sensor to images, as a transform of training data.

    DarkNoise(temperature_c=(25.0, 65.0))(image) takes a tensor (..., rows, columns) in DN and gives
    image + dark frame - pedestal, or the dark frame as it is with ``keep_pedestal``. A pair draws
    the temperature between its two ends, anew for each image. Each call draws another frame, by
    torch's own generator, so that its seed and its workers hold; ``sensors`` virtual sensors of
    this make take turns, so that a network does not learn one fixed pattern by heart.
    """

    def __init__(
        self,
        temperature_c={temperature_c!r},
        exposure_s={exposure_s!r},
        gain={gain!r},
        channel={channel!r},
        *,
        sensors=16,
        keep_pedestal=False,
    ):
        self.temperature_c, self.exposure_s, self.gain = temperature_c, exposure_s, gain
        self.channel, self.sensors, self.keep_pedestal = channel, sensors, keep_pedestal

    def __call__(self, image):
        """The image with noise, same shape, type and device."""
        import torch

        def draw(high):
            return int(torch.randint(high, (1,)))

        celsius = self.temperature_c
        if isinstance(celsius, (tuple, list)):
            celsius = celsius[0] + (celsius[1] - celsius[0]) * float(torch.rand(1))
        *before, rows, columns = image.shape
        count = int(np.prod(before)) if before else 1
        point = OperatingPoint(celsius, self.exposure_s, self.gain, self.channel)
        noise = dark_frames(
            celsius, self.exposure_s, self.gain, self.channel,
            shape=(rows, columns), frames=count, first=draw(2**20),
            seed=MODEL.seed + draw(self.sensors),
        )
        if not self.keep_pedestal:
            noise = noise - np.float32(laws_value_at(MODEL.pedestal, point))
        made = torch.from_numpy(noise).to(image.device).reshape(image.shape)
        return image + made.to(image.dtype) if image.is_floating_point() else image + made
'''


def torch_source(model: NoiseModel) -> str:
    """`numpy_source` with ``DarkNoise``, a transform that imports torch when it is called."""
    return numpy_source(model) + _TORCH.format(**_home(model))


def _home(model: NoiseModel) -> dict[str, object]:
    """Where frames are drawn by default: the reference, of the first channel where there are."""
    channel = next(iter(channels_of(model)), None)
    return vars(model.reference_of(channel)) | {"channel": channel}


def _model(model: NoiseModel) -> str:
    """The model as an expression."""
    effects = "".join(f"        {_effect(e)},\n" for e in model.effects)
    return (
        f"NoiseModel(\n    (\n{effects}    ),\n    {model.pedestal!r},\n"
        f"    {model.reference!r},\n    {model.seed!r},\n    {model.channel_references!r},\n)"
    )


def _effect(effect: Effect) -> str:
    values = ", ".join(f"{name}={getattr(effect, name)!r}" for name in effect.parameters())
    return f"{type(effect).__name__}({values})"
