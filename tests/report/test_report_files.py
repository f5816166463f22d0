import os
import signal
import stat

import pytest

from dnanalyze.errors import InputError
from dnanalyze.loaders.writers import atomic_write
from dnanalyze.report.output_files import atomic_folder, check_output, write_together


def test_a_file_is_written_whole_and_replaces_the_old_one(tmp_path):
    path = tmp_path / "out.json"
    path.write_text("old")
    atomic_write(path, "new")
    assert path.read_text() == "new"
    assert os.listdir(tmp_path) == ["out.json"]


def test_a_file_is_as_readable_as_any_other(tmp_path):
    plain = tmp_path / "plain"
    plain.write_text("")
    atomic_write(tmp_path / "ours", b"x")
    mode = stat.S_IMODE((tmp_path / "ours").stat().st_mode)
    assert mode == stat.S_IMODE(plain.stat().st_mode)


@pytest.mark.parametrize("raised", [KeyboardInterrupt, OSError(28, "No space left on device")])
def test_an_interrupted_write_leaves_the_old_file_and_nothing_else(tmp_path, monkeypatch, raised):
    path = tmp_path / "out.json"
    path.write_text("old")

    def broken(*_):
        raise raised

    monkeypatch.setattr(os, "replace", broken)
    with pytest.raises((KeyboardInterrupt, InputError)):
        atomic_write(path, "new")
    assert path.read_text() == "old"
    assert os.listdir(tmp_path) == ["out.json"]


def test_a_folder_appears_only_when_it_is_complete(tmp_path):
    with atomic_folder(tmp_path / "frames") as folder:
        (folder / "a").write_text("1")
        assert not (tmp_path / "frames").exists()
    assert (tmp_path / "frames" / "a").read_text() == "1"
    assert os.listdir(tmp_path) == ["frames"]


def test_an_interrupted_folder_leaves_nothing(tmp_path):
    def fill():
        with atomic_folder(tmp_path / "frames") as folder:
            (folder / "a").write_text("1")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fill()
    assert os.listdir(tmp_path) == []


def test_a_folder_with_something_in_it_is_refused(tmp_path):
    (tmp_path / "frames").mkdir()
    (tmp_path / "frames" / "mine").write_text("")

    def fill():
        with atomic_folder(tmp_path / "frames"):
            pass

    with pytest.raises(InputError, match="exists already"):
        fill()


def test_outputs_inside_the_captures_are_refused(tmp_path):
    captures = tmp_path / "captures"
    (captures / "T25").mkdir(parents=True)
    for path in (captures / "out.json", captures / "T25" / "out.json"):
        with pytest.raises(InputError, match="never changed"):
            check_output(path, captures)
    check_output(tmp_path / "out.json", captures)
    check_output(tmp_path / "out.json", "s3://bucket/captures")


def test_outputs_that_cannot_be_written_are_refused_early(tmp_path):
    with pytest.raises(InputError, match="is a folder"):
        check_output(tmp_path)
    with pytest.raises(InputError, match="does not exist"):
        check_output(tmp_path / "nowhere" / "out.json")


def test_files_that_belong_together_appear_all_or_none(tmp_path):
    model, page = tmp_path / "m.yaml", tmp_path / "r.html"
    write_together({model: "1", page: "1"})
    with pytest.raises(InputError, match=r"no/r\.json"):
        write_together({model: "2", page: "2", tmp_path / "no" / "r.json": "2"})
    assert [p.read_text() for p in (model, page)] == ["1", "1"]
    assert sorted(os.listdir(tmp_path)) == ["m.yaml", "r.html"]


@pytest.mark.parametrize("which", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_waits_until_all_of_them_have_their_names(tmp_path, monkeypatch, which):
    came, real = [], os.replace
    monkeypatch.setattr(os, "replace", lambda *a: (signal.raise_signal(which), real(*a)))
    before = signal.signal(which, lambda *_: came.append(sorted(os.listdir(tmp_path))))
    try:
        write_together({tmp_path / "m.yaml": "1", tmp_path / "r.html": "1"})
    finally:
        signal.signal(which, before)
    assert came == [["m.yaml", "r.html"]]
