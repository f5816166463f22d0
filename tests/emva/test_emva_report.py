"""The EMVA quantities in JSON, on the page and as maps."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from known_sensor import sensor_frames

from dnanalyze.analyzers.analyze import analyze
from dnanalyze.emva import evaluate
from dnanalyze.report import emva_tables
from dnanalyze.report.figures.dark_signal import dark_signal
from dnanalyze.report.figures.sensor_maps import sensor_maps, shown
from dnanalyze.report.page import render
from dnanalyze.report.results.statistics import document, headline, page

POINTS = [(t, e, 3) for t in (25.0, 45.0) for e in (0.0, 2.0, 4.0)]


@pytest.fixture(scope="module")
def captures():
    return sensor_frames(0, POINTS, (160, 140), current_e_s=10.0)


@pytest.fixture(scope="module")
def measured(captures):
    return analyze(captures, workers=1)


def test_json_keeps_its_keys_and_gains_emva(measured):
    plain = document(measured)
    text = json.dumps(plain, allow_nan=False)
    assert {"sensor", "settings", "trends", "doubts", "emva"} <= set(plain)
    (group,) = json.loads(text)["emva"]
    keys = {q["key"] for q in group["operating_points"][0]["quantities"]}
    assert {"temporal_dark_noise_dn", "dsnu_row_dn", "dsnu_col_dn", "dsnu_pixel_dn"} <= keys
    for quantity in group["operating_points"][0]["quantities"]:
        assert (quantity["value"] is None) == bool(quantity["reason"])
        assert set(quantity) == {
            "key", "symbol", "name", "unit", "value", "se", "low", "high", "reason", "note",
        }  # fmt: skip


@pytest.mark.long
def test_page_begins_with_maps_and_quantities(captures, measured):
    text = render(page(measured))
    assert text.index("The sensor") < text.index("EMVA 1288 dark quantities")
    assert text.index("EMVA 1288 dark quantities") < text.index("Mean dark signal and noise")
    assert "σ<sub>y.dark</sub>" in text


def test_maps_are_light(measured):
    assert sum(len(panel.svg) for panel in sensor_maps(measured).panels) < 2e5


def test_headline_states_noise_dsnu_and_dark_current(measured):
    text = headline(measured)
    for word in ("Temporal dark noise", "DSNU", "dark current", "doubling every"):
        assert word in text


def test_hot_pixels_survive_the_reduction_of_maps():
    captures = sensor_frames(0, [(25.0, 0.0, 2)], (300, 300), spread=0.0)
    setting = captures.settings[0]
    held = tuple(replace(f, load=_with_hot_pixel(f.read().copy())) for f in setting.frames)
    changed = replace(captures, settings=(replace(setting, frames=held),))
    curves = analyze(changed, workers=1).settings[0].curves
    assert curves["picture_hot"].shape == (128, 128)
    assert curves["picture_hot"].max() == pytest.approx(2900, abs=20)
    assert np.unravel_index(curves["picture_hot"].argmax(), (128, 128)) == (64, 3)


def _with_hot_pixel(pixels: np.ndarray):
    pixels[151, 7] = 3000
    return lambda window: pixels


def test_the_warmest_operating_point_that_is_not_clipped_is_drawn(measured):
    assert shown(measured).point.temperature_c == 45.0
    assert shown(measured).point.exposure_s == 4.0
    assert "45 °C" in sensor_maps(measured).caption


def test_a_single_operating_point_draws_no_empty_axes():
    found = evaluate(analyze(sensor_frames(0, [(25.0, 1.0, 2)], (32, 32)), workers=1))
    assert dark_signal(found) is None


def test_reasons_are_given_once_with_their_quantities():
    found = evaluate(analyze(sensor_frames(0, [(25.0, 1.0, 1)], (32, 32)), workers=1))
    lines = emva_tables.undetermined(found)
    assert len(lines) == len(set(lines))
    assert any(line.startswith("σ_y.dark") and "one frame" in line for line in lines)
