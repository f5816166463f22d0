"""The documentation of the public API: complete in numpydoc's terms, with examples that run."""

import doctest
import importlib
import inspect
from pathlib import Path

import matplotlib.pyplot as plt
import pytest
from numpydoc.validate import validate

import dnanalyze

ROOT = Path(__file__).resolve().parents[2]
# not asked for: an extended summary, "See Also", where the text of a summary begins, and the
# parameters that Python's own enumerations take
LEFT_OUT = {"GL01", "ES01", "SA01", "SA04", "EX01"}
OTHERS = {"dnanalyze.model.effect.Stage": {"PR01"}}
RESULT = ("plot", "save", "summary", "to_dataframe", "to_dict")
SLOW = {
    "add",
    "benchmark",
    "classify",
    "compare",
    "describe",
    "diagnose",
    "refine",
}  # their examples simulate a lot


def public():
    for name in dnanalyze.__all__:
        if not name.startswith("__"):
            yield name, getattr(dnanalyze, name)


def members(kind):
    """Public functions and properties that the project documents."""
    for name, value in inspect.getmembers(kind):
        function = value.fget if isinstance(value, property) else getattr(value, "func", value)
        module = getattr(function, "__module__", "") or ""
        callable_ = inspect.isfunction(function) or inspect.ismethod(function)
        own = not getattr(function, "__name__", "_").startswith("_")
        if not name.startswith("_") and own and callable_ and module.startswith("dnanalyze"):
            yield name


def documented():
    for _, item in public():
        path = f"{item.__module__}.{item.__qualname__}"
        yield path
        if inspect.isclass(item):
            yield from (f"{path}.{name}" for name in members(item))


@pytest.mark.parametrize("path", sorted(set(documented())))
def test_numpydoc_finds_nothing_missing(path):
    left_out = LEFT_OUT | OTHERS.get(path, set())
    found = [f"{code}: {text}" for code, text in validate(path)["errors"] if code not in left_out]
    assert not found


def functions():
    yield from ((name, item) for name, item in public() if inspect.isfunction(item))
    yield from ((name, getattr(dnanalyze.Statistics, name)) for name in RESULT)


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "item"),
    [
        pytest.param(name, item, marks=[pytest.mark.slow] if name in SLOW else [], id=name)
        for name, item in functions()
    ],
)
def test_the_examples_run(name, item, monkeypatch):
    monkeypatch.chdir(ROOT)
    module = importlib.import_module(item.__module__)
    flags = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    finder, said = doctest.DocTestFinder(recurse=False), []
    (test,) = finder.find(item, name, module)
    assert test.examples, f"{name} has no example"
    doctest.DocTestRunner(optionflags=flags, verbose=False).run(test, out=said.append)
    plt.close("all")
    assert not said, "".join(said)


def test_what_a_type_checker_reads_is_what_is_imported():
    """The imports under TYPE_CHECKING, the table of homes and `__all__` name the same."""
    import ast

    tree = ast.parse(Path(dnanalyze.__file__).read_text())
    checked = {
        (node.module, name.name)
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and str(node.module).startswith("dnanalyze")
        for name in node.names
    }
    homes = {(module, name) for module, names in dnanalyze._HOME.items() for name in names}
    assert checked == homes
    assert {name for _, name in homes} | {"__version__"} == set(dnanalyze.__all__)


@pytest.mark.parametrize(
    ("name", "function"), [(name, item) for name, item in public() if inspect.isfunction(item)]
)
def test_a_function_has_at_most_eight_parameters(name, function):
    assert len(inspect.signature(function).parameters) <= 8
