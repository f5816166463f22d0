"""The examples in the docstrings of the workbench."""

from __future__ import annotations

import doctest
import importlib
import pkgutil

import pytest

pytest.importorskip("panel", reason="the extra workbench is not installed")

import dnanalyze.workbench

MODULES = sorted(
    m.name for m in pkgutil.walk_packages(dnanalyze.workbench.__path__, "dnanalyze.workbench.")
)


@pytest.mark.parametrize("name", MODULES)
def test_the_examples_of_a_module_run(name):
    flags = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    assert doctest.testmod(importlib.import_module(name), optionflags=flags).failed == 0
