"""Pictures of the sensor, measured and simulated, as a screen shows them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from dnanalyze.loaders.captures import CaptureSet, OperatingPoint, Window
from dnanalyze.model.memo import Memo
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.simulate import simulate, simulated_by
from dnanalyze.model.simulator import Simulator
from dnanalyze.report.fields import side_of
from dnanalyze.workbench import frames
from dnanalyze.workbench.frames import Outliers, View
from dnanalyze.workbench.heap import give_back
from dnanalyze.workbench.places import Places, kind_of, places
from dnanalyze.workbench.tiles import aligned, tiled

MEASURED = 64 << 20  # bytes of whole images kept, one at least: some files are read as a whole only
SIMULATED = 128 << 20  # bytes of tiles kept: an image of 32 million pixels, or its means often
FIELDS = 32 << 20  # bytes kept of what the frames of a tile have in common
THUMBNAIL = 96, 128  # pixels
MOST_OUTLIERS = 2000  # that are drawn of a picture
LARGE = 1 << 22  # pixels of a simulated image that leaves much free memory


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
    measured, simulated : int
        Bytes of measured images and of tiles of simulated ones that are kept, the last used ones.
    """

    def __init__(
        self, captures: CaptureSet, measured: int = MEASURED, simulated: int = SIMULATED
    ) -> None:
        self.captures = captures
        self._room = measured, simulated
        self.clear()

    def picture(
        self,
        view: View,
        window: Window,
        model: NoiseModel | None,
        most: int,
        far: bool,
        look: Callable[[], None] = lambda: None,
    ) -> Picture:
        """A window of a view, grown to whole blocks.

        Parameters
        ----------
        view : View
        window : Window
        model : NoiseModel, optional
        most : int
            Rows and columns of the images at most.
        far : bool
            Whether outliers are looked for.
        look : callable
            Called before each frame that is read or simulated; what it raises ends the work.
        """
        whole = self.measured(view, look)
        side = side_of(window.shape, most)
        window = aligned(window, side, whole.shape)
        means = frames.block_means(whole[window.slices], side)
        found = {"measured": frames.outliers(whole, window, MOST_OUTLIERS)} if far else {}
        simulated = np.full_like(means, np.nan)
        if model is not None and far:
            pixels = self._simulated(view, model, window, 1, whole.shape, look)
            simulated = frames.block_means(pixels, side)
            inside = frames.outliers(pixels, Window.whole(pixels.shape), MOST_OUTLIERS)
            found["simulated"] = inside.moved(window.top, window.left)
        elif model is not None:
            simulated = self._simulated(view, model, window, side, whole.shape, look)
        return Picture(view, window, side, means, simulated, found)

    def measured(self, view: View, look: Callable[[], None] = lambda: None) -> np.ndarray:
        """A whole image of the captures; the last ones are kept."""
        return self._measured.once(view, lambda: frames.image(self.captures, view, look=look))

    def _simulated(
        self,
        view: View,
        model: NoiseModel,
        window: Window,
        side: int,
        shape: tuple[int, int],
        look: Callable[[], None],
    ) -> np.ndarray:
        """Block means of an aligned window of a model's image, of a shape; its tiles are kept."""
        sensor = self.captures.sensor
        whole_fields = Memo(4 * math.prod(sensor.shape) * (1 + frames.MOST_FRAMES))
        simulator = Simulator(model.in_codes, sensor.shape, _shared=whole_fields)

        def made(tile: Window) -> np.ndarray:
            its_own = replace(simulator, memo=Memo(FIELDS), _maps=Memo(FIELDS))
            drawn = simulated_by(its_own, self._layout(), sensor=sensor)
            return frames.block_means(frames.image(drawn, view, tile, look), side)

        def kept(tile: Window) -> np.ndarray:
            return self._tiles.once((view, model, side, tile), lambda: made(tile))

        found = tiled(window, side, shape, kept)
        if math.prod(window.shape) >= LARGE:
            give_back()
        return found

    def clear(self) -> None:
        """Keep no image."""
        self._measured, self._tiles = map(Memo, self._room)

    def thumbnail(self, setting: int, model: NoiseModel | None) -> np.ndarray:
        """The middle of the first frame, at its own sampling, of the captures or of a model."""
        rows, columns = self.captures.sensor.shape
        height, width = min(rows, THUMBNAIL[0]), min(columns, THUMBNAIL[1])
        top, left = (rows - height) // 4 * 2, (columns - width) // 4 * 2
        made = self.captures if model is None else self._drawn(model, 1)
        window = Window(top, top + height, left, left + width)
        return np.asarray(made.settings[setting].frames[0].read(window), np.float32)

    def places(self, name: str, setting: int, plane: str) -> Places | None:
        """Where in a measured image a statistic comes from; None where it has no place."""
        kind = kind_of(name)
        if kind is None:
            return None
        several = len(self.captures.settings[setting].frames) > 1
        view = View(setting, kind if several else "frame", 0, plane)
        found = places(name, self.measured(view))
        return found and replace(found, kind=view.kind)

    def pixel(self, row: int, column: int, model: NoiseModel | None) -> dict[str, list[np.ndarray]]:
        """Values of a pixel in the frames of every operating point, DN."""
        found = {"measured": frames.pixel(self.captures, row, column)}
        if model is not None:
            made = self._drawn(model, frames.MOST_FRAMES)
            found["simulated"] = frames.pixel(made, row, column)
        return found

    def _drawn(self, model: NoiseModel, most: int) -> CaptureSet:
        """The frames of a model, ``most`` an operating point."""
        sensor = self.captures.sensor
        return simulate(model.in_codes, sensor.shape, self._layout(most), sensor=sensor)

    def _layout(self, most: int | None = None) -> list[tuple[OperatingPoint, int]]:
        """Operating points with their number of frames, ``most`` of each."""
        settings = self.captures.settings
        return [(s.point, min(len(s.frames), most or len(s.frames))) for s in settings]
