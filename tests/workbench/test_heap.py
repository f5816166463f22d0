from __future__ import annotations

import platform
import re
from pathlib import Path

import numpy as np
import pytest

from dnanalyze.workbench.heap import give_back

PIECE, PIECES = 100 << 10, 2000  # bytes; pieces of that size come from the heap


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="another C library")
def test_free_memory_below_what_is_in_use_goes_back_to_the_system():
    pieces = [np.ones(PIECE, np.uint8) for _ in range(PIECES)]
    pieces = pieces[::100]  # some in use above what is free
    before = _resident()
    give_back()
    assert _resident() < before - PIECE * PIECES / 2


def _resident() -> int:
    status = Path("/proc/self/status").read_text()
    return 1024 * int(re.search(r"VmRSS:\s+(\d+)", status).group(1))
