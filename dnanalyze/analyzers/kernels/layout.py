"""What loops and their callers agree on: sizes, and what stands where in the sums.

Constants, so that loops over them unroll; apart from the loops, so that Numba is not imported for
them.
"""

from __future__ import annotations

BATCH = 4  # frames that go over the sums of pixels together, to spare memory traffic
RANK_PIXELS, RANK_HIGH, RANK_LOW, PEAK_TOP, PEAK_TIES, PEAK_EXCESS = range(6)
RANK_SUMS, PEAK_SUMS = 3, 8
TILE_COUNT, TILE_VARIANCE, TILE_SQUARE, HAAR_COUNT, HAAR_SECOND, HAAR_FOURTH = range(6)
TILE_SUMS = 6
TILE = 4  # pixels along a side
