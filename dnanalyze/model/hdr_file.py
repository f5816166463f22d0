"""The file that says how the channels of an HDR sensor become one output."""

from __future__ import annotations

from pathlib import Path

from dnanalyze.errors import InputError
from dnanalyze.loaders.text import read_yaml
from dnanalyze.model.hdr import ChannelUse, Combination

KEYS = ("channels", "companding", "black", "bits")
CHANNEL_KEYS = ("channel", "black", "sensitivity", "knee", "blend", "exposure")


def load_combination(path: Path) -> Combination:
    """Read a combination file (YAML).

    Raises
    ------
    InputError
        Not YAML, unknown or missing keys, a combination that cannot be.
    """
    raw = read_yaml(path)
    if not isinstance(raw, dict) or not isinstance(raw.get("channels"), list):
        raise InputError(f"{path}: not a combination file; it needs 'channels', a list")
    for place, valid in [(raw, KEYS), *((c, CHANNEL_KEYS) for c in raw["channels"])]:
        extra = [k for k in place if k not in valid] if isinstance(place, dict) else [place]
        if extra:
            raise InputError(f"{path}: unknown key {extra[0]!r}; valid: {', '.join(valid)}")
    try:
        uses = tuple(ChannelUse(**c) for c in raw["channels"])
        knees = tuple((float(x), float(y)) for x, y in raw.get("companding", ()))
        rest = {k: raw[k] for k in ("black", "bits") if k in raw}
        return Combination(uses, knees, **rest)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    except (TypeError, ValueError, OverflowError):
        need = "channel, black, sensitivity, knee"
        raise InputError(
            f"{path}: each channel needs {need}; companding is [linear, code] pairs"
        ) from None
