"""A short part of ``benchmarks/fuzz_inputs.py``: damaged files are read or refused, no more."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[2] / "benchmarks" / "fuzz_inputs.py"


@pytest.mark.skipif(os.name != "posix" or not Path("/proc").is_dir(), reason="limits are Linux's")
def test_damaged_files_are_read_or_refused():
    done = subprocess.run(
        [sys.executable, SCRIPT, "--count", "660", "--workers", "1"],
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-1000:]
    (total,) = [line.split() for line in done.stdout.splitlines() if line.startswith("all ")]
    files, read, refused, other = map(int, total[1:5])
    assert (files, other) == (660, 0)
    assert min(read, refused) > 66  # the mutations neither spare nor ruin everything
