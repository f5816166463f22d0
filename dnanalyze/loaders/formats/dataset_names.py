"""What the names of datasets mean: NeXus, data exchange, and files of photon counters."""

from __future__ import annotations

from collections.abc import Sequence

from dnanalyze.loaders.files import natural_key

MASKS = ("pixel_mask", "bad_pixel_mask", "badpixel_mask", "bad_pixels", "mask", "pixelmask")
# Calibration that lies beside the frames, in their shape.
BESIDE = (
    "flatfield", "flat_field", "threshold", "trimbit", "gain_map", "gainmap", "efficiency",
    "error", "errors", "uncertainty", "variance", "data_errors", "countrate_correction_table",
)  # fmt: skip
DARK = ("data_dark", "dark", "darks", "dark_frames", "dark_field", "darkfield")
LIT = ("data_white", "white", "flat", "flats", "data_flat", "flatfields")
# Scalars of detector groups, in the words of header keys.
SCALARS = {
    "count_time": "EXPOSURE", "exposure_time": "EXPOSURE", "exposure": "EXPOSURE",
    "integration_time": "EXPOSURE", "acquire_time": "EXPOSURE", "frame_exposure_time": "EXPOSURE",
    "exposure_s": "EXPOSURE", "temperature": "TEMPERATURE", "temperature_c": "TEMPERATURE",
    "detector_temperature": "TEMPERATURE", "sensor_temperature": "TEMPERATURE",
    "ccd_temperature": "TEMPERATURE", "gain": "GAIN", "gain_setting": "GAIN",
}  # fmt: skip


def last(label: str) -> str:
    """The name of a dataset without its groups, in lower case."""
    return label.rsplit("/", 1)[-1].lower()


def is_mask(label: str) -> bool:
    """Whether a dataset, or an array of an archive, is a mask by its name."""
    return last(label) in MASKS


def frames_of(labels: Sequence[str]) -> tuple[list[str], str]:
    """Which datasets are dark frames, and a note on those that are not.

    Parameters
    ----------
    labels : sequence of str
        All datasets of two or three dimensions that are no masks.
    """
    own = [x for x in labels if last(x) not in BESIDE]
    dark = [x for x in own if last(x) in DARK]
    lit = [x for x in own if last(x) in LIT]
    if dark:
        left = [x for x in labels if x not in dark]
        named = ", ".join(left[:3]) + (", ..." if len(left) > 3 else "")
        note = f"Taken as dark frames: {', '.join(dark[:3])}; left out: {named}." if left else ""
        return sorted(dark, key=natural_key), note
    if lit and len(lit) < len(own):
        own = [x for x in own if x not in lit]
        note = f"Left out as lit: {', '.join(lit[:3])}."
        return sorted(own, key=natural_key), note
    return sorted(own, key=natural_key), ""
