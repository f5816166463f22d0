"""Where the metadata of the frames were taken from, and what is doubtful about them."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from dnanalyze.loaders.recording import Metadata


@dataclass(frozen=True)
class Taken:
    """One source of one quantity.

    Parameters
    ----------
    quantity : str
        "temperature_c", "exposure_s", "gain", "channel" or "frame".
    source : str
        Such as "header CCD-TEMP", "name" or "manifest.csv".
    example : str
        How it stands in the first frame, or "".
    file : str
        That frame.
    frames : int
        Frames of which this source states it.
    """

    quantity: str
    source: str
    example: str
    file: str
    frames: int


@dataclass
class Tally:
    """Sources and doubts of frame after frame, each kind with its first example."""

    taken: dict[tuple[str, str], Taken] = field(default_factory=dict)
    doubts: dict[str, tuple[str, list[str]]] = field(default_factory=dict)

    def add(self, name: str, metadata: Metadata) -> None:
        """Count one frame; ``name`` is its file."""
        for quantity, (source, example) in metadata.taken.items():
            if getattr(metadata, quantity) is None:
                continue
            known = self.taken.get((quantity, source)) or Taken(quantity, source, example, name, 0)
            self.taken[quantity, source] = replace(known, frames=known.frames + 1)
        for doubt in metadata.doubts:
            files = self.doubts.setdefault(doubt.kind, (doubt.text, []))[1]
            if not files or files[-1] != name:
                files.append(name)

    def sources(self) -> tuple[Taken, ...]:
        """Every source of every quantity."""
        order = {name: k for k, name in enumerate(Metadata.__dataclass_fields__)}
        return tuple(sorted(self.taken.values(), key=lambda t: order[t.quantity]))

    def notes(self) -> list[str]:
        """The doubts, a sentence each."""
        return [
            f"{files[0]}{f' and {len(files) - 1} more' if len(files) > 1 else ''}: {text}."
            for text, files in self.doubts.values()
        ]
