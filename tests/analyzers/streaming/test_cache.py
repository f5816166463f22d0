"""Kept statistics are those of the frames, and never those of other frames."""

import os

import numpy as np
import pytest
from dark_frames import dark_frames

from dnanalyze.analyzers.analyze import analyze, analyze_windows
from dnanalyze.analyzers.streaming import cache
from dnanalyze.loaders import load
from dnanalyze.loaders.captures import Window

SHAPE = (48, 64)


@pytest.fixture
def folder(tmp_path):
    root = tmp_path / "captures" / "25C"
    root.mkdir(parents=True)
    for n, frame in enumerate(dark_frames(2, 4, SHAPE)):
        np.save(root / f"dark_{n}.npy", frame)
    return root.parent


@pytest.fixture
def store(tmp_path):
    return tmp_path / "store"


def captures(folder, store):
    return load(folder).cached(str(store))


def unread(found, monkeypatch):
    """Let every reading of pixels fail."""
    from dnanalyze.loaders.recording import FrameReader

    def refuse(*_):
        raise AssertionError("a frame was read")

    monkeypatch.setattr(FrameReader, "__call__", refuse)
    return found


def assert_same(ours, theirs):
    assert ours.name == theirs.name
    assert ours.sensor == theirs.sensor
    assert ours.trends == theirs.trends
    for a, b in zip(ours.settings, theirs.settings, strict=True):
        assert (a.point, a.plane, a.frames, a.shape) == (b.point, b.plane, b.frames, b.shape)
        assert a.values == b.values
        assert a.missing == b.missing
        assert a.curves.keys() == b.curves.keys()
        for name, curve in a.curves.items():
            np.testing.assert_array_equal(curve, b.curves[name])
            assert curve.dtype == np.asarray(b.curves[name]).dtype


def test_a_second_analysis_reads_no_frame(folder, store, monkeypatch):
    first = analyze(captures(folder, store))
    done = []
    again = unread(captures(folder, store), monkeypatch)
    second = analyze(again, progress=lambda n, total: done.append((n, total)))
    assert_same(second, first)
    assert done == [(4, 4)]


def test_windows_and_errors_are_kept_apart(folder, store):
    found = captures(folder, store)
    halves = (Window(0, 48, 0, 32), Window(0, 48, 32, 64))
    for errors in (True, False):
        ours = analyze_windows(found, halves, errors=errors)
        again = analyze_windows(found, halves, errors=errors)
        theirs = analyze_windows(load(folder), halves, errors=errors)
        for a, b, c in zip(ours, again, theirs, strict=True):
            assert_same(a, c)
            assert_same(b, c)
    assert len(list(store.glob("*.npz"))) == 2


def test_changed_frames_are_read_again(folder, store):
    before = analyze(captures(folder, store))
    path = folder / "25C" / "dark_1.npy"
    state = path.stat()
    np.save(path, np.load(path)[::-1])
    os.utime(path, ns=(state.st_atime_ns, state.st_mtime_ns))
    after = analyze(captures(folder, store))
    assert after.settings[0].values != before.settings[0].values
    assert_same(after, analyze(load(folder)))


@pytest.mark.parametrize("spoilt", [b"", b"PK not an archive", None])
def test_a_spoilt_entry_is_written_anew(folder, store, spoilt):
    right = analyze(captures(folder, store))
    (path,) = store.glob("*.npz")
    content = path.read_bytes()
    path.write_bytes(content[: len(content) // 2] if spoilt is None else spoilt)
    assert_same(analyze(captures(folder, store)), right)
    assert path.stat().st_size == len(content)


def test_nothing_is_kept_among_the_captures_nor_where_nothing_can_be_written(folder, tmp_path):
    inner = folder / "25C" / "cache"
    analyze(captures(folder, inner))
    assert not inner.exists()
    blocked = tmp_path / "file"
    blocked.write_text("")
    analyze(captures(folder, blocked / "below"))


def test_without_a_named_folder_nothing_is_kept(folder):
    assert cache.held(load(folder)) is None
    assert cache.held(load(folder).cached(None)) is None


def test_the_oldest_entries_make_room(folder, store, monkeypatch):
    found = captures(folder, store)
    monkeypatch.setattr(cache, "LIMIT", 1)
    analyze(found)
    analyze(found, window=Window(0, 32, 0, 64))
    (kept,) = store.glob("*.npz")
    assert kept == cache.held(found, [Window(0, 32, 0, 64)], True, ()).path


def test_the_user_chooses_the_folder(monkeypatch, tmp_path):
    monkeypatch.setenv("DNANALYZE_CACHE", str(tmp_path))
    assert cache.default_folder() == tmp_path
    monkeypatch.setenv("DNANALYZE_CACHE", "off")
    assert cache.default_folder() is None
    monkeypatch.delenv("DNANALYZE_CACHE")
    assert cache.default_folder().name == "dnanalyze"
