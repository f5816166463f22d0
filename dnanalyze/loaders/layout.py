"""Whether a stated layout of raw pixels is the one that the codes show, and which would be.

A dark frame varies little from pixel to pixel. Read in the right layout its neighbours differ by
the noise; in a wrong one, low bits stand where high ones should, and they differ by much more.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from dnanalyze.loaders.packing import PACKED_BITS, PACKINGS, group_of, row_bytes, unpack

GROUPS = 105  # bytes; whole groups of every packing: of 3, 5 and 7
ROWS = 64  # enough for differences to a percent; with wide rows 1 MB
# Of the mean log2 difference. Swapped bytes weigh the noise 256-fold, 8 in log2: half of it.
SWAPPED = 4.0
PACKED = 1.0  # a wrong packing at least doubles the differences; the right one is never doubled
# The low byte of a word carries the noise, the high one changes where it is carried over: a quarter
# at most. Of two pixels each changes as the other does.
CARRY, MOVING = 0.25, 0.3
SCATTER = 4.0  # bits below full scale; a sixteenth of it is no noise of a dark frame
UNIFORM = 40.0  # DN; bytes that hold low bits of larger codes differ by 85 on average
FAR, WIDE = 20.0, 4.0  # noises off the level and factor of the noise that make a row no pixels
# Of the mean log share of pairs of bytes; that of 64 pixels scatters by a quarter of it
UNLIKELY = 1.0
LOOKED_AT = 1 << 22  # pixels
VARIANCE_ERRORS = 8.0  # standard errors of a variance of column means
EDGE = 8  # rows; sensors embed one to four


def step(pixels: np.ndarray, group: int = 2) -> float:
    """Mean log2 of 1 + |difference| of pixels a group apart; of the places in it the largest.

    Pixels two columns apart have the colour of a mosaic alike, those a group of a packing apart
    also their place in it.
    """
    wide = pixels.astype(np.int64)
    change = np.log2(1 + np.abs(wide[:, group:] - wide[:, :-group]))
    return max(float(change[:, k::group].mean()) for k in range(group))


def is_swapped(words: np.ndarray) -> bool:
    """Whether 16-bit words, (rows, columns), are smooth in the other byte order alone."""
    return step(words) - step(words.byteswap()) > SWAPPED


def words_fault(words: np.ndarray, bits: int, order: str, lead: int = 0) -> str:
    """What is wrong with two bytes a pixel, and the remedy; "" if nothing.

    Parameters
    ----------
    words : ndarray of uint16, (rows, columns)
        As read in the stated byte order.
    bits : int
        As stated.
    order : str
        As stated, "little" or "big".
    lead : int
        Bytes to the next multiple of ``GROUPS`` from the begin of the frame.
    """
    other = "big" if order == "little" else "little"
    if is_swapped(words):
        low, high = (int(v) for v in (words.byteswap().min(), words.byteswap().max()))
        return (
            f"codes scatter over {int(words.min())} to {int(words.max())} in {order}-endian order "
            f"and lie at {low} to {high} in the other; set byte_order: {other}"
        )
    if _two_pixels(words):
        return "its two-byte words hold two alike bytes, two pixels of 8 bits; set bits: 8"
    top = int(words.max())
    if bits < 16 and top >= 1 << bits:
        unused = 16 - bits
        if not (words & ((1 << unused) - 1)).any():
            return (
                f"codes reach {top}, beyond {bits} bits, in steps of {1 << unused}: they are "
                "left-justified; set bits: 16"
            )
        data = (words if order == "little" else words.byteswap()).astype("<u2").view(np.uint8)
        if found := _other_packing(data.reshape(1, -1)[:, lead:], step(words) - 16):
            return found
        fitting = next(b for b in (*PACKED_BITS, 16) if top < 1 << b)
        return f"codes reach {top}, beyond {bits} bits; set bits: {fitting}"
    return ""


def bytes_fault(pixels: np.ndarray, lead: int = 0) -> str:
    """What is wrong with one byte a pixel, and the remedy; "" if nothing.

    Parameters
    ----------
    pixels : ndarray of uint8, (rows, columns)
    lead : int
        As for `words_fault`.
    """
    flat = pixels.reshape(1, -1)
    even, odd = flat[:, ::2], flat[:, 1::2]
    for order, high, low in (("little", odd, even), ("big", even, odd)):
        saturated = int(high.max()) == 255
        if not saturated and step(low) > MOVING and step(high) < CARRY * step(low):
            return (
                "every second byte hardly changes: they are the high bytes of two-byte words; set "
                f"bits: 16 (or those of the converter) and byte_order: {order}"
            )
    return _other_packing(
        flat[:, lead:], step(flat, 6) - 8
    )  # three bytes of two phases of a mosaic


def packing_fault(rows: np.ndarray, width: int, bits: int, packing: str, lead: int = 0) -> str:
    """What is wrong with packed pixels, and the remedy; "" if nothing.

    Parameters
    ----------
    rows : ndarray of uint8, (rows, bytes)
    width, bits, packing
        As stated.
    lead : int
        As for `words_fault`.
    """
    steps = {
        how: _packed_step(rows, width, bits, how)
        for how, known in PACKINGS.items()
        if bits in known and row_bytes(width, bits, how) == row_bytes(width, bits, packing)
    }
    best = min(steps, key=lambda how: steps[how])
    if steps[packing] - steps[best] <= PACKED:
        if packing == "genicam" and (used := _genicam_bits(rows)) != bits:
            return f"pixels use {used} bits of the packing; set bits: {used}"
        return _other_packing(rows.reshape(1, -1)[:, lead:], steps[packing] - bits)
    return (
        f"pixels scatter in the packing {packing} of {bits} bits and are smooth in another; set "
        f"packing: {best}"
    )


def _genicam_bits(rows: np.ndarray) -> int:
    """Two of the four low bits are unused by Mono10Packed."""
    return 12 if (rows[:, 1::3] & 0xCC).any() else 10


def _packed_step(rows: np.ndarray, width: int, bits: int, packing: str) -> float:
    pixels = unpack(rows, width, bits, packing)
    scale = max(1, int(np.gcd.reduce(pixels, axis=None)))  # left-justified codes
    return step(pixels // scale, group_of(bits, packing)[0])


def _other_packing(data: np.ndarray, smooth: float) -> str:
    """The packing and bits in which bytes are far smoother; "" if none.

    Parameters
    ----------
    data : ndarray of uint8, (1, bytes)
        From the begin of a group of any packing.
    smooth : float
        `step` as stated, less the bits of a pixel: a share of full scale.
    """
    if smooth < -SCATTER:
        return ""
    steps = {}
    for how, known in PACKINGS.items():
        for bits in known:
            pixels, size = group_of(bits, how)
            width = data.size // size * pixels
            steps[how, bits] = _packed_step(data, width, bits, how) - bits
    how, bits = min(steps, key=lambda key: steps[key])
    if smooth - steps[how, bits] <= SWAPPED:
        return ""
    bits = _genicam_bits(data) if how == "genicam" else bits
    return f"pixels scatter as stated and are smooth in a packing; set packing: {how}, bits: {bits}"


def is_turned(pixels: np.ndarray) -> bool:
    """Whether pixels in a row make more of a pattern of columns with height and width exchanged.

    Parameters
    ----------
    pixels : ndarray, (rows, columns)
        The first frame as stated.
    """
    rows, columns = pixels.shape
    if rows == columns:
        return False
    size = min(pixels.size, LOOKED_AT)
    middle = float(np.median(pixels))
    reach = 6 * max(1.0, float(np.median(np.abs(pixels - middle))))
    clipped = np.clip(pixels - middle, -reach, reach)
    # a pattern of rows may be one of columns in the other shape, and is none of this question
    flat = (clipped - clipped.mean(axis=1, keepdims=True)).ravel()[:size]
    found = []
    for width in (columns, rows):
        held = flat[: size // width * width].reshape(-1, width)
        by_chance = float(flat.var()) / held.shape[0]
        found.append((float(held.mean(axis=0).var()) - by_chance, by_chance))
    (stated, _), (turned, by_chance) = found
    return turned > max(2.0 * stated, VARIANCE_ERRORS * by_chance * float(np.sqrt(2 / rows)))


def odd_edges(read: Callable[[int, int], np.ndarray], height: int) -> str:
    """A note on rows at the top or bottom that hold no pixels; "" if there are none.

    Parameters
    ----------
    read : callable
        ``read(top, bottom)``: these rows, DN.
    height : int
        Rows of the frame.
    """
    edge = min(EDGE, height // 4)
    middle = read(max(edge, height // 2 - ROWS // 2), min(height - edge, height // 2 + ROWS // 2))
    level, noise = _levels(middle)
    usual, spread = np.median(level), max(float(np.median(noise)), 0.5)

    def count(rows: np.ndarray) -> int:
        """Odd rows from the first on; 0 where all are, for that is a gradient or a masked strip."""
        own, scatter = _levels(rows)
        off = np.abs(own - usual) > FAR * spread
        odd = off | (scatter > WIDE * spread) | (scatter < spread / WIDE)
        run = int(np.argmin(odd)) if not odd.all() else 0
        return run

    top, bottom = count(read(0, edge)), count(read(height - edge, height)[::-1])
    if not top and not bottom:
        return ""
    where = " and ".join(
        f"{n} row{'s' * (n > 1)} at the {side}"
        for n, side in ((top, "top"), (bottom, "bottom"))
        if n
    )
    return (
        f"The {where} {'are' if top + bottom > 1 else 'is'} unlike all others, as embedded data "
        f"are; active_rows: [{top}, {height - bottom}] in the sidecar leaves them out."
    )


def sign_doubt(codes: np.ndarray, unsigned: bool) -> str:
    """A note on 16-bit FITS codes whose offset BZERO = 32768 seems wrong; "" where it is right.

    Parameters
    ----------
    codes : ndarray, (rows, columns)
        Of int16, or uint16 where the header has the offset.
    unsigned : bool
        Whether it has.
    """
    low, high, half = int(codes.min()), int(codes.max()), 1 << 15
    if unsigned and low >= half:
        return (
            f"Every code is {half} or more ({low} to {high} DN), as if BZERO = {half} were added "
            "to codes that were stored without this offset; check the header."
        )
    if not unsigned and (high < 0 or (low < -half // 2 and high > half // 2)):
        return (
            f"Codes are {low} to {high} DN, as if the header lacked BZERO = {half} of codes "
            "without a sign; add it to the header."
        )
    return ""


def side_of(data: bytes, rest: int) -> str:
    """Whether ``rest`` bytes too many stand before or behind the pixels: "header" or "footer".

    Their bytes are those that pixels hardly have at even and at odd places; "" where that holds
    for both ends, as embedded rows make it, or for neither.
    """
    values = np.frombuffer(data, np.uint8) + 256 * (np.arange(len(data)) % 2)
    body = values[rest:-rest]
    share = (np.bincount(body, minlength=512) + 0.5) / (body.size / 2 + 128.0)
    chance = np.log(share)
    usual = float(chance[body].mean())
    odd = [float(chance[end].mean()) < usual - UNLIKELY for end in (values[:rest], values[-rest:])]
    if odd[0] == odd[1]:
        return ""
    return "header" if odd[0] else "footer"


def _levels(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Median of each row, and the mean difference of its pixels two columns apart."""
    wide = rows.astype(np.float64)
    return np.median(wide, axis=1), np.abs(wide[:, 2:] - wide[:, :-2]).mean(axis=1)


def _two_pixels(words: np.ndarray) -> bool:
    """Whether both bytes of the words have the same level and the same small noise."""
    low, high = (words & 255).astype(np.int64), (words >> 8).astype(np.int64)
    noises = [float(np.abs(b[:, 1:] - b[:, :-1]).mean()) for b in (low, high)]
    alike = abs(float(low.mean() - high.mean())) < max(noises)
    return alike and 0.5 * max(noises) < min(noises) and 0.25 < max(noises) < UNIFORM
