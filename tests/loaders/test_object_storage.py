"""Captures on object storage, by fsspec, are those of a folder."""

import numpy as np
import pytest

from dnanalyze.loaders import load


@pytest.fixture
def bucket():
    """fsspec's storage in memory, with a bucket of its own."""
    fsspec = pytest.importorskip("fsspec", reason="fsspec is not installed")
    system = fsspec.filesystem("memory")
    yield system
    system.rm("/dark-bucket", recursive=True)


def test_a_bucket_gives_what_its_folder_gives(bucket, tmp_path):
    rng = np.random.default_rng(1)
    for t in (25, 65):
        (tmp_path / f"T{t}C").mkdir()
        for n in range(3):
            frame = rng.normal(100, 5, (16, 24)).astype(np.uint16)
            np.save(tmp_path / f"T{t}C" / f"dark_{n}.npy", frame)
    bucket.put(str(tmp_path), "/dark-bucket/run", recursive=True)
    there, here = load("memory://dark-bucket/run"), load(tmp_path)
    assert [s.point for s in there.settings] == [s.point for s in here.settings]
    for one, other in zip(there.frames(), here.frames(), strict=True):
        assert one.name == other.name
        np.testing.assert_array_equal(one.read(), other.read())
    single = load("memory://dark-bucket/run/T65C/dark_2.npy")
    np.testing.assert_array_equal(next(single.frames()).read(), frame)
