"""The CI check: targets in, yes or no out, and how often a correct simulation fails."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
import pytest
import yaml

from dnanalyze.checking import margins
from dnanalyze.checking.check import check
from dnanalyze.checking.check_data import CheckData
from dnanalyze.checking.margins import propose
from dnanalyze.checking.targets import dump_targets, load_targets, targets_from_plain
from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effects.column_fpn import ColumnFpn
from dnanalyze.model.effects.convolved_lognormal import ConvolvedLognormal
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.laws import TableLaw
from dnanalyze.model.noise_model import NoiseModel, dump_model
from dnanalyze.model.simulate import simulate

P = OperatingPoint
SETTINGS = [(P(25.0, 1.0), 4), (P(65.0, 1.0), 4)]
MODEL = NoiseModel(
    (
        ConvolvedLognormal(
            mu=TableLaw((P(25.0), P(65.0)), (1.0, 3.0)), delta=0.3, phi=0.005, sigma=0.01
        ),
        ReadNoise(sigma=2.0),
    ),
    64.0,
    P(25.0, 1.0, 1.0),
    seed=3,
)


def sensor(seed: int = 3, model: NoiseModel = MODEL, size: int = 96):
    return simulate(replace(model, seed=seed), (size, size), SETTINGS, "sensor")


@pytest.fixture(scope="module")
def targets():
    return propose(sensor(), MODEL, replicates=12)


def held(*items, **head):
    return targets_from_plain({"targets": list(items), **head}, "T.yaml")


def test_targets_are_read_back_as_written(targets, tmp_path):
    (tmp_path / "T.yaml").write_text(dump_targets(targets))
    assert load_targets(tmp_path / "T.yaml") == targets


def test_new_seeds_pass_and_a_changed_model_fails_with_what_changed(targets):
    for seed in (101, 102, 103):
        result = check(sensor(), targets, replace(MODEL, seed=seed))
        assert result.passed, [c.name for c in result.failures]
    noisier = MODEL.with_effect(ReadNoise(sigma=2.3))
    result = check(sensor(), targets, noisier)
    assert not result.passed
    assert result.failures[0].subject in ("temporal_noise", "noise_at_50", "temporal_noise_core")
    assert result.failures[0].floors_beyond > 3
    assert result.failures[0].beyond > 0


def test_a_missing_effect_breaks_the_statistics_of_its_kind():
    truth = MODEL.with_effect(ColumnFpn(sigma=2.0))
    limits = propose(sensor(3, truth), truth, replicates=8)
    result = check(sensor(3, truth), limits, MODEL)
    broken = {c.subject for c in result.failures}
    assert "pattern_columns_0.1_0.3" in broken
    assert "temporal_noise" not in broken


def test_what_the_model_misses_at_first_is_written_down_but_not_enforced():
    truth = MODEL.with_effect(ColumnFpn(sigma=2.0))
    limits = propose(sensor(3, truth), MODEL, replicates=8)
    columns = [t for t in limits.targets if t.statistic == "pattern_columns_0.1_0.3"]
    assert columns
    assert not any(t.enforced for t in columns)
    assert "violates" in columns[0].note
    result = check(sensor(3, truth), limits, replace(MODEL, seed=77))
    assert result.passed
    assert "pattern_columns_0.1_0.3" in {c.subject for c in result.known_misses}


def test_frames_of_the_teams_own_simulator_are_held_without_a_model(targets):
    own = held(*[t.model_dump(exclude_none=True) for t in targets.targets if t.statistic])
    assert check(sensor(7), own).passed
    assert not check(sensor(7, MODEL.with_effect(ReadNoise(sigma=2.5))), own).passed
    with_errors = check(sensor(8), targets, measured=sensor())
    assert with_errors.passed
    with pytest.raises(InputError, match="an error needs the measured captures"):
        check(sensor(8), targets)


def test_relative_and_floors_refer_to_the_measured_value():
    at = {"temperature_c": 25, "exposure_s": 1}
    result = check(
        sensor(),
        held(
            {"statistic": "temporal_noise", "at": at, "relative": 0.05},
            {"statistic": "temporal_noise", "at": at, "floors": 6},
            {"statistic": "temporal_noise", "at": at, "measured": 5.0, "relative": 0.1},
        ),
        replace(MODEL, seed=5),
    )
    close, floors, stated = result.checks
    assert close.passed
    assert floors.passed
    assert close.upper == pytest.approx(close.measured * 1.05)
    assert floors.upper - floors.measured < 0.1 * floors.measured
    assert (stated.lower, stated.upper) == (4.5, 5.5)
    assert not stated.passed
    assert stated.beyond == pytest.approx(stated.value - 4.5)


def test_parameters_errors_and_trends():
    result = check(
        sensor(),
        held(
            {"parameter": "read_noise.sigma", "min": 1.9, "max": 2.1},
            {"parameter": "convolved_lognormal.mu", "at": {"temperature_c": 65}, "max": 2.5},
            {"error": "pooled", "max": 1.5},
            {"statistic": "mean", "max": 200},
        ),
        replace(MODEL, seed=5),
    )
    assert [c.passed for c in result.checks] == [True, False, True, True, True]
    assert result.checks[1].value == pytest.approx(3.0)
    assert [c.point.temperature_c for c in result.checks[3:]] == [25.0, 65.0]


@pytest.mark.parametrize(
    ("item", "words"),
    [
        (
            {"statistic": "temporal_nois", "max": 1},
            "no statistic is called 'temporal_nois'.*temporal_noise",
        ),
        (
            {"statistic": "xyz", "max": 1},
            "'xyz'; valid: mean, .*; `dnanalyze analyze --json` lists",
        ),
        (
            {"statistic": "mean", "maks": 1},
            "target 1 .mean.: unknown key 'maks'; did you mean 'max'",
        ),
        ({"statistic": "mean"}, "sets no limit"),
        (3, "target 1: not a mapping, such as .statistic: mean"),
        ({1: 2}, "keys are words"),
        ({"statistic": "mean", "max": 1, "at": "hcg"}, "at: not a mapping"),
        ({"statistic": "mean", "max": float("nan")}, "finite"),
        ({"statistic": "mean", "min": 2, "max": 1}, "min 2 is above max 1"),
        ({"statistic": "mean", "error": "pooled", "max": 1}, "exactly one of"),
        ({"error": "poold", "max": 1}, "no error is called 'poold'; valid: pooled, level"),
        ({"statistic": "mean", "max": "wide"}, "max: .*number"),
        (
            {"statistic": "mean", "at": {"celsius": 3}, "max": 1},
            "unknown key 'celsius'.*temperature_c",
        ),
    ],
)
def test_bad_targets_are_refused_in_one_line(item, words):
    with pytest.raises(InputError, match=words) as caught:
        held(item)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"\x00\x01\xff", "is not UTF-8 text"),
        (b"targets: [1", "not YAML"),
        (b"", "needs 'targets', a list"),
        (b"- 1", "needs 'targets', a list"),
        (b"targets: []", "targets: the list is empty"),
        (b"schema: other/1\ntargets: [{statistic: mean, max: 1}]", "schema 'other/1' is not"),
        (b"1: 2\ntargets: [{statistic: mean, max: 1}]", "keys are words"),
        (b"captures: {shape: [1]}\ntargets: [{statistic: mean, max: 1}]", "captures.shape"),
    ],
)
def test_files_that_are_no_targets_are_refused_in_one_line(content, words, tmp_path):
    path = tmp_path / "T.yaml"
    path.write_bytes(content)
    with pytest.raises(InputError, match=words) as caught:
        load_targets(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("item", "words"),
    [
        (
            {"statistic": "mean", "at": {"temperature_c": 85}, "max": 1},
            "no frames at 85 °C; the captures have 25 °C",
        ),
        ({"statistic": "mean", "at": {"channel": "hcg"}, "max": 1}, "no frames at hcg"),
        (
            {"parameter": "read_noise.sigm", "max": 1},
            "no parameter 'read_noise.sigm'; valid: pedestal",
        ),
    ],
)
def test_targets_that_fit_nothing_are_refused_in_one_line(item, words):
    with pytest.raises(InputError, match=words):
        check(sensor(), held(item), MODEL)


def test_margins_are_not_held_against_other_captures(targets):
    with pytest.raises(InputError, match="made for 96 x 96"):
        check(sensor(size=64), targets, MODEL)


def test_a_statistic_that_the_simulation_lacks_fails_with_the_reason():
    single = simulate(MODEL, (96, 96), [(P(25.0, 1.0), 1)], "single")
    result = check(single, held({"statistic": "temporal_noise", "max": 3}))
    (only,) = result.checks
    assert not only.passed
    assert "one frame" in only.reason


def test_junit_and_markdown_are_well_formed_and_name_the_failure(targets):
    from dnanalyze.report.results.checkresult import junit, markdown

    result = check(sensor(), targets, MODEL.with_effect(ReadNoise(sigma=2.3)))
    named = replace(result.captures, name='dark <"&"> frames')
    result = replace(result, captures=named)
    tree = ET.fromstring(junit(result))
    suite = tree.find("testsuite")
    assert int(suite.get("tests")) == len(result.checks) == len(suite.findall("testcase"))
    assert (
        int(suite.get("failures")) == len(result.failures) == len(suite.findall("testcase/failure"))
    )
    messages = [f.get("message") for f in suite.findall("testcase/failure")]
    assert any(
        "sigma" in m and "DN" in m and "see 'Mean dark signal and noise'" in m for m in messages
    )
    text = markdown(result, "T.yaml", "M.yaml")
    assert result.failures[0].subject in text
    assert "dnanalyze compare" in text


def run(*arguments):
    from dnanalyze_cli.main import main

    return main([str(a) for a in arguments])


def test_the_command_inits_holds_and_exits_as_it_promises(tmp_path, capsys):
    from dnanalyze.loaders import write_captures

    write_captures(sensor(), tmp_path / "dark", "npy")
    (tmp_path / "M.yaml").write_text(dump_model(replace(MODEL, seed=40)))
    (tmp_path / "bad.yaml").write_text(dump_model(MODEL.with_effect(ReadNoise(sigma=3.0))))
    model, limits = tmp_path / "M.yaml", tmp_path / "T.yaml"
    assert run("check", tmp_path / "dark", "--model", model, "--init", limits, "-q") == 0
    outputs = (
        "--junit",
        tmp_path / "J.xml",
        "--json",
        tmp_path / "J.json",
        "--markdown",
        tmp_path / "J.md",
    )
    assert (
        run("check", tmp_path / "dark", "--model", model, "--targets", limits, *outputs, "-q") == 0
    )
    written = json.loads((tmp_path / "J.json").read_text())
    assert written["schema"] == "dnanalyze/check/1"
    assert written["passed"] is True
    assert {"name", "limit", "value", "passed"} <= set(written["checks"][0])
    assert (
        run(
            "check",
            tmp_path / "dark",
            "--model",
            tmp_path / "bad.yaml",
            "--targets",
            limits,
            *outputs,
        )
        == 1
    )
    assert json.loads((tmp_path / "J.json").read_text())["passed"] is False
    assert ET.parse(tmp_path / "J.xml").getroot().find(".//failure") is not None
    assert "FAIL" in capsys.readouterr().out.upper()
    limits.write_text(yaml.safe_dump({"targets": [{"statistic": "men", "max": 1}]}))
    assert run("check", tmp_path / "dark", "--model", model, "--targets", limits) == 2
    assert "men" in capsys.readouterr().err
    assert run("check", tmp_path / "dark", "--model", model) == 2
    assert "--targets" in capsys.readouterr().err


@pytest.mark.parametrize("frames", [2, 4, 8, 64])
def test_limits_hold_for_a_variance_of_few_frames(frames):
    """The scatter of few frames' means has a heavy low tail on the log scale, which t lacks."""
    from scipy.stats import t

    from dnanalyze.analyzers.families.time import log_spread_error

    rng, freedom, share = np.random.default_rng(frames), frames - 1, 5e-4
    outside, tried = 0, 0
    for _ in range(100):
        draws = 0.5 * np.log(rng.chisquare(freedom, 17) / freedom)
        reading = margins._Reading(
            P(25.0), "", "drift", draws[0], log_spread_error(freedom), draws[1:]
        )
        width = margins._Width(float(t.isf(share, 23)), share, reading)
        limit = margins._target(reading, width, simulated=True)
        new = np.sqrt(rng.chisquare(freedom, 4000) / freedom)
        outside += int(np.sum((new < limit.min) | (new > limit.max))) if limit.enforced else 0
        tried += new.size
    assert outside <= 2 * share * tried


@pytest.mark.slow
def test_a_correct_simulation_fails_at_most_once_in_a_thousand():
    """Over virtual sensors and seeds; the stated rate is 1e-3, the bound is one-sided at 99.9 %."""
    from scipy.stats import binom

    failed, tried = 0, 0
    for make in range(10):
        limits = propose(sensor(1000 + make), replace(MODEL, seed=5000 + 40 * make))
        for seed in range(100):
            result = check(
                sensor(1000 + make), limits, replace(MODEL, seed=20_000 + 100 * make + seed)
            )
            tried += 1
            failed += not result.passed
    print(f"\n{failed} of {tried} correct simulations with a new seed failed; stated: 1 in 1000")
    assert binom.sf(failed - 1, tried, 1e-3) > 1e-3


def test_each_operating_point_of_a_target_is_looked_at_by_itself():
    """Frames that differ by noise alone are one operating point for a fit, not for a target."""
    points = [OperatingPoint(t, 0.1, 1.0) for t in (-30.0, -20.0)]
    model = NoiseModel((ReadNoise(3.0),), 64.0, points[0])
    captures = simulate(model, (64, 48), [(point, 1) for point in points])
    assert [point for point, _ in CheckData(captures, None, None).plan.settings] == points
