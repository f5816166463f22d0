"""The site is built without a warning and loads nothing from another server."""

import re
import subprocess
import sys

import docs_tree as tree
import pytest

LOADED = re.compile(
    r"<(?:script|img|iframe|source|link)\b[^>]*?\b(?:src|href)=[\"']?(https?:)?//[^>]*>"
)


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    for package in ("material", "mkdocstrings", "latex2mathml"):
        pytest.importorskip(package, reason="needs the extra docs")
    folder = tmp_path_factory.mktemp("site")
    done = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "-d", str(folder)],
        cwd=tree.ROOT, capture_output=True, text=True, timeout=300,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-2000:]
    return folder


@pytest.mark.slow
def test_pages_load_nothing_from_another_server(site):
    for page in site.rglob("*.html"):
        text = page.read_text(encoding="utf-8")
        foreign = [found[0] for found in LOADED.finditer(text) if "canonical" not in found[0]]
        assert not foreign, page
    for sheet in site.rglob("*.css"):
        assert not re.search(r"url\([\"']?https?:", sheet.read_text(encoding="utf-8")), sheet


@pytest.mark.slow
def test_search_and_formulas_need_no_server(site):
    assert (site / "search" / "search_index.js").read_text(encoding="utf-8").startswith("var __ind")
    assert "iframe-worker.js" in (site / "index.html").read_text(encoding="utf-8")
    physics = (site / "physics.html").read_text(encoding="utf-8")
    assert physics.count("<math") > 10
    assert "arithmatex" not in physics


@pytest.mark.slow
def test_every_public_name_has_its_page(site):
    import dnanalyze

    pages = "".join(p.read_text(encoding="utf-8") for p in (site / "api").glob("*.html"))
    for name in dnanalyze.__all__:
        if name != "__version__":
            assert f"dnanalyze.{name}" in re.sub(r"<[^>]+>", "", pages), name
