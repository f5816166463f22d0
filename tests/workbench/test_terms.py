"""The page's words are those of the manual."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

pytest.importorskip("panel", reason="the extra workbench is not installed")

from dnanalyze.model.registry import built_in
from dnanalyze.workbench.page.terms import SENTENCES, explained, plain_name

DOCS = Path(__file__).parents[2] / "docs"
GLOSSARY = "".join((DOCS / p).read_text(encoding="utf-8") for p in ("glossary.md", "words.md"))


@pytest.mark.parametrize("term", SENTENCES)
def test_every_sentence_is_the_glossary_s(term):
    text = re.sub(r"[`*]", "", GLOSSARY)
    assert SENTENCES[term] in text


def test_the_longest_term_of_a_text_is_explained_and_unknown_ones_are_not():
    assert "Half of the distance" in explained("pixels above 5 robust sigma")
    assert explained("nothing of the kind") == ""
    assert 'title="' in explained("power of the DSNU")


def test_every_effect_has_a_name_of_its_own_in_words():
    names = [plain_name(effect) for effect in built_in()]
    assert len(set(names)) == len(names)
    assert not [name for name in names if "_" in name or not name[0].isupper()]
