"""The verdict: power on one filter of each kind, silence on unfiltered sensors, degenerate
input.
"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import hidden_filters as hidden
import numpy as np
import pytest
from virtual_sensor import BAYER, Traits, VirtualSensor, captures, from_stacks, random_traits

from dnanalyze.detection import detect
from dnanalyze.detection.excess import standing_out

SHAPE = (256, 256)
SERIES = (25.0, 55.0, 85.0)
ORDINARY = Traits(gain=1.2, hot=2e-3)
SAMPLES = Path(__file__).parents[3] / "shared" / "captures"


@pytest.mark.long
@pytest.mark.parametrize("name", hidden.FILTERS)
def test_each_filter_is_found_and_named(name):
    kind, run = hidden.FILTERS[name]
    found = detect(captures(VirtualSensor(ORDINARY, SHAPE, 1), SERIES, 8, run))
    assert found.kind == kind
    assert found.filtered
    assert found.evidence
    assert list(found.effect) == [kind]


@pytest.mark.long
@pytest.mark.parametrize(
    "name", ["clamp to neighbours", "Gaussian .5, half", "static DPC, 500 ppm"]
)
def test_filters_within_a_colour_are_found_on_a_mosaic(name):
    kind, run = hidden.FILTERS[name]
    sensor = VirtualSensor(replace(ORDINARY, plane_offset=4.0), (320, 320), 2)
    found = detect(captures(sensor, SERIES, 8, hidden.in_planes(run), BAYER))
    assert found.kind == kind
    assert found.estimate is not None
    assert found.estimate.view == "planes"


@pytest.mark.long
@pytest.mark.parametrize("seed", range(4))  # the rate: benchmarks/detection_roc.py
def test_unfiltered_sensors_are_left_in_peace(seed):
    sensor = VirtualSensor(random_traits(np.random.default_rng(500 + seed)), (192, 192), seed)
    found = detect(captures(sensor, SERIES, 6))
    assert found.kind == "none"
    assert not any(f.flagged for f in found.findings)
    assert found.estimate is None
    assert found.effect == {}


@pytest.mark.long
@pytest.mark.parametrize(
    "traits",
    [
        Traits(crosstalk=0.02, dark=20.0),
        Traits(hot=4e-3, clusters=1.0, cluster_size=5.0),
        Traits(flicker=5.0, pink=3.0, row_noise=3.0, column_fpn=4.0),
        Traits(hum=4.0, rts=0.03),
        Traits(hum=8.0, hum_at=(0.144, 0.175)),  # neighbours alike along rows and columns
        Traits(gain=0.09, pedestal=2.0, white=255.0),
        Traits(plane_offset=6.0, plane_gain=0.2),
        Traits(glow=300.0, drift=0.02, cosmic=20.0),
    ],
    ids=["crosstalk", "clusters", "1/f", "hum", "diagonal hum", "coarse", "mosaic", "glow"],
)
def test_nuisances_at_their_worst_are_not_filters(traits):
    found = detect(captures(VirtualSensor(traits, SHAPE, 3), SERIES, 8))
    assert found.kind == "none", found.evidence


def test_the_threshold_of_a_dynamic_correction_comes_back():
    traits = Traits(gain=2.0, hot=5e-3, hot_scale=8.0, dsnu=0.2)
    series = captures(VirtualSensor(traits, SHAPE, 4), SERIES, 8, hidden.dynamic_dpc(6.0))
    found = detect(series).estimate
    assert found is not None
    assert found.subkind == "dynamic"
    assert found.threshold_sigma == pytest.approx(6.0, rel=0.25)


def test_a_ratio_with_a_threshold_comes_back_as_the_models_rule():
    hot = Traits(gain=1.2, hot=2e-2, hot_scale=60.0)
    run = hidden.ratio_rule(2.0, hot.pedestal, 80.0, hidden.RING24)
    found = detect(captures(VirtualSensor(hot, SHAPE, 11), SERIES, 8, run))
    assert found.kind == "dpc"
    rule = found.effect["dpc"]
    assert (rule["kind"], rule["neighbours"], rule["replacement"]) == ("ratio", 24, "mean")
    assert rule["factor"] == pytest.approx(2.0, rel=0.2)
    level = hot.pedestal * (1 - rule["factor"]) + 80.0  # what it adds to factor x max, as recorded
    told = rule["black"] * (1 - rule["factor"]) + rule["threshold"]
    assert told == pytest.approx(level, abs=0.25 * 80.0)


def test_a_low_threshold_is_a_correction_not_a_denoise():
    series = captures(VirtualSensor(ORDINARY, SHAPE, 11), SERIES, 8, hidden.dynamic_dpc_median(2.6))
    assert detect(series).kind == "dpc"


def test_pixels_beside_replaced_sites_do_not_hide_the_edge():
    rng = np.random.default_rng(12)
    frame = rng.normal(100, 1, (300, 300))
    frame[rng.random(frame.shape) < 0.03] += 200.0
    hot = np.argwhere(frame > 250)
    pairs = hot[(hot[:, 1] < 299) & (hot.min(axis=1) > 2)][::2]
    frame[pairs[:, 0], pairs[:, 1] + 1] = 150.0  # a fainter neighbour, which stays
    frame[hot[:, 0], hot[:, 1]] = 100.0
    stack = np.repeat(frame[None], 3, axis=0).astype(np.float32)
    bare, masked = (standing_out([stack], 1, 1.0, replaced=r).difference for r in ((), [hot]))
    k = int(np.searchsorted(bare.bounds, 20.0))
    assert bare.own[k] > 100 * 3
    assert masked.own[k] < 0.05 * bare.own[k]


@pytest.mark.parametrize(
    ("run", "subkind"),
    [
        (hidden.gaussian(), "gaussian"),
        (hidden.median(), "median"),
        (hidden.bilateral(), "edge_preserving"),
    ],
    ids=["gaussian", "median", "bilateral"],
)
def test_the_shape_of_the_correlation_tells_the_kernel(run, subkind):
    uneven = replace(ORDINARY, rts=0.02, heavy=0.05)  # noise that is not the same everywhere
    found = detect(captures(VirtualSensor(uneven, SHAPE, 13), (25.0, 65.0), 8, run)).estimate
    assert found is not None
    assert found.subkind == subkind


def test_a_filter_that_averages_like_colours_alone_is_no_interference():
    # patches of a frame whose colours differ match two pixels away: the noise of next neighbours
    # becomes anticorrelated, as interference makes it
    sensor = VirtualSensor(replace(ORDINARY, plane_offset=9.0), (192, 192), 14)
    assert detect(captures(sensor, (25.0, 65.0), 6, hidden.nlm())).kind == "denoise"


def test_the_share_of_replaced_sites_comes_back():
    sensor = VirtualSensor(ORDINARY, SHAPE, 5)
    found = detect(captures(sensor, SERIES, 8, hidden.static_dpc(500))).estimate
    assert found is not None
    assert found.subkind == "static"
    count = 500e-6 * SHAPE[0] * SHAPE[1]
    assert found.site_ppm == pytest.approx(500, rel=5 / np.sqrt(count))


def test_a_list_shows_over_settings_of_one_frame_each():
    sensor = VirtualSensor(ORDINARY, SHAPE, 5)
    series = (25.0, 45.0, 65.0, 85.0)
    found = detect(captures(sensor, series, 1, hidden.static_dpc(500)))
    assert found.kind == "dpc"
    assert found.estimate is not None
    assert found.estimate.subkind == "static"
    count = 500e-6 * SHAPE[0] * SHAPE[1]
    assert found.estimate.site_ppm == pytest.approx(500, rel=5 / np.sqrt(count))
    assert found.evidence[0].startswith("All operating points: ")
    flagged = [f for f in found.findings if f.flagged]
    assert {(f.test, f.temperature_c) for f in flagged} == {("static_replacement", None)}
    assert detect(captures(sensor, series, 1)).kind == "none"


def test_rows_that_alone_are_filtered_are_named():
    def some_rows(stack):
        out = stack.copy()
        out[:, 3::8] = np.round(stack[:, 3::8] * 0.5 + 0.25 * np.roll(stack, 1, 2)[:, 3::8]
                                + 0.25 * np.roll(stack, -1, 2)[:, 3::8])  # fmt: skip
        return out

    found = detect(captures(VirtualSensor(Traits(gain=2.0), SHAPE, 6), SERIES, 8, some_rows))
    assert found.kind == "denoise"
    rows = [f for f in found.findings if f.test == "row_phase" and f.flagged]
    assert rows
    assert "row 3 of every 8 rows" in rows[0].words


def test_colours_in_other_rows_are_no_row_filter():
    sensor = VirtualSensor(Traits(gain=1.2, plane_offset=9.0), (192, 192), 15)
    assert detect(captures(sensor, SERIES, 1)).kind == "none"


def test_one_setting_and_one_frame_are_enough_for_strong_filters():
    sensor = VirtualSensor(ORDINARY, SHAPE, 7)
    assert detect(captures(sensor, (25.0,), 8, hidden.median(1.0))).kind == "denoise"
    assert detect(captures(sensor, (25.0,), 1, hidden.clamp())).kind == "dpc"
    single = detect(captures(sensor, (25.0,), 1))
    assert single.kind == "none"
    assert any("Single frames" in a for a in single.ambiguous)


@pytest.mark.parametrize(
    ("traits", "run"),
    [
        (Traits(gain=1.2, crosstalk=0.02, dark=20.0), None),
        (Traits(gain=1.2), hidden.gaussian(share=0.25)),
    ],
    ids=["crosstalk", "smoothing"],
)
def test_one_setting_cannot_tell_weak_smoothing_from_crosstalk_and_says_so(traits, run):
    found = detect(captures(VirtualSensor(traits, SHAPE, 1), (65.0,), 8, run))
    assert found.kind == "none"
    assert any("are not distinguishable" in a for a in found.ambiguous)


@pytest.mark.parametrize(
    "stack",
    [
        np.zeros((3, 64, 64), np.uint16),
        np.full((1, 40, 40), 7, np.uint8),
        np.random.default_rng(0).integers(0, 3, (2, 8, 8)).astype(np.uint16),
        np.random.default_rng(0).normal(100, 3, (4, 64, 64)).astype(np.float32),
        np.random.default_rng(0).integers(0, 2, (5, 48, 64)).astype(np.uint8),
        np.random.default_rng(0).normal(100, 3, (4, 30, 200)).round().astype(np.uint16),
    ],
    ids=["constant", "one constant frame", "tiny", "float", "binary", "narrow"],
)
def test_degenerate_frames_give_an_answer(stack):
    found = detect(from_stacks({None: lambda: stack}, stack.shape[1:], len(stack)))
    assert found.kind == "none"
    assert 0.0 <= found.confidence <= 1.0
    json.dumps(found.to_plain(), allow_nan=False)


@pytest.mark.parametrize(
    ("stack", "words"),
    [
        (np.random.default_rng(0).integers(0, 9, (4, 8, 8)).astype(np.uint16), "too small"),
        (
            np.where(np.random.default_rng(0).random((4, 64, 64)) < 0.5, 4095, 100).astype("u2"),
            "do not apply",
        ),
    ],
    ids=["tiny", "saturated"],
)
def test_where_the_tests_cannot_be_put_that_is_said(stack, words):
    found = detect(from_stacks({25.0: lambda: stack}, stack.shape[1:], len(stack)))
    assert found.kind == "none"
    assert found.confidence == 0
    assert any(words in said for said in found.ambiguous)


def test_progress_is_told_and_the_answer_repeats():
    sensor = VirtualSensor(ORDINARY, (96, 96), 8)
    told: list[tuple[int, int]] = []
    first = detect(captures(sensor, SERIES, 4), progress=lambda n, total: told.append((n, total)))
    assert told == [(1, 3), (2, 3), (3, 3)]
    assert first.to_plain() == detect(captures(sensor, SERIES, 4)).to_plain()


def _sample(name: str):
    folder = SAMPLES / name
    if not folder.is_dir():
        pytest.skip(f"sample captures {name} are not here")
    return pytest.importorskip("dnanalyze.loaders").load(folder)


@pytest.mark.parametrize(
    "name", ["scmos_single"]
    + [
        pytest.param(n, marks=pytest.mark.slow) for n in (
            "qsi583_2x2", "exposures_cc0",
            "fp30_cooling", "stl1001_2017", "fp30_warm", "st7_2019", "shane_amplifiers",
            "msdp_lines",
        )
    ],
)  # fmt: skip
def test_real_unfiltered_frames_are_left_in_peace(name):
    assert detect(_sample(f"real/{name}")).kind == "none"


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("corrected", "dpc"),
        ("smoothed", "denoise"),
        pytest.param("two", "none", marks=pytest.mark.slow),
        ("hot", "none"),
    ],
)
def test_sensors_of_an_independent_generator(name, kind):
    assert detect(_sample(f"hidden/{name}")).kind == kind
