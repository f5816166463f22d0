"""Constants of the engine stand beside a reason."""

import ast
from itertools import chain
from pathlib import Path

import pytest

import dnanalyze

ROOT = Path(dnanalyze.__file__).parent
ENGINE = "comparator", "fitting", "diagnosis", "detection", "description", "classifier"
FILES = sorted(
    chain.from_iterable((ROOT / part).rglob("*.py") for part in (*ENGINE, "model/guesses"))
)


def numbers(node):
    return [
        n.value
        for n in ast.walk(node)
        if isinstance(n, ast.Constant) and type(n.value) in (int, float)
    ]


def without_reason(source):
    """Names of module constants with a number that have a comment neither beside nor above."""
    lines = source.split("\n")
    found, told = [], False
    for node in ast.parse(source).body:
        if not isinstance(node, ast.Assign | ast.AnnAssign) or node.value is None:
            told = False
            continue
        above = lines[node.lineno - 2].strip()
        beside = any("#" in line for line in lines[node.lineno - 1 : node.end_lineno])
        # a comment is of all constants that stand below it without a gap
        told = above.startswith("#") or (told and above != "")
        target = node.targets[0] if isinstance(node, ast.Assign) else node.target
        name = ast.unparse(target).strip("(_").split(",")[0]
        if name.isupper() and numbers(node.value) and not (beside or told):
            found.append(name)
    return found


@pytest.mark.parametrize("file", FILES, ids=lambda file: str(file.relative_to(ROOT)))
def test_a_constant_states_its_reason(file):
    assert without_reason(file.read_text("utf-8")) == []


def test_a_bare_constant_is_noticed():
    assert without_reason("FEW = 3\n") == ["FEW"]
    assert without_reason("FEW = 3  # for a median\n") == []
    assert without_reason("# For a median\nFEW = 3\nMANY = 9\n\nMOST = 4\n") == ["MOST"]
