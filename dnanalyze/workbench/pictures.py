"""Pictures of the sensor, measured and simulated, as a screen shows them."""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass, replace
from threading import RLock

import numpy as np

from dnanalyze.loaders.captures import CaptureSet, Window
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.simulate import simulate
from dnanalyze.workbench import frames
from dnanalyze.workbench.frames import Outliers, View
from dnanalyze.workbench.places import Places, kind_of, places

MEMORY = 256 << 20  # bytes of whole images kept
THUMBNAIL = 96, 128  # pixels
MOST_OUTLIERS = 2000  # that are drawn of a picture


@dataclass(frozen=True)
class Picture:
    """A window of an image of the captures and of a model.

    Parameters
    ----------
    view : View
    window : Window
        Of the frame or of the colour plane.
    side : int
        Pixels to a side of the blocks, of which the images are the means.
    measured, simulated : ndarray
        Means, DN; ``simulated`` is NaN without a model.
    outliers : mapping of Outliers
        "measured" and "simulated".
    """

    view: View
    window: Window
    side: int
    measured: np.ndarray
    simulated: np.ndarray
    outliers: dict[str, Outliers]

    @property
    def difference(self) -> np.ndarray:
        """Measured minus simulated, DN."""
        return self.measured - self.simulated


class Pictures:
    """Pictures of captures and of models.

    Parameters
    ----------
    captures : CaptureSet
        In codes.
    memory : int
        Bytes of whole images that are kept, the last used ones.
    """

    def __init__(self, captures: CaptureSet, memory: int = MEMORY) -> None:
        self.captures = captures
        self._memory = memory
        self._held: OrderedDict[tuple[View, NoiseModel | None], np.ndarray] = OrderedDict()
        self._lock = RLock()

    def picture(
        self, view: View, window: Window, model: NoiseModel | None, most: int, far: bool
    ) -> Picture:
        """A window of a view.

        Parameters
        ----------
        view : View
        window : Window
        model : NoiseModel, optional
        most : int
            Rows and columns of the images at most.
        far : bool
            Whether outliers are looked for.
        """
        whole = {"measured": self.whole(view, None)}
        means, side = frames.block_means(whole["measured"], window, most)
        if model is None:
            simulated = np.full_like(means, np.nan)
        else:
            whole["simulated"] = self.whole(view, model)
            simulated, _ = frames.block_means(whole["simulated"], window, most)
        found = {}
        if far:
            found = {k: frames.outliers(x, window, MOST_OUTLIERS) for k, x in whole.items()}
        return Picture(view, window, side, means, simulated, found)

    def whole(self, view: View, model: NoiseModel | None) -> np.ndarray:
        """A whole image, of the captures or of a model; the last few are kept."""
        key = view, model
        with self._lock:
            if key not in self._held:
                made = self.captures if model is None else self._simulated(model)
                self._held[key] = frames.image(made, view)
                held = sum(x.nbytes for x in self._held.values())
                while held > self._memory and len(self._held) > 2:
                    held -= self._held.popitem(last=False)[1].nbytes
            self._held.move_to_end(key)
            return self._held[key]

    def clear(self) -> None:
        """Keep no image."""
        with self._lock:
            self._held.clear()

    def thumbnail(self, setting: int, model: NoiseModel | None) -> np.ndarray:
        """The middle of the first frame, at its own sampling, of the captures or of a model."""
        rows, columns = self.captures.sensor.shape
        height, width = min(rows, THUMBNAIL[0]), min(columns, THUMBNAIL[1])
        top, left = (rows - height) // 4 * 2, (columns - width) // 4 * 2
        made = self.captures if model is None else self._simulated(model, 1)
        window = Window(top, top + height, left, left + width)
        return np.asarray(made.settings[setting].frames[0].read(window), np.float32)

    def places(self, name: str, setting: int, plane: str) -> Places | None:
        """Where in a measured image a statistic comes from; None where it has no place."""
        kind = kind_of(name)
        if kind is None:
            return None
        several = len(self.captures.settings[setting].frames) > 1
        view = View(setting, kind if several else "frame", 0, plane)
        found = places(name, self.whole(view, None))
        return found and replace(found, kind=view.kind)

    def pixel(self, row: int, column: int, model: NoiseModel | None) -> dict[str, list[np.ndarray]]:
        """Values of a pixel in the frames of every operating point, DN."""
        found = {"measured": frames.pixel(self.captures, row, column)}
        if model is not None:
            made = self._simulated(model, frames.MOST_FRAMES)
            found["simulated"] = frames.pixel(made, row, column)
        return found

    def _simulated(self, model: NoiseModel, most: int | None = None) -> CaptureSet:
        """The frames of a model, as many as of the captures or ``most`` an operating point."""
        captures = self.captures
        layout = [(s.point, min(len(s.frames), most or len(s.frames))) for s in captures.settings]
        return simulate(
            model.in_codes, captures.sensor.shape, layout, "simulation", captures.sensor
        )
