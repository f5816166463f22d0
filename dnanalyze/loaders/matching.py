"""The user's regular expression, searched under a limit of time.

Python's ``re`` backtracks: an expression such as ``(a+)+b`` takes a time that doubles with every
character of a name that does not match, and a running match cannot be stopped from within on all
systems. So the names are matched in a process of its own, which is ended when its time is up.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Sequence

from dnanalyze.errors import InputError

# Time of the processor, so that a busy machine refuses nothing: 100,000 names take about 0.3 s.
CPU_SECONDS = 1
# Where the system has no such limit, and for a process that hangs.
WALL_SECONDS = 20.0
_CODE = f"""
import json, re, sys
try:
    import resource
    resource.setrlimit(resource.RLIMIT_CPU, ({CPU_SECONDS}, {CPU_SECONDS}))
except (ImportError, OSError, ValueError):
    pass
pattern, names = json.load(sys.stdin)
try:
    found = re.compile(pattern)
except (re.error, RecursionError, OverflowError) as error:
    json.dump({{"error": str(error) or type(error).__name__}}, sys.stdout)
else:
    said = []
    for name in names if found.groupindex else ():
        match = found.search(name)
        said.append(match.groupdict() if match else {{}})
    json.dump({{"groups": list(found.groupindex), "said": said}}, sys.stdout)
"""


def named_groups(pattern: str, names: Sequence[str]) -> tuple[set[str], list[dict[str, str]]]:
    """The named groups of an expression, and what they hold in each name.

    Parameters
    ----------
    pattern : str
        A Python regular expression.
    names : sequence of str

    Returns
    -------
    groups : set of str
    found : list of dict
        Group to text for each name; empty where it does not match.

    Raises
    ------
    InputError
        No regular expression, or one that takes too long.
    """
    try:
        done = subprocess.run(
            [sys.executable, "-I", "-S", "-c", _CODE],
            input=json.dumps([pattern, list(names)]),
            capture_output=True,
            text=True,
            timeout=WALL_SECONDS,
        )
        said = json.loads(done.stdout)
    except (subprocess.TimeoutExpired, ValueError) as error:  # ended: nothing, or half a text
        raise InputError(
            f"name_regex {pattern[:60]!r}: takes more than {CPU_SECONDS} s over the file names; "
            "avoid nested repetitions such as (a+)+"
        ) from error
    if "error" in said:
        raise InputError(f"name_regex: is no regular expression: {said['error'][:120]}")
    return set(said["groups"]), said["said"]
