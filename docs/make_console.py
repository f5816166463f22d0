"""Run the console blocks of the manual again and write what the commands print.

    python docs/make_console.py README.md docs/first-hour.md ...

Each page has a scratch folder of its own that begins with the demo's sensor (`sensor`) and the
files of sample_configs. Every line `$ dnanalyze ...` of a ```console block is run there, in order,
80 columns wide. A line "..." stands for what is left out: as many lines as before are kept
on either side. Python blocks that write a folder of frames are run first.
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
RUN = "from dnanalyze_cli.main import run; run()"
BLOCK = re.compile(r"```console\n(.*?)```", re.S)
SCRIPT = re.compile(r"```python\n([^`]*write_folder\([^`]*)```")  # makes a page's own captures
SKIPPED = ("dnanalyze simulate",)  # large frames for no text


def rerun(page: Path) -> None:
    """Write a page with the present output of its commands."""
    text = page.read_text(encoding="utf-8")
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        for file in (ROOT / "sample_configs").iterdir():
            if file.is_file():
                shutil.copy(file, folder)
        _printed("dnanalyze demo sensor", folder)
        for script in SCRIPT.findall(text):
            subprocess.run(
                [sys.executable, "-c", script], cwd=folder, env=_environment(), check=True
            )
        text = BLOCK.sub(lambda found: f"```console\n{_block(found[1], folder)}```", text)
    page.write_text(text, encoding="utf-8")


def _block(old: str, folder: Path) -> str:
    """A block's commands, each with what it prints now."""
    parts = re.split(r"^(?=\$ )", old, flags=re.M)
    return "".join(_part(part, folder) for part in parts if part)


def _part(old: str, folder: Path) -> str:
    command, _, shown = old.partition("\n")
    if not command.startswith("$ dnanalyze ") or command[2:].startswith(SKIPPED):
        return old
    lines = _printed(command[2:], folder)
    kept = shown.rstrip().splitlines()
    marks = [n for n, line in enumerate(kept) if line.strip() == "..."]
    if marks:
        after = [line for line in kept[marks[0] + 1 :] if line.strip()]
        end = [line for line in lines if line.strip()][-len(after) :] if after else []
        lines = [*lines[: marks[0] - 1], "", "  ...", "", *end]
    if not kept:
        lines = []
    body = "\n".join(lines).strip("\n")
    return f"{command}\n" + (f"{body}\n" if body else "")


def _printed(command: str, folder: Path) -> list[str]:
    """What a command prints, without the spaces at the ends of lines."""
    arguments = shlex.split(command)[1:]
    done = subprocess.run(
        [sys.executable, "-c", RUN, *arguments],
        cwd=folder, capture_output=True, text=True,
        env=_environment(),
    )  # fmt: skip
    if done.returncode not in (0, 1):
        raise SystemExit(f"{command}: exit {done.returncode}: {done.stderr.strip()}")
    return [line.rstrip() for line in done.stdout.splitlines()]


def _environment() -> dict[str, str]:
    path = os.pathsep.join([str(ROOT), str(ROOT / "cli")])
    return os.environ | {"COLUMNS": "80", "PYTHONPATH": path}


if __name__ == "__main__":
    for name in sys.argv[1:]:
        rerun(Path(name))
