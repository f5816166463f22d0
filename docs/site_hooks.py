"""What MkDocs adds while it builds the site: API pages, notebooks as pages, formulas as MathML."""

from __future__ import annotations

import base64
import html
import inspect
import json
import re
from pathlib import Path
from typing import Any

GROUPS = {
    "loaders": "Captures",
    "analyzers": "Statistics",
    "model": "Noise model",
    "fitting": "Fit",
    "comparator": "Comparison and checks",
    "diagnosis": "Diagnosis and refinement",
    "detection": "Hidden filters",
    "benchmarking": "Benchmark",
    "errors": "Errors",
}
INLINE = re.compile(r'<span class="arithmatex">\\\((.*?)\\\)</span>', re.DOTALL)
DISPLAY = re.compile(r'<div class="arithmatex">\s*\\\[(.*?)\\\]\s*</div>', re.DOTALL)


def on_config(config: Any) -> Any:
    """List the generated pages in the navigation."""
    tutorials = next(part["Tutorials"] for part in config.nav if "Tutorials" in part)
    tutorials.append({"Notebooks": [f"notebooks/{path.stem}.md" for path in _notebooks(config)]})
    reference = next(part["Reference"] for part in config.nav if "Reference" in part)
    place = next(n for n, part in enumerate(reference) if "Effects" in part)
    reference[place] = {"Effects": ["effects/index.md", *_effects(config)]}
    reference.append({"Python API": [{title: f"api/{key}.md"} for key, title in _groups().items()]})
    return config


def on_files(files: Any, config: Any) -> Any:
    """Add the API pages and a page for each notebook; the notebook itself stays for download."""
    from mkdocs.structure.files import File

    pages = {f"api/{key}.md": api_page(key) for key in _groups()}
    for path in _notebooks(config):
        pages[f"notebooks/{path.stem}.md"] = notebook_page(path)
    for name, text in pages.items():
        files.append(File.generated(config, name, content=text))
    return files


def on_page_markdown(text: str, page: Any, config: Any, **_: Any) -> str:
    """Links to a notebook lead to its page, where the link is a download; figures have two tones.

    A figure ``x.png`` beside which there is ``x-dark.png`` gives way to it in the dark scheme.
    """
    if page.file.src_uri.startswith("notebooks/"):
        return text
    folder = (Path(config.docs_dir) / page.file.src_uri).parent

    def both(found: re.Match[str]) -> str:
        words, stem = found[1], found[2]
        if not (folder / f"{stem}-dark.png").exists():
            return found[0]
        return f"![{words}]({stem}.png#only-light)![{words}]({stem}-dark.png#only-dark)"

    text = re.sub(r"!\[([^\]]*)\]\(([\w./-]+)\.png\)", both, text)
    return re.sub(r"\((notebooks/[\w-]+)\.ipynb\)", r"(\1.md)", text)


def on_page_content(text: str, **_: Any) -> str:
    """Formulas as MathML, which browsers draw without a script."""
    text = DISPLAY.sub(lambda found: _mathml(found[1], "block"), text)
    return INLINE.sub(lambda found: _mathml(found[1], "inline"), text)


def public() -> dict[str, list[tuple[str, Any]]]:
    """The names of ``dnanalyze.__all__`` by the package that defines them."""
    import dnanalyze

    found: dict[str, list[tuple[str, Any]]] = {}
    for name in dnanalyze.__all__:
        thing = getattr(dnanalyze, name)
        if inspect.isclass(thing) or inspect.isfunction(thing):
            found.setdefault(thing.__module__.split(".")[1], []).append((name, thing))
    return found


def api_page(key: str) -> str:
    """Functions, then classes, of one package, for mkdocstrings."""
    things = sorted(public()[key], key=lambda item: inspect.isclass(item[1]))
    parts = [f"# {_groups()[key]}\n"]
    for name, thing in things:
        path = f"{thing.__module__}.{thing.__qualname__}"
        parts.append(f"::: {path}\n    options:\n      heading: dnanalyze.{name}\n")
    return "\n".join(parts)


def notebook_page(path: Path) -> str:
    """Cells of a notebook and the output that is stored in it."""
    parts = []
    for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]:
        source = "".join(cell["source"])
        if cell["cell_type"] == "markdown":
            parts.append(source)
        elif source.strip():
            parts.append(f"```python\n{source}\n```")
            parts += [_output(out) for out in cell["outputs"]]
    title, rest = parts[0], parts[1:]
    link = f"[Download the notebook]({path.name})"
    return "\n\n".join([title, link, *rest]) + "\n"


def _output(out: dict[str, Any]) -> str:
    """One output of a cell: picture, HTML or text."""
    data = out.get("data", {})
    if "image/png" in data:
        png = "".join(data["image/png"].split())
        base64.b64decode(png, validate=True)
        return f'<p><img alt="Output of the cell above" src="data:image/png;base64,{png}"></p>'
    if "text/html" in data:
        table = re.sub(
            r"<style.*?</style>|<table[^>]*>", _bare, "".join(data["text/html"]), flags=re.S
        )
        return f"<div>{table}</div>".replace("\n\n", "\n")
    text = "".join(out.get("text", data.get("text/plain", "")))
    return f"<pre><code>{html.escape(text)}</code></pre>" if text else ""


def _bare(found: re.Match[str]) -> str:
    """A pandas table in the style of the site."""
    return "<table>" if found[0].startswith("<table") else ""


def _effects(config: Any) -> list[str]:
    found = sorted(Path(config.docs_dir).glob("effects/*.md"))
    return [f"effects/{path.name}" for path in found if path.stem != "index"]


def _notebooks(config: Any) -> list[Path]:
    return sorted(Path(config.docs_dir).glob("notebooks/*.ipynb"))


def _groups() -> dict[str, str]:
    """Package to title, in the order of the analysis; a new package comes last."""
    there = public()
    known = {key: title for key, title in GROUPS.items() if key in there}
    return known | {key: key.capitalize() for key in there if key not in known}


def _mathml(tex: str, display: str) -> str:
    from latex2mathml.converter import convert

    return convert(html.unescape(tex).strip(), display=display)
