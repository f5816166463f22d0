"""Evidence that was kept gives the same answer without a look at the frames."""

from __future__ import annotations

import json

import numpy as np
import pytest

from dnanalyze.detection import detect
from dnanalyze.loaders import load
from dnanalyze.loaders.recording import FrameReader


@pytest.fixture
def folder(tmp_path):
    rng = np.random.default_rng(5)
    for celsius in (25, 45):
        place = tmp_path / "captures" / f"{celsius}C"
        place.mkdir(parents=True)
        for n in range(4):
            np.save(place / f"dark_{n}.npy", rng.normal(100, 3, (64, 64)).astype(np.uint16))
    return tmp_path / "captures"


def _refuse(*_):
    raise AssertionError("a frame was read")


def test_a_second_detection_reads_no_frame(folder, tmp_path, monkeypatch):
    kept = str(tmp_path / "store")
    first = detect(load(folder).cached(kept))
    captures = load(folder)
    monkeypatch.setattr(FrameReader, "__call__", _refuse)
    again = detect(captures.cached(kept))
    assert json.dumps(again.to_plain()) == json.dumps(first.to_plain())
    assert len(again.findings) == len(first.findings)
    with pytest.raises(AssertionError, match="was read"):
        detect(captures)


def test_other_frames_have_an_entry_of_their_own(folder, tmp_path, monkeypatch):
    kept = str(tmp_path / "store")
    detect(load(folder).cached(kept))
    one = next((folder / "25C").iterdir())
    np.save(one, np.load(one)[::-1])
    captures = load(folder)
    monkeypatch.setattr(FrameReader, "__call__", _refuse)
    with pytest.raises(AssertionError, match="was read"):
        detect(captures.cached(kept))
