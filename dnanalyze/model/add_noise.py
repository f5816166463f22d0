"""Dark noise of a model on images of a scene."""

from __future__ import annotations

import numpy as np

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.laws import value_at
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.simulate import simulate


def add_dark_noise(
    image: np.ndarray,
    model: NoiseModel,
    point: OperatingPoint,
    *,
    seed: int = 0,
    keep_pedestal: bool = False,
) -> np.ndarray:
    """Add the dark signal and its noise to an image, or to several.

    Several images in one call share the fixed pattern of the sensor, which each call draws anew.

    Parameters
    ----------
    image : ndarray
        (rows, columns), or (images, rows, columns): linear sensor values in DN, without the black
        level. They hold their own shot noise already: the model is of the dark.
    model : NoiseModel
        Its seed selects the sensor, whose fixed pattern is the same in every image.
    point : OperatingPoint
        Temperature, exposure and gain.
    seed : int
        Number of the first image: the temporal noise of an image follows from it.
    keep_pedestal : bool
        Leave the black level of the model in the result.

    Returns
    -------
    ndarray of float32
        As the image, DN, neither rounded nor clipped.

    Raises
    ------
    InputError
        An image of another number of axes, or of no real numbers; a seed below 0.

    Examples
    --------
    >>> import numpy as np
    >>> import dnanalyze
    >>> from dnanalyze import NoiseModel, OperatingPoint
    >>> model = NoiseModel((dnanalyze.catalogue()["read_noise"](sigma=2.0),), pedestal=64.0)
    >>> scene = np.full((64, 64), 100.0, np.float32)
    >>> noisy = dnanalyze.add_dark_noise(scene, model, OperatingPoint(85.0, 1 / 30), seed=7)
    >>> bool(abs(noisy.mean() - 100.0) < 0.2)
    True
    """
    values = np.asarray(image)
    if values.ndim not in (2, 3) or values.dtype.kind not in "uif":
        raise InputError(
            f"image: has {values.ndim} axes of {values.dtype}; valid: 2 or 3 axes of integers or "
            "floats"
        )
    if seed < 0:
        raise InputError(f"seed {seed}: valid: 0 or more")
    stack = values if values.ndim == 3 else values[None]
    captures = simulate(model, stack.shape[1:], [(point, seed + len(stack))])
    frames = captures.settings[0].frames[seed:]
    level = 0.0 if keep_pedestal else model.unit * value_at(model.pedestal, point)
    made = np.empty(stack.shape, np.float32)
    for number, (scene, frame) in enumerate(zip(stack, frames, strict=True)):
        np.add(scene, frame.read() - np.float32(level), out=made[number], casting="unsafe")
    return made.reshape(values.shape)
