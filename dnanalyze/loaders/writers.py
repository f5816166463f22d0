"""A capture set as a folder of files that ``load`` reads back, with its manifest."""

from __future__ import annotations

import csv
import io
import os
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

import numpy as np
import yaml

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import CaptureSet, OperatingPoint, Sensor
from dnanalyze.loaders.files import unreadable
from dnanalyze.loaders.manifest import COLUMNS
from dnanalyze.loaders.packing import PACKED_BITS, pack
from dnanalyze.progress import Progress

RAW = {  # format to (bits, packing)
    **{f"raw{bits}": (bits, "plain") for bits in (8, 10, 12, 14, 16)},
    **{f"raw{bits}-{how}": (bits, how) for bits in PACKED_BITS for how in ("mipi", "lsb")},
}
FORMATS = ("tif", "fits", "npy", "h5", "png", "pgm", *RAW)


def write_captures(
    captures: CaptureSet,
    folder: str | os.PathLike[str],
    format: str = "tif",
    *,
    bits: int | None = None,
    progress: Progress | None = None,
) -> Path:
    """Write every frame, one file each, as ``T+065C/dark_000.tif``, and a manifest last.

    Frames are rounded and clipped to 0 .. 2**bits - 1 DN. Each file appears under its name only
    when it is complete; a folder without manifest was interrupted.

    Parameters
    ----------
    captures : CaptureSet
    folder : str or path
        Made where absent; must hold no manifest yet.
    format : str
        One of ``FORMATS``; "raw12" is headerless with two bytes a pixel, "raw12-mipi" packed as
        CSI-2 does, "raw12-lsb" packed from the lowest bit.
    bits : int, optional
        Bits of a pixel, up to 16; the sensor's where it knows them, otherwise 16. Headerless raw
        has the bits of its name.
    progress : callable, optional
        ``progress(done, total)`` after each frame.

    Returns
    -------
    Path
        The folder.

    Raises
    ------
    InputError
        Unknown format or bits, or a folder that cannot be written or holds a capture already.
    """
    raw = RAW.get(format)
    bits = raw[0] if raw else bits or min(captures.sensor.bits or 16, 16)
    encode = _encoder(format, bits)
    suffix = "raw" if raw else format
    root = Path(folder)
    manifest = root / "manifest.csv"
    if manifest.exists():
        raise InputError(f"{root}: holds a capture already; give an empty folder")
    rows: list[list[Any]] = []
    try:
        root.mkdir(parents=True, exist_ok=True)
        for below, setting in zip(_folders(captures), captures.settings, strict=True):
            (root / below).mkdir(parents=True, exist_ok=True)
            for number, frame in enumerate(setting.frames):
                name = f"{below}/dark_{number:03d}.{suffix}"
                with atomic(root / name) as file:
                    encode(file, as_codes(frame.read(), bits), frame.point)
                p = frame.point
                rows.append([name, p.temperature_c, p.exposure_s, p.gain, p.channel, number])
                if progress:
                    progress(len(rows), captures.frame_count)
        if sidecar := _sidecar(captures.sensor, bits, raw and raw[1]):
            with atomic(root / "dnanalyze.yaml") as file:
                file.write(yaml.safe_dump(sidecar, sort_keys=False).encode())
        with atomic(manifest) as file:
            file.write(_table(rows))
    except OSError as error:
        raise unreadable(str(root), error) from error
    return root


def as_codes(array: np.ndarray, bits: int) -> np.ndarray:
    """Counts rounded and clipped to ``bits`` bits; uint8 up to 8 bits, else uint16.

    Raises
    ------
    InputError
        A pixel is not finite.
    """
    if array.dtype.kind == "f" and not np.isfinite(array).all():
        raise InputError(
            "frames hold pixels that are NaN or infinite; correct the parameters of the model"
        )
    dtype = np.uint8 if bits <= 8 else np.uint16
    return np.clip(np.rint(array), 0, (1 << bits) - 1).astype(dtype)


@contextmanager
def atomic(path: Path) -> Iterator[IO[bytes]]:
    """A file that takes its name only when it is complete, and leaves nothing otherwise."""
    handle, temporary = tempfile.mkstemp(prefix=f".{path.name}.", dir=path.parent)
    os.close(handle)
    try:
        with open(temporary, "w+b") as file:  # by name: encoders ask for it
            yield file
        os.chmod(temporary, 0o666 & ~_umask())
        os.replace(temporary, path)
    except BaseException:  # an interrupt too must leave no half-written file
        Path(temporary).unlink(missing_ok=True)
        raise


def atomic_write(path: Path, content: str | bytes) -> None:
    """Write a file under a temporary name in its folder, then give it its name.

    Raises
    ------
    InputError
        The folder is missing or cannot be written.
    """
    try:
        with atomic(path) as stream:
            stream.write(
                content.encode("utf-8", "backslashreplace") if isinstance(content, str) else content
            )
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror or error}") from None


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


Encoder = Callable[[IO[bytes], np.ndarray, OperatingPoint], None]


def _encoder(format: str, bits: int) -> Encoder:
    if format not in FORMATS:
        raise InputError(f"format {format!r}: valid formats: {', '.join(FORMATS)}")
    if not 1 <= bits <= 16:
        raise InputError(f"bits {bits}: valid: 1 to 16")
    if format in RAW:
        return lambda file, codes, point: _raw(file, codes, *RAW[format])
    if format == "pgm":
        return lambda file, codes, point: _pgm(file, codes, bits)
    return {"tif": _tif, "fits": _fits, "npy": _npy, "h5": _h5, "png": _png}[format]


def _tif(file: IO[bytes], codes: np.ndarray, point: OperatingPoint) -> None:
    import tifffile

    tifffile.imwrite(file, codes, photometric="minisblack", metadata=None)


def _fits(file: IO[bytes], codes: np.ndarray, point: OperatingPoint) -> None:
    from astropy.io import fits

    hdu = fits.PrimaryHDU(codes)
    for key, value, unit in (
        ("CCD-TEMP", point.temperature_c, "[C]"), ("EXPTIME", point.exposure_s, "[s]"),
        ("GAIN", point.gain, "factor"),
    ):  # fmt: skip
        if value is not None:
            hdu.header[key] = value, unit
    hdu.writeto(file)


def _npy(file: IO[bytes], codes: np.ndarray, point: OperatingPoint) -> None:
    np.save(file, codes, allow_pickle=False)


def _h5(file: IO[bytes], codes: np.ndarray, point: OperatingPoint) -> None:
    import h5py

    with h5py.File(file, "w") as h5:
        data = h5.create_dataset("frames", data=codes)
        for key, value in vars(point).items():
            if value is not None:
                data.attrs[key] = value


def _png(file: IO[bytes], codes: np.ndarray, point: OperatingPoint) -> None:
    from PIL import Image

    Image.fromarray(codes).save(file, format="PNG")


def _pgm(file: IO[bytes], codes: np.ndarray, bits: int) -> None:
    file.write(f"P5\n{codes.shape[1]} {codes.shape[0]}\n{(1 << bits) - 1}\n".encode())
    file.write(codes.astype(">u2" if bits > 8 else "u1").tobytes())


def _raw(file: IO[bytes], codes: np.ndarray, bits: int, packing: str) -> None:
    if packing == "plain":
        file.write(codes.astype("<u2" if bits > 8 else "u1").tobytes())
    else:
        file.write(pack(codes, bits, packing).tobytes())


def _sidecar(sensor: Sensor, bits: int, packing: str | None) -> dict[str, Any]:
    """What the format cannot hold: the raw layout (``packing`` given), and the sensor's facts."""
    plain: dict[str, Any] = {}
    if packing is not None:
        plain = {"width": sensor.shape[1], "height": sensor.shape[0], "bits": bits}
        plain |= {"byte_order": "little"} if packing == "plain" else {"packing": packing}
    facts = {
        "bits": bits if bits < 16 else None,
        "cfa": None if sensor.cfa is None else "".join("".join(row) for row in sensor.cfa),
        "black_level": sensor.black_level,
        "white_level": sensor.white_level,
        "pixel_pitch_um": sensor.pixel_pitch_um,
        "system_gain_dn_e": sensor.system_gain_dn_e,
    }
    return plain | {key: value for key, value in facts.items() if value is not None}


def _folders(captures: CaptureSet) -> list[str]:
    """``T+065C``, with what else tells the settings apart: ``T+065C_exp0.05s_gain4_hcg``."""
    points = [s.point for s in captures.settings]

    def differ(name: str) -> bool:
        return len({getattr(p, name) for p in points}) > 1

    names: list[str] = []
    for p in points:
        parts = [f"T{_signed(p.temperature_c)}C"] if p.temperature_c is not None else []
        if p.exposure_s is not None and differ("exposure_s"):
            short = 0 < p.exposure_s < 1e-3
            parts.append(f"exp{p.exposure_s * (1e6 if short else 1):g}{'us' if short else 's'}")
        if p.gain is not None and differ("gain"):
            parts.append(f"gain{p.gain:.6g}")
        if p.channel is not None and differ("channel"):
            parts.append(_safe(p.channel))
        name = "_".join(parts) or "dark"
        names.append(name if name not in names else f"{name}_{len(names)}")
    return names


def _signed(value: float) -> str:
    text = f"{abs(value):07.3f}".rstrip("0").rstrip(".")
    return ("-" if value < 0 else "+") + text


def _safe(text: str) -> str:
    return "".join(c if c.isalnum() or c in "+-" else "-" for c in text)[:40]


def _table(rows: list[list[Any]]) -> bytes:
    kept = [k for k in range(len(COLUMNS)) if any(row[k] is not None for row in rows)]
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow([COLUMNS[k] for k in kept])
    table.writerows([["" if row[k] is None else row[k] for k in kept] for row in rows])
    return text.getvalue().encode()
