"""The action, the workflows and the package's own data say what the code says."""

import importlib.util
import re
import tomllib

import docs_tree as tree
import typer
import yaml

PROJECT = tomllib.loads((tree.ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
ACTION = yaml.safe_load((tree.ROOT / "action.yml").read_text(encoding="utf-8"))


def test_options_of_the_action_are_those_of_check():
    from dnanalyze_cli.main import app

    check = typer.main.get_command(app).commands["check"]
    known = {flag for option in check.params for flag in option.opts}
    script = "\n".join(step["run"] for step in ACTION["runs"]["steps"][1:])
    used = set(re.findall(r"--[a-z]+", script))
    assert "--targets" in used
    assert used <= known


def test_inputs_of_the_action_are_documented_and_used():
    inputs = set(ACTION["inputs"])
    page = (tree.DOCS / "ci.md").read_text(encoding="utf-8")
    table = page.split("Inputs of the action:")[1].split("Without the action")[0]
    assert set(re.findall(r"^\| `(\w+)` \|", table, re.MULTILINE)) == inputs
    steps = yaml.safe_dump(ACTION["runs"])
    assert set(re.findall(r"inputs\.(\w+)", steps)) == inputs


def test_no_input_is_written_into_a_script():
    for step in ACTION["runs"]["steps"]:
        assert "${{" not in step["run"]


def test_the_matrix_tests_what_the_classifiers_promise():
    workflow = tree.ROOT / ".github" / "workflows" / "ci.yml"
    jobs = yaml.safe_load(workflow.read_text(encoding="utf-8"))["jobs"]
    tested = set(jobs["test"]["strategy"]["matrix"]["python"])
    promised = {m[1] for c in PROJECT["classifiers"] if (m := re.search(r":: (3\.\d+)$", c))}
    assert tested == promised


def test_every_direct_dependency_is_imported_by_the_package():
    imported = {"pillow": "PIL", "pyyaml": "yaml", "scikit-learn": "sklearn"}
    code = "\n".join(
        path.read_text(encoding="utf-8")
        for folder in ("dnanalyze", "cli")
        for path in (tree.ROOT / folder).rglob("*.py")
    )
    for requirement in PROJECT["dependencies"]:
        name = re.match(r"[A-Za-z0-9-]+", requirement)[0].lower()
        module = imported.get(name, name)
        assert re.search(rf"^\s*(import|from) {module}\b", code, re.MULTILINE), requirement


def test_the_version_stands_in_one_place():
    citation = yaml.safe_load((tree.ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert citation["version"] == PROJECT["version"]
    assert f"[{PROJECT['version']}]" in (tree.ROOT / "CHANGELOG.md").read_text(encoding="utf-8")


def test_public_workflow_and_own_checks_run_the_same_steps():
    run = (tree.ROOT / ".ci" / "run").read_text(encoding="utf-8")
    steps = re.search(r"^\.ci/step (.+)$", run, re.MULTILINE)[1].split()
    steps += re.search(r"^for step in (.+); do$", run, re.MULTILINE)[1].split()
    workflow = yaml.safe_load((tree.ROOT / ".github/workflows/ci.yml").read_text(encoding="utf-8"))
    assert workflow["jobs"]["steps"]["strategy"]["matrix"]["step"] == steps
    known = re.findall(
        r"^(\w+)\(\) \{", (tree.ROOT / ".ci" / "step").read_text(encoding="utf-8"), re.MULTILINE
    )
    assert {*steps, "oldest"} == set(known)


def test_the_long_description_has_no_link_into_the_repository():
    spec = importlib.util.spec_from_file_location("setup_of_the_package", tree.ROOT / "setup.py")
    setup = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(setup)
    readme = (tree.ROOT / "README.md").read_text(encoding="utf-8")
    relative = re.compile(r"\]\((?!https?:|#)")
    assert relative.search(readme)
    bare = setup.long_description(readme)
    assert not relative.search(bare)
    assert "a first hour" in bare.lower()
    linked = setup.long_description(readme, "https://example.org/dnanalyze")
    assert not relative.search(linked)
    assert "(https://example.org/dnanalyze/blob/main/docs/first-hour.md)" in linked
    assert "(https://example.org/dnanalyze/raw/main/docs/figures/" in linked
