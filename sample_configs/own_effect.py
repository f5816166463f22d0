"""A user's own effect: two pixels on a diagonal share an amplifier, and with it its noise."""

from dataclasses import dataclass

import numpy as np

from dnanalyze import Effect, Stage, Window, parameter


@dataclass(frozen=True)
class SharedAmplifier(Effect):
    """Adds the same noise to the two pixels of each pair (2i, 2j) and (2i+1, 2j+1)."""

    name = "shared_amplifier"
    stage = Stage.LINE_READ
    varies = "temporal"
    summary = "Diagonal pairs of pixels share an amplifier: half the pixels have a common noise."
    physics = "Where two pixels share a source follower, its noise appears in both, frame by frame."
    formula = "y += sigma n(i, j) at (2i, 2j) and (2i+1, 2j+1); correlation of diagonals sigma^2/8"
    fingerprint = ("temporal_corr_11",)

    sigma: float = parameter(1.0, "DN", 1e-3, 1e3, "standard deviation of the shared noise")

    def apply(self, signal, site):
        """The signal with the shared noise, DN."""
        w = site.window  # any part of the frame: the numbers belong to the cell, not to the window
        cells = Window(w.top // 2, (w.bottom + 1) // 2, w.left // 2, (w.right + 1) // 2)
        noise = site.frame_stream.child("cells").normal(cells, site.shape[1] // 2 + 1)
        rows, columns = site.row_index[:, None], site.column_index[None, :]
        paired = (rows + columns) % 2 == 0
        shared = noise[rows // 2 - cells.top, columns // 2 - cells.left] * paired
        return signal + np.float32(self.value("sigma", site.point) * site.gain_ratio) * shared

    @classmethod
    def guess(cls, clues):
        """sigma from the correlation of diagonal neighbours that the model lacks."""
        surplus = clues.measured("temporal_corr_11") - clues.simulated("temporal_corr_11")
        variance = np.nanmedian(8 * surplus * clues.measured("temporal_noise") ** 2)
        return [cls(float(np.sqrt(variance)))] if variance > 1e-4 else []
