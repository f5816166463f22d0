"""``load``: a capture folder to a ``CaptureSet``: headers, and a glance at the frames."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import replace
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING, Literal, TypeVar, cast

import numpy as np

from dnanalyze.errors import InputError, printable
from dnanalyze.loaders import exposures
from dnanalyze.loaders.black_level import common, with_levels
from dnanalyze.loaders.captures import CaptureSet, Frame, OperatingPoint, Sensor, Source, Window
from dnanalyze.loaders.checks import check_count, check_shape
from dnanalyze.loaders.config import Config, read_config, sidecar_of
from dnanalyze.loaders.files import Place, find
from dnanalyze.loaders.formats import MODULES, module_of, read_header, suffix_of
from dnanalyze.loaders.formats.unread import instead
from dnanalyze.loaders.grouping import group
from dnanalyze.loaders.health import examined
from dnanalyze.loaders.manifest import read_manifest
from dnanalyze.loaders.masks import Mask, is_mask_file, make_mask, read_mask
from dnanalyze.loaders.mosaic import large_mosaic
from dnanalyze.loaders.recording import Cfa, FrameReader, Metadata, Recording, shifted_cfa
from dnanalyze.loaders.remote import Fetched
from dnanalyze.loaders.sources import merged
from dnanalyze.loaders.thermometer import TOLERANCE_C

if TYPE_CHECKING:
    Region = Literal["active", "masked", "all"]

T = TypeVar("T")


def load(
    path: str | os.PathLike[str] | Iterable[str | os.PathLike[str]],
    *,
    config: str | os.PathLike[str] | Config | None = None,
    tolerance_c: float | None = None,
    channel: str | None = None,
    include_masked: bool = False,
    region: Region | None = None,
    keep_outliers: bool = False,
    mask: str | os.PathLike[str] | np.ndarray | None = None,
) -> CaptureSet:
    """Load the dark frames of one sensor, grouped by operating point.

    Pixels are read when asked for.

    A sample of each frame is compared: identical frames of an operating point count once, a frame
    unlike the others is left out, and the notes report these and other suspect frames
    (`dnanalyze.loaders.health`).

    Each of temperature, exposure, gain and channel is taken from the first source that states it:
    manifest, file header, text of a capture program, name, sidecar.

    Parameters
    ----------
    path : str or path, or several
        A folder, one file, a manifest, an archive, or an fsspec URL; several files, or the
        ``ImageFileCollection`` of ccdproc.
    config : str, path or Config, optional
        A sidecar; without it ``dnanalyze.yaml`` in the folder, where there is one.
    tolerance_c : float, optional
        Frames of one operating point span at most this, C. Where the sidecar does not say it
        either, 1.5, or less where the scatter of the temperatures shows several set points.
    channel : str, optional
        Only the frames of this HDR readout channel.
    include_masked : bool
        The whole readout, masked pixels and all; the same as ``region="all"``.
    region : {"active", "masked", "all"}, optional
        Which part of the readout makes the frames. Where neither this nor the sidecar says it:
        "active", or "masked" for camera raw files that are lit, which a note then tells.
    keep_outliers : bool
        Keep frames that are unlike the others of their operating point; the notes tell them.
    mask : str, path or ndarray, optional
        Pixels to leave out, those that are not 0: an array of the shape of the readout or of its
        active area, or a file with one (.npy, .fits, .h5, .png, .tif); it adds to a mask that the
        captures hold.

    Returns
    -------
    CaptureSet
        The frames, which are read when asked for.

    Raises
    ------
    InputError
        Bad input: one line that names the file, what is wrong and the remedy.

    Examples
    --------
    >>> captures = load("captures/")                                # doctest: +SKIP
    >>> captures.settings[0].frames[0].read().mean()                # doctest: +SKIP
    """
    listed = getattr(path, "files_filtered", None)  # of an ImageFileCollection
    place = find(path if listed is None else listed(include_path=True))
    sidecar = _sidecar(config, place)
    tolerance = _first(tolerance_c, sidecar.tolerance_c)
    if tolerance is not None and not tolerance >= 0:
        raise InputError(f"tolerance_c {tolerance}: must be 0 C or more")
    asked = "all" if include_masked else region or sidecar.region
    notes: list[str] = []
    manifest = read_manifest(place)
    files = _frame_files(place, sidecar, manifest, notes)
    masks = [f for f in files if manifest is None and is_mask_file(f)]
    masks = masks if len(masks) < len(files) else []
    files = [f for f in files if f not in masks]
    recordings = _recordings(place, files, sidecar, notes)
    part = asked or _dark_part(recordings, notes)
    found = _capture_set(
        place, sidecar, manifest or {}, recordings, part, tolerance, keep_outliers,
        [*masks, *([] if mask is None else [mask])], notes,
    )  # fmt: skip
    return found if channel is None else found.channel(channel)


def _sidecar(config: str | os.PathLike[str] | Config | None, place: Place) -> Config:
    if config is None:
        return sidecar_of(place.root)
    return config if isinstance(config, Config) else read_config(config)


def _frame_files(
    place: Place, config: Config, manifest: dict[Path, Metadata] | None, notes: list[str]
) -> list[Path]:
    if place.single:
        return list(place.files)
    files = [f for f in place.files if module_of(f)]
    if manifest is not None:
        unnamed = [f for f in files if f not in manifest]
        files = [f for f in place.files if f in manifest]
        if unnamed:
            notes.append(f"{len(unnamed)} files that the manifest does not name are left out.")
    skipped = {f for f in files for glob in config.skip if fnmatchcase(place.relative(f), glob)}
    if skipped:
        notes.append(f"{len(skipped)} frames are skipped as the sidecar says.")
    files = [f for f in files if f not in skipped]
    if not files and (found := instead(place.files)):
        raise InputError(f"{place.name}: no frames; it holds {found}")
    if not files:
        raise InputError(
            f"{place.name}: no frames; give a folder with files of: {', '.join(sorted(MODULES))}"
        )
    return files


def _recordings(
    place: Place, files: list[Path], config: Config, notes: list[str]
) -> list[tuple[Path, Recording]]:
    recordings: list[tuple[Path, Recording]] = []
    left_out: Counter[str] = Counter()
    previous = None
    for file in files:
        recording = previous = read_header(file, printable(place.relative(file)), config, previous)
        if recording.left_out and config.image_type is None:
            left_out[recording.left_out] += 1
        else:
            if place.origin is not None:
                recording = replace(recording, read=Fetched(recording.read, file, place.origin))
            recordings.append((file, recording))
    notes += [f"{n} files are left out: {reason}." for reason, n in left_out.items()]
    if not recordings:
        raise InputError(
            f"{place.name}: no dark frames; {next(iter(left_out))} in every file: give the folder "
            "of the darks, or, where these are darks, image_type: dark in the sidecar"
        )
    return _one_camera(place, recordings, notes)


def _one_camera(
    place: Place, recordings: list[tuple[Path, Recording]], notes: list[str]
) -> list[tuple[Path, Recording]]:
    """Camera raw files of the commonest camera; any other mixture of shapes is refused.

    The readout of a camera's raw files has one size, so two sizes are two cameras, and each
    file's own format and size tell which.
    """
    first_file, first = recordings[0]
    if all((r.shape, r.dtype) == (first.shape, first.dtype) for _, r in recordings):
        return recordings
    if all(suffix_of(f) in _CAMERA_RAW for f, _ in recordings):
        counts = Counter((r.format, r.shape) for _, r in recordings)
        (kind, shape), count = counts.most_common(1)[0]
        others = [f for f, r in recordings if (r.format, r.shape) != (kind, shape)]
        notes.append(
            f"The folder holds raw files of {len(counts)} cameras; taken: {count} {kind} of "
            f"{shape[0]} x {shape[1]}; left out: {printable(place.relative(others[0]))}"
            + (f" and {len(others) - 1} more" if len(others) > 1 else "")
            + ", to be loaded by itself."
        )
        return [(f, r) for f, r in recordings if (r.format, r.shape) == (kind, shape)]
    file, other = next(
        (f, r) for f, r in recordings if (r.shape, r.dtype) != (first.shape, first.dtype)
    )
    raise InputError(
        f"{place.relative(file)}: has {other.shape[0]} x {other.shape[1]} pixels of {other.dtype}, "
        f"{place.relative(first_file)} has {first.shape[0]} x {first.shape[1]} of {first.dtype}; "
        "one folder holds frames of one sensor and one mode: move one kind elsewhere"
    )


_CAMERA_RAW = {suffix for suffix, module in MODULES.items() if module == "camera_raw"}


def _dark_part(recordings: list[tuple[Path, Recording]], notes: list[str]) -> str:
    if not any(r.lit for _, r in recordings):
        return "active"
    notes.append(
        "The frames are lit: their active area lies far above their masked strip. The masked "
        "strip alone is loaded; region 'active' loads the lit area all the same."
    )
    return "masked"


def _capture_set(
    place: Place,
    config: Config,
    manifest: dict[Path, Metadata],
    recordings: list[tuple[Path, Recording]],
    part: str,
    tolerance_c: float | None,
    keep_outliers: bool,
    masks: Sequence[str | os.PathLike[str] | np.ndarray],
    notes: list[str],
) -> CaptureSet:
    frames: list[tuple[Frame, float | None]] = []
    first = recordings[0][1]
    window = Window.whole(first.shape)
    cfa = config.colour_filter() or first.cfa
    filters: set[Cfa | None] = set()
    blacks: dict[str, float | None] = {}
    notes += dict.fromkeys(n for _, r in recordings for n in r.notes)
    known_of, taken = merged(place, config, manifest, recordings, notes)
    for (file, recording), own in zip(recordings, known_of, strict=True):
        name = printable(place.relative(file))
        check_count(place.name, len(frames) + len(recording.frames))
        for index, known in enumerate(own):
            if recording.area(index).again and (part == "all" or config.names_active):
                continue
            active, masked = _areas(recording, index, config, name)
            window = _region(part, active, masked, Window.whole(recording.shape), name)
            check_shape(name, window.shape, mosaic=cfa is not None)
            filters.add(shifted_cfa(cfa, window.top, window.left))
            label = name if len(recording.frames) == 1 else f"{name}[{index}]"
            point = OperatingPoint(known.temperature_c, known.exposure_s, known.gain, known.channel)
            black = None
            if part == "active" and masked is not None:
                black = FrameReader(label, recording.read, index, masked, checked=False)
            reader = FrameReader(label, recording.read, index, window)
            frames.append((Frame(label, point, reader, black), known.frame))
            blacks[label] = _first(config.black_level, recording.black_level)
    shapes = {f.load.region.shape for f, _ in frames if isinstance(f.load, FrameReader)}
    if len(shapes) > 1:
        raise InputError(
            f"{place.name}: active areas of different shapes {sorted(shapes)}; set active_rows and "
            "active_columns in the sidecar"
        )
    if len(filters) > 1:
        raise InputError(
            f"{place.name}: active areas that begin on different colours of the filter; set "
            "active_rows and active_columns in the sidecar"
        )
    sensor = Sensor(
        window.shape,
        _first(config.bits, first.bits),
        None,
        _first(config.white_level, first.white_level),
        filters.pop(),
        _first(config.pixel_pitch_um, first.pixel_pitch_um),
        _first(config.system_gain_dn_e, _common(r.system_gain_dn_e for _, r in recordings)),
    )
    left = _mask(masks, recordings, window, cfa, notes)
    if left is not None:
        sensor = replace(sensor, shape=left.shape, filled=left.filled)
        frames = [
            (replace(f, load=replace(cast("FrameReader", f.load), mask=left)), place_in_time)
            for f, place_in_time in frames
        ]
    together = group(frames, tolerance_c, config.tolerance_s)
    notes += exposures.notes(together)
    grouped = []
    for setting in together:
        with_black, text = common(setting, [blacks[f.name] for f in setting.frames])
        grouped.append(with_black)
        notes += [text] if text else []
    settings, suspect = examined(grouped, keep_outliers, config.black_level is not None)
    sensor, differing = with_levels(sensor, settings)
    notes += [*suspect, *differing]
    if sensor.cfa is not None and len(sensor.cfa) > 2:
        notes.append(large_mosaic(sensor.cfa, settings[0].frames[0].read()))
    formats = tuple(dict.fromkeys(r.format for _, r in recordings))
    span = TOLERANCE_C if tolerance_c is None else tolerance_c
    source = Source(formats, str(first.dtype), span, part, taken=taken)
    return CaptureSet(printable(place.name), sensor, settings, tuple(notes), source)


def _mask(
    given: Sequence[str | os.PathLike[str] | np.ndarray],
    recordings: list[tuple[Path, Recording]],
    window: Window,
    cfa: tuple[tuple[str, ...], ...] | None,
    notes: list[str],
) -> Mask | None:
    """What masks of the files and of the user leave of the frames; None where there are none."""
    masked = np.zeros(window.shape, bool)
    whose = []
    for file, recording in recordings:
        if recording.mask is not None:
            masked |= recording.mask[window.slices]
            whose = [printable(file.name)]
    for mask in given:
        own = mask if isinstance(mask, np.ndarray) else read_mask(mask)
        name = "mask" if isinstance(mask, np.ndarray) else printable(str(mask))
        whole = recordings[0][1].shape
        if own.shape not in (whole, window.shape):
            raise InputError(
                f"{name}: has {own.shape} pixels, the frames have {window.shape}; give a mask of "
                "the shape of the frames"
            )
        masked |= (own if own.shape == window.shape else own[window.slices]) != 0
        whose.append(name)
    if not masked.any():
        return None
    left = make_mask(masked, " and ".join(whose), 1 if cfa is None else len(cfa))
    notes.append(left.words(window.shape, " and ".join(whose)))
    return left


def _common(values: Iterable[float | None]) -> float | None:
    """What all files say; None where they differ or one says nothing."""
    found = set(values)
    return found.pop() if len(found) == 1 else None


def _areas(
    recording: Recording, index: int, config: Config, name: str
) -> tuple[Window, Window | None]:
    """Active and masked area of a frame's readout; the sidecar outranks the header."""
    whole, own = Window.whole(recording.shape), recording.area(index)
    active = own.active or whole
    if config.names_active:
        active = Window(
            *(config.active_rows or (active.top, active.bottom)),
            *(config.active_columns or (active.left, active.right)),
        )
    masked = own.masked
    if config.optical_black_rows or config.optical_black_columns:
        masked = Window(
            *(config.optical_black_rows or (0, whole.bottom)),
            *(config.optical_black_columns or (0, whole.right)),
        )
    for area in (active, masked):
        if area is not None and (area.bottom > whole.bottom or area.right > whole.right):
            raise InputError(
                f"{name}: the sidecar names rows {area.top} to {area.bottom}, columns {area.left} "
                f"to {area.right}, but the file has {whole.bottom} x {whole.right} pixels"
            )
    return active, masked


def _region(part: str, active: Window, masked: Window | None, whole: Window, name: str) -> Window:
    if part == "active":
        return active
    if part == "all":
        return whole
    if part != "masked":
        raise InputError(f"region {part!r}: valid: active, masked, all")
    if masked is None:
        raise InputError(
            f"{name}: no masked area is known; give optical_black_columns or "
            "optical_black_rows in the sidecar"
        )
    return masked


def _first(*values: T | None) -> T | None:
    return next((v for v in values if v is not None), None)
