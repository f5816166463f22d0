"""Links between pages lead somewhere, and the site lists every page."""

import docs_tree as tree
import pytest
import yaml


@pytest.mark.parametrize("page", tree.PAGES, ids=lambda p: str(p.relative_to(tree.ROOT)))
def test_links_resolve(page):
    for target in tree.links(page):
        if target.startswith(("http://", "https://", "mailto:")):
            continue
        path, _, anchor = target.partition("#")
        there = (page.parent / path).resolve() if path else page
        assert there.exists(), f"{target}: no such file"
        if anchor:
            assert anchor in tree.anchors(there), f"{target}: no such heading"


def test_every_page_is_in_the_site():
    site = yaml.safe_load((tree.ROOT / "mkdocs.yml").read_text())
    listed: set[str] = set()

    def walk(part):
        if isinstance(part, str):
            listed.add(part)
        else:
            for inner in part.values() if isinstance(part, dict) else part:
                walk(inner)

    walk(site["nav"])
    pages = {str(p.relative_to(tree.DOCS)) for p in tree.DOCS.rglob("*.md")}
    assert listed == {p for p in pages if not p.startswith("effects/")} | {"effects/index.md"}


def test_pages_hold_no_template_left_open():
    for page in tree.PAGES:
        for mark in ("TODO", "TBD", "FIXME", "XXX"):
            assert mark not in page.read_text(), f"{page}: {mark}"
