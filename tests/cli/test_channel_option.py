"""Every command by channel (--channel) and over channels (without it)."""

import json
from dataclasses import replace

import pytest
import report_fakes as fakes
from dnanalyze_cli.main import main

from dnanalyze.channels.refinement import ChannelRefinement, ChannelStep
from dnanalyze.loaders import load, write_captures
from dnanalyze.loaders.captures import CaptureSet
from dnanalyze.model.channel_models import channels_of, merged
from dnanalyze.model.effects.column_fpn import ColumnFpn
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.noise_model import NoiseModel, dump_model, load_model

READING = ("inspect", "analyze", "fit", "compare", "diagnose", "add", "refine", "detect")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Two channels of the same frames."""
    one = fakes.captures()
    settings = [
        replace(s, point=replace(s.point, channel=c)) for c in ("hcg", "lcg") for s in one.settings
    ]
    settings = [
        replace(s, frames=tuple(replace(f, point=s.point) for f in s.frames)) for s in settings
    ]
    made = CaptureSet("hdr", one.sensor, tuple(settings))
    return write_captures(made, tmp_path_factory.mktemp("hdr") / "sensor")


@pytest.fixture
def model(tmp_path):
    """Of both channels."""
    path = tmp_path / "M.yaml"
    models = {
        c: NoiseModel((ReadNoise(sigma=s), ColumnFpn(sigma=s)), 64.0, fakes.POINTS[0])
        for c, s in (("hcg", 2.0), ("lcg", 3.0))
    }
    path.write_text(dump_model(merged(models)))
    return path


def finished(found, own):
    """A refinement over channels, with one effect of hcg's own."""
    parts = {c: fakes.refinement() for c in found.channels}
    steps = [ChannelStep(None, 6.5), ChannelStep("column_fpn", 2.0, 0.9, [], channel="hcg")]
    steps.append(ChannelStep(None, 1.2))
    own = {"hcg": ["column_fpn"], "lcg": []}
    said = ["column_fpn: in hcg only, so of that readout"]
    return ChannelRefinement(found, parts, [], own, said, steps, fakes.model(), None, None)


@pytest.mark.parametrize("command", [*READING, "check", "benchmark"])
def test_an_unknown_channel_is_one_line_with_the_valid_names(command, folder, tmp_path, capsys):
    more = {"add": ["column_fpn"], "check": ["--init", str(tmp_path / "T.yaml")]}.get(command, [])
    assert main([command, str(folder), *more, "--channel", "lofic", "-q"]) == 2
    text = capsys.readouterr().err
    assert "no channel 'lofic'; valid: hcg, lcg" in text
    assert text.count("\n") == 1


def test_frames_that_name_no_channel_say_how_to_name_it(tmp_path, capsys):
    plain = write_captures(fakes.captures(), tmp_path / "plain")
    assert main(["inspect", str(plain), "--channel", "hcg"]) == 2
    assert "column 'channel' of manifest.csv" in capsys.readouterr().err


def test_one_channel_alone_is_inspected_and_analyzed(folder, tmp_path, capsys):
    out = tmp_path / "out.json"
    assert main(["inspect", str(folder), "--channel", "lcg", "--json", str(out), "-q"]) == 0
    seen = json.loads(out.read_text())
    assert seen["channel"] == "lcg"
    assert {p["channel"] for p in seen["operating_points"]} == {"lcg"}
    assert "sensor: channel lcg, 3 operating points" in capsys.readouterr().out
    assert main(["analyze", str(folder), "--channel", "hcg", "--json", str(out), "-q"]) == 0
    assert {s["channel"] for s in json.loads(out.read_text())["settings"]} == {"hcg"}


def test_over_channels_each_has_its_own_laws(folder, tmp_path, capsys):
    out = tmp_path / "out.json"
    assert main(["analyze", str(folder), "--json", str(out), "-q"]) == 0
    written = json.loads(out.read_text())
    assert set(written["channels"]) == {"hcg", "lcg"}
    assert len(written["settings"]) == 6
    assert "sensor: 2 channels, 6 operating points" in capsys.readouterr().out


@pytest.mark.long
def test_refine_and_add_over_channels_complete_each_and_give_one_model(
    folder, tmp_path, monkeypatch, capsys
):
    from dnanalyze.channels import refinement as channels
    from dnanalyze.comparator import compare

    seen = {}

    def refined(found, own, **options):
        seen.update(options)
        return finished(found, own)

    monkeypatch.setattr(channels, "refine_channels", refined)
    monkeypatch.setattr(
        channels, "add_channels", lambda found, name, own, **_: finished(found, own)
    )
    monkeypatch.setattr(compare, "compare_on", lambda *_, **__: fakes.comparison())
    monkeypatch.setattr(channels, "uncertain", lambda *_: fakes.fit())
    for command, more in (
        ("refine", ["--max-effects", "3"]), ("add", ["column_fpn"]), ("channels", [])
    ):  # fmt: skip
        out, page, file = (tmp_path / f"{command}.{end}" for end in ("json", "html", "yaml"))
        named = ["--json", str(out), "-o", str(file)]
        if command == "refine":  # the pages are alike, and slow to draw
            named += ["--report", str(page)]
        assert main([command, str(folder), *more, *named, "-q"]) == 0
        written = json.loads(out.read_text())
        assert written["schema"] == f"dnanalyze/{command}/1"
        assert [s["added"] for s in written["steps"]] == [None, "column_fpn", None]
        assert written["steps"][1]["channel"] == "hcg"
        assert written["verdict"] == "adequate"
        assert written["own"] == {"hcg": ["column_fpn"], "lcg": []}
        assert set(written["channels"]) == {"hcg", "lcg"}
        assert load_model(file).names == ["convolved_lognormal"]
        shown = capsys.readouterr().out
        assert "Identified: column_fpn in hcg; the model error falls from 6.5 to 1.2" in shown
        assert max(map(len, shown.splitlines())) <= 80
    assert seen["limits"].max_effects == 3
    assert "column_fpn: in hcg only" in (tmp_path / "refine.html").read_text()


def test_diagnose_over_channels_names_the_channel_of_each_candidate(
    folder, tmp_path, monkeypatch, capsys
):
    from dnanalyze.channels import refinement as channels

    made = {"hcg": fakes.diagnosis("missing"), "lcg": fakes.diagnosis("adequate")}
    monkeypatch.setattr(channels, "diagnose_channels", lambda *_, **__: made)
    out, page, table = (tmp_path / f"D.{end}" for end in ("json", "html", "csv"))
    named = ["--json", str(out), "--report", str(page), "--csv", str(table)]
    assert main(["diagnose", str(folder), *named, "-q"]) == 0
    written = json.loads(out.read_text())
    assert written["verdict"] == "missing"
    assert written["channels"]["lcg"]["verdict"] == "adequate"
    assert {c["channel"] for c in written["candidates"]} == {"hcg"}  # adequate: none
    assert "channel" in table.read_text().splitlines()[0]
    assert "2 channels, each diagnosed separately: missing" in capsys.readouterr().out
    assert "hcg: Candidates" in page.read_text()


def test_fit_gives_each_readout_its_own_numbers(folder, tmp_path, monkeypatch):
    from dnanalyze.fitting import fit

    seen = {}

    def fitted(found, model=None, **_):
        seen["model"] = model
        return fakes.fit()

    monkeypatch.setattr(fit, "fit_on", fitted)
    monkeypatch.setattr("dnanalyze.fitting.problem.fit_problem", lambda *_: None)
    path = tmp_path / "one.yaml"
    path.write_text(dump_model(NoiseModel((ReadNoise(sigma=2.0),), 64.0, fakes.POINTS[0])))
    assert main(["fit", str(folder), "--model", str(path), "-q"]) == 0
    assert channels_of(seen["model"]) == ["hcg", "lcg"]
    assert len(seen["model"].get("read_noise").sigma.values) == 2


def test_simulate_draws_the_channels_that_are_named_or_all(model, folder, tmp_path, capsys):
    base = ["simulate", "--model", str(model), "--shape", "16x16", "--frames", "1", "-q"]
    assert main([*base, str(tmp_path / "all")]) == 0
    assert load(tmp_path / "all").channels == ["hcg", "lcg"]
    assert main([*base, str(tmp_path / "one"), "--channel", "lcg"]) == 0
    assert load(tmp_path / "one").channels == ["lcg"]
    assert main([*base, str(tmp_path / "like"), "--like", str(folder), "--channel", "hcg"]) == 0
    assert len(load(tmp_path / "like").settings) == 3
    assert main([*base, str(tmp_path / "none"), "--channel", "lofic"]) == 2
    assert "the model has no channel 'lofic'; valid: hcg, lcg" in capsys.readouterr().err


def test_a_model_that_lacks_a_channel_of_the_captures_is_refused(folder, tmp_path, capsys):
    path = tmp_path / "M.yaml"
    models = {c: NoiseModel((ReadNoise(sigma=2.0),), 64.0) for c in ("hcg", "lofic")}
    path.write_text(dump_model(merged(models)))
    for command in ("compare", "refine", "check"):
        more = ["--init", str(tmp_path / "T.yaml")] if command == "check" else []
        assert main([command, str(folder), "--model", str(path), *more, "-q"]) == 2
        assert "the model has no channel 'lcg'; valid: hcg, lofic" in capsys.readouterr().err


def test_check_holds_the_targets_of_one_channel(folder, model, tmp_path):
    targets = tmp_path / "T.yaml"
    targets.write_text(
        "targets:\n"
        "- {statistic: mean, at: {channel: hcg}, min: 0}\n"
        "- {statistic: mean, at: {channel: lcg}, max: 1}\n"
        "- {error: pooled, max: 0.001}\n"
    )
    out = tmp_path / "out.json"
    named = ["--model", str(model), "--targets", str(targets), "--json", str(out), "-q"]
    assert main(["check", str(folder), *named, "--channel", "hcg"]) == 0
    assert len(json.loads(out.read_text())["checks"]) == 3  # one temperature each
    assert main(["check", str(folder), *named, "--channel", "lcg"]) == 1


@pytest.mark.parametrize("command", ["compare", "diagnose", "check"])
def test_a_model_of_channels_refuses_frames_that_name_none(command, model, tmp_path, capsys):
    folder = write_captures(fakes.captures(), tmp_path / "plain")
    more = ["--init", str(tmp_path / "T.yaml")] if command == "check" else []
    assert main([command, str(folder), "--model", str(model), *more, "-q"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "has parameters by channel (hcg, lcg)" in line
    assert "manifest.csv" in line
