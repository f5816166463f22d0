"""Words of terminal and pages stand in the glossary: columns, headings, families of statistics."""

import ast
import re

import docs_tree as tree
import pytest

from dnanalyze.analyzers.catalogue import catalogue
from dnanalyze.report.words import family_title

GLOSSARY = "".join(
    (tree.DOCS / page).read_text(encoding="utf-8") for page in ("glossary.md", "words.md")
)
PRINTERS = {"table", "_table", "points", "_points", "add_column", "Table", "Section"}
ARTICLES = re.compile(r"^(the|a|an) ")


def terms() -> set[str]:
    """The first cells of all tables of the glossary, and each of the names in them."""
    found: set[str] = set()
    for row in re.findall(r"^\| (.+?) \|", GLOSSARY, re.MULTILINE):
        plain = re.sub(r"[`*]", "", row).lower().strip()
        found |= {plain, *(part.strip() for part in re.split(r",(?! c/px)", plain))}
    return {singular(term) for term in found - {"term", "key", "---"}}


def singular(word: str) -> str:
    """Without the plural's ending: discrepancies, statistics, limits."""
    return re.sub(r"s$", "", re.sub(r"ies$", "y", word))


def printed() -> dict[str, set[str]]:
    """Columns and headings that are written out in the code of terminal and pages."""
    words: dict[str, set[str]] = {"column": set(), "heading": set()}
    for folder in ("cli", "dnanalyze/report"):
        for path in sorted((tree.ROOT / folder).rglob("*.py")):
            for call in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                if isinstance(call, ast.Assign) and ast.unparse(call.targets[0]) == "columns":
                    named = getattr(call.value, "elts", [])
                    words["column"] |= {e.value for e in named if isinstance(e, ast.Constant)}
                if not isinstance(call, ast.Call):
                    continue
                name = getattr(call.func, "id", getattr(call.func, "attr", ""))
                if name not in PRINTERS:
                    continue
                for argument in call.args[1:2] if name == "Section" else call.args[:2]:
                    if isinstance(argument, ast.Tuple):
                        words["column"] |= {text for text in constants(argument) if text}
                    elif isinstance(argument, ast.Constant) and argument.value:
                        kind = "column" if name == "add_column" else "heading"
                        words[kind].add(argument.value)
    return words


def constants(node: ast.AST) -> list[str]:
    return [
        n.value for n in ast.walk(node) if isinstance(n, ast.Constant) and isinstance(n.value, str)
    ]


def plain(text: str) -> str:
    return singular(ARTICLES.sub("", re.sub(r"\s*\[.*?\]", "", text).lower().strip()))


TERMS = terms()
PRINTED = printed()


def test_the_words_are_found_where_they_are_printed():
    assert "confidence" in PRINTED["column"]
    assert len(PRINTED["column"]) > 15
    assert len(PRINTED["heading"]) > 8


@pytest.mark.parametrize("column", sorted(PRINTED["column"]))
def test_columns_stand_in_the_glossary(column):
    assert plain(column) in TERMS


@pytest.mark.parametrize("heading", sorted(PRINTED["heading"]))
def test_headings_hold_a_term_of_the_glossary(heading):
    words = plain(heading)
    known = (re.escape(t) for t in TERMS if len(t) > 3)
    assert re.search(rf"\b({'|'.join(known)})s?\b", words)


@pytest.mark.parametrize("family", sorted({info.family for info in catalogue().values()}))
def test_families_stand_in_the_glossary(family):
    assert plain(family_title(family)) in TERMS


def test_each_term_is_defined_once():
    sections = re.findall(r"^\| term \|.*?(?=^#|\Z)", GLOSSARY, re.MULTILINE | re.DOTALL)
    rows = [row for part in sections for row in re.findall(r"^\| (.+?) \|", part, re.MULTILINE)]
    defined = [row for row in rows if row not in ("term", "---")]
    assert len(defined) > 80
    assert sorted(defined) == sorted(set(defined))
