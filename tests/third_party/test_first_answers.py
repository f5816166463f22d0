"""Which first answers are right, and the part of a case that is looked at."""

import sys
from pathlib import Path

import numpy as np
import pytest
import tifffile

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

from first_answers import EVERY, FRAMES, SIDE, part_of, right
from third_party.score import hidden_only


def row(hides, *candidates, generator="plain"):
    named = [name for name, _ in candidates]
    said = {"hides": hides, "generator": generator, "named": named, "additions": candidates}
    return hidden_only(said)


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        (row(["row_noise"], ("row_noise", 0.3)), True),
        (row(["row_noise"], ("row_noise", 0.1)), False),
        (row(["row_noise"], ("row_fpn", 0.6), ("row_noise", 0.4)), False),
        (row(["row_noise"]), False),
        (row([]), True),
        (row([], ("rts", 0.4)), True),
        (row([], ("rts", 0.5)), False),
        (row(["clipping_at_zero"]), True),
        (row(["edge_offset"], ("amp_glow", 0.5)), True),
        (row(["edge_offset"], ("amp_glow", 0.95)), False),
        (row([], ("dark_current_fpn", 1.0), generator="pyxel"), True),
    ],
)
def test_an_answer_is_right_by_what_is_hidden(given, expected):
    assert right(given) is expected


def test_a_part_has_fewer_temperatures_frames_and_pixels(tmp_path):
    rng = np.random.default_rng(1)
    for t in range(5):
        (tmp_path / f"case/T{t}").mkdir(parents=True)
        for n in range(6):
            image = rng.integers(0, 99, (160, 200), dtype=np.uint16)
            tifffile.imwrite(tmp_path / f"case/T{t}/{n}.tif", image)
    part_of(tmp_path / "case", tmp_path / "part")
    points = sorted(p.name for p in (tmp_path / "part").iterdir())
    assert points == [f"T{t}" for t in range(0, 5, EVERY)]
    for point in points:
        frames = sorted((tmp_path / "part" / point).iterdir())
        assert len(frames) == FRAMES
        whole = tifffile.imread(tmp_path / "case" / point / frames[0].name)
        np.testing.assert_array_equal(tifffile.imread(frames[0]), whole[:SIDE, :SIDE])
