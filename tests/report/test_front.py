"""The first two pages of a report: what they say and show."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import report_fakes as fakes

import dnanalyze
from dnanalyze.analyzers.statistics import SettingStatistics, Statistics, Value
from dnanalyze.demo import tiny
from dnanalyze.diagnosis.results import Step
from dnanalyze.fitting.design import design
from dnanalyze.fitting.problem import fit_problem
from dnanalyze.loaders.captures import OperatingPoint, Sensor
from dnanalyze.model.effects.column_fpn import ColumnFpn
from dnanalyze.model.effects.denoise import Denoise
from dnanalyze.report.fields import (
    FRAME,
    MEAN,
    TEMPORAL,
    Place,
    fields,
    kind_of,
    side_of,
    worst_place,
)
from dnanalyze.report.figures.before_after import before_after, changed
from dnanalyze.report.figures.field_images import block_means, field_row, robust_range
from dnanalyze.report.figures.style import Layer, layers
from dnanalyze.report.figures.wang_2025 import figure_1, figure_2
from dnanalyze.report.leads import compare_lead, diagnose_lead, plain_name, refine_lead
from dnanalyze.report.page import render, tone_of
from dnanalyze.report.results import refinement, statistics
from dnanalyze.report.rivals import Rival, Rivals, of_steps, unfiltered
from dnanalyze.report.significant_structure import plainest, sentence_of, structures
from dnanalyze.report.words import compare_headline

POINTS = OperatingPoint(15.0), OperatingPoint(95.0)


def measured(**by_point):
    """Statistics of two operating points with these values and errors."""
    settings = tuple(
        SettingStatistics(
            point, "", 4, (64, 64), {name: Value(*v[n]) for name, v in by_point.items()}
        )
        for n, point in enumerate(POINTS)
    )
    return Statistics("sensor", Sensor((64, 64)), settings)


def row(name, point, z, family="level", simulated=1.0):
    return {
        "name": name, "family": family, **vars(point), "plane": "", "discrepancy": z,
        "simulated": simulated,
    }  # fmt: skip


def test_stripes_are_found_where_they_are_plain_and_said_in_words():
    found = measured(column_noise=[(4.2, 0.04), (1.01, 0.04)], row_noise=[(1.0, 0.04), (1.1, 0.04)])
    (one,) = structures(found)
    assert one.place == Place(POINTS[0], "", MEAN)
    assert "columns scatter 4.2 times" in sentence_of(one, found)
    assert "15 °C" in sentence_of(one, found)
    assert plainest(found) == one.place


def test_what_chance_makes_is_no_structure():
    assert structures(measured(column_noise=[(1.1, 0.04), (1.15, 0.04)])) == []
    assert structures(measured(temporal_corr_10=[(0.2, 0.1), (0.02, 0.001)])) == []


def test_columns_that_differ_by_a_slow_shape_are_shading_and_no_stripes():
    slow = measured(
        column_noise=[(5.0, 0.03)] * 2,
        column_mean_sd=[(35.0, 0.2)] * 2,
        frame_noise_core=[(40.0, 0.01)] * 2,
        shading_1_0=[(10.0, 13.0)] * 2,
        shading_2_0=[(29.0, 13.0)] * 2,
        shading_0_1=[(1.0, 0.1)] * 2,
    )
    (one,) = structures(slow)
    assert sentence_of(one, slow).startswith("shading: the slow shape of the field scatters 0.77")


def test_lines_that_move_are_said_once():
    found = structures(
        measured(row_noise=[(3, 0.04), (2, 0.04)], temporal_row_noise=[(3, 0.04), (2, 0.04)])
    )
    assert [f.sign.name for f in found] == ["temporal_row_noise"]


def test_the_page_of_a_quiet_sensor_says_that_nothing_stands_out():
    text = render(statistics.page(fakes.statistics()))
    assert "No structure is significant" in text
    assert text.index("No structure") < text.index('id="frames"') < text.index('id="capture"')


@pytest.mark.parametrize(
    ("name", "kind"),
    [("temporal_psd", TEMPORAL), ("frame_q0.1", FRAME), ("row_extreme", MEAN)],
)  # fmt: skip
def test_a_statistic_has_its_kind_of_picture(name, kind):
    assert kind_of(name) == kind


def test_the_worst_place_is_where_the_model_or_the_step_before_fails_most():
    cold, hot = POINTS
    rows = [row("pattern_x", cold, 9.0), row("temporal_x", hot, 20.0)]
    assert worst_place(rows) == Place(hot, "", TEMPORAL)
    better = [row("pattern_x", cold, 1.0), row("temporal_x", hot, 19.0)]
    assert worst_place(rows, better) == Place(cold, "", MEAN)
    assert worst_place([]) is None


def test_blocks_keep_a_pattern_of_two_columns():
    image = np.tile([1.0, -1.0], (700, 350))
    assert side_of(image.shape, 400) == 3
    found = block_means(image, 400)
    assert found.shape == (233, 233)
    assert np.allclose(np.abs(found), 1 / 3)
    assert np.allclose(found[:, 0], -found[:, 1])
    assert np.allclose(block_means(image, 400, squares=True), 1.0)


def test_one_hot_pixel_does_not_move_the_scale():
    image = np.random.default_rng(1).normal(100, 2, (50, 50))
    image[3, 4] = 60000
    low, high = robust_range(image)
    assert abs(low - 92) < 1
    assert abs(high - 108) < 1


def test_fields_are_the_mean_and_the_scatter_of_the_frames():
    captures = tiny()
    setting = captures.settings[1]
    stack = np.stack([f.read() for f in setting.frames]).astype(float)
    mean = fields(captures, Place(setting.point), {})
    noise = fields(captures, Place(setting.point, "", TEMPORAL), {})
    assert np.allclose(mean.images["measured"], stack.mean(axis=0), atol=1e-3)
    assert np.allclose(noise.images["measured"], stack.std(axis=0, ddof=1), atol=1e-3)
    assert fields(captures, Place(OperatingPoint(-200.0)), {}) is None


@pytest.fixture(scope="module")
def fitted():
    captures = tiny()
    problem = fit_problem(design(captures))
    return captures, problem, dnanalyze.fit(captures).model


def test_the_row_of_frames_ends_with_the_difference(fitted):
    captures, _, model = fitted
    found = fields(captures, Place(captures.settings[0].point), {"model": model})
    picture = field_row(found)
    assert len(picture.panels) == 3
    assert "measured − model" in picture.caption


def test_the_named_effect_stands_beside_the_model_of_the_step_before(fitted):
    _, problem, model = fitted
    with_it = model.with_effect(ColumnFpn(sigma=2.0))
    steps = [Step(None, 5.0, model=model), Step("column_fpn", 2.0, model=with_it)]
    found = of_steps(problem, steps, ["column_fpn"])
    assert found.effect == "column_fpn"
    assert (found.before.model, found.after.model) == (model, with_it)
    assert found.raw is None
    assert of_steps(problem, steps, []).before is None


def test_a_filtered_model_is_shown_without_its_filters(fitted):
    _, problem, model = fitted
    assert unfiltered(problem, model) is None
    raw = unfiltered(problem, model.with_effect(Denoise()))
    assert raw.model == model


def test_figure_1_draws_every_layer_and_figure_2_every_temperature():
    drawn = layers(fakes.statistics(3.0), fakes.statistics(2.5))
    one = figure_1(drawn, drawn[0].statistics.settings[0])
    assert [k.label for k in one.legend] == ["measured", "model"]
    two = figure_2(drawn)
    assert {"measured", "model"} < {k.label for k in two.legend}
    raw = figure_2(drawn, Layer("raw", fakes.statistics(4.0)))
    assert len(raw.panels) == 2
    assert any("processed" in p.svg for p in raw.panels)


def test_the_statistics_corrected_most_come_first():
    before = [row("a_1", POINTS[0], 50.0), row("a_2", POINTS[0], 40.0), row("b", POINTS[1], 5.0)]
    after = [row("a_1", POINTS[0], 1.0), row("a_2", POINTS[0], 1.0), row("b", POINTS[1], 6.0)]
    before += [row("c", POINTS[0], 6.0, simulated=float("nan"))]  # the model has none
    after += [row("c", POINTS[0], 1.0)]
    assert changed(before, after) == ["a_1"]


def test_before_and_after_of_no_change_is_no_picture():
    same = [row("a", POINTS[0], 2.0)]
    assert before_after([], same, same, ("without", "with")) is None


def test_leads_say_what_the_sensor_has():
    assert plain_name("column_fpn") == "column FPN"
    steps = [Step(None, 5.0), Step("read_noise", 3.0), Step("column_fpn", 1.0, 0.97)]
    done = SimpleNamespace(steps=steps, finished=True, verdict="adequate")
    assert "has column FPN (fixed vertical stripes" in refine_lead(done)
    done.steps = steps[:2]
    assert refine_lead(done).startswith("No fault is visible in these captures")
    done.verdict = "unexplained"
    assert "no effect of the catalogue explains" in refine_lead(done)
    doubtful = [*steps[:2], replace(steps[2], confidence=0.6)]
    assert "possibly column FPN" in refine_lead(
        SimpleNamespace(steps=doubtful, finished=True, verdict="adequate")
    )


def test_the_lead_of_a_diagnosis_names_the_candidate():
    assert "row FPN" in diagnose_lead(fakes.diagnosis()) or "column FPN" in diagnose_lead(
        fakes.diagnosis()
    )


def test_the_lead_of_a_comparison_names_a_structure_that_the_model_lacks():
    with_it = measured(column_noise=[(4.2, 0.04), (1.0, 0.04)])
    without = measured(column_noise=[(1.0, 0.04), (1.0, 0.04)])
    result = fakes.Comparison(
        error=6.0, failures=["other"], unexplained=["drift"], measured=with_it, simulated=without
    )
    assert "It lacks fixed vertical stripes" in compare_lead(result)
    result.simulated = with_it
    assert compare_lead(result).endswith("Other.")


def test_an_error_near_1_does_not_hide_what_sensors_of_the_design_do_not_show():
    """A real camera: error 1.16, whole rows 11 standard deviations off."""
    result = fakes.comparison()
    result.error, result.unexplained = 1.16, ["drift"]
    assert "as close to this sensor" in compare_lead(result)
    assert "but not everywhere: " in compare_lead(result)
    assert "<script>" in compare_lead(result)  # the worst failure is told
    assert tone_of(result.error, result.adequate) == "fair"
    assert "but not everywhere: " in compare_headline(result)
    result.unexplained = []
    assert compare_lead(result).endswith("a second sensor of the same design.")
    assert tone_of(result.error, result.adequate) == "good"
    result.error = 1.4  # a replicate may have as much: `diagnose` calls it adequate
    assert compare_lead(result).endswith("a second sensor of the same design.")


def test_a_refinement_shows_before_and_after_in_front():
    result, comparison = fakes.refinement(), fakes.comparison()
    rows = comparison.statistics
    better = [r | {"discrepancy": r["discrepancy"] / 9} for r in rows]
    beside = Rivals(
        "column_fpn",
        Rival(fakes.model(), comparison.gaussian, rows),
        Rival(fakes.model(), comparison.simulated, better),
    )
    text = render(refinement.page_so_far(result, comparison, beside))
    assert "Column FPN: before and after" in text
    assert text.index('id="effect"') < text.index('id="figure-1"') < text.index('class="detail"')
