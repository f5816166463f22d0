"""Files that hold pictures and are not read: what they are, and what to give instead."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path

_GROUPS = (
    (
        "jpg jpeg jpe heic heif webp gif bmp avif",
        "processed pictures, whose noise is filtered and compressed; save raw frames (the camera's "
        "raw format, DNG, FITS or 16-bit TIFF)",
    ),
    (
        "mp4 mov avi mkv m4v mpg mpeg wmv webm mts",
        "video; record SER, FITS or TIFF frames without compression, or, where it is uncompressed, "
        "extract them: ffmpeg -i VIDEO -pix_fmt gray16le dark_%04d.tif",
    ),
    (
        "czi nd2 lif oib oif vsi ims scn",
        "a microscope's own format; export OME-TIFF (bfconvert FILE dark.ome.tif)",
    ),
    ("xisf", "PixInsight's format; save them as FITS"),
    ("mat", "MATLAB files; write the frames as TIFF or HDF5 (h5create, h5write)"),
    ("cine mraw seq ptw", "a high-speed camera's own format; export 16-bit TIFF"),
    ("7z rar", "archives; unpack them and give the folder"),
    ("zip tar tgz gz bz2 xz", "archives; give each by itself, or unpack them here"),
)
UNREAD = {f".{suffix}": text for names, text in _GROUPS for suffix in names.split()}


def instead(files: Sequence[Path]) -> str:
    """What was found and what to do, of the commonest kind that is not read; "" if none is."""
    counts = Counter(f.suffix.lower() for f in files if f.suffix.lower() in UNREAD)
    if not counts:
        return ""
    (suffix, count) = counts.most_common(1)[0]
    return f"{count} {suffix} file{'s' * (count > 1)}: {UNREAD[suffix]}"
