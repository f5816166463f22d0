"""What only POSIX systems have is not needed."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from dnanalyze import processors

LACKING = """
import os, signal, sys
for module in ("fcntl", "grp", "pwd", "resource", "termios", "tty"):
    sys.modules[module] = None
for name in ("sched_getaffinity", "fork", "forkpty", "getuid", "geteuid", "getgid", "sysconf",
             "statvfs", "mkfifo", "pread", "preadv", "readv", "posix_fadvise", "getloadavg",
             "nice", "killpg", "setsid", "wait3", "wait4", "chown", "lchown"):
    if hasattr(os, name):
        delattr(os, name)
for name in ("SIGKILL", "SIGHUP", "SIGALRM", "SIGUSR1", "pthread_kill", "setitimer", "alarm"):
    if hasattr(signal, name):
        delattr(signal, name)
"""
COMMANDS = [["inspect", "FOLDER"], ["analyze", "FOLDER", "--json=o.json", "--report=o.html"],
            ["fit", "FOLDER", "-o", "m.yaml"], ["compare", "FOLDER", "--model", "m.yaml"],
            ["simulate", "made", "--model", "m.yaml", "--like", "FOLDER"]]  # fmt: skip
ONE_BY_ONE = """
from dnanalyze_cli.main import run
for command in {!r}:
    sys.argv = ["dnanalyze", *command]
    try:
        run()
    except SystemExit as ended:
        if ended.code:
            raise
"""


def run(lines, folder, **environment):
    return subprocess.run(
        [sys.executable, "-c", LACKING + lines],
        cwd=folder,
        env=os.environ | environment,
        capture_output=True,
        timeout=300,
    )


@pytest.fixture
def folder(tmp_path):
    made = run(
        "from pathlib import Path\nfrom dnanalyze.demo import tiny\n"
        "from dnanalyze.loaders import write_captures\n"
        "one = tiny().select(lambda point: point.temperature_c == 45.0)\n"
        "write_captures(one, Path('captures'))",
        tmp_path,
    )
    assert made.returncode == 0, made.stderr
    return tmp_path


@pytest.mark.long
def test_commands_run_without_them_and_in_a_console_of_one_byte_a_character(folder):
    given = [["captures" if a == "FOLDER" else a for a in command] for command in COMMANDS]
    made = run(ONE_BY_ONE.format(given), folder, PYTHONIOENCODING="cp1252")
    assert made.returncode == 0, made.stderr
    assert b"Traceback" not in made.stderr
    made.stdout.decode("cp1252")
    assert {"o.json", "o.html", "m.yaml", "made"} <= {p.name for p in Path(folder).iterdir()}


def test_processors_are_counted_with_and_without_the_affinity(monkeypatch):
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 2, 5}, raising=False)
    assert processors.cpu_count() == 3
    monkeypatch.delattr(os, "sched_getaffinity")
    monkeypatch.setattr(os, "cpu_count", lambda: 7)
    assert processors.cpu_count() == 7
    monkeypatch.setattr(os, "cpu_count", lambda: None)
    assert processors.cpu_count() == 1
