"""Where a session's captures and effects come from: what a worker process reads again by itself."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from dnanalyze.analyzers.streaming.cache import default_folder
from dnanalyze.loaders import load
from dnanalyze.loaders.captures import CaptureSet
from dnanalyze.model.effect import Effect
from dnanalyze.model.registry import catalogue


@dataclass(frozen=True)
class CaptureSource:
    """A capture folder as named on the command line.

    Parameters
    ----------
    folder : Path
    config : Path, optional
        Sidecar that states what the files do not.
    tolerance_c : float, optional
        Span of temperatures within one operating point, C.
    channel : str, optional
        HDR readout channel; all by default.
    effects : tuple of Path
        Files of the user's own effects.
    keep_outliers : bool
        Whether frames unlike the others of their operating point are kept.
    mask : Path, optional
        File of the pixels to leave out.
    """

    folder: Path
    config: Path | None = None
    tolerance_c: float | None = None
    channel: str | None = None
    effects: tuple[Path, ...] = ()
    keep_outliers: bool = False
    mask: Path | None = None

    def captures(self) -> CaptureSet:
        """The frames, read lazily; statistics of unchanged frames come from the cache.

        Raises
        ------
        InputError
            A folder without frames, or frames that cannot be read.
        """
        found = load(
            str(self.folder),
            config=self.config,
            tolerance_c=self.tolerance_c,
            keep_outliers=self.keep_outliers,
            mask=self.mask,
        )
        if self.channel is not None:
            found = found.channel(self.channel)
        return found.cached(str(kept)) if (kept := default_folder()) else found

    def known(self) -> dict[str, type[Effect]]:
        """The catalogue of effects with the user's own.

        Raises
        ------
        InputError
            A file of effects that cannot be read.
        """
        return catalogue(self.effects)
