import xml.etree.ElementTree as ET
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import report_fakes as fakes

from dnanalyze.analyzers.statistics import Statistics
from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import OperatingPoint, Sensor
from dnanalyze.report.figures import (
    candidates,
    code_use,
    correlations,
    distribution,
    exceedance,
    frame_means,
    heatmap,
    noise_and_dark_signal,
    over_operating_points,
    pixel_and_neighbours,
    rows_and_columns,
    shading,
    spectrum,
    spectrum_2d,
    suppression,
    waterfall,
)
from dnanalyze.report.figures.pictures import plotted
from dnanalyze.report.figures.style import (
    Cell,
    axis_of,
    chosen,
    labels,
    layers,
    panels,
    plane_note,
    power_label,
    runs,
)

SVG = "{http://www.w3.org/2000/svg}"
FAMILIES = {
    "distribution": distribution.histograms,
    "tails": exceedance.exceedance,
    "spectrum": spectrum.spectra,
    "planes": spectrum_2d.planes,
    "profiles": rows_and_columns.profiles,
    "lines": rows_and_columns.spectra,
    "shading": lambda d: (shading.maps(d) or [None])[0],
    "timeline": frame_means.frame_means,
    "codes": code_use.roughness,
    "trends": noise_and_dark_signal.over_temperature,
    "panels": lambda d: over_operating_points.statistics(d, ("mean", "hot_count_8", "absent"), "c"),
}


def words_of(made):
    """All text in a picture; its SVG must be well formed."""
    found = [
        "".join(t.itertext()) for p in made.panels for t in ET.fromstring(p.svg).iter(f"{SVG}text")
    ]
    return " ".join([*found, *(key.label for key in made.legend)])


def drawn_axes(made):
    """The panels of a picture as matplotlib axes."""
    import matplotlib as mpl

    mpl.use("Agg")
    axes = np.atleast_1d(plotted(made))
    mpl.pyplot.close("all")
    return list(axes)


@pytest.mark.parametrize("name", FAMILIES)
@pytest.mark.parametrize("sources", [1, 3])
def test_every_family_draws_measured_alone_and_all_three_together(name, sources):
    three = fakes.statistics(3.0), fakes.statistics(2.5), fakes.statistics(4.0)
    made = FAMILIES[name](layers(*three[:sources]))
    text = words_of(made)
    assert made.alt
    if sources == 3:
        assert "measured" in text
        assert "model" in text


@pytest.mark.parametrize("name", FAMILIES)
def test_every_panel_has_data_and_names_its_quantities(name):
    made = FAMILIES[name](layers(fakes.statistics(3.0), fakes.statistics(2.5)))
    for ax in drawn_axes(made):
        assert ax.has_data()
        assert ax.get_xlabel() or not len(ax.get_xticks())
        assert ax.get_ylabel() or not len(ax.get_yticks())


def test_the_legend_names_what_is_drawn_and_nothing_else():
    measured, simulated = fakes.statistics(3.0), fakes.statistics(2.5)
    gone = tuple(replace(s, curves={}) for s in simulated.settings)
    both = layers(measured, simulated)
    assert [k.label for k in exceedance.exceedance(both).legend] == ["measured", "model"]
    bare = layers(measured, replace(simulated, settings=gone))
    assert exceedance.exceedance(bare).legend == ()


def test_panels_choose_the_operating_points_that_have_the_curve():
    measured = fakes.statistics()
    first, *rest = measured.settings
    some = replace(measured, settings=(replace(first, curves={}), *rest))
    text = words_of(exceedance.exceedance(layers(some)))
    assert "25 °C" not in text
    assert "65 °C" in text
    assert "105 °C" in text


def test_the_axis_is_what_takes_the_most_values():
    setting = fakes.statistics().settings[0]
    many = [
        replace(setting, point=OperatingPoint(t, e, 1.0)) for t in (-10.0, -5.0) for e in (0, 1, 9)
    ]
    assert axis_of(many)[0] == "exposure_s"
    assert [len(run) for run in runs(many)] == [3, 3]
    assert axis_of(many[::3])[0] == "temperature_c"
    assert axis_of(many[:1])[0] == ""


def test_names_with_mathematics_or_markup_are_drawn_as_they_are():
    def draw(ax):
        ax.plot([0, 1], [0, 1])
        ax.set_title("$<b>\\no$")

    made = panels([Cell(draw)], "c", "a")
    assert "$<b>\\no$" in words_of(made)
    assert "<b>" not in made.panels[0].svg


def test_panels_that_share_a_scale_have_the_same_limits():
    def cell(top):
        return Cell(lambda ax: ax.plot([0, 1], [0, top]), share="y")

    limits = {ax.get_ylim() for ax in drawn_axes(panels([cell(1), cell(9)], "c", "a"))}
    assert len(limits) == 1
    assert limits.pop()[1] > 9


def test_a_picture_draws_on_the_users_axes():
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot

    made = waterfall.waterfall(fakes.refinement().steps)
    _, (ax, other) = pyplot.subplots(1, 2)
    assert plotted(made, ax) is ax
    assert ax.has_data()
    many = plotted(exceedance.exceedance(layers(fakes.statistics())), other)
    assert len(many) == 3
    with pytest.raises(InputError, match="grid"):
        plotted(
            exceedance.exceedance(layers(fakes.statistics())),
            pyplot.figure().add_axes((0, 0, 1, 1)),
        )
    pyplot.close("all")


@pytest.mark.parametrize("name", FAMILIES)
def test_a_family_without_its_curves_draws_nothing(name):
    bare = [replace(s, curves={}, values={}) for s in fakes.statistics().settings]
    empty = Statistics("x", Sensor((8, 8)), tuple(bare))
    assert not FAMILIES[name](layers(empty))


def test_a_single_setting_of_unknown_temperature_can_be_drawn():
    lone = replace(fakes.statistics().settings[0], point=OperatingPoint())
    drawn = layers(Statistics("x", Sensor((8, 8)), (lone,)))
    for name in ("distribution", "tails", "spectrum", "lines"):
        assert FAMILIES[name](drawn) is not None
    assert FAMILIES["panels"](drawn) is None  # one dot over one tick says nothing
    assert noise_and_dark_signal.over_temperature(drawn) is None


def test_the_settings_shown_run_from_first_to_last_in_one_plane():
    many = fakes.statistics(plane="R").settings
    other = [replace(s, plane="B") for s in many]
    shown = chosen(Statistics("x", Sensor((8, 8)), (*many, *other)), 2)
    assert [s.point.temperature_c for s in shown] == [25.0, 105.0]
    assert labels(shown) == ["25 °C", "105 °C"]


def test_only_settings_that_differ_in_temperature_alone_are_joined():
    dark = fakes.statistics().settings
    bias = [replace(s, point=replace(s.point, exposure_s=0.0)) for s in dark[:2]]
    both = Statistics("x", Sensor((8, 8)), (*bias, *dark))
    assert runs(both.settings) == [[2, 3, 4], [0, 1]]
    assert [s.point.exposure_s for s in chosen(both)] == [0.05] * 3
    assert plane_note(both) == " Shown: 0.05 s. The tables have every operating point."
    assert plane_note(fakes.statistics()) == ""
    other = Statistics("x", Sensor((8, 8)), tuple(reversed(dark)))
    assert [other.settings[n].point.temperature_c for n in runs(other.settings)[0]] == [
        25.0, 65.0, 105.0,
    ]  # fmt: skip


def test_white_noise_pools_to_its_variance_and_its_modes_to_the_plane():
    rng = np.random.default_rng(3)
    setting = fakes.statistics().settings[0]
    f = np.arange(1, 46) / 64
    modes = np.pi * f * np.gradient(f) * 64 * 64
    s = 9.0 * rng.gamma(modes) / modes
    radius, power, held = spectrum.pooled((f, s), setting)
    assert np.all(held[:-1] >= spectrum.FEWEST_MODES)
    assert held.sum() == pytest.approx(modes.sum())
    assert np.all(np.diff(radius) > 0)
    z = (power / 9.0 - 1) * np.sqrt(held)
    assert np.abs(z).max() < 5  # 5 sigma of the pooled exponentials


def test_a_missing_code_shows_as_zero_and_a_smooth_histogram_as_one():
    setting = fakes.statistics().settings[0]
    x = np.arange(0, 201)
    n = np.round(1e7 * np.exp(-(((x - 100) / 20) ** 2) / 2))
    n[103] = 0
    made = replace(setting, curves={"histogram_codes": x, "histogram_counts": n})
    code, ratio = code_use._ratio(made)
    assert ratio[code == 103] == 0
    assert ratio[(code < 85) & (code > 75)] == pytest.approx(1, abs=0.02)


def test_suppression_is_named_in_its_legend():
    text = words_of(suppression.suppression(fakes.detection().series))
    for word in ("measured", "unfiltered", "crosstalk of 1 %"):
        assert word in text
    assert suppression.suppression(None) is None


def test_the_largest_neighbour_leaves_the_pixel_itself_out():
    frame = np.zeros((5, 5))
    frame[2, 2], frame[1, 3] = 9, 4
    pixel, around = pixel_and_neighbours.largest_neighbour(frame)
    assert pixel[1, 1] == 9
    assert around[1, 1] == 4
    assert around[0, 0] == 9
    assert pixel_and_neighbours.scatter([("a", np.zeros((8, 8), np.uint16))]) is not None
    assert pixel_and_neighbours.scatter([]) is None


def test_the_heat_map_shows_every_operating_point_and_the_worst_statistics():
    result = fakes.comparison()
    text = words_of(heatmap.discrepancies(result.statistics))
    for word in ("25 °C", "105 °C", "temporal dark noise", "0.08 to 0.16 c/px"):
        assert word in text
    assert "kurtosis" not in text  # it is not a number
    assert heatmap.discrepancies([]) is None


def test_family_errors_stand_beside_the_baselines():
    result = fakes.comparison()
    made = heatmap.families(result.families, result.baselines, result.error)
    text = words_of(made)
    for word in ("Mean dark signal and noise", "Wang 2025 model", "this model", "Gaussian"):
        assert word in text
    assert "Hot-pixel tail" not in text  # NaN
    assert heatmap.families({}, {}, 1.0) is None


def test_colours_of_the_heat_map_tell_13_from_225():
    rows = [
        {"name": f"mean{n}", "family": "level", "temperature_c": 25.0, "plane": "",
         "discrepancy": d}
        for n, d in enumerate((225.0, 13.0, 2.0))
    ]  # fmt: skip
    (ax,) = drawn_axes(heatmap.discrepancies(rows))
    image = ax.images[0]
    red = [image.cmap(image.norm(v)) for v in (225.0, 13.0, 2.0)]
    bright = [0.299 * r + 0.587 * g + 0.114 * b for r, g, b, _ in red]
    assert bright[0] < bright[1] - 0.2 < bright[2] - 0.3
    bar = [float(t.replace("−", "-").replace(",", "")) for t in _ticks(ax)]
    assert {3, 10, 100} <= set(bar)


def _ticks(ax):
    """Labels of the colour bar beside these axes."""
    bar = ax.images[0].colorbar.ax
    bar.figure.draw_without_rendering()
    return [t.get_text() for t in bar.get_xticklabels() if t.get_text()]


def test_the_waterfall_names_every_step():
    made = waterfall.waterfall(fakes.refinement().steps)
    text = words_of(made)
    for word in ("start", "column_", "fpn", "final", "6.5", "1.1", "model error"):
        assert word in text
    assert waterfall.waterfall([]) is None


def test_what_every_sensor_has_is_one_stage_of_the_waterfall():
    steps = [
        SimpleNamespace(added=a, error=e)
        for a, e in ((None, 4.4), ("read_noise", 4.6), ("pixel_fpn", 4.3), ("quantization", 1.5),
                     ("column_fpn", 0.8))
    ]  # fmt: skip
    shown = waterfall.stages(steps)
    assert [(s.name, s.error) for s in shown] == [
        ("start", 4.4), ("baseline model", 1.5), ("column_fpn", 0.8),
    ]  # fmt: skip
    assert [p.added for p in shown[1].parts] == ["read_noise", "pixel_fpn", "quantization"]
    assert [s.name for s in waterfall.stages(steps[:2])] == ["start", "read_noise"]


def test_shading_is_measured_model_and_residual_with_one_bar():
    made = shading.maps(layers(fakes.statistics(3.0), fakes.statistics(2.5)), 1)[0]
    *fields, bar = drawn_axes(made)
    assert [ax.get_title(loc="left") for ax in fields] == ["measured", "model", "residual"]
    assert len({ax.images[0].get_clim() for ax in fields}) == 1
    measured, model, residual = (ax.images[0].get_array() for ax in fields)
    np.testing.assert_allclose(residual, measured - model)
    assert "[DN]" in bar.get_ylabel()


def test_the_plane_is_symmetric_and_reaches_nyquist_on_every_side():
    rng = np.random.default_rng(1)
    full = np.abs(np.fft.fft2(rng.normal(size=(16, 16)))) ** 2
    half = np.fft.fftshift(np.log10(full + 1), axes=0)[:, :9]
    setting = replace(fakes.statistics().settings[0], curves={"pattern_psd2d": half})
    plane = spectrum_2d._plane(setting, "pattern")
    assert plane.shape == (17, 17)
    np.testing.assert_allclose(plane, plane[::-1, ::-1], atol=1e-6)  # of a real image
    expected = 10 * (np.fft.fftshift(np.log10(full + 1)) - np.median(half))
    np.testing.assert_allclose(plane[:16, :16], expected, atol=1e-6)


def test_the_nyquist_mode_never_stands_alone():
    f = np.arange(1, 33) / 64
    s = np.ones(32)
    s[-1] = 1000.0  # one real mode: a single exponential, no average
    frequency, power = rows_and_columns._pooled(f, s)
    assert frequency[-1] < 0.5
    assert power[-1] < 500


def test_candidates_of_the_baseline_model_are_one_bar_and_the_rest_start_from_it():
    found = [
        SimpleNamespace(effect=e, error_after=a, confidence=0.9)
        for e, a in (("column_fpn", 0.8), ("read_noise", 4.0), ("quantization", 1.5))
    ]
    bars = candidates._bars(found, 4.4, ["read_noise", "quantization"])
    assert bars == [("baseline model", 4.4, 1.5, 0.9), ("column_fpn", 1.5, 0.8, 0.9)]


def test_a_statistic_that_is_zero_everywhere_gets_no_panel():
    measured = fakes.statistics()
    assert over_operating_points.statistics(layers(measured), ("column_outliers",), "c") is None


def test_candidates_stand_best_first_from_the_top():
    made = candidates.candidates(fakes.diagnosis().candidates, 6.5)
    assert "column_gain" in words_of(made)
    assert candidates.candidates([], None) is None


def test_ticks_of_log_axes_are_plain_text():
    assert [power_label(v) for v in (0.01, 1.0, 100.0, 1e5, 1e-6, 5.0)] == [
        "0.01", "1", "100", "10⁵", "10⁻⁶", "5",
    ]  # fmt: skip


def test_drawing_leaves_no_trace_in_matplotlib():
    import matplotlib as mpl

    before = dict(mpl.rcParams)
    distribution.histograms(layers(fakes.statistics()))
    assert dict(mpl.rcParams) == before


def test_correlations_leave_out_what_is_not_determined():
    matrix = np.array([[1, 0.5, np.nan], [0.5, 1, np.nan], [np.nan] * 3])
    text = words_of(correlations.correlations(["mu", "delta", "phi"], matrix))
    assert "mu" in text
    assert "phi" not in text
    assert correlations.correlations(["mu"], [[1.0]]) is None


def test_lines_that_are_all_alike_have_no_spectrum():
    measured = fakes.statistics()
    settings = tuple(
        replace(s, curves={k: np.zeros_like(v) if "_spectrum" in k and not k.endswith("_f") else v
                           for k, v in s.curves.items()})
        for s in measured.settings
    )  # fmt: skip
    drawn = layers(replace(measured, settings=settings))
    assert rows_and_columns.profiles(drawn) is not None  # a warning is an error
    assert rows_and_columns.spectra(drawn) is None
