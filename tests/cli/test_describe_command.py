"""`dnanalyze describe`: what it writes, and what it never overwrites."""

import json
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
import report_fakes as fakes
import yaml
from dnanalyze_cli.main import main

from dnanalyze.loaders import write_captures

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "description"))
from made_description import description


@pytest.fixture
def folder(tmp_path):
    return str(write_captures(fakes.captures(), tmp_path / "sensor"))


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    module = "dnanalyze.description.describe.describe_on"
    monkeypatch.setattr(module, lambda captures, *_, **__: description(captures))
    monkeypatch.setattr("dnanalyze.fitting.problem.fit_problem", lambda *_: None)
    monkeypatch.setattr(
        "dnanalyze.fitting.design.design", lambda captures: SimpleNamespace(pixels=0)
    )


def test_it_prints_and_writes_all_that_is_asked_for(folder, tmp_path, capsys):
    out = {name: tmp_path / name for name in ("m.yaml", "own.py", "d.json", "d.html", "d.csv")}
    code = main(
        ["describe", folder, "-o", str(out["m.yaml"]), "--write", str(out["own.py"]), "--json",
         str(out["d.json"]), "--report", str(out["d.html"]), "--csv", str(out["d.csv"])]
    )  # fmt: skip
    assert code == 0
    assert "Fixed rings" in capsys.readouterr().out
    assert json.loads(out["d.json"].read_text())["verdict"] == "described"
    assert "composite" in str(yaml.safe_load(out["m.yaml"].read_text())["effects"])
    assert "class RingsEffect(Effect)" in out["own.py"].read_text()
    assert "Fixed rings" in out["d.html"].read_text()
    assert out["d.csv"].read_text().startswith("name,value,se")


def test_an_own_effect_file_is_overwritten_only_by_force(folder, tmp_path, capsys):
    own = tmp_path / "own.py"
    own.write_text("mine")
    assert main(["describe", folder, "--write", str(own)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert (
        line
        == f"dnanalyze: --write {own}: exists; name another file, or give --force to replace it"
    )
    assert own.read_text() == "mine"
    assert main(["describe", folder, "--write", str(own), "--force"]) == 0
    assert "RingsEffect" in own.read_text()


def test_one_file_for_two_outputs_is_refused(folder, tmp_path, capsys):
    same = str(tmp_path / "x.yaml")
    assert main(["describe", folder, "--write", same, "-o", same]) == 2
    assert "named for two outputs" in capsys.readouterr().err


@pytest.mark.parametrize("command", ["diagnose", "refine"])
def test_what_stays_unexplained_is_described(command, folder, tmp_path, capsys, monkeypatch):
    """A refinement by the statistics and the yardstick that its fitted state is stated in."""
    seen, fitted = [], {"refine": ("of the refinement", "refined"), "diagnose": (None, "begun")}
    found = {"diagnose": fakes.diagnosis("unexplained"), "refine": fakes.refinement()}[command]
    found.verdict = "unexplained"
    if command == "refine":
        found.problem, found.state = fitted[command]
    monkeypatch.setattr("dnanalyze.fitting.state.start", lambda *_: "begun")
    module = "diagnose" if command == "diagnose" else "refine"
    monkeypatch.setattr(f"dnanalyze.diagnosis.{module}.{command}_on", lambda *_, **__: found)

    def described(captures, problem, state, *_, rivals):
        assert (problem, state) == fitted[command]
        seen.append(rivals)
        return description(captures)

    monkeypatch.setattr("dnanalyze.description.describe.described", described)
    out = tmp_path / "d.json"
    assert main([command, folder, "--json", str(out)]) == 0
    assert seen == [False]
    assert "Fixed rings" in capsys.readouterr().out
    assert json.loads(out.read_text())["description"]["composite"]["where"] == "rings"
    assert main([command, folder, "--json", str(out), "--no-describe"]) == 0
    assert seen == [False]
    assert "description" not in json.loads(out.read_text())
    found.verdict = "missing"
    assert main([command, folder]) == 0
    assert seen == [False]


def test_a_map_is_written_with_the_model_that_names_it(tmp_path, capsys, monkeypatch):
    import numpy as np

    from dnanalyze.description.pattern import LearnedPattern
    from dnanalyze.model.learned.field_map import FieldMap
    from dnanalyze.model.learned.pattern_map import PatternMap

    effect = PatternMap(map=FieldMap(np.full((8, 8), 0.5, np.float32)))

    def learned(captures, model, **_):
        one = np.ones(1)
        return LearnedPattern(
            captures, effect, model.with_effect(effect), 0.5, one, one, [], 0.4, 0.3, 2.0, 1.1
        )

    monkeypatch.setattr("dnanalyze.description.pattern.learn_pattern", learned)
    folder = str(write_captures(fakes.captures(), tmp_path / "sensor"))
    made, model = tmp_path / "map.npy", tmp_path / "m.yaml"
    call = ["describe", folder, "--map", str(made), "-o", str(model)]
    assert main(call) == 0
    assert "It predicts 40 % of the variance" in " ".join(capsys.readouterr().out.split())
    assert np.load(made).shape == (8, 8)
    (held,) = (e for e in yaml.safe_load(model.read_text())["effects"] if "pattern_map" in e)
    assert held["pattern_map"]["map"]["file"] == "map.npy"
    assert main(call) == 2
    assert "exists; name another file, or give --force" in capsys.readouterr().err
    assert main(["describe", folder, "--map", str(tmp_path / "map.tif")]) == 2
    assert "a name that ends in .npy" in capsys.readouterr().err
