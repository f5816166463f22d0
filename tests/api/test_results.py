"""Every type of result: what it prints, holds, writes, draws, and shows in a notebook."""

import json
import math
import re
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "report"))
import report_fakes as fakes

import dnanalyze
from dnanalyze.channels.refinement import ChannelRefinement, ChannelStep
from dnanalyze.checking.check import Check
from dnanalyze.diagnosis.results import Candidate, Step
from dnanalyze.fitting.whole_field import Coverage
from dnanalyze.loaders.captures import Window
from dnanalyze.model.noise_model import load_model

NAME = "folder/<sensor> & co"
HOSTILE = "<script>alert(1)</script>"


def captures():
    return replace(fakes.captures(), name=NAME)


def statistics():
    return replace(fakes.statistics(), name=NAME, captures=captures())


def fitted():
    plain = fakes.fit()
    problem = Held(captures())
    made = dnanalyze.Fit(
        plain.model, plain.parameters, plain.correlations, plain.undetermined, problem, None,
        captures(),
    )  # fmt: skip
    vars(made)["direct"] = []  # which it would read off the problem
    return made


class Held:
    """As much of a bench as a figure asks for."""

    def __init__(self, captures):
        self.plan = type("Plan", (), {"captures": captures})
        self.measured = (fakes.statistics(), fakes.statistics())

    def statistics(self, model, errors):
        return [fakes.statistics(2.5), fakes.statistics(2.5)]


def comparison():
    return dnanalyze.Comparison(**vars(fakes.comparison()) | {"captures": captures()})


def diagnosis():
    plain = fakes.diagnosis()
    candidates = [Candidate(**vars(c)) for c in plain.candidates]
    candidates[0] = replace(candidates[0], evidence=[HOSTILE])
    whole = Coverage(3, 3, 12, 12, Window.whole(fakes.SHAPE), fakes.SHAPE)
    found = vars(plain) | {"candidates": candidates, "captures": captures(), "coverage": whole}
    return dnanalyze.Diagnosis(**found)


def refinement(by_hand=False):
    plain = fakes.refinement()
    steps = [
        Step(s.added, s.error, s.confidence, s.evidence, s.confused_with) for s in plain.steps[:3]
    ]
    made = dnanalyze.Refinement(
        captures(), steps, plain.effects, plain.verdict, plain.model, diagnosis(),
        Held(captures()), None, by_hand,
    )  # fmt: skip
    fitted = SimpleNamespace(parameters=plain.parameters, undetermined=[])
    vars(made)["_fitted"] = fitted  # which it would simulate for
    vars(made)["direct"] = []  # which it would read off the problem
    return made


def channel_refinement():
    part = refinement()
    steps = [ChannelStep(**vars(s), channel="hcg" if s.added else None) for s in part.steps]
    made = ChannelRefinement(
        captures(), {"hcg": part, "lcg": part}, [], {"hcg": ["column_fpn"], "lcg": []},
        ["column_fpn: in hcg only, so of that readout"], [*steps, ChannelStep(None, 0.9)],
        part.model, part.problem, None,
    )  # fmt: skip
    vars(made)["parameters"] = part.parameters  # which it would simulate for
    return made


def detection():
    return replace(fakes.detection(), captures=captures())


def classification():
    return replace(fakes.classification(), captures=captures())


def checked():
    at = fakes.POINTS[0]
    checks = [
        Check("temporal_noise at 25 °C", "statistic", "temporal_noise", at, "", 1.9, 2.1, value,
              2.0, "DN", passed, floor=0.02)
        for value, passed in ((2.0, True), (2.5, False))
    ]  # fmt: skip
    checks.append(
        Check("pooled error", "error", "pooled", at, "", -math.inf, 1.3, 1.1, None, "1", True)
    )
    return dnanalyze.CheckResult(captures(), "model.yaml", checks, 1e-3)


MADE = {
    "Statistics": statistics, "Fit": fitted, "Comparison": comparison, "Diagnosis": diagnosis,
    "Refinement": refinement, "ChannelRefinement": channel_refinement, "Detection": detection,
    "CheckResult": checked, "Classification": classification,
}  # fmt: skip


@pytest.fixture(params=MADE)
def result(request):
    yield MADE[request.param]()
    plt.close("all")


def test_captures_are_the_object_and_the_document_names_them(result):
    assert isinstance(result.captures, dnanalyze.CaptureSet)
    assert result.captures.frame_count == fakes.captures().frame_count
    assert result.to_dict()["captures"] == result.captures.name == NAME


def test_the_summary_is_plain_text_of_80_columns(result):
    text = result.summary()
    assert max(map(len, text.splitlines())) <= 80
    assert "\x1b" not in text
    assert text.startswith("<sensor> & co: 3 operating points")


def test_the_document_is_json_of_finite_numbers(result):
    made = result.to_dict()
    assert re.fullmatch(r"dnanalyze/[a-z]+/1", made["schema"])
    assert made["captures"] == NAME
    assert json.loads(json.dumps(made, allow_nan=False)) == made


def test_the_table_has_rows(result):
    table = result.to_dataframe()
    assert isinstance(table, pd.DataFrame)
    assert len(table) > 0


def test_the_repr_is_one_short_line(result):
    text = repr(result)
    assert text.startswith(f"<{type(result).__name__}: ")
    assert "\n" not in text
    assert len(text) < 160


def test_a_notebook_gets_escaped_html_that_fetches_nothing(result):
    html = result._repr_html_()
    assert "<script" not in html
    assert "<sensor>" not in html
    assert not re.search(r"(src|href)=\"(?!data:)", html)
    assert "data:image/svg+xml" in html


def test_it_is_saved_by_suffix(result, tmp_path):
    result.save(tmp_path / "r.json")
    assert json.loads((tmp_path / "r.json").read_text()) == result.to_dict()
    result.save(str(tmp_path / "r.csv"))
    assert len(pd.read_csv(tmp_path / "r.csv")) == len(result.to_dataframe())
    if getattr(result, "model", None) is None:
        with pytest.raises(dnanalyze.InputError, match=r"valid: \.json, \.html, \.csv$"):
            result.save(tmp_path / "r.yaml")
    else:
        result.save(tmp_path / "r.yaml")
        assert load_model(tmp_path / "r.yaml") == result.model
    with pytest.raises(dnanalyze.InputError, match="unknown suffix"):
        result.save(tmp_path / "r.pickle")
    assert not list(tmp_path.glob("*.pickle"))


@pytest.mark.long
def test_it_is_drawn_on_new_axes_or_on_the_users(result):
    axes = result.plot()
    first = axes if isinstance(axes, plt.Axes) else axes[0]
    assert isinstance(first, plt.Axes)
    assert plt.fignum_exists(first.figure.number)
    figure, (left, right) = plt.subplots(1, 2)
    drawn = np.atleast_1d(result.plot(ax=right))
    assert all(ax.figure is figure for ax in drawn)
    assert not left.has_data()
    assert any(ax.has_data() for ax in drawn)


def test_an_unknown_kind_is_refused_with_the_valid_ones(result):
    with pytest.raises(dnanalyze.InputError, match=r"kind='pie': unknown; valid: [a-z_]+"):
        result.plot("pie")


def test_a_figure_of_one_panel_is_drawn_on_the_axes_given():
    _, ax = plt.subplots()
    assert comparison().plot("families", ax=ax) is ax
    assert refinement().plot("steps", ax=ax) is ax
    plt.close("all")


def test_a_refinement_over_channels_is_drawn_together_and_channel_by_channel():
    result = channel_refinement()
    names = [t.get_text() for t in result.plot("steps").get_xticklabels()]
    assert names[0] == "start"
    assert names[-1].split() == ["final", "model"]
    assert [ax.get_title(loc="left") for ax in result.plot("channels")] == ["hcg", "lcg"]
    plt.close("all")


def test_what_the_captures_lack_is_said():
    bare = fakes.statistics()
    bare = replace(bare, settings=tuple(replace(s, curves={}) for s in bare.settings))
    with pytest.raises(dnanalyze.InputError, match="nothing to draw; kinds: sensor"):
        bare.plot("tails")
    plt.close("all")


@pytest.mark.long
@pytest.mark.parametrize("make", [comparison, checked, statistics])
def test_the_report_is_a_page(make, tmp_path):
    make().save(tmp_path / "r.html")
    text = (tmp_path / "r.html").read_text()
    assert text.startswith("<!DOCTYPE html>")
    assert "<sensor>" not in text


def test_a_report_without_captures_says_what_is_wanted(tmp_path):
    with pytest.raises(dnanalyze.InputError, match="shows the captures"):
        replace(statistics(), captures=None).save(tmp_path / "r.html")


def test_the_summary_is_what_the_terminal_prints():
    from dnanalyze.report.terminal import as_text, show

    made = refinement()
    assert made.summary() == as_text(lambda console: show(console, made))


def test_an_effect_added_by_hand_is_reported_as_such():
    made = refinement(by_hand=True)
    assert made.to_dict()["schema"] == "dnanalyze/add/1"
    assert made.summary().splitlines()[2].strip().startswith("With column_fpn")
