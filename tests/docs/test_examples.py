"""What the pages tell a reader to type is accepted, and the files they show are valid."""

import re
import shlex

import docs_tree as tree
import pytest
import typer
import yaml

from dnanalyze.loaders.config import Config
from dnanalyze.model.noise_model import model_from_plain
from dnanalyze.model.registry import catalogue

COMMANDS = [
    pytest.param(line, id=f"{page.relative_to(tree.ROOT)}: {line}")
    for page in tree.PAGES
    for line in dict.fromkeys(tree.command_lines(page))
]
YAML = [pytest.param(block, id=str(block)) for p in tree.PAGES for block in tree.blocks(p, "yaml")]


@pytest.mark.parametrize("line", COMMANDS)
def test_command_lines_are_accepted(line):
    from dnanalyze_cli.main import app

    words = shlex.split(line.split(" > ")[0].split(" | ")[0])[1:]
    group = typer.main.get_command(app)
    if words[0].startswith("-") or words[0] == "COMMAND":
        return
    command = group.commands[words[0]]
    if "--help" in words[1:]:
        return
    command.make_context(words[0], words[1:])  # refuses unknown options and missing arguments


@pytest.mark.parametrize("block", YAML)
def test_yaml_is_valid(block):
    raw = yaml.safe_load(block.text)
    if isinstance(raw, dict) and "effects" in raw and "targets" not in raw:
        own = tree.ROOT / "sample_configs" / "own_effect.py"
        model_from_plain(raw, str(block), catalogue((own,)))
    elif isinstance(raw, dict) and "width" in raw:
        Config(**raw)


def test_readme_has_the_two_commands_as_the_ci_reads_them():
    text = (tree.ROOT / "README.md").read_text()
    install = "python3 -m venv .venv && .venv/bin/pip install -q . && .venv/bin/dnanalyze demo"
    tests = (
        "python3 -m venv .venv && .venv/bin/pip install -q -e '.[dev]' "
        "&& .venv/bin/python -m pytest -n 2"
    )
    assert f"```sh\n{install}\n```" in text
    assert f"<!-- tests -->\n```sh\n{tests}\n```" in text


def test_changelog_names_the_version():
    import dnanalyze

    assert f"## [{dnanalyze.__version__}]" in (tree.ROOT / "CHANGELOG.md").read_text()


def test_counts_in_the_changelog_hold():
    from dnanalyze.analyzers.catalogue import catalogue as statistics

    text = (tree.ROOT / "CHANGELOG.md").read_text()
    found = re.search(r"^- (\d+) statistics", text, re.MULTILINE)
    assert found is not None
    assert int(found[1]) == len(statistics())
