"""Mutated files of every format: loading them succeeds or is refused, and nothing else.

``python benchmarks/fuzz_inputs.py --count 100000 --workers 2`` damages samples of every format of
frames, of manifests, sidecars, models, targets and tables, and reads them as the commands do: the
header, two frames, a frame of the model. Each file must give a result or an ``InputError`` of one
line, without warnings, within 5 s of processor time and 512 MB. File ``k`` of a seed is always the
same; ``--repeat k`` reads it again and shows the traceback.

Prints a table by format; exit 1 where anything else happened.
"""

from __future__ import annotations

import argparse
import io
import multiprocessing
import multiprocessing.connection
import re
import resource
import shutil
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any

import numpy as np

LIMIT_S = 5.0  # of the processor, so that a busy machine changes no outcome
BLOCKED_S = 60.0  # of the clock, for a file that waits
HEADROOM = 512 << 20  # bytes beyond what the libraries take
SHAPE = (32, 40)
CODES = np.random.default_rng(0).integers(60, 70, (2, *SHAPE)).astype(np.uint16)


# --- samples ---------------------------------------------------------------------------------


@dataclass(frozen=True)
class Sample:
    """One file to be damaged, the intact ones beside it, and what reads them."""

    name: str
    data: bytes
    read: Callable[[Path], None]
    text: bool = False
    beside: dict[str, bytes] = field(default_factory=dict)


def samples() -> dict[str, Sample]:
    """A sample of every kind by name."""
    made = dict(_frames())
    npy = {"T+025C/a.npy": _npy(CODES), "T+065C/b.npy": _npy(CODES[:, ::-1])}
    for kind, name, content in _tables():
        made[kind] = Sample(name, content.encode(), _read_folder, True, npy)
    for kind, name, content, read in _documents():
        made[kind] = Sample(name, content.encode(), read, True)
    return made


def _frames() -> Iterator[tuple[str, Sample]]:
    from dnanalyze.loaders.packing import pack

    for kind, (name, data) in _binary_files().items():
        yield kind, Sample(name, data, _read_folder)
    raw = {"a.raw": CODES.tobytes()}
    layout = f"width: {SHAPE[1]}\nheight: {SHAPE[0]}\nbits: 12\n"
    packed = layout + "packing: mipi\nheader_offset: 12\nrow_bytes: 64\n"
    yield (
        "raw",
        Sample("a.raw", raw["a.raw"], _read_folder, False, {"dnanalyze.yaml": layout.encode()}),
    )
    padded = np.pad(pack(CODES[0], 12, "mipi"), ((0, 0), (0, 4)))
    rows = {"a.raw": bytes(12) + padded.tobytes()}
    genicam = layout + "packing: genicam\nfooter_bytes: 4\n"
    yield (
        "raw genicam",
        Sample(
            "a.raw", pack(CODES[0], 12, "genicam").tobytes() + bytes(4), _read_folder, False,
            {"dnanalyze.yaml": genicam.encode()},
        ),
    )  # fmt: skip
    video = _ser()
    program = "[ZWO ASI178MM]\nExposure=20.0ms\nGain=120 (30%)\nTemperature=-10,5 C\nOffset=10\n"
    yield "ser", Sample("a.ser", video, _read_folder, False, {"a.txt": program.encode()})
    yield "program text", Sample("a.txt", program.encode(), _read_folder, True, {"a.ser": video})
    page = {"a.npy": _npy(CODES)}
    yield "mask", Sample("mask.npy", _npy(CODES[0] > 68), _read_folder, False, page)
    camera = b'{"ExposureTime": 20000, "AnalogueGain": 4.0, "FrameDuration": 33333}'
    table = b'{"Summary": {}, "k": {"FileName": "x/a.npy", "Exposure-ms": 10, "Channel": "a"}}'
    yield "program json", Sample("a.json", camera, _read_folder, True, page)
    yield "program table", Sample("metadata.txt", table, _read_folder, True, page)
    yield from _archives(video, program)
    yield "raw sidecar", Sample("dnanalyze.yaml", packed.encode(), _read_folder, True, rows)
    header = (
        f"ENVI\nsamples = {SHAPE[1]}\nlines = {SHAPE[0]}\nbands = 2\nheader offset = 0\n"
        "data type = 12\ninterleave = bil\nbyte order = 0\nexposure time = 20 ms\n"
        "wavelength = { 400.0,\n 410.0 }\n"
    )
    yield "envi header", Sample("a.hdr", header.encode(), _read_folder, True, raw)
    yield (
        "envi pixels",
        Sample("a.raw", raw["a.raw"], _read_folder, False, {"a.hdr": header.encode()}),
    )


def _binary_files() -> dict[str, tuple[str, bytes]]:
    import gzip
    import zipfile

    import h5py
    import tifffile
    from astropy.io import fits
    from PIL import Image

    def held(write: Callable[[Any], Any]) -> bytes:
        stream = io.BytesIO()
        write(stream)
        return stream.getvalue()

    def archive(compression: int) -> bytes:
        def write(stream: io.BytesIO) -> None:
            with zipfile.ZipFile(stream, "w", compression) as file:
                file.writestr("frames.npy", _npy(CODES))
                file.writestr("temperature_c.npy", _npy(np.float64(25.0)))

        return held(write)

    def hdf5(**options: Any) -> bytes:
        def write(stream: io.BytesIO) -> None:
            with h5py.File(stream, "w") as file:
                data = file.create_dataset("darks/frames", data=CODES, **options)
                data.attrs["temperature_c"] = [25.0, 65.0]
                file.attrs["exposure_s"] = 0.5

        return held(write)

    def tif(array: np.ndarray, **options: Any) -> bytes:
        return held(lambda s: tifffile.imwrite(s, array, **options))

    def png(array: np.ndarray) -> bytes:
        return held(lambda s: Image.fromarray(array).save(s, format="PNG"))

    primary = fits.PrimaryHDU(CODES)
    for key, value in (("CCD-TEMP", -10.5), ("EXPTIME", 20.0), ("GAIN", 1.0)):
        primary.header[key] = value
    primary.header["DATASEC"] = f"[3:{SHAPE[1]},1:{SHAPE[0]}]"
    plain = held(primary.writeto)
    scaled = fits.ImageHDU(CODES[0].astype(np.int16))
    scaled.header["BSCALE"], scaled.header["BLANK"] = 0.5, -5
    extension = held(fits.HDUList([fits.PrimaryHDU(), scaled]).writeto)
    tiles = {
        how: held(
            fits.HDUList(
                [
                    fits.PrimaryHDU(),
                    fits.CompImageHDU(CODES[0].astype(np.int16), compression_type=how),
                ]
            ).writeto
        )
        for how in ("RICE_1", "GZIP_1", "GZIP_2")
    }
    first, second = fits.ImageHDU(CODES[0], name="A"), fits.ImageHDU(CODES[1], name="B")
    flags = fits.ImageHDU((CODES[0] > 68).astype(np.int16), name="DQ")
    quality = held(fits.HDUList([fits.PrimaryHDU(), first, flags]).writeto)
    last = io.BytesIO()
    planes_last = np.random.default_rng(1).integers(60, 70, (*SHAPE, 1)) + CODES[:1].reshape(
        *SHAPE, 1
    )
    np.savez(last, frames=np.repeat(planes_last, 6, 2).astype(np.uint16), mask=CODES[0] > 68)
    empty = fits.PrimaryHDU(header=primary.header.copy(strip=True))
    chips = held(fits.HDUList([empty, first, second]).writeto)
    half = SHAPE[1] // 2
    amplifiers = fits.PrimaryHDU(CODES[0])
    for letter, start in (("A", 0), ("B", half)):
        rows = f"1:{SHAPE[0]}]"
        amplifiers.header[f"DATASEC{letter}"] = f"[{start + 1}:{start + half - 4},{rows}"
        amplifiers.header[f"BIASSEC{letter}"] = f"[{start + half - 3}:{start + half},{rows}"
    micro = (51123, 2, 0, b'{"Exposure-ms": 20.0, "Zyla-SensorTemperature": "0,50"}', True)
    planes = {"ExposureTime": [20.0, 40.0], "ExposureTimeUnit": ["ms", "ms"]}
    grey = np.stack([CODES[0].astype(np.uint8)] * 3, -1)
    mono = {"metadata": None, "photometric": "minisblack"}
    unity = (1, 1, 0, 1, 0, 1, 0, 1, 1, 1, 0, 1, 0, 1, 0, 1, 1, 1)
    tags = [
        (50706, 1, 4, b"\x01\x04\x00\x00", True), (50708, 2, 0, "Test Camera", True),
        (33421, 3, 2, (2, 2), True), (33422, 1, 4, b"\x00\x01\x01\x02", True),
        (50714, 4, 1, 64, True), (50717, 4, 1, 4095, True), (50721, 10, 9, unity, True),
        (33434, 5, 1, (1, 20), True),
    ]  # fmt: skip
    mosaic = np.tile(CODES[0], (2, 2))
    return {
        "fits": ("a.fits", plain),
        "fits extension": ("a.fit", extension),
        "fits chips": ("a.fits", chips),
        "fits quality": ("a.fits", quality),
        "fits amplifiers": ("a.fits", held(amplifiers.writeto)),
        "fits.gz": ("a.fits.gz", gzip.compress(plain, mtime=0)),
        "fits in gz": ("a.fits.gz", plain),  # damaged, then packed
        **{f"fz {how}": ("a.fits.fz", data) for how, data in tiles.items()},
        "npy": ("a.npy", _npy(CODES)),
        "npz": ("a.npz", archive(zipfile.ZIP_STORED)),
        "npz deflated": ("a.npz", archive(zipfile.ZIP_DEFLATED)),
        "npz last": ("a.npz", last.getvalue()),
        "hdf5": ("a.h5", hdf5()),
        "hdf5 chunked": ("a.h5", hdf5(chunks=(1, 8, 8), compression="gzip")),
        "tiff": ("a.tif", tif(CODES, **mono)),
        "tiff imagej": ("a.tif", tif(CODES, imagej=True)),
        "tiff deflated": ("a.tif", tif(CODES, compression="zlib", predictor=True, **mono)),
        "tiff tiled": ("a.tif", tif(CODES[0], tile=(16, 16), **mono)),
        "tiff colour": ("a.tif", tif(grey, photometric="rgb", metadata=None)),
        "tiff packed": ("a.tif", _packed_tif()),
        "tiff manager": ("a.tif", tif(CODES[0], extratags=[micro], **mono)),
        "tiff text": ("a.tif", tif(CODES, description="Exposure (ms): 20\nT [C] = 5", **mono)),
        "tiff ome": ("a.ome.tif", tif(CODES, ome=True, metadata={"axes": "TYX", "Plane": planes})),
        "png": ("a.png", png(CODES[0])),
        "png colour": ("a.png", png(grey)),
        "pgm": (
            "a.pgm",
            b"P5\n# exposure_s = 0.5\n40 32\n4095\n" + CODES[0].astype(">u2").tobytes(),
        ),
        "dng": ("a.dng", tif(mosaic, photometric="cfa", metadata=None, extratags=tags)),
    }  # fmt: skip


def _ser() -> bytes:
    rows, columns = SHAPE
    head = b"LUCAM-RECORDER" + np.array([0, 8, 0, columns, rows, 12, 2], "<i4").tobytes()
    return head.ljust(178, b"\0") + CODES.astype("<u2").tobytes() + bytes(16)


def _archives(video: bytes, program: str) -> Iterator[tuple[str, Sample]]:
    import tarfile
    import zipfile

    members = {"darks/a.ser": video, "darks/a.txt": program.encode(), "darks/.hidden": b"x"}
    for kind, compression in (("zip", zipfile.ZIP_DEFLATED), ("zip stored", zipfile.ZIP_STORED)):
        stream = io.BytesIO()
        with zipfile.ZipFile(stream, "w", compression) as archive:
            for name, data in members.items():
                archive.writestr(zipfile.ZipInfo(name), data, compression)
        yield kind, Sample("a.zip", stream.getvalue(), _read_archive)
    for kind, mode in (("tar.gz", "w:gz"), ("tar", "w")):
        stream = io.BytesIO()
        with tarfile.open(fileobj=stream, mode=mode, format=tarfile.PAX_FORMAT) as tar:
            for name, data in members.items():
                info = tarfile.TarInfo(name)
                info.size, info.pax_headers = len(data), {"comment": "darks"}
                tar.addfile(info, io.BytesIO(data))
        yield kind, Sample(f"a.{kind}", stream.getvalue(), _read_archive)


def _packed_tif() -> bytes:
    """One page of 12-bit samples, packed, as bytes: tags in the order of their numbers."""
    import struct

    from dnanalyze.loaders.packing import pack

    data = pack(CODES[0], 12, "msb").tobytes()
    rows, columns = SHAPE
    tags = [(256, columns), (257, rows), (258, 12), (259, 1), (262, 1), (273, 8), (277, 1),
            (278, rows), (279, len(data))]  # fmt: skip
    head = b"II*\0" + struct.pack("<I", 8 + len(data)) + data + struct.pack("<H", len(tags))
    return head + b"".join(struct.pack("<HHII", n, 4, 1, v) for n, v in tags) + bytes(4)


def _npy(array: Any) -> bytes:
    stream = io.BytesIO()
    np.save(stream, array)
    return stream.getvalue()


def _tables() -> Iterator[tuple[str, str, str]]:
    rows = "file,temperature_c,exposure_s,gain,channel,frame\n"
    rows += "T+025C/*.npy,25.0,0.05,1,hcg,0\nT+065C/b.npy,65.0,0.05,1,hcg,1\n"
    yield "manifest.csv", "manifest.csv", rows
    yield (
        "manifest.yaml",
        "manifest.yaml",
        "frames:\n- file: T+025C/a.npy\n  temperature_c: 25.0\n  exposure_s: 0.05\n"
        "- {file: T+065C/b.npy, temperature_c: 65.0, gain: 2, channel: lcg, frame: 3}\n",
    )
    yield (
        "sidecar",
        "dnanalyze.yaml",
        "cfa: GRBG\nbits: 12\nblack_level: 64\nwhite_level: 4095.0\npixel_pitch_um: 3.45\n"
        "active_columns: [2, 40]\noptical_black_columns: [0, 2]\ntemperature_c: 25\n"
        "exposure_s: 0.05\ngain: 1\nchannel: hcg\ntolerance_c: 1.5\nskip: ['*/c.npy']\n"
        "region: active\n",
    )


def _documents() -> Iterator[tuple[str, str, str, Callable[[Path], None]]]:
    from dnanalyze.model.export.table import to_csv, to_json
    from dnanalyze.model.noise_model import dump_model

    model = _model()
    yield "model", "model.yaml", dump_model(model), _read_model
    yield "table csv", "model.csv", to_csv(model), _read_table
    yield "table json", "model.json", to_json(model), _read_table
    yield (
        "targets",
        "targets.yaml",
        "schema: dnanalyze/targets/1\ndescription: nightly\nfalse_failures: 0.001\n"
        "captures: {name: darks, shape: [64, 64], frames: 8}\ntargets:\n"
        "- {statistic: mean, max: 70, at: {temperature_c: 65.0, exposure_s: 0.05}}\n"
        "- {statistic: temporal_noise, relative: 0.05, floors: 3.0, note: read noise}\n"
        "- {error: pooled, max: 1.5, enforced: false}\n"
        "- {parameter: read_noise.sigma, measured: 1.5, relative: 0.1}\n",
        _read_targets,
    )
    yield (
        "combination",
        "hdr.yaml",
        "channels:\n- {channel: hcg, black: 64, sensitivity: 1.0, knee: 3000, blend: 200}\n"
        "- {channel: lcg, black: 64, sensitivity: 0.1, knee: 3000, exposure: 1.0}\n"
        "companding: [[0, 64], [1000, 1000], [40000, 4095]]\nblack: 64\nbits: 12\n",
        _read_combination,
    )


def _model() -> Any:
    """A model with one of each kind of law and parameter."""
    from dnanalyze.loaders.captures import OperatingPoint
    from dnanalyze.model.laws import ArrheniusLaw, TableLaw
    from dnanalyze.model.noise_model import NoiseModel
    from dnanalyze.model.registry import built_in

    known = built_in()
    points = tuple(OperatingPoint(t, c) for t in (25.0, 65.0) for c in (0.05, 0.1))
    effects = (
        known["convolved_lognormal"](mu=ArrheniusLaw(1.0, 25.0, 0.6)),
        known["dark_shot_noise"](), known["hot_pixels"](), known["rts"](), known["column_fpn"](),
        known["read_noise"](sigma=TableLaw(points, (1.0, 1.5, 2.0, 2.5))),
        known["periodic_pattern"](), known["flicker_noise"](overhead=3),
        known["defect_lines"](lines=(3.0, 5.0), offsets=(1.0, -1.0)), known["quantization"](),
        known["missing_codes"](), known["dpc"](), known["denoise"](), known["temporal_denoise"](),
    )  # fmt: skip
    return NoiseModel(effects, 64.0, OperatingPoint(65.0, 0.05, 1.0))


# --- what reads them -------------------------------------------------------------------------


def _read_folder(path: Path) -> None:
    """Load the folder, and read the first and the last frame, in part and whole."""
    _read_capture(path.parent)


def _read_archive(path: Path) -> None:
    _read_capture(path)


def _read_capture(path: Path) -> None:
    from dnanalyze.loaders import load
    from dnanalyze.loaders.captures import Window

    captures = load(path)
    frames = list(captures.frames())
    rows, columns = captures.sensor.shape
    for frame in {id(f): f for f in (frames[0], frames[-1])}.values():
        array = frame.read()
        assert array.shape == (rows, columns), array.shape
        assert array.dtype.isnative, array.dtype
        assert np.isfinite(array).all()
        window = Window(1, rows - 1, 2, columns - 1)
        assert np.array_equal(frame.read(window), array[window.slices])
        if frame.masked is not None:
            frame.masked()


def _read_model(path: Path) -> None:
    from dnanalyze.model.noise_model import load_model

    _drawn(load_model(path))


def _drawn(model: Any) -> None:
    """A frame of the model at its reference, as ``simulate`` writes it."""
    from dnanalyze.loaders.writers import as_codes
    from dnanalyze.model.simulate import simulate

    frame = next(simulate(model, (16, 16), [(model.reference, 1)]).frames())
    as_codes(frame.read(), 16)


def _read_table(path: Path) -> None:
    from dnanalyze.model.export.table import read_table

    read_table(path)


def _read_targets(path: Path) -> None:
    from dnanalyze.checking.targets import load_targets

    load_targets(path)


def _read_combination(path: Path) -> None:
    from dnanalyze.model.hdr_file import load_combination

    load_combination(path).combine({"hcg": CODES[0], "lcg": CODES[1]})


# --- mutations -------------------------------------------------------------------------------

_NUMBER = re.compile(rb"[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?")
_WHOLE = (0, 1, -1, 127, 255, 32767, 65535, 2**31 - 1, -(2**31), 2**32 - 1, 2**63 - 1, 999999999)
_TOKENS = (
    *(str(n).encode() for n in _WHOLE), b"1e400", b"-1e-400", b".nan", b".inf", b"nan", b"9" * 400,
    b"1" + b":1" * 300, b"1" + b":1" * 300 + b".5", b"2001-99-99", b"", b"~", b"yes", b"[" * 200,
    b"{" * 50, b"- " * 100, b"&a [*a]", b"*a", b"!!binary xx", b"!!python/name:os.system", b"'",
    b'"', b"\x00", b"\xff\xfe", b"\xe2\x80\xae", b"../../etc/passwd", b"*" * 300, b"x" * 5000,
    b"{a: 1}", b"[1, 2]", b"1000001", b"-273.15", b"-300", b"? [a]", b"%s%n", b"\r",
)  # fmt: skip


def mutated(data: bytes, text: bool, rng: np.random.Generator) -> bytes:
    """The file with one damage or more."""
    for _ in range(min(6, int(rng.geometric(0.5)))):
        kinds = _OF_TEXT if text or rng.random() < 0.2 else _OF_BYTES
        data = kinds[rng.integers(len(kinds))](data, rng)
    return data[: 1 << 20]


def _at(data: bytes, rng: np.random.Generator) -> int:
    """A place in the file, half of the time among the first bytes, where headers are."""
    most = len(data) if rng.random() < 0.5 else min(len(data), 1024)
    return int(rng.integers(most)) if most else 0


def _flip(data: bytes, rng: np.random.Generator) -> bytes:
    out = bytearray(data)
    for _ in range(int(rng.integers(1, 9))):
        if out:
            out[_at(data, rng)] ^= 1 << int(rng.integers(8))
    return bytes(out)


def _noise(data: bytes, rng: np.random.Generator) -> bytes:
    place = _at(data, rng)
    block = rng.bytes(int(rng.integers(1, 33)))
    return data[:place] + block + data[place + len(block) :]


def _cut(data: bytes, rng: np.random.Generator) -> bytes:
    return data[: int(rng.integers(len(data) + 1))]


def _grow(data: bytes, rng: np.random.Generator) -> bytes:
    return data + bytes(int(rng.integers(1, 5000)))


def _splice(data: bytes, rng: np.random.Generator) -> bytes:
    """A block of the file copied, moved or taken away."""
    start, place = _at(data, rng), _at(data, rng)
    block = data[start : start + int(rng.integers(1, 2000))]
    drop = len(block) if rng.random() < 0.5 else 0
    return data[:place] + block * int(rng.integers(0, 4)) + data[place + drop :]


def _integer(data: bytes, rng: np.random.Generator) -> bytes:
    """A binary integer of a header made absurd."""
    size = int(rng.choice([1, 2, 4, 8]))
    place = _at(data, rng) // size * size
    value = _WHOLE[rng.integers(len(_WHOLE))] % (1 << (8 * size))
    order: Any = "little" if rng.random() < 0.5 else "big"
    return data[:place] + value.to_bytes(size, order) + data[place + size :]


def _number(data: bytes, rng: np.random.Generator) -> bytes:
    """A number in text made absurd; where columns are fixed (FITS), they stay."""
    numbers = list(_NUMBER.finditer(data[:20000]))
    if not numbers:
        return data
    match = numbers[rng.integers(len(numbers))]
    token = _TOKENS[rng.integers(len(_TOKENS))]
    end = match.end()
    if rng.random() < 0.5 and len(token) <= 20:
        start = max(0, end - max(len(token), len(match[0])))
        return data[:start] + token.rjust(end - start) + data[end:]
    return data[: match.start()] + token + data[end:]


def _token(data: bytes, rng: np.random.Generator) -> bytes:
    place = _at(data, rng)
    return data[:place] + _TOKENS[rng.integers(len(_TOKENS))] + data[place:]


def _lines(data: bytes, rng: np.random.Generator) -> bytes:
    """Lines repeated, lost or in another order."""
    lines = data.split(b"\n")
    what = rng.integers(4)
    place, other = rng.integers(len(lines), size=2)
    if what == 0:
        lines.insert(place, lines[other])
    elif what == 1:
        del lines[place]
    elif what == 2:
        lines[place], lines[other] = lines[other], lines[place]
    else:
        lines[place] = b"  " * int(rng.integers(1, 30)) + lines[place]
    return b"\n".join(lines)


def _word(data: bytes, rng: np.random.Generator) -> bytes:
    """A word replaced by another word of the file."""
    words = list(re.finditer(rb"[A-Za-z_]+", data[:20000]))
    if len(words) < 2:
        return data
    first, second = (words[k] for k in rng.integers(len(words), size=2))
    return data[: first.start()] + second[0] + data[first.end() :]


_OF_BYTES = (_flip, _noise, _cut, _grow, _splice, _integer, _integer, _flip)
_OF_TEXT = (*[_number] * 4, *[_lines] * 2, *[_word] * 2, _token, _flip, _cut, _splice)


# --- one file --------------------------------------------------------------------------------


class OutOfTime(BaseException):
    """Not an Exception: what is read must not be able to catch it."""


@dataclass(frozen=True)
class Outcome:
    """What became of one file."""

    number: int
    kind: str
    result: str  # "read", "refused", or what went wrong
    seconds: float


def attempt(number: int, seed: int, known: dict[str, Sample], folder: Path, show: bool) -> Outcome:
    """Damage a file, and read it under the alarm."""
    from dnanalyze.errors import InputError

    kind = list(known)[number % len(known)]
    sample = known[kind]
    shutil.rmtree(folder, ignore_errors=True)
    data = mutated(sample.data, sample.text, np.random.default_rng([seed, number]))
    if kind == "fits in gz":
        import gzip

        data = gzip.compress(data, 1, mtime=0)
    for name, content in {**sample.beside, sample.name: data}.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)
    begin = time.process_time()
    signal.setitimer(signal.ITIMER_PROF, LIMIT_S)
    signal.setitimer(signal.ITIMER_REAL, BLOCKED_S)
    try:
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            sample.read(folder / sample.name)
        result = "read" if not told else f"warning: {told[0].category.__name__}: {told[0].message}"
    except InputError as error:
        lines = str(error).count("\n") + 1
        long = len(str(error)) > 900
        result = "refused" if lines == 1 and not long else f"refused in {lines} lines: {error}"
    except OutOfTime:
        result = f"slower than {LIMIT_S:g} s: {_place(sys.exc_info()[2])}"
    except BaseException as error:
        result = f"{type(error).__name__}: {str(error)[:200]}: {_place(error.__traceback__)}"
        if show:
            traceback.print_exc()
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.setitimer(signal.ITIMER_REAL, 0)
    if show:
        print(kind, result)
    return Outcome(number, kind, " ".join(result.split()), time.process_time() - begin)


def _place(trace: Any) -> str:
    """The innermost lines of dnanalyze and of all."""
    frames = traceback.extract_tb(trace)
    own = [f for f in frames if "dnanalyze" in f.filename]
    return " < ".join(f"{Path(f.filename).name}:{f.lineno}" for f in (*frames[-1:], *own[-1:]))


def _limited() -> None:
    def ring(*_: object) -> None:
        raise OutOfTime

    for kind in (signal.SIGALRM, signal.SIGPROF):
        signal.signal(kind, ring)
    with open("/proc/self/statm", encoding="ascii") as file:
        now = int(file.read().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (now + HEADROOM, now + HEADROOM))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def _work(pipe: Connection, numbers: range, seed: int, folder: str) -> None:
    """A worker: outcomes one by one; "begun" before each, so that a crash is known by number."""
    tempfile.tempdir = folder  # what is unpacked goes when the worker is ended
    known = samples()
    _imported()
    _limited()
    for number in numbers:
        pipe.send(number)
        pipe.send(attempt(number, seed, known, Path(folder) / "case", False))
    pipe.close()


def _imported() -> None:
    """Import what readers import when they are asked, before memory is limited."""
    import numba  # noqa: F401
    import rawpy  # noqa: F401

    with tempfile.TemporaryDirectory() as folder:
        for kind, sample in samples().items():
            for name, content in {**sample.beside, sample.name: sample.data}.items():
                path = Path(folder, kind, name)
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_bytes(content)
            if kind != "fits in gz":
                sample.read(Path(folder, kind, sample.name))  # an intact sample must be read


# --- many ------------------------------------------------------------------------------------


@dataclass
class Worker:
    """A process with its share of the numbers."""

    numbers: range
    process: BaseProcess
    pipe: Connection
    folder: str
    current: int | None = None
    since: float = 0.0


def run(
    first: int, count: int, seed: int, workers: int, tell: Callable[[int], None]
) -> list[Outcome]:
    """Outcomes of ``count`` files from the number ``first`` on."""
    context = multiprocessing.get_context("spawn")
    outcomes: list[Outcome] = []
    kinds = list(samples())

    def start(numbers: range) -> Worker:
        folder = tempfile.mkdtemp(prefix="dnanalyze-fuzz-")
        mine, theirs = context.Pipe(False)
        process = context.Process(target=_work, args=(theirs, numbers, seed, folder), daemon=True)
        process.start()
        theirs.close()
        return Worker(numbers, process, mine, folder)

    def ended(worker: Worker, why: str) -> None:
        """Note what the file in hand did, and go on behind it."""
        worker.process.kill()
        worker.process.join()
        shutil.rmtree(worker.folder, ignore_errors=True)
        active.remove(worker)
        if worker.current is None:
            if why:
                raise RuntimeError(f"a worker did not start: {why}")
            return
        number, spent = worker.current, time.monotonic() - worker.since
        outcomes.append(Outcome(number, kinds[number % len(kinds)], why, spent))
        rest = worker.numbers[worker.numbers.index(number) + 1 :]
        if rest:
            active.append(start(rest))

    active = [start(range(first + k, first + count, workers)) for k in range(min(workers, count))]
    while active:
        ready = multiprocessing.connection.wait([w.pipe for w in active], 1.0)
        for worker in [w for w in active if w.pipe in ready]:
            try:
                said = worker.pipe.recv()
            except EOFError:
                worker.process.join(5)
                code = worker.process.exitcode
                ended(worker, f"the process ended with {code}" if code else "")
                continue
            if isinstance(said, Outcome):
                outcomes.append(said)
                worker.current = None
                tell(len(outcomes))
            else:
                worker.current, worker.since = said, time.monotonic()
        for worker in [w for w in active if w.current is not None]:
            if time.monotonic() - worker.since > 2 * BLOCKED_S:
                ended(worker, f"slower than {2 * BLOCKED_S:g} s, in a library that does not stop")
    return outcomes


def table(outcomes: list[Outcome]) -> str:
    """Outcomes by format, and each that is neither success nor refusal."""
    lines = [
        f"{'format':16s} {'files':>7s} {'read':>7s} {'refused':>8s} {'else':>5s} {'most, s':>10s}"
    ]
    kinds = dict.fromkeys(o.kind for o in sorted(outcomes, key=lambda o: o.number))
    for kind in (*kinds, "all"):
        own = [o for o in outcomes if kind in (o.kind, "all")]
        read, refused = (sum(o.result == r for o in own) for r in ("read", "refused"))
        slowest = max(o.seconds for o in own)
        lines.append(
            f"{kind:16s} {len(own):7d} {read:7d} {refused:8d} "
            f"{len(own) - read - refused:5d} {slowest:10.2f}"
        )
    bad = [o for o in outcomes if o.result not in ("read", "refused")]
    lines += [f"--repeat {o.number}: {o.kind}: {o.result}" for o in bad[:200]]
    return "\n".join(lines)


def main(arguments: list[str] | None = None) -> int:
    """The command line; 0 where every file was read or refused."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--count", type=int, default=5000, help="files")
    parser.add_argument("--first", type=int, default=0, help="number of the first")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--repeat", type=int, help="read this file again, with its traceback")
    given = parser.parse_args(arguments)
    if given.repeat is not None:
        folder = Path(tempfile.mkdtemp(prefix="dnanalyze-fuzz-"))
        print(folder)
        known = samples()
        _imported()
        _limited()
        again = attempt(given.repeat, given.seed, known, folder / "case", True)
        return 0 if again.result in ("read", "refused") else 1

    def tell(done: int) -> None:
        if sys.stderr.isatty() and done % 100 == 0:
            print(f"\r{done} of {given.count}", end="", file=sys.stderr)

    begin = time.monotonic()
    outcomes = run(given.first, given.count, given.seed, given.workers, tell)
    print(table(outcomes))
    print(f"{len(outcomes)} files, seed {given.seed}: {time.monotonic() - begin:.0f} s")
    return int(any(o.result not in ("read", "refused") for o in outcomes))


if __name__ == "__main__":
    sys.exit(main())
