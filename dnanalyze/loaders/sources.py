"""The metadata of every frame: manifest, header, a capture program's text, name, sidecar."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from dnanalyze.errors import printable
from dnanalyze.loaders import offsets
from dnanalyze.loaders.config import Config
from dnanalyze.loaders.files import Place
from dnanalyze.loaders.gains import settled
from dnanalyze.loaders.names import from_folder, from_regex
from dnanalyze.loaders.program_text import ProgramTexts
from dnanalyze.loaders.provenance import Taken, Tally
from dnanalyze.loaders.recording import Metadata, Recording

# Quantity, relative and absolute difference from which header and name contradict each other: a
# name rounds the exposure, and tells the set point.
_APART = (("temperature_c", 0.0, 5.0), ("exposure_s", 0.05, 1e-6))


def merged(
    place: Place,
    config: Config,
    manifest: dict[Path, Metadata],
    recordings: Sequence[tuple[Path, Recording]],
    notes: list[str],
) -> tuple[list[tuple[Metadata, ...]], tuple[Taken, ...]]:
    """What is known of each frame of each file, and where it was taken from.

    Parameters
    ----------
    place : Place
    config : Config
    manifest : dict of Path to Metadata
    recordings : sequence of (Path, Recording)
    notes : list of str
        Takes what is doubtful or was left out, a sentence each.

    Returns
    -------
    known : list of tuple of Metadata
        For each recording, one for each frame.
    taken : tuple of Taken
    """
    names = [printable(place.relative(file)) for file, _ in recordings]
    odd: dict[str, list[str]] = {}
    named_otherwise: dict[str, list[tuple[str, Metadata, Metadata]]] = {}
    frames: list[Metadata] = []
    elsewhere = config.metadata().of("sidecar")
    named = _named(place, [f for f, _ in recordings], config)
    texts = ProgramTexts(place.files)
    for (file, recording), name, said in zip(recordings, names, named, strict=True):
        for header in recording.frames:
            own, wrong = header.plausible()
            for text in wrong:
                odd.setdefault(text, []).append(name)
            stated = manifest.get(file, Metadata())
            known = stated.or_else(own.of("header"))
            for quantity in _contradicted(known, said):
                named_otherwise.setdefault(quantity, []).append((name, known, said))
            frames.append(known.or_else(texts.of(file)).or_else(said).or_else(elsewhere))
    frames, note = settled(
        frames, [r.system_gain_dn_e for _, r in recordings for _ in range(len(r.frames))]
    )
    frames, apart = offsets.settled(frames)
    tally = Tally()
    waiting = iter(frames)
    known_of = [tuple(next(waiting) for _ in r.frames) for _, r in recordings]
    for name, own_frames in zip(names, known_of, strict=True):
        for metadata in own_frames:
            tally.add(name, metadata)
    notes += [
        f"The header says {text}; taken as unknown in {files[0]}"
        + (f" and {len(files) - 1} more." if len(files) > 1 else ".")
        for text, files in odd.items()
    ]
    notes += [*filter(None, [note, apart]), *tally.notes()]
    notes += [_of_names(quantity, files) for quantity, files in named_otherwise.items()]
    return known_of, tally.sources()


def _contradicted(header: Metadata, name: Metadata) -> list[str]:
    """Quantities of which a header says one value and a name, with its unit, another."""
    found = []
    for quantity, relative, least in _APART:
        stated, named = getattr(header, quantity), getattr(name, quantity)
        if stated is None or named is None or not _unit_of(name, quantity):
            continue
        source, example = header.taken.get(quantity, ("", ""))
        if not source.startswith("header") or example.startswith("image type"):
            continue
        if abs(stated - named) > max(relative * abs(stated), least):
            found.append(quantity)
    return found


def _unit_of(name: Metadata, quantity: str) -> bool:
    """Whether the text of a name ends with a unit."""
    return name.taken.get(quantity, ("", ""))[1][-1:].isalpha()


def _of_names(quantity: str, files: Sequence[tuple[str, Metadata, Metadata]]) -> str:
    """A note on names that say another value than the header."""
    name, header, said = files[0]
    count = len(dict.fromkeys(file for file, _, _ in files))
    (source, example), (_, text) = header.taken[quantity], said.taken[quantity]
    return (
        f"{name}{f' and {count - 1} more' if count > 1 else ''}: the name says {text}, the "
        f"{source} {example}; the header is used, and a manifest with {quantity} settles it."
    )


def _named(place: Place, files: list[Path], config: Config) -> list[Metadata]:
    """What the name of each file and its folders say; the user's own expression first."""
    below = [Path(place.relative(f)) for f in files]
    root = Path(os.path.realpath(place.root)).name
    parts = [[f.stem, *reversed(f.parent.parts), root] for f in below]
    guessed = [said.plausible()[0] for said in from_folder(parts)]
    if config.name_regex is None:
        return guessed
    own = from_regex(config.name_regex, [f.as_posix() for f in below])
    return [
        mine.of("name_regex").or_else(theirs) for mine, theirs in zip(own, guessed, strict=True)
    ]
