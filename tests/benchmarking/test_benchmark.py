"""Sensors side by side: laws over temperature, ranks, and the command."""

from __future__ import annotations

import json
import math
from dataclasses import asdict, replace
from types import SimpleNamespace

import numpy as np
import pytest

from dnanalyze.benchmarking import sensor_record as records
from dnanalyze.benchmarking.benchmark_value import ABSENT, BenchmarkValue
from dnanalyze.benchmarking.criteria import CRITERIA, SINGLE
from dnanalyze.benchmarking.model_findings import model_findings, strengths
from dnanalyze.benchmarking.run import benchmark, side_by_side, unique_names
from dnanalyze.benchmarking.sensor_record import SensorRecord, gain_of
from dnanalyze.benchmarking.temperature_laws import Reading, common_temperatures, estimate
from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import CaptureSet, OperatingPoint, Sensor, Setting
from dnanalyze.model.effects.convolved_lognormal import ConvolvedLognormal
from dnanalyze.model.effects.dark_shot_noise import DarkShotNoise
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.laws import TableLaw
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import built_in
from dnanalyze.model.simulate import simulate
from dnanalyze.report.page import render
from dnanalyze.report.results import benchmarkresult as results
from dnanalyze.report.sections.benchmark import rankings
from dnanalyze.thermal import arrhenius

P = OperatingPoint


def activated(celsius, ea=0.65, level=3.0):
    return level * arrhenius(celsius, 45.0, ea)


def test_a_law_finds_an_activated_rate_between_and_beyond_the_measured():
    rng = np.random.default_rng(1)
    pulls, inside, outside = [], [], []
    for _ in range(60):
        readings = [
            Reading(t, activated(t) * (1 + 0.02 * rng.standard_normal()), 0.02 * activated(t))
            for t in (25.0, 35.0, 45.0, 55.0, 65.0)
        ]
        for celsius, kept in ((50.0, inside), (85.0, outside)):
            found = estimate(readings, celsius)
            pulls.append(math.log(found.value / activated(celsius)) / (found.se / found.value))
            kept.append(found.se / found.value)
    # the error must cover the truth: 4.5 sigma over 120 draws, and not overstate it threefold
    assert np.max(np.abs(pulls)) < 4.5
    assert np.std(pulls) > 0.3
    assert np.mean(outside) > 2 * np.mean(inside)


def test_a_noise_with_a_floor_is_not_taken_for_an_activated_one():
    truth = lambda t: math.sqrt(4.0 + 0.5 * activated(t))  # noqa: E731
    readings = [Reading(t, truth(t), 0.01 * truth(t)) for t in (25.0, 45.0, 65.0, 85.0)]
    found = estimate(readings, 5.0)
    assert abs(found.value - truth(5.0)) < 4 * found.se
    assert found.se < 0.4 * truth(5.0)


def test_one_temperature_tells_no_law():
    assert estimate([Reading(25.0, 2.0, 0.1)], 60.0) is None
    assert estimate([Reading(25.0, 2.0, 0.1)], 25.0).value == 2.0
    assert estimate([], 25.0) is None


def test_common_temperatures_lie_inside_or_between():
    assert common_temperatures([(25, 105), (45, 85)]) == [45.0, 65.0, 85.0]
    assert common_temperatures([(-90, -10), (20, 60)]) == [5.0]
    assert common_temperatures([(-9, -7), (25, 105), (30, 90)]) == [30.0, 60.0, 90.0]
    assert common_temperatures([]) == []


def test_names_are_told_apart():
    assert unique_names(["a/x", "b/y/"]) == ["x", "y"]
    assert unique_names(["a/x", "b/x"]) == ["a/x", "b/x"]


def made_record(name, level, se=0.01, **more):
    """A record with one law of dark current, everything else absent."""
    points = [P(t, 0.1) for t in (25.0, 45.0, 65.0)]
    captures = CaptureSet(name, Sensor((8, 8)), tuple(Setting(p, ()) for p in points))
    readings = {c.name: [] for c in CRITERIA}
    readings["dark_current"] = [
        Reading(t, activated(t, level=level), se * activated(t, level=level))
        for t in (25.0, 45.0, 65.0)
    ]
    single = {c.name: ABSENT for c in SINGLE}
    kept = {"dn_per_e": ABSENT, "errors": {}} | more
    return SensorRecord(name, name, captures, None, readings, single, **kept)


def test_sensors_are_ranked_and_those_not_told_apart_share_a_rank():
    result = side_by_side(
        [made_record("worst", 9.0), made_record("good", 3.0), made_record("same", 3.03)], [45.0]
    )
    (ranking,) = [r for r in result.rankings if r.criterion == "dark_current"]
    assert [(p.sensor, p.rank) for p in ranking.places] == [("good", 1), ("same", 1), ("worst", 3)]


def ranked(figures):
    """Sensor, rank and what it is not told from, by figures of read noise."""
    sensors = []
    for name, value, se in figures:
        made = made_record(name, 3.0)
        made.single["read_noise"] = BenchmarkValue(value, se)
        sensors.append(made)
    result = side_by_side(sensors)
    (ranking,) = [r for r in result.rankings if r.criterion == "read_noise"]
    return result, [(p.sensor, p.rank, p.alike) for p in ranking.places]


def test_ranks_go_by_the_errors_that_are_printed():
    """1499 apart, by an error of 1492: not told apart, whatever the ratio."""
    result, places = ranked([("vague", 1562.0, 1492.0), ("fine", 63.0, 13.0)])
    assert places == [("fine", 1, ("vague",)), ("vague", 1, ("fine",))]
    made = results.document(result)
    (told,) = [r for r in made["rankings"] if r["criterion"] == "read_noise"]
    assert told["places"][0]["not_distinguishable_from"] == ["vague"]
    row = rankings(result).tables[0].rows[-1]
    assert "not distinguishable from vague" in row[-1]
    assert "fine and vague are not distinguishable" in " ".join(result.summary().split())


def test_the_result_prints_tabulates_draws_and_shows_itself():
    found, _ = ranked([("one", 500.0, 1.0), ("<two>", 63.0, 1.0)])
    assert max(map(len, found.summary().splitlines())) <= 80
    assert found.to_dict() == results.document(found)
    assert set(found.to_dataframe()["sensor"]) == {"<two>", "one"}
    assert repr(found) == "<BenchmarkResult: one, <two>>"
    html = found._repr_html_()
    assert "&lt;two&gt;" in html
    assert "<two>" not in html
    with pytest.raises(InputError, match="valid: temperature, spectra, errors"):
        found.plot("pie")


def test_who_is_told_from_the_best_is_no_first_whatever_stands_between():
    _, places = ranked([("worst", 500.0, 1.0), ("best", 63.0, 1.0), ("vague", 100.0, 300.0)])
    assert places == [
        ("best", 1, ("vague",)), ("vague", 1, ("best", "worst")), ("worst", 2, ("vague",)),
    ]  # fmt: skip


def test_gain_and_area_normalise():
    gains = BenchmarkValue(0.5, 0.005, "")
    a, b = made_record("a", 3.0, dn_per_e=gains), made_record("b", 3.0)
    object.__setattr__(a.captures.sensor, "pixel_pitch_um", 5.0)
    result = side_by_side([a, b], [45.0])
    electrons = next(r for r in result.rankings if r.criterion == "dark_current_e").of("a")
    assert electrons.value == pytest.approx(6.0, rel=0.02)
    area = next(r for r in result.rankings if r.criterion == "dark_current_area").of("a")
    assert area.value == pytest.approx(electrons.value * 1.602e-19 / 25e-8 * 1e12, rel=0.01)
    assert not next(r for r in result.rankings if r.criterion == "dark_current_e").of("b").known
    assert any("conversion gain of b" in n for n in result.notes)


def test_a_filtered_sensor_is_not_to_be_believed():
    made = [made_record("a", 3.0, filtered=True, filter_kind="dpc"), made_record("b", 3.0)]
    result = side_by_side(made, [45.0])
    assert any("the frames of a were filtered (dpc)" in n for n in result.notes)
    (ranking,) = [r for r in result.rankings if r.criterion == "dark_current"]
    assert [(p.sensor, p.rank) for p in ranking.places] == [("b", 1), ("a", None)]
    assert ranking.of("a").note == "measured there; of a filtered output, so not ranked"


def test_a_law_is_not_read_far_outside_what_was_measured():
    a, b = made_record("a", 3.0), made_record("b", 3.0)  # 25 to 65 C
    result = side_by_side([a, b], [5.0, 180.0, 190.0])
    told = [r for r in result.rankings if r.criterion == "dark_current"]
    assert [r.temperature_c for r in told] == [5.0, 180.0]
    assert told[1].of("a").note.startswith("extrapolated by 115 C")


def test_single_frames_are_not_ranked_beside_what_tells_noise_from_pattern():
    noise = {"read_noise": BenchmarkValue(2.0, 0.01)}
    both = {"read_noise": BenchmarkValue(1.0, 0.01, one_frame=True)}
    several, single = made_record("several", 3.0), made_record("single", 3.0)
    several.single.update(noise)
    single.single.update(both)

    def ranks(*records):
        (ranking,) = [r for r in side_by_side(records).rankings if r.criterion == "read_noise"]
        return [(p.sensor, p.rank) for p in ranking.places]

    assert ranks(single, several) == [("several", 1), ("single", None)]
    assert ranks(single, replace(single, name="other")) == [("single", 1), ("other", 1)]


def test_a_figure_measured_at_the_temperature_stands_as_measured():
    a, b = made_record("a", 3.0), made_record("b", 3.0)
    kept = [r for r in b.readings["dark_current"] if r.temperature_c != 45.0]
    a.readings["dark_current"][1] = Reading(45.0, 4.0, 0.01)  # off its law
    b.readings["dark_current"] = kept
    (ranking,) = side_by_side([a, b], [45.0]).rankings
    assert (ranking.of("a").value, ranking.of("a").note) == (4.0, "measured there")
    assert ranking.of("b").value == pytest.approx(3.0, rel=0.05)
    assert ranking.of("b").note.startswith("by its law")


def virtual(name, mu, seed, temperatures=(25.0, 45.0, 65.0), k=0.5):
    """Frames of such a sensor."""
    return captures_of(name, *virtual_model(mu, seed, temperatures, k))


def virtual_model(mu, seed, temperatures=(25.0, 45.0, 65.0), k=0.5):
    """A sensor of doubling step about 9.5 C whose gain is k, and where it is taken."""
    base = TableLaw(
        tuple(P(t) for t in temperatures),
        tuple(mu + math.log(activated(t, level=1.0)) for t in temperatures),
    )
    model = NoiseModel(
        (
            ConvolvedLognormal(mu=base, delta=0.3, phi=1e-3, sigma=1e-5),
            DarkShotNoise(dn_per_e=k),
            ReadNoise(sigma=1.5),
        ),
        64.0,
        P(45.0, 0.1, 1.0),
        seed,
    )
    return model, [(P(t, 0.1, 1.0), 4) for t in temperatures]


def captures_of(name, model, settings):
    return simulate(model, (96, 96), settings, name, Sensor((96, 96), black_level=64.0))


def test_the_temporal_dark_noise_is_that_of_emva_without_what_moves_whole_frames():
    from dnanalyze.analyzers.analyze import analyze

    model, _ = virtual_model(1.0, 3)
    moving = model.with_effect(built_in()["offset_drift"](step=10.0))
    seen = analyze(captures_of("moving", moving, [(P(45.0, 0.1, 1.0), 6)]))
    (noise,) = records.readings_of(seen)["temporal_noise"]
    (point,) = seen.emva.groups[0].points
    stated = point.quantities["temporal_dark_noise_dn"]
    assert noise.value == pytest.approx(stated.value, rel=1e-6)
    assert noise.value < 0.5 * seen.settings[0]["temporal_noise"].value


def test_the_gain_is_read_off_the_dark_series():
    from dnanalyze.analyzers.analyze import analyze

    found = gain_of(analyze(virtual("a", 4.0, 1)))
    assert abs(found.value - 0.5) < 5 * found.se
    assert found.se < 0.05


@pytest.fixture
def no_filters(monkeypatch):
    import dnanalyze.detection as detection

    none = SimpleNamespace(filtered=False, kind="none")
    monkeypatch.setattr(detection, "detect", lambda captures, **_: none, raising=False)


@pytest.mark.long
def test_the_command_gives_page_table_and_json(no_filters, tmp_path, monkeypatch):
    from dnanalyze_cli.main import main

    from dnanalyze.loaders import write_captures

    write_captures(virtual("cool", 3.0, 1), tmp_path / "cool", "npy")
    write_captures(virtual("warm", 5.0, 2, (35.0, 55.0, 75.0)), tmp_path / "warm", "npy")
    folders = [str(tmp_path / "cool"), str(tmp_path / "warm")]
    paths = {k: tmp_path / f"B.{k}" for k in ("json", "html", "csv")}
    named = {"--json": "json", "--report": "html", "--csv": "csv"}
    options = [part for flag, key in named.items() for part in (flag, str(paths[key]))]
    assert main(["benchmark", *folders, *options, "--quick", "-q"]) == 0
    written = json.loads(paths["json"].read_text())
    assert written["schema"] == "dnanalyze/benchmark/1"
    assert written["temperatures_c"] == [35.0, 50.0, 65.0]
    ranks = {
        p["sensor"]: p["rank"]
        for r in written["rankings"]
        if r["criterion"] == "dark_current" and r["temperature_c"] == 50.0
        for p in r["places"]
    }
    assert ranks == {"cool": 1, "warm": 2}
    values = {
        p["sensor"]: (p["value"], p["se"])
        for r in written["rankings"]
        if r["criterion"] == "dark_current" and r["temperature_c"] == 50.0
        for p in r["places"]
    }
    for name, mu in (("cool", 3.0), ("warm", 5.0)):  # the median pixel's rate, DN/s, at 0.1 s
        value, se = values[name]
        assert abs(value - 10 * math.exp(mu) * activated(50.0, level=1.0)) < 5 * se + 0.05 * value
    assert "sortable" in paths["html"].read_text()
    assert "dark_current" in paths["csv"].read_text()


def test_the_strength_of_every_effect_of_the_catalogue_is_told():
    known = built_in()
    model = NoiseModel(tuple(kind() for kind in known.values()), 64.0, P(45.0, 0.1, 1.0))
    told = {s.effect: s for s in strengths(model)}
    assert set(told) == set(known)
    for name, strength in told.items():
        assert strength.rms_dn is None or math.isfinite(strength.rms_dn), name
        assert all(math.isfinite(v) for v, _ in strength.parameters.values()), name
    assert told["read_noise"].rms_dn == pytest.approx(known["read_noise"]().sigma, rel=1e-6)
    warmer = NoiseModel((ReadNoise(sigma=TableLaw((P(25.0), P(45.0)), (1.0, 3.0))),), 64.0, P(45.0))
    (only,) = strengths(warmer)
    assert (only.rms_dn, only.parameters["sigma"]) == (pytest.approx(3.0), (3.0, "DN"))


@pytest.mark.long
def test_each_sensor_is_said_to_be_made_of_what_its_refinement_found(
    no_filters, tmp_path, monkeypatch
):
    """The refinement itself is replaced by a fit of the right effects."""
    from dnanalyze.diagnosis import refine as refinement
    from dnanalyze.fitting.fit import fit_on

    def right(captures, model, problem, on_progress):
        truth = sensors[captures.name]
        done = fit_on(captures, truth, problem=problem, replicates=0)
        return SimpleNamespace(
            model=done.model, steps=[SimpleNamespace(error=1.1)], verdict="adequate",
            problem=problem, state=done.state,
        )  # fmt: skip

    made = {name: virtual_model(mu, seed, k=k) for name, mu, seed, k in
            (("a", 4.0, 1, 0.5), ("b", 5.0, 2, 1.0))}  # fmt: skip
    sensors = {name: model for name, (model, _) in made.items()}
    monkeypatch.setattr(refinement, "refine_on", right)
    result = benchmark([captures_of(name, *made[name]) for name in made])
    for record, gain in zip(result.sensors, (0.5, 1.0), strict=True):
        assert [e.effect for e in record.effects] == [
            "convolved_lognormal", "dark_shot_noise", "read_noise"
        ]  # fmt: skip
        assert abs(record.dn_per_e.value - gain) < 5 * record.dn_per_e.se
        assert "refined model" in record.dn_per_e.note
        assert record.effects[2].rms_dn == pytest.approx(1.5, rel=0.1)
    written = results.document(result)["sensors"]
    assert [s["errors"]["refined"] for s in written] == [1.1, 1.1]
    page = render(results.page(result))
    assert "dark_shot_noise" in page
    assert "dn_per_e 0.5" in page  # its strength, since it has no closed form
    assert [r.reference for r in result.sensors] == [
        r.captures.settings[1].point.label() for r in result.sensors
    ]


@pytest.mark.long
def test_the_channels_of_one_sensor_stand_side_by_side(no_filters):
    model, settings = virtual_model(3.0, 1)
    channels = [(replace(p, channel=c), n) for c in ("hcg", "lcg") for p, n in settings]
    result = benchmark([captures_of("hdr", model, channels)], quick=True)
    assert [s.name for s in result.sensors] == ["hdr hcg", "hdr lcg"]
    assert {s.point.channel for s in result.sensors[1].captures.settings} == {"lcg"}
    shown = results.page(result)  # two pages; a row for every temperature is folded away
    assert all(len(t.rows) <= 12 for s in shown.front for t in s.tables if not t.folded)
    assert [s.key for s in shown.sections][:2] == ["temperatures", "figures"]


def test_bad_input_is_one_line(capsys, tmp_path):
    from dnanalyze_cli.main import main

    assert main(["benchmark", str(tmp_path)]) == 2
    assert f"{tmp_path}: no frames" in capsys.readouterr().err
    assert main(["benchmark", "a", "b", "--at", "warm"]) == 2
    assert "--at warm" in capsys.readouterr().err
    with pytest.raises(InputError, match="two capture folders"):
        benchmark([virtual("a", 3.0, 1)])
    assert records.ABSENT.known is False


def test_the_headline_compares_electrons_where_they_are_known():
    # fewer DN, yet more electrons: its gain is a tenth
    low = made_record("low", 3.0, dn_per_e=BenchmarkValue(0.05, 0.0005, ""))
    high = made_record("high", 9.0, dn_per_e=BenchmarkValue(0.5, 0.005, ""))
    assert results.headline(side_by_side([low, high], [45.0])) == (
        "Of 2 sensors at 45 °C, high is best in dark current (e⁻/s)."
    )
    best = made_record("best", 1.0, filtered=True, filter_kind="dpc", dn_per_e=high.dn_per_e)
    assert "high is best in dark current (e⁻/s) of the 2 ranked" in results.headline(
        side_by_side([low, best, high], [45.0])
    )
    unknown = [made_record("low", 3.0), made_record("high", 9.0)]
    assert "low is best in dark current (DN/s)" in results.headline(side_by_side(unknown, [45.0]))


def test_what_was_found_of_the_same_files_is_not_worked_out_again(
    no_filters, tmp_path, monkeypatch
):
    from dnanalyze.comparator import compare as comparison
    from dnanalyze.loaders import load, write_captures

    write_captures(virtual("cool", 3.0, 1), tmp_path / "cool", "npy")
    captures = load(str(tmp_path / "cool")).cached(str(tmp_path / "cache"))
    told = []
    first = model_findings(captures, True, told.append)
    assert told == ["Wang 2025 model", "hidden filters"]
    monkeypatch.setattr(comparison, "compare_on", None)  # would fail
    second = model_findings(captures, True, told.append)
    assert len(told) == 2
    assert second.errors == first.errors
    assert (second.filtered, second.notes) == (first.filtered, first.notes)
    assert set(second.errors) == {"gaussian", "paper"}


def test_a_sensor_is_read_back_as_it_was_kept():
    from dnanalyze.benchmarking import model_findings as kept

    model, _ = virtual_model(3.0, 1)
    found = kept.ModelFindings(
        {"gaussian": 9.0}, BenchmarkValue(0.5, 0.01, "n"), strengths(model), "adequate", "45 °C",
        True, "dpc", ["a note"],
    )  # fmt: skip
    assert kept.KEPT.validate_python(json.loads(json.dumps(asdict(found)))) == found
