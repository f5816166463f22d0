from __future__ import annotations

import numpy as np
import pytest

from dnanalyze.classifier.places import FOLDS, places


@pytest.mark.parametrize("shape", [(64, 64), (100, 333), (512, 512), (3000, 4096)])
def test_no_row_and_no_column_both_trains_and_tests(shape):
    where = places(shape)
    for fold in FOLDS:
        own = where.half(fold)
        other = where.half((1 - fold[0], 1 - fold[1]))
        for axis in (0, 1):
            assert not set(own[axis]) & set(other[axis])


@pytest.mark.parametrize("shape", [(64, 64), (100, 333), (512, 512), (3000, 4096)])
def test_the_bands_spread_from_end_to_end_and_stay_few(shape):
    where = places(shape)
    for bands, length in ((where.rows, shape[0]), (where.columns, shape[1])):
        assert bands.pixels[0] == 0
        assert bands.pixels[-1] == length - 1
        assert len(set(bands.pixels.tolist())) == len(bands.pixels) <= 512
        assert bands.width % where.side == 0


def test_windows_and_one_piece_give_the_same_compact_picture():
    where = places((700, 1100))
    field = np.arange(700 * 1100).reshape(700, 1100)
    compact = where.compact(field)
    blocks = [field[w.slices] for w in where.windows()]
    columns = len(where.columns.starts)
    rows = [np.hstack(blocks[n : n + columns]) for n in range(0, len(blocks), columns)]
    assert np.array_equal(np.vstack(rows), compact)


def test_a_small_field_has_none():
    assert places((63, 500)) is None
