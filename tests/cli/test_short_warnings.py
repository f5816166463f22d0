"""A numerical warning reaches the user as one line."""

import subprocess
import sys

from dnanalyze_cli.short_warnings import ShortWarnings


def test_a_warning_is_one_line_and_told_once(capsys):
    told = ShortWarnings()
    for _ in range(3):
        told(RuntimeWarning("overflow\nencountered in multiply"), RuntimeWarning, "/a/b.py", 7)
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert err.startswith("note: overflow encountered in multiply (RuntimeWarning at b.py:7): ")


def test_a_run_has_no_more_than_three(capsys):
    told = ShortWarnings()
    for line in range(9):
        told(RuntimeWarning("invalid value"), RuntimeWarning, "c.py", line)
    assert capsys.readouterr().err.count("note: ") == 3


def test_the_command_prints_no_source_line():
    code = (
        "import sys, numpy as np, dnanalyze_cli.main as m\n"
        "m.main = lambda: int(np.float32(1e38) * np.float32(1e38) == 0)\n"
        "m.run()"
    )
    done = subprocess.run(
        [sys.executable, "-W", "default", "-c", code], capture_output=True, text=True
    )
    assert done.returncode == 0
    assert done.stderr.startswith("note: overflow encountered in ")
    assert done.stderr.count("\n") == 1
