import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
import pytest
import report_fakes as fakes

from dnanalyze.analyzers.statistics import Scale, Statistics, Value
from dnanalyze.loaders.captures import OperatingPoint, Sensor
from dnanalyze.report.figures import (
    against_neighbours,
    candidates,
    codes,
    correlations,
    distribution,
    heatmap,
    lines,
    over_temperature,
    planes,
    shading,
    spectrum,
    suppression,
    tails,
    timeline,
    trends,
    waterfall,
)
from dnanalyze.report.figures.style import (
    chosen,
    labels,
    layers,
    picture,
    plane_note,
    power_label,
    runs,
)

SVG = "{http://www.w3.org/2000/svg}"
FAMILIES = {
    "distribution": distribution.histograms,
    "tails": tails.exceedance,
    "spectrum": spectrum.spectra,
    "planes": planes.planes,
    "lines": lines.profiles,
    "shading": shading.maps,
    "timeline": timeline.frame_means,
    "codes": codes.roughness,
    "trends": trends.over_temperature,
    "panels": lambda d: over_temperature.panels(d, ("mean", "hot_count_8", "absent"), "c"),
}


def words_of(made):
    """All text in a figure; its SVG must be well formed."""
    return " ".join("".join(t.itertext()) for t in ET.fromstring(made.svg).iter(f"{SVG}text"))


@pytest.mark.parametrize("name", FAMILIES)
@pytest.mark.parametrize("sources", [1, 3])
def test_every_family_draws_measured_alone_and_all_three_together(name, sources):
    three = fakes.statistics(3.0), fakes.statistics(2.5), fakes.statistics(4.0)
    made = FAMILIES[name](layers(*three[:sources]))
    text = words_of(made)
    assert made.alt
    assert made.caption
    if sources == 3 and name not in ("shading", "planes"):
        assert "measured" in text
        assert "model" in text


@pytest.mark.parametrize("name", FAMILIES)
def test_a_family_without_its_curves_draws_nothing(name):
    bare = [replace(s, curves={}, values={}) for s in fakes.statistics().settings]
    empty = Statistics("x", Sensor((8, 8)), tuple(bare))
    assert FAMILIES[name](layers(empty)) is None


def test_a_single_setting_of_unknown_temperature_can_be_drawn():
    lone = replace(fakes.statistics().settings[0], point=OperatingPoint())
    drawn = layers(Statistics("x", Sensor((8, 8)), (lone,)))
    for name in ("distribution", "tails", "spectrum", "lines"):
        assert FAMILIES[name](drawn) is not None
    assert FAMILIES["panels"](drawn) is None  # one dot over one tick says nothing
    assert trends.over_temperature(drawn) is None


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
    assert plane_note(both) == " Shown: 0.05 s. The rest is in the numbers."
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
    radius, power, held = spectrum._pooled((f, s), setting)
    assert np.all(held[:-1] >= spectrum.FEWEST_MODES)
    assert held.sum() == pytest.approx(modes.sum())
    assert np.all(np.diff(radius) > 0)
    z = (power / 9.0 - 1) * np.sqrt(held)
    assert np.abs(z).max() < 5  # 5 sigma of the pooled exponentials


def test_bands_are_taken_on_the_scale_of_the_statistic():
    low, high = over_temperature.ends_of(Value(4.0, 0.1), Scale.LOG)
    assert (low, high) == pytest.approx((4 * np.exp(-0.2), 4 * np.exp(0.2)))
    low, high = over_temperature.ends_of(Value(0.0, 1.0), Scale.ROOT)
    assert low == 0.0
    assert high == pytest.approx(((2 * 0.375**0.5 + 2) / 2) ** 2 - 0.375)
    assert over_temperature.ends_of(Value(1.0, 0.5), Scale.LINEAR) == (0.0, 2.0)
    assert over_temperature.ends_of(Value(1.0, np.nan), Scale.LOG) == (1.0, 1.0)


def test_a_missing_code_shows_as_zero_and_a_smooth_histogram_as_one():
    setting = fakes.statistics().settings[0]
    x = np.arange(0, 201)
    n = np.round(1e7 * np.exp(-(((x - 100) / 20) ** 2) / 2))
    n[103] = 0
    made = replace(setting, curves={"histogram_codes": x, "histogram_counts": n})
    code, ratio = codes._ratio(made)
    assert ratio[code == 103] == 0
    assert ratio[(code < 85) & (code > 75)] == pytest.approx(1, abs=0.02)


def test_suppression_is_named_at_its_end():
    text = words_of(suppression.suppression(fakes.detection().series))
    for word in ("measured", "unfiltered", "crosstalk 1 %"):
        assert word in text
    assert suppression.suppression(None) is None
    ends = suppression._apart(((1.0, "a", ""), (1.0, "b", ""), (0.2, "c", "")), 0.1)
    assert [y for y, *_ in ends] == pytest.approx([0.2, 1.0, 1.1])


def test_the_largest_neighbour_leaves_the_pixel_itself_out():
    frame = np.zeros((5, 5))
    frame[2, 2], frame[1, 3] = 9, 4
    pixel, around = against_neighbours.largest_neighbour(frame)
    assert pixel[1, 1] == 9
    assert around[1, 1] == 4
    assert around[0, 0] == 9
    assert against_neighbours.scatter([("a", np.zeros((8, 8), np.uint16))]) is not None
    assert against_neighbours.scatter([]) is None


def test_the_heat_map_shows_every_operating_point_and_the_worst_statistics():
    result = fakes.comparison()
    text = words_of(heatmap.discrepancies(result.statistics))
    for word in ("25 °C", "105 °C", "temporal_noise", "pattern_psd_0.08_0.16"):
        assert word in text
    assert "temporal_kurtosis" not in text  # it is not a number
    assert heatmap.discrepancies([]) is None


def test_family_errors_stand_beside_the_baselines():
    result = fakes.comparison()
    made = heatmap.families(result.families, result.baselines, result.error)
    text = words_of(made)
    for word in ("Mean dark signal and noise", "a second sensor", "this model", "Gaussian"):
        assert word in text
    assert "Hot-pixel tail" not in text  # NaN
    assert heatmap.families({}, {}, 1.0) is None


def test_the_waterfall_names_every_step():
    text = words_of(waterfall.waterfall(["start", "column_fpn"], [6.5, 1.1]))
    for word in ("start", "column_", "fpn", "final", "6.5", "1.1"):
        assert word in text
    assert waterfall.waterfall([], []) is None


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
    picture(lambda: None, "", "")
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
    assert lines.profiles(drawn) is not None  # a warning is an error
