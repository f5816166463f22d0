"""Lent arrays come back when nothing, not even a view, refers to them any more."""

import numpy as np

from dnanalyze.analyzers.streaming.buffers import Buffers


def test_no_one_gets_what_another_still_holds():
    buffers = Buffers()
    first = buffers.take((4, 5))
    view = first.ravel()[3:]
    address = first.ctypes.data
    del first
    second = buffers.take((4, 5))
    assert second.ctypes.data != address
    assert not np.shares_memory(second, view)
    del view
    assert buffers.take((4, 5)).ctypes.data == address
    assert buffers.take((3, 5)).shape == (3, 5)
