"""Functions and classes with all that they lean on, gathered from their sources into one file.

The syntax trees of the package's own modules are cut to what is used, so that an exported simulator
is the simulator itself, not a second one to keep in step. Functions of modules are named
``module_function``; compiled modules are replaced by their NumPy forms.
"""

from __future__ import annotations

import ast
import builtins
import importlib
import importlib.util
import inspect
import sys
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from dnanalyze.errors import InputError

REPLACED = {
    "dnanalyze.model.draws": "dnanalyze.model.export.numpy_draws",
    "dnanalyze.model.kernels": "dnanalyze.model.export.numpy_draws",
    "scipy.special": "dnanalyze.model.export.numpy_special",
    "scipy.signal": "dnanalyze.model.export.numpy_special",
    "scipy.ndimage": "dnanalyze.model.export.numpy_special",
    "scipy.fft": "numpy.fft",
}
# What a simulation does not call: text for users, guesses from measurements, checks, reading and
# writing.
DROPPED = {
    "guess", "variance", "inactive_parameters", "measured_parameters", "parameters", "from_plain",
    "to_plain", "__post_init__",
    "summary", "physics", "formula", "references", "fingerprint", "confused_with", "varies",
    "nuisance_bias", "relatives", "lies_in",
}  # fmt: skip
DROPPED_DECORATORS = {"recordable"}  # frames of one file are always drawn
DROPPED_OF = {
    "NoiseModel": {"with_effect", "without", "get", "names", "save", "load", "_repr_html_"}
}
PLAIN = {"numpy", *sys.stdlib_module_names}


@dataclass
class Bundle:
    """Definitions in the order in which they can stand in one file."""

    imports: dict[str, None] = field(default_factory=dict)
    made: dict[str, str] = field(default_factory=dict)
    _open: set[tuple[str, str]] = field(default_factory=set)

    def add(self, module: str, name: str) -> str:
        """Take in a definition and all that it uses; returns the name that it has in the file.

        Raises
        ------
        InputError
            Its source is not at hand, or leans on another package.
        """
        module = REPLACED.get(module, module)
        tree = _tree(module)
        node = tree.defined.get(name)
        if node is None:
            origin = tree.imported.get(name)
            if origin is None:
                raise InputError(f"export: {name} is not defined in {module}")
            return self._imported(name, *origin)
        new = _new_name(module, name, node)
        if new in self.made or (module, name) in self._open:
            return new
        self._open.add((module, name))
        changed = _Rewrite(self, module, tree).visit(_trimmed(node))
        if isinstance(changed, (ast.FunctionDef, ast.ClassDef)):
            changed.name = new
        else:
            for leaf in _targets(changed):
                self._open.add((module, leaf.id))
                leaf.id = _new_name(module, leaf.id, changed)
        self.made[new] = ast.unparse(ast.fix_missing_locations(changed))
        return new

    def _imported(self, name: str, module: str, original: str | None) -> str:
        module = REPLACED.get(module, module)
        if original is not None and module.startswith("dnanalyze"):
            return self.add(module, original)
        if module == "numba":
            self.made.setdefault("njit", _NJIT)
            return "njit"
        if module.split(".")[0] not in PLAIN:
            raise InputError(f"export: {module} is used, which a NumPy file cannot lean on")
        if original is None:
            self.imports[f"import {module}" + (f" as {name}" if name != module else "")] = None
        else:
            self.imports[f"from {module} import {original}"] = None
        return name

    def text(self) -> str:
        """The file's imports and definitions."""
        head = sorted(self.imports, key=lambda line: (line.startswith("from"), line))
        return "\n".join(head) + "\n\n\n" + "\n\n\n".join(self.made.values()) + "\n"


_NJIT = '''\
def njit(*_, **__):
    """Compiles with Numba where that is installed; plain loops, slowly, where it is not."""
    try:
        from numba import njit as compiler
    except ImportError:
        return lambda function: function
    return compiler(nogil=True)'''


@dataclass(frozen=True)
class _Module:
    defined: dict[str, ast.stmt]
    imported: dict[str, tuple[str, str | None]]


@lru_cache(maxsize=128)
def _tree(module: str) -> _Module:
    try:
        source = inspect.getsource(importlib.import_module(module))
    except (OSError, TypeError, ImportError):
        raise InputError(
            f"export: the source of {module} is not at hand; export frames with simulate instead"
        ) from None
    defined: dict[str, ast.stmt] = {}
    imported: dict[str, tuple[str, str | None]] = {}
    tree = ast.parse(source)
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                imported[alias.asname or alias.name] = alias.name, None
        elif isinstance(node, ast.ImportFrom) and node.module != "__future__":
            for alias in node.names:
                origin: tuple[str, str | None] = (str(node.module), alias.name)
                if _is_module(f"{node.module}.{alias.name}"):
                    origin = f"{node.module}.{alias.name}", None
                imported[alias.asname or alias.name] = origin
    for node in tree.body:
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            defined[node.name] = node
        elif isinstance(node, ast.Assign):
            for target in node.targets:
                names = (leaf for leaf in ast.walk(target) if isinstance(leaf, ast.Name))
                defined.update((leaf.id, node) for leaf in names)
        elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
            defined[node.target.id] = node
    return _Module(defined, imported)


def _is_module(name: str) -> bool:
    if name in REPLACED:
        return True
    if not name.startswith("dnanalyze."):
        return False
    try:
        return importlib.util.find_spec(name) is not None
    except ModuleNotFoundError:  # its parent is a module, not a package
        return False


def _new_name(module: str, name: str, node: ast.stmt) -> str:
    """Classes keep their name; functions and constants take that of their module before it."""
    if isinstance(node, ast.ClassDef):
        return name
    return f"{module.rsplit('.', 1)[-1].removeprefix('numpy_')}_{name.strip('_')}"


def _targets(node: ast.stmt) -> list[ast.Name]:
    """The names that an assignment sets."""
    targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", node)]
    return [leaf for t in targets for leaf in ast.walk(t) if isinstance(leaf, ast.Name)]


def _trimmed(node: ast.stmt) -> ast.stmt:
    """A copy of a definition without what a simulation does not call."""
    copy = ast.parse(ast.unparse(node)).body[0]
    if isinstance(copy, ast.ClassDef):
        dropped = DROPPED | DROPPED_OF.get(copy.name, set())
        kept = []
        for part in copy.body:
            name = getattr(part, "name", None)
            if isinstance(part, ast.AnnAssign) and isinstance(part.target, ast.Name):
                name = part.target.id
            if name not in dropped:
                kept.append(part)
        copy.body = kept or [ast.Pass()]
    return copy


class _Rewrite(ast.NodeTransformer):
    """Points every global name at its definition in the one file."""

    def __init__(self, bundle: Bundle, module: str, tree: _Module) -> None:
        self.bundle, self.module, self.tree = bundle, module, tree
        self.local: list[set[str]] = []

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        """Arguments and assigned names hide globals."""
        names = {a.arg for a in [*node.args.args, *node.args.kwonlyargs, *node.args.posonlyargs]}
        names |= {a.arg for a in (node.args.vararg, node.args.kwarg) if a is not None}
        for leaf in ast.walk(node):
            if isinstance(leaf, ast.Name) and isinstance(leaf.ctx, ast.Store):
                names.add(leaf.id)
            elif isinstance(leaf, ast.FunctionDef) and leaf is not node:
                names.add(leaf.name)
        for arg in [*node.args.args, *node.args.kwonlyargs]:
            arg.annotation = None
        node.returns = None
        node.decorator_list = [
            self.visit(d) for d in node.decorator_list if ast.unparse(d) not in DROPPED_DECORATORS
        ]
        node.args.defaults = [self.visit(d) for d in node.args.defaults]
        node.args.kw_defaults = [d and self.visit(d) for d in node.args.kw_defaults]
        self.local.append(names)
        node.body = [kept for part in node.body if (kept := self.visit(part)) is not None]
        self.local.pop()
        return node

    def visit_Lambda(self, node: ast.Lambda) -> ast.AST:
        """As a function."""
        self.local.append({a.arg for a in node.args.args})
        node.body = self.visit(node.body)
        self.local.pop()
        return node

    def visit_Import(self, node: ast.Import) -> None:
        """Imports within functions are resolved."""

    def visit_ImportFrom(self, node: ast.ImportFrom) -> None:
        """Imports within functions are resolved."""

    def visit_AnnAssign(self, node: ast.AnnAssign) -> ast.AST:
        """Fields lose their declarations: ``parameter(default, ...)`` becomes the default."""
        value = node.value
        called = value.func if isinstance(value, ast.Call) else None
        if isinstance(called, ast.Name) and called.id in ("parameter", "choice"):
            value = value.args[0]  # type: ignore[union-attr]
        text = ast.unparse(node.annotation)
        node.annotation = self.visit(node.annotation) if "ClassVar" in text else ast.Name("object")
        node.value = None if value is None else self.visit(value)
        return node

    def visit_Attribute(self, node: ast.Attribute) -> ast.AST:
        """``draws.normal`` is a function of a module."""
        if isinstance(node.value, ast.Name) and not self._hidden(node.value.id):
            origin = self.tree.imported.get(node.value.id)
            if origin is not None and origin[1] is None:
                module = REPLACED.get(origin[0], origin[0])
                if module.startswith("dnanalyze"):
                    return ast.Name(self.bundle.add(module, node.attr), node.ctx)
                if module == "numpy.fft":
                    if not hasattr(np.fft, node.attr):
                        raise InputError(
                            f"export: {self.module} calls {origin[0]}.{node.attr}, which NumPy has "
                            "not"
                        )
                    self.bundle.imports["import numpy as np"] = None
                    base = ast.Attribute(ast.Name("np", ast.Load()), "fft", ast.Load())
                    return ast.Attribute(base, node.attr, node.ctx)
        node.value = self.visit(node.value)
        return node

    def visit_Name(self, node: ast.Name) -> ast.AST:
        """A global's name in the one file."""
        name = node.id
        if isinstance(node.ctx, ast.Store) or self._hidden(name):
            return node
        if name in self.tree.defined or name in self.tree.imported:
            return ast.Name(self.bundle.add(self.module, name), node.ctx)
        if not hasattr(builtins, name):
            raise InputError(f"export: {name} in {self.module} cannot be resolved")
        return node

    def _hidden(self, name: str) -> bool:
        return any(name in names for names in self.local)
