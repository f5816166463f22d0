"""How the fixed pattern of one frame lies to that of others: shifted, rolled or flipped."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

# Root mean squares of the correlation: the largest of 4 x 10^7 normal values is 5.7
CORRELATION_SCALES = 8.0
CAP = 6.0  # robust sigmas
MAX_PIXELS = 1 << 24  # pixels


@dataclass(frozen=True)
class Move:
    """Flipped or not, then moved by so many rows and columns."""

    upside_down: bool
    mirrored: bool
    rows: int
    columns: int

    def words(self) -> str:
        """Such as "shifted by 1 column"."""
        said = []
        if self.upside_down and self.mirrored:
            said.append("turned by 180 degrees")
        elif self.upside_down or self.mirrored:
            said.append("flipped top to bottom" if self.upside_down else "flipped left to right")
        by = [
            f"{abs(n)} {name}{'s' if abs(n) > 1 else ''}"
            for n, name in ((self.rows, "row"), (self.columns, "column"))
            if n
        ]
        if by:
            said.append("shifted by " + " and ".join(by))
        return " and ".join(said)


def find_move(frame: np.ndarray, other: np.ndarray) -> Move | None:
    """The move that makes ``frame`` of ``other``, both (rows, columns); None where there is none.

    The peak of the circular cross-correlation of the fine patterns, for each of the four
    orientations that leave rows rows.
    """
    if frame.size > MAX_PIXELS:
        return None
    target = np.fft.rfft2(_fine(frame))
    best: tuple[float, Move] | None = None
    for upside_down in (False, True):
        for mirrored in (False, True):
            turned = other[:: -1 if upside_down else 1, :: -1 if mirrored else 1]
            product = np.fft.irfft2(target * np.conj(np.fft.rfft2(_fine(turned))), frame.shape)
            height = float(product.max() / np.sqrt(np.mean(product**2)))
            if best is None or height > best[0]:
                row, column = np.unravel_index(int(np.argmax(product)), product.shape)
                move = Move(
                    upside_down, mirrored, _signed(int(row), frame.shape[0]),
                    _signed(int(column), frame.shape[1]),
                )  # fmt: skip
                best = height, move
    if best is None or best[0] < CORRELATION_SCALES or not best[1].words():
        return None
    return best[1]


def _signed(shift: int, size: int) -> int:
    return shift - size if shift > size // 2 else shift


def _fine(frame: np.ndarray) -> np.ndarray:
    """The frame less its neighbours of the same colour, hits and whole lines."""
    y = frame.astype(np.float64)
    y -= 0.25 * (
        np.roll(y, 2, 0) + np.roll(y, -2, 0) + np.roll(y, 2, 1) + np.roll(y, -2, 1)
    )  # fmt: skip
    reach = CAP * max(float(np.quantile(np.abs(y), 0.9)) / 1.645, 1e-6)
    np.clip(y, -reach, reach, out=y)
    return y - y.mean(axis=0) - y.mean(axis=1, keepdims=True)
