"""Colour images whose channels are all the same: a grey frame that some program has processed."""

from __future__ import annotations

import numpy as np

from dnanalyze.errors import InputError

PROCESSED = (
    "The files are colour pictures whose channels are all the same: processed pictures, not raw "
    "frames. One channel is read; what its noise shows may be the processing."
)


def check_grey(name: str, array: np.ndarray) -> None:
    """Refuse an image whose colour channels differ.

    Parameters
    ----------
    name : str
        For the message.
    array : ndarray, (rows, columns, 3 or 4)
        A fourth channel is opacity, and may be anything.

    Raises
    ------
    InputError
        They differ.
    """
    red, green, blue = (array[..., k] for k in range(3))
    if not (np.array_equal(red, green) and np.array_equal(red, blue)):
        raise InputError(
            f"{name}: is a colour image whose channels differ; give raw frames, one value a pixel"
        )
