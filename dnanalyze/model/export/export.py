"""A model in the form of another program, by the name of the form or the suffix of the file."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

from dnanalyze.errors import InputError
from dnanalyze.loaders.writers import atomic_write
from dnanalyze.model.noise_model import NoiseModel, dump_model

FORMATS = ("csv", "getframes", "json", "numpy", "pyxel", "torch", "yaml")
BY_SUFFIX = {".csv": "csv", ".json": "json", ".py": "numpy", ".toml": "getframes", ".yaml": "yaml"}
MAX_SIDE = 100_000  # rows or columns of another program's detector


@dataclass(frozen=True)
class Exported:
    """A model in another form.

    Parameters
    ----------
    text : str
        What the file holds.
    lost : tuple of str
        What the other program cannot express.
    """

    text: str
    lost: tuple[str, ...] = ()


def exported(
    model: NoiseModel,
    format: str,
    temperatures: Sequence[float] = (),
    shape: tuple[int, int] = (512, 512),
) -> Exported:
    """Return a model as text of another form; see `export` for the arguments."""
    from dnanalyze.model.export.getframes_camera import getframes_preset
    from dnanalyze.model.export.numpy_code import numpy_source, torch_source
    from dnanalyze.model.export.pyxel_pipeline import pyxel_pipeline
    from dnanalyze.model.export.table import to_csv, to_json

    plain: dict[str, Callable[[], str]] = {
        "csv": lambda: to_csv(model, temperatures),
        "json": lambda: to_json(model, temperatures),
        "numpy": lambda: numpy_source(model),
        "torch": lambda: torch_source(model),
        "yaml": lambda: dump_model(model),
    }
    if format in plain:
        return Exported(plain[format]())
    if format not in FORMATS:
        raise InputError(f"format {format}: valid: {', '.join(FORMATS)}; frames come from simulate")
    if len(temperatures) > 1:
        stated = ",".join(f"{t:g}" for t in temperatures)
        raise InputError(f"temperatures {stated}: {format} takes one temperature")
    if not all(1 <= n <= MAX_SIDE for n in shape):
        raise InputError(f"shape {shape[0]}x{shape[1]}: valid: 1 to {MAX_SIDE} rows and columns")
    translate = getframes_preset if format == "getframes" else pyxel_pipeline
    made = translate(model, shape, temperatures[0] if temperatures else None)
    return Exported(made.text, tuple(made.lost))


def export(
    model: NoiseModel,
    path: str | PathLike[str],
    *,
    format: str | None = None,
    temperatures: Sequence[float] = (),
    shape: tuple[int, int] = (512, 512),
) -> list[str]:
    """Write a model for those who do not run dnanalyze.

    Parameters
    ----------
    model : NoiseModel
        The model.
    path : str or PathLike
        File to write; an existing one is replaced.
    format : str, optional
        "csv" or "json": a table of the parameters over temperature; "numpy": a module with
        ``dark_frames``; "torch": the same with a transform; "getframes": a camera preset (TOML);
        "pyxel": a pipeline (YAML); "yaml": the model file. By default as the suffix says.
    temperatures : sequence of float
        C, at which a table states the parameters; for getframes and pyxel one, at which the dark
        current is stated. By default those of the model.
    shape : tuple of int
        (rows, columns) of the detector of getframes or pyxel.

    Returns
    -------
    list of str
        What the other program cannot express.

    Raises
    ------
    InputError
        Unknown format or suffix; an effect that cannot be exported; the file cannot be written.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import dnanalyze
    >>> model = dnanalyze.NoiseModel((dnanalyze.catalogue()["read_noise"](sigma=2.0),), 64.0)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = pathlib.Path(folder) / "dark_noise.py"
    ...     lost = dnanalyze.export(model, file)
    ...     "def dark_frames" in file.read_text()
    True
    """
    target = Path(path)
    name = format or BY_SUFFIX.get(target.suffix.lower())
    if name is None:
        raise InputError(f"{target}: no format has this suffix; valid: {', '.join(BY_SUFFIX)}")
    made = exported(model, name, temperatures, shape)
    atomic_write(target, made.text)
    return list(made.lost)
