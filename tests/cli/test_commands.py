"""Each command on a small folder; what takes minutes is replaced by its result."""

import json
import math
import shlex
from importlib import import_module
from types import SimpleNamespace

import pytest
import report_fakes as fakes
import yaml
from dnanalyze_cli.main import main

from dnanalyze import SearchLimits
from dnanalyze.loaders import load, write_captures
from dnanalyze.model.noise_model import dump_model, load_model

SLOW = {
    "fit": ("dnanalyze.fitting.fit.fit_on", fakes.fit),
    "compare": ("dnanalyze.comparator.compare.compare_on", fakes.comparison),
    "diagnose": ("dnanalyze.diagnosis.diagnose.diagnose_on", fakes.diagnosis),
    "detect": ("dnanalyze.detection.detect.detect", fakes.detection),
    "add": ("dnanalyze.diagnosis.refine.add_on", fakes.addition),
    "refine": ("dnanalyze.diagnosis.refine.refine_on", fakes.refinement),
}
HELPERS = object()


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return write_captures(fakes.captures(), tmp_path_factory.mktemp("captures") / "sensor")


@pytest.fixture
def calls(monkeypatch):
    """Replaces the long calls; gives their arguments by command."""
    seen = {}

    def stand_in(command, result):
        def call(*args, **named):
            seen[command] = args, named
            made = result()
            vars(made)["captures"] = args[0]
            return made

        return call

    for command, (path, result) in SLOW.items():
        module, name = path.rsplit(".", 1)
        monkeypatch.setattr(import_module(module), name, stand_in(command, result))
    compare = "dnanalyze.comparator.compare"  # what reports ask of it
    monkeypatch.setattr(f"{compare}.paper_model", lambda *_, **__: None)
    monkeypatch.setattr(f"{compare}.compared", lambda *_: fakes.comparison())
    monkeypatch.setattr("dnanalyze.fitting.yardstick.by_design", lambda problem, _: problem)
    held = SimpleNamespace(helpers=HELPERS)
    monkeypatch.setattr("dnanalyze.fitting.problem.fit_problem", lambda *_: held)
    plan = SimpleNamespace(pixels=0)
    monkeypatch.setattr("dnanalyze.fitting.design.design", lambda captures: plan)
    return seen


@pytest.mark.long
def test_compare_tells_what_a_classifier_can_tell(folder, calls, tmp_path, capsys, monkeypatch):
    seen = []

    def classify(captures, model, *, seed, helpers):
        seen.append((seed, helpers))
        return fakes.classification()

    monkeypatch.setattr("dnanalyze.classifier.classify.classify_on", classify)
    out, page = tmp_path / "out.json", tmp_path / "out.html"
    more = ["--classifier", "--json", str(out), "--report", str(page), "-q"]
    assert main(["compare", str(folder), *more]) == 0
    assert seen == [(0, HELPERS)]
    assert json.loads(out.read_text())["classifier"]["auc"] == 0.76
    assert "A classifier tells the simulated frames" in capsys.readouterr().out
    assert "Classifier two-sample test" in page.read_text()


def finite(value):
    if isinstance(value, dict):
        return all(map(finite, value.values()))
    if isinstance(value, list):
        return all(map(finite, value))
    return not isinstance(value, float) or math.isfinite(value)


@pytest.mark.parametrize("command", ["inspect", "analyze", *SLOW])
def test_every_command_writes_its_json_and_shows_its_verdict(
    command, folder, calls, tmp_path, capsys
):
    out = tmp_path / "out.json"
    more = ["column_fpn"] if command == "add" else []
    assert main([command, str(folder), *more, "--json", str(out), "--quiet"]) == 0
    made = json.loads(out.read_text())
    assert made["schema"] == f"dnanalyze/{command}/1"
    assert made["captures"] == str(folder)
    assert finite(made)
    shown = capsys.readouterr()
    assert "sensor: 3 operating points" in shown.out
    assert shown.err == ""
    assert max(map(len, shown.out.splitlines())) <= 80
    assert "\x1b" not in shown.out


def test_the_verdict_comes_before_the_numbers(folder, calls, capsys):
    main(["compare", str(folder), "-q"])
    text = capsys.readouterr().out
    assert text.index("Model error 6.5") < text.index("Failure 0") < text.index("family")
    main(["diagnose", str(folder), "-q"])
    text = capsys.readouterr().out
    assert text.index("Missing: column_fpn") < text.index("candidate")


@pytest.mark.long
@pytest.mark.parametrize("command", ["compare", "analyze"])
def test_a_report_and_a_table_are_written(command, folder, calls, tmp_path):
    page, table = tmp_path / "out.html", tmp_path / "out.csv"
    assert main([command, str(folder), "--report", str(page), "--csv", str(table), "-q"]) == 0
    assert page.read_text().startswith("<!DOCTYPE html>")
    assert table.read_text().splitlines()[0].startswith(("name", "temperature_c"))


@pytest.mark.long
def test_processed_frames_are_drawn_beside_the_raw_ones(folder, calls, tmp_path):
    page = tmp_path / "out.html"
    other = write_captures(fakes.captures(), tmp_path / "processed")
    assert main(["analyze", str(folder), "--with", str(other), "-q"]) == 2
    assert main(["analyze", str(folder), "--with", str(other), "--report", str(page), "-q"]) == 0
    assert "Left: sensor; right: processed" in page.read_text()


def test_json_to_standard_output_is_all_that_stands_there(folder, capsys):
    assert main(["inspect", str(folder), "--json", "-", "-q"]) == 0
    shown = capsys.readouterr()
    assert json.loads(shown.out)["frames"] == 12
    assert "operating points" in shown.err


@pytest.mark.parametrize(
    ("option", "begins"),
    [("-o", "schema: "), ("--csv", "step,added"), ("--report", "<!DOCTYPE html>"), ("--json", "{")],
)
def test_any_one_output_can_be_the_standard_output(option, begins, folder, calls, capsys):
    assert main(["refine", str(folder), option, "-", "-q"]) == 0
    shown = capsys.readouterr()
    assert shown.out.startswith(begins)
    assert "The model error" in shown.err


def test_two_outputs_to_the_standard_output_are_refused(folder, calls, capsys):
    assert main(["fit", str(folder), "--json", "-", "--csv", "-"]) == 2
    assert "named for two outputs" in capsys.readouterr().err
    assert not calls.get("fit")


def test_the_new_model_is_written_and_can_be_read_again(folder, calls, tmp_path):
    for command in ("fit", "refine", "add"):
        path = tmp_path / f"{command}.yaml"
        more = ["column_fpn"] if command == "add" else []
        assert main([command, str(folder), *more, "-o", str(path), "-q"]) == 0
        assert load_model(path).names == ["convolved_lognormal"]


def test_add_takes_its_two_names_in_either_order_and_says_so(folder, calls, capsys):
    assert main(["add", "column_fpn", str(folder)]) == 0
    assert calls["add"][0][1] == "column_fpn"
    assert "taken as effect column_fpn" in capsys.readouterr().err
    assert main(["add", str(folder), "column_fpn"]) == 0
    assert "taken as" not in capsys.readouterr().err


def test_refine_is_steered(folder, calls, tmp_path):
    model = tmp_path / "m.yaml"
    model.write_text(dump_model(fakes.model()))
    steer = ["--exclude", "rts", "--exclude", "dpc", "--max-effects", "2", "--until-error", "1.5"]
    assert main(["refine", str(folder), "--model", str(model), "--seed", "7", *steer, "-q"]) == 0
    named = calls["refine"][1]
    assert named["exclude"] == ("rts", "dpc")
    assert named["limits"] == SearchLimits(max_effects=2, until_error=1.5)
    assert named["model"].seed == 7


def test_clear_names_stand_beside_the_short_ones(folder, calls, capsys):
    assert main(["refine", str(folder), "--baseline-only", "--time-limit", "100", "-q"]) == 0
    named = calls["refine"][1]
    assert named["limits"] == SearchLimits(max_effects=0)
    assert 0.0 < named["budget"] <= 100.0
    assert main(["refine", str(folder), "--baseline-only", "--max-effects", "2"]) == 2
    assert "leave out --max-effects" in capsys.readouterr().err
    for option in ("--config", "--sidecar"):
        assert main(["refine", str(folder), option, "nothing.yaml"]) == 2
        assert "nothing.yaml" in capsys.readouterr().err


def test_a_users_own_effect_is_listed_and_offered(folder, calls, tmp_path, capsys):
    own = tmp_path / "own.py"
    own.write_text(
        "from dataclasses import dataclass\n"
        "from dnanalyze import Effect, Stage, parameter\n"
        "@dataclass(frozen=True)\n"
        "class Hum(Effect):\n"
        "    name = 'my_hum'\n"
        "    stage = Stage.LINE_READ\n"
        "    summary = 'a hum of mine'\n"
        "    amplitude: float = parameter(1.0, 'DN', 1e-3, 1e3, 'amplitude')\n"
    )
    assert main(["effects", "--effects", str(own)]) == 0
    assert "my_hum" in capsys.readouterr().out
    assert main(["effects", "my_hum", "--effects", str(own)]) == 0
    assert "amplitude" in capsys.readouterr().out
    assert main(["diagnose", str(folder), "--effects", str(own), "-q"]) == 0
    assert "my_hum" in calls["diagnose"][1]["known"]


def test_the_catalogue_as_json(tmp_path, capsys):
    out = tmp_path / "effects.json"
    assert main(["effects", "--json", str(out)]) == 0
    names = {e["name"] for e in json.loads(out.read_text())["effects"]}
    assert {"convolved_lognormal", "read_noise"} <= names


@pytest.mark.parametrize("form", ["tif", "fits", "npy", "h5", "png", "pgm", "raw12", "raw12-mipi"])
def test_simulated_frames_are_a_capture_folder(form, tmp_path, capsys):
    model, out = tmp_path / "m.yaml", tmp_path / "frames"
    model.write_text(dump_model(fakes.model()))
    grid = ["--shape", "32x48", "--temperatures", "25,45", "--exposure", "0.05", "--frames", "2"]
    assert main(["simulate", str(out), "--model", str(model), *grid, "--format", form, "-q"]) == 0
    found = load(out)
    assert found.sensor.shape == (32, 48)
    assert [s.point.temperature_c for s in found.settings] == [25.0, 45.0]
    assert {len(s.frames) for s in found.settings} == {2}
    assert {s.point.exposure_s for s in found.settings} == {0.05}


def test_a_simulation_like_a_folder_has_its_layout(folder, tmp_path):
    model, out = tmp_path / "m.yaml", tmp_path / "frames"
    model.write_text(dump_model(fakes.model()))
    made = tmp_path / "out.json"
    base = ["simulate", str(out), "--model", str(model), "--like", str(folder), "-q"]
    assert main([*base, "--seed", "5", "--json", str(made)]) == 0
    here, there = load(out), load(folder)
    assert here.sensor.shape == there.sensor.shape
    assert [s.point for s in here.settings] == [s.point for s in there.settings]
    assert json.loads(made.read_text())["seed"] == 5


def test_the_same_seed_gives_the_same_frames_and_another_others(tmp_path):
    model = tmp_path / "m.yaml"
    model.write_text(yaml.safe_dump(fakes.model().to_plain()))
    frames = []
    for name, seed in (("a", "1"), ("b", "1"), ("c", "2")):
        base = ["simulate", str(tmp_path / name), "--model", str(model), "--shape", "16x16"]
        assert main([*base, "--seed", seed, "--frames", "1", "-q"]) == 0
        frames.append(load(tmp_path / name).settings[0].frames[0].read())
    assert (frames[0] == frames[1]).all()
    assert (frames[0] != frames[2]).any()


def test_a_seed_without_a_model_seeds_the_papers(folder, calls, monkeypatch):
    monkeypatch.setattr(
        import_module("dnanalyze.fitting.fit"), "paper_start", lambda _: fakes.model()
    )
    for command in ("fit", "refine", "diagnose"):
        assert main([command, str(folder), "--seed", "9", "-q"]) == 0
        assert calls[command][1]["model"].seed == 9
    assert main(["compare", str(folder), "--seed", "9", "-q"]) == 0
    assert calls["fit"][0][1].seed == 9
    assert main(["refine", str(folder), "-q"]) == 0
    assert calls["refine"][1]["model"] is None


@pytest.mark.parametrize(("verdict", "shown"), [("missing", True), ("adequate", False)])
def test_where_nothing_is_missing_the_terminal_shows_no_candidates(
    folder, calls, monkeypatch, capsys, verdict, shown
):
    monkeypatch.setattr(
        "dnanalyze.diagnosis.diagnose.diagnose_on", lambda *_, **__: fakes.diagnosis(verdict)
    )
    assert main(["diagnose", str(folder)]) == 0
    said = capsys.readouterr().out
    assert ("column_gain" in said) is shown
    assert ("Evidence for" in said) is shown


def stopped_by(error, monkeypatch):
    """A refinement that is stopped after its second step."""

    def run(*_, on_result, **__):
        for count in (1, 2):
            so_far = fakes.refinement()
            so_far.steps, so_far.finished, so_far.diagnosis = so_far.steps[:count], False, None
            so_far.verdict = "missing"
            on_result(so_far)
        raise error

    monkeypatch.setattr("dnanalyze.diagnosis.refine.refine_on", run)


@pytest.mark.parametrize(("error", "code"), [(KeyboardInterrupt(), 130), (SystemExit(143), 143)])
def test_an_interrupted_refinement_leaves_all_files_of_one_step_and_says_how_to_go_on(
    folder, calls, tmp_path, monkeypatch, capsys, error, code
):
    stopped_by(error, monkeypatch)
    model, out, page = (tmp_path / name for name in ("m.yaml", "r.json", "r.html"))
    files = ["-o", str(model), "--json", str(out), "--report", str(page)]
    more = ["--exclude", "rts", "--max-effects", "3", "-q"]
    assert main(["refine", str(folder), *files, *more]) == code
    made = json.loads(out.read_text())
    assert [s["added"] for s in made["steps"]] == [None, "row_fpn"]
    assert made["finished"] is False
    assert "row_fpn" in page.read_text()
    assert load_model(model).names == ["convolved_lognormal"]
    assert sorted(p.name for p in tmp_path.iterdir()) == ["m.yaml", "r.html", "r.json"]
    (line,) = capsys.readouterr().err.splitlines()
    words = shlex.split(line.split("continue with: ")[1])
    assert words[:3] == ["dnanalyze", "refine", str(folder)]
    assert words[3:7] == ["--model", str(model), "-o", str(model)]
    assert words[words.index("--max-effects") + 1] == "2"  # one is in already
    assert {"--exclude", "--json", "--report"} <= set(words)


def test_an_interrupted_refinement_without_a_model_file_asks_for_one(
    folder, calls, tmp_path, monkeypatch, capsys
):
    stopped_by(KeyboardInterrupt(), monkeypatch)
    assert main(["refine", str(folder), "-q"]) == 130
    (line,) = capsys.readouterr().err.splitlines()
    assert "-o" in line
