"""Frames that cannot be what they are taken for, and those that are."""

import json

import numpy as np
import pytest
import tifffile

from dnanalyze import analyze
from dnanalyze.errors import InputError
from dnanalyze.loaders import health, inspect, load

SHAPE = (200, 512)
PATTERN = np.random.default_rng(99).normal(100.0, 8.0, SHAPE)


def frames(count, seed=0, noise=2.0, moved=lambda k: 0.0):
    """Frames of one sensor with new noise in each."""
    rng = np.random.default_rng(seed)
    return [
        np.rint(PATTERN + rng.normal(0.0, noise, SHAPE) + moved(k)).astype(np.uint16)
        for k in range(count)
    ]


def folder(root, some, name="T25C_exp_1s", save=np.save, suffix=".npy"):
    for k, frame in enumerate(some):
        save(root / f"{name}_{k:02d}{suffix}", frame)
    return load(root)


def deflated(path, frame):
    tifffile.imwrite(path, frame, compression="zlib")


@pytest.mark.parametrize(("save", "suffix"), [(np.save, ".npy"), (deflated, ".tif")])
def test_identical_frames_count_once(tmp_path, save, suffix):
    some = frames(4)
    captures = folder(tmp_path, [*some, some[1], some[2]], save=save, suffix=suffix)
    assert captures.frame_count == 4
    (note,) = captures.notes
    assert note.startswith(f"T25C_exp_1s_04{suffix} has the same pixels as T25C_exp_1s_01{suffix},")
    assert "and so 1 more" in note
    assert inspect(captures)["notes"] == [note]


def test_a_copy_makes_neither_noise_nor_errors_smaller(tmp_path):
    some, found = frames(3), []
    for name, given in (("clean", some), ("copied", [*some, some[2]])):
        (tmp_path / name).mkdir()
        measured = analyze(folder(tmp_path / name, given), families=("level", "time"))
        found.append({n: (v.value, v.se) for n, v in measured.settings[0].values.items()})
    assert found[0] == found[1]


def test_a_copy_at_another_operating_point_is_told_and_kept(tmp_path):
    some = frames(3)
    folder(tmp_path, some)
    captures = folder(tmp_path, [*frames(2, seed=5), some[0]], name="T25C_exp_2s")
    assert captures.frame_count == 6
    (note,) = captures.notes
    assert "T25C_exp_2s_02.npy (25 °C, 2 s) has the same pixels as T25C_exp_1s_00.npy" in note


def test_copies_of_one_frame_everywhere_leave_one_at_each_operating_point(tmp_path):
    (frame,) = frames(1)
    folder(tmp_path, [frame] * 3)
    captures = folder(tmp_path, [frame] * 2, name="T45C_exp_1s")
    assert [len(s.frames) for s in captures.settings] == [1, 1]
    copies, elsewhere = captures.notes
    assert "and so 2 more: identical frames count once" in copies
    assert elsewhere.startswith("T45C_exp_1s_00.npy (45 °C, 1 s) has the same pixels as")


def test_frames_nearly_all_at_one_code_may_be_equal_at_two_operating_points(tmp_path):
    still = np.zeros(SHAPE, np.uint16)
    still[::7, ::50] = 3
    folder(tmp_path, [still])
    (note,) = folder(tmp_path, [still], name="T45C_exp_1s").notes
    assert "In 2 of 2 operating points" in note


def test_frames_that_differ_where_no_strip_lies_are_two(tmp_path):
    shape = (512, 512)
    first = np.random.default_rng(0).integers(90, 110, shape).astype(np.uint16)
    second = first.copy()
    second[20, 7] += 1  # the strips are 8 of every 33 rows
    assert folder(tmp_path, [first, second]).frame_count == 2


def test_a_frame_that_hardly_differs_from_the_one_before_is_told(tmp_path):
    some = frames(5)
    near = some[2].copy()
    near[:, ::10] += 1
    captures = folder(tmp_path, [*some[:3], near, *some[3:]])
    assert captures.frame_count == 6
    (note,) = captures.notes
    assert note.startswith("T25C_exp_1s_03.npy hardly differs from T25C_exp_1s_02.npy:")


@pytest.mark.parametrize(("share", "said"), [(0.995, True), (0.98, False)])
def test_pixels_that_are_nearly_all_at_one_code_are_told(tmp_path, share, said):
    rng = np.random.default_rng(0)
    some = [np.where(rng.random(SHAPE) < share, 0, 5).astype(np.uint16) for _ in range(3)]
    notes = folder(tmp_path, some).notes
    assert any("have one code, 0 DN at 25 °C, 1 s" in n for n in notes) == said
    assert len(notes) == said


@pytest.mark.parametrize("slope", [0.05, -0.5])
def test_a_level_that_drifts_is_told(tmp_path, slope):
    (note,) = folder(tmp_path, frames(8, moved=lambda k: slope * k)).notes
    assert "moves within 1 of 1 operating points, at 25 °C, 1 s by" in note
    told = float(note.split(" by ")[1].split()[0])
    assert told == pytest.approx(7 * abs(slope), abs=0.1)


def rows_of_one_over_f(k):
    """A level that wanders from row to row, .3 of the noise, anew in each frame."""
    rng = np.random.default_rng(1000 + k)
    spectrum = rng.normal(size=(2, 101)) / np.sqrt(np.maximum(np.arange(101), 1))
    wander = np.fft.irfft(spectrum[0] + 1j * spectrum[1], SHAPE[0])
    return (0.6 * wander / wander.std())[:, None]


@pytest.mark.parametrize(
    "moved",
    [
        lambda k: 0.0,
        lambda k: np.random.default_rng(k).normal(0.0, 1.0, (SHAPE[0], 1)),
        lambda k: np.random.default_rng(k).normal(0.0, 1.0, (1, SHAPE[1])),
        rows_of_one_over_f,
    ],
    ids=["pixels", "rows", "columns", "1/f"],
)
def test_noise_moves_no_level(tmp_path, moved):
    for seed in range(6):
        (tmp_path / str(seed)).mkdir()
        made = frames(6, seed, moved=lambda k, seed=seed: moved(100 * seed + k))
        assert folder(tmp_path / str(seed), made).notes == ()


def test_hits_move_no_level(tmp_path):
    some = frames(6)
    some[3][:, 40:42] = 60_000  # a track
    assert folder(tmp_path, some).notes == ()


def test_what_cannot_be_read_is_left_to_who_reads_it(tmp_path):
    some = frames(3)
    some[1][:] = 7
    captures = folder(tmp_path, some, save=deflated, suffix=".tif")
    path = tmp_path / "T25C_exp_1s_02.tif"
    data = bytearray(path.read_bytes())
    data[3000:3400] = bytes(400)
    path.write_bytes(data)
    captures = load(tmp_path)
    assert captures.frame_count == 3
    with pytest.raises(InputError, match=r"_02\.tif: cannot be decoded"):
        captures.settings[0].frames[2].read()
    with pytest.raises(InputError, match=r"_01\.tif: all pixels equal 7"):
        captures.settings[0].frames[1].read()


def test_few_frames_are_decoded_whole_for_their_strips(tmp_path, monkeypatch):
    some = frames(5)
    folder(tmp_path, [*some, some[0]], save=deflated, suffix=".tif")
    monkeypatch.setattr(health, "DECODED", 3 * SHAPE[0] * SHAPE[1])
    assert load(tmp_path).frame_count == 6  # the copy is the sixth
    np.save(tmp_path / "x.npy", some[0])
    np.save(tmp_path / "y.npy", some[0])
    for path in tmp_path.glob("*.tif"):
        path.unlink()
    assert load(tmp_path).frame_count == 1


def test_a_published_series_holds_one_file_twice(captures_root):
    captures = load(captures_root / "real" / "st7_2019")
    assert captures.frame_count == 21
    assert "DarkBefore-007D120s.fit" in captures.notes[0]
    assert "moves within 3 of 3 operating points" in captures.notes[1]
    assert json.loads(json.dumps(inspect(captures)))["notes"] == list(captures.notes)
