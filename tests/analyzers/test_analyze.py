import math

import numpy as np
import pytest
from dark_frames import ROOM, capture_of, captures_of, dark_frames

from dnanalyze.analyzers.analyze import analyze, analyze_windows
from dnanalyze.analyzers.catalogue import FAMILIES, catalogue, find
from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import OperatingPoint, Window

SHAPE = (96, 128)


def same(one, two):
    assert one.values == two.values
    assert one.missing == two.missing
    for name in one.curves:
        np.testing.assert_array_equal(one.curves[name], two.curves[name])


def test_every_statistic_is_there_or_has_a_reason():
    names = {info.name for family in FAMILIES for info in family.INFOS}
    for count in (1, 2, 3, 6):
        (setting,) = analyze(capture_of(dark_frames(1, count, SHAPE))).settings
        told = set(setting.values) | set(setting.missing)
        families = {i.family for i in catalogue().values()}
        lost = {n for n in names - told if catalogue()[n].family not in setting.missing}
        if count > 1:  # those of the DSNU and of the temporal noise are there instead
            parts = ("corr", "columns", "rows", "u", "v", "line", "axis", "nyquist")
            lost -= {n for n in lost if n.startswith(tuple(f"frame_{p}_" for p in parts))}
            lost.discard("frame_line")
        assert not lost, (count, sorted(lost))
        assert set(setting.values) <= set(catalogue())
        assert set(setting.missing) <= set(catalogue()) | families
        assert setting.frames == count
        assert setting.shape == SHAPE


@pytest.mark.parametrize("codes", [True, False])
@pytest.mark.parametrize("count", [1, 2, 6])
def test_values_are_finite_and_errors_positive(codes, count):
    (setting,) = analyze(capture_of(dark_frames(2, count, SHAPE, codes=codes))).settings
    for name, value in setting.values.items():
        assert math.isfinite(value.value), name
        assert math.isfinite(value.se), name
        assert value.se > 0, name
        assert math.isfinite(catalogue()[name].scale.coordinate(value.value)), name


def test_a_window_is_a_frame_of_its_own():
    frames = dark_frames(3, 3, SHAPE)
    window = Window(8, 72, 16, 112)
    cut = [np.ascontiguousarray(f[window.slices]) for f in frames]
    (inside,) = analyze(capture_of(frames), window=window).settings
    (alone,) = analyze(capture_of(cut)).settings
    same(inside, alone)


def test_windows_share_one_reading_of_each_frame():
    frames = dark_frames(4, 3, SHAPE)
    captures = capture_of(frames)
    reads = []
    (setting,) = captures.settings
    counted = [
        type(f)(f.name, f.point, lambda w, f=f: (reads.append(f.name), f.read(w))[1])
        for f in setting.frames
    ]
    captures = type(captures)(
        captures.name, captures.sensor, (type(setting)(setting.point, tuple(counted)),)
    )
    windows = [None, Window(0, 48, 0, 128), Window(48, 96, 0, 128)]
    found = analyze_windows(captures, windows)
    assert len(reads) == 3
    for window, statistics in zip(windows, found, strict=True):
        same(statistics.settings[0], analyze(capture_of(frames), window=window).settings[0])


def test_colour_planes_are_analysed_one_by_one():
    frames = dark_frames(5, 3, SHAPE)
    statistics = analyze(capture_of(frames, cfa=(("R", "G"), ("G", "B"))))
    assert [s.plane for s in statistics.settings] == ["R", "Gr", "Gb", "B"]
    for plane, (row, column) in zip(statistics.settings, np.ndindex(2, 2), strict=True):
        cut = [np.ascontiguousarray(f[row::2, column::2]) for f in frames]
        same(plane, analyze(capture_of(cut)).settings[0])


@pytest.mark.parametrize("period", [4, 6])  # quad, X-Trans
def test_larger_mosaics_are_analysed_as_every_second_row_and_column(period):
    frames = dark_frames(5, 3, SHAPE)
    cfa = tuple(tuple("RGB"[(r + c) % 3] for c in range(period)) for r in range(period))
    found = analyze(capture_of(frames, cfa=cfa)).settings
    bayer = analyze(capture_of(frames, cfa=(("R", "G"), ("G", "B")))).settings
    assert [s.plane for s in found] == ["00", "01", "10", "11"]
    for one, two in zip(found, bayer, strict=True):
        assert one.values["temporal_noise"] == two.values["temporal_noise"]


def test_mosaics_of_an_odd_period_are_refused():
    with pytest.raises(InputError, match="odd period"):
        analyze(capture_of(dark_frames(5, 3, SHAPE), cfa=(("R", "G", "B"),)))


def test_a_window_on_a_mosaic_begins_at_a_whole_block():
    frames = dark_frames(6, 2, SHAPE)
    captures = capture_of(frames, cfa=(("R", "G"), ("G", "B")))
    odd = analyze(captures, window=Window(3, 71, 5, 111)).settings
    even = analyze(captures, window=Window(4, 70, 6, 110)).settings
    for one, two in zip(odd, even, strict=True):
        same(one, two)


def test_workers_do_not_change_the_result():
    captures = capture_of(dark_frames(7, 6, (640, 640)))
    alone = analyze(captures, workers=1).settings[0]
    for workers in (2, 3):
        same(analyze(captures, workers=workers).settings[0], alone)


def test_progress_counts_frames():
    seen = []
    cold = OperatingPoint(0.0, 1.0)
    captures = captures_of([(cold, dark_frames(8, 2, SHAPE)), (ROOM, dark_frames(9, 1, SHAPE))])
    analyze(captures, progress=lambda done, total: seen.append((done, total)))
    assert seen == [(1, 3), (2, 3), (3, 3)]


@pytest.mark.parametrize("codes", [True, False])
@pytest.mark.parametrize(
    "kind", ["constant", "constant rows", "two values", "one hot", "saturated"]
)
def test_degenerate_frames_give_finite_values(codes, kind):
    base = np.full(SHAPE, 64.0)
    if kind == "constant rows":
        base += np.arange(SHAPE[0])[:, None]
    if kind == "two values":
        base[::2] += 1
    if kind == "one hot":
        base[3, 5] = 4000
    if kind == "saturated":
        base = np.random.default_rng(1).normal(70, 8, SHAPE).clip(64, 66).round()
    dtype = np.uint16 if codes else np.float32
    frames = [(base if codes else base + 0.25).astype(dtype)] * 5
    (setting,) = analyze(capture_of(frames)).settings
    for name, value in setting.values.items():
        assert math.isfinite(value.value), name
        assert math.isfinite(value.se), name
        assert value.se > 0, name


def test_bad_windows_and_shapes_are_one_clear_line():
    captures = capture_of(dark_frames(10, 2, SHAPE))
    with pytest.raises(InputError, match="must lie within"):
        analyze(captures, window=Window(0, 200, 0, 100))
    with pytest.raises(InputError, match="too few"):
        analyze(captures, window=Window(0, 4, 0, 100))
    mixed = capture_of([*dark_frames(10, 1, SHAPE), *dark_frames(10, 1, (80, 128))])
    with pytest.raises(InputError, match="frame 1"):
        analyze(mixed)


def test_names_are_unique_and_near_ones_are_offered():
    names = [info.name for family in FAMILIES for info in family.INFOS]
    assert len(names) == len(set(names))
    assert find("temporal_noise").unit == "DN"
    with pytest.raises(InputError, match="temporal_noise"):
        find("temporal_nose")


def test_every_compared_statistic_says_what_a_misfit_means():
    for info in catalogue().values():
        if info.compared:
            assert info.high, info.name
            assert info.low, info.name


def test_chosen_families_have_the_values_of_all_and_nothing_else():
    captures = capture_of(dark_frames(3, 5, (64, 80)))
    whole = analyze(captures).settings[0]
    for chosen in (("level",), ("lines", "level"), ("neighbours",), ("spectrum", "codes")):
        some = analyze(captures, families=chosen).settings[0]
        families = {catalogue()[name].family for name in some.values}
        assert families == set(chosen)
        assert some.values == {n: v for n, v in whole.values.items() if n in some.values}
        assert len(some.values) == sum(catalogue()[n].family in chosen for n in whole.values) - sum(
            n == "dark_rate_dn_s" for n in whole.values
        )


def test_the_spectrum_of_the_mean_frame_alone_is_that_of_the_whole_family():
    captures = capture_of(dark_frames(3, 6, (64, 80)))
    whole = analyze(captures, families=("spectrum",)).settings[0]
    alone = analyze(captures, families=("pattern_spectrum",)).settings[0]
    assert set(alone.values) == {n for n in whole.values if n.startswith("pattern_")}
    for name, value in alone.values.items():
        assert value.value == whole.values[name].value
        if not name.endswith("peak"):  # whose error knows how white the temporal noise is
            assert value.se == whole.values[name].se, name
    both = analyze(captures, families=("pattern_spectrum", "spectrum")).settings[0]
    assert both.values == whole.values
    (single,) = analyze(
        capture_of(dark_frames(3, 1, (64, 80))), families=("pattern_spectrum",)
    ).settings
    assert not single.values
    assert "one frame does not separate" in single.missing["spectrum"]


def test_an_unknown_family_is_named_with_the_valid_ones():
    with pytest.raises(InputError, match="no family is called 'colour'; valid: level, dist"):
        analyze(capture_of(dark_frames(3, 2)), families=("colour",))
