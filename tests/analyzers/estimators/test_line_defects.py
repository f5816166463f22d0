"""Single lines that stand out, and how far along."""

from __future__ import annotations

import numpy as np
import pytest

from dnanalyze.analyzers.estimators.line_defects import defects, standing_out

SHAPE = (400, 300)


def _pattern(*lines: tuple[int, float, int, int], seed: int = 1) -> np.ndarray:
    image = np.random.default_rng(seed).standard_normal(SHAPE).astype(np.float32)
    for column, offset, begin, end in lines:
        image[begin:end, column] += np.float32(offset)
    return image


def _of(image: np.ndarray) -> np.ndarray:
    return defects(image, np.clip(image, -6, 6).mean(axis=0))


def test_lines_of_noise_do_not_stand_out():
    for seed in range(20):
        assert _of(_pattern(seed=seed)).size == 0


@pytest.mark.parametrize("offset", [3.0, -3.0, 50.0])
def test_a_part_of_a_line_is_measured(offset):
    ((column, level, begin, end),) = _of(_pattern((40, offset, 130, 400)))
    assert column == 40
    # a median of 270 pixels, and of the 14 neighbours of each
    assert level == pytest.approx(offset, abs=5 * 1.2533 / np.sqrt(270))
    assert begin == pytest.approx(130, abs=10)
    assert end == pytest.approx(400, abs=10)


def test_a_whole_line_is_whole():
    ((_, level, begin, end),) = _of(_pattern((40, 0.6, 0, 400)))
    assert (begin, end) == (0, 400)
    assert level == pytest.approx(0.6, abs=5 * 1.2533 / np.sqrt(400))


def test_several_lines_come_in_their_order():
    seen = _of(_pattern((200, 2.0, 0, 400), (7, -3.0, 0, 200), (298, 4.0, 100, 300)))
    assert list(seen[:, 0]) == [7, 200, 298]


def test_a_profile_in_which_many_are_far_off_has_no_single_ones():
    profile = np.random.default_rng(2).standard_normal(200) * 0.1
    profile[::8] += 5.0
    assert standing_out(profile)[0].size == 0
    assert standing_out(profile[:20])[0].size == 0


def test_a_line_of_a_constant_image_is_seen():
    image = np.zeros(SHAPE, np.float32)
    image[100:, 9] = 3.0
    ((column, level, begin, end),) = _of(image)
    assert (column, level, begin, end) == (9, 3.0, 100, 400)
