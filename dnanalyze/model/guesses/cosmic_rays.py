"""First guesses of cosmic_rays: its parameters as the statistics suggest them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.cosmic_rays import STEPPED, CosmicRays
from dnanalyze.model.guesses import hints
from dnanalyze.model.guesses.evidence import curve, excess, histogram, shows
from dnanalyze.significance import CERTAIN, SIGN

LIMIT = 8.0  # noises that a transient stands out by; a difference of two frames by `CERTAIN`
REACH, MUCH = 60.0, 0.1  # noises up to which differences are counted, nearly; share beyond
CROSSED = 4.0 / math.pi  # pixels that a pixel of track crosses, in the mean over its direction
KINDS = "track", "path"  # whose charge is exponential
QUIET = 1.3  # times the least noise, up to which clumps are counted
# Share of the hits beyond the model below which its noise is what took them: then it has to give
# them back, and all that are seen are the effect's.
TAKEN = 0.5
FEWEST, PLAIN = 4, 30.0  # differences that tell a charge; noises where they do not


def guess(effect: type[CosmicRays], clues: Clues) -> list[Effect]:
    """Rate and length from the clumps of pixels that stand out once: how many, and how large.

    The charge comes from how far frames differ, where those differ that do by far; where that is
    beyond what is counted, also from the brightest values.
    """
    if not shows(clues, ("transient_high", "transient_adjacent")):
        return []
    beyond, seen = excess(clues, "transient_high"), clues.measured("transient_high")
    found = _from_hits(effect, clues, np.maximum(beyond, 0))
    if np.nansum(beyond) < TAKEN * np.nansum(seen):
        found += _from_hits(effect, clues, seen)
    return found


def _from_hits(effect: type[CosmicRays], clues: Clues, hits: np.ndarray) -> list[Effect]:
    """`guess` with so many pixels that stand out once, one number a setting."""
    noise = np.asarray(clues.measured("temporal_noise_core"), float)
    good = (hits > 0) & (noise > 0)
    if not good.any():
        return []
    place = int(np.nanargmin(np.where(good, noise, np.nan)))  # hot pixels flicker less there
    a_pixel, reached = _charge(clues, place, noise[place])
    brightest = _brightest(clues, place, float(hits[place])) if reached else 0.0
    quiet = (noise > 0) & (noise <= QUIET * noise[place])  # noise breaks tracks into pieces
    seen = _clumps(clues, hits, quiet)
    length, rate, pixels = _by_share(clues, hits, good) if seen is None else seen.tracks(CROSSED)
    readout_s = 0.0 if seen is None else seen.readout_s
    unseen = np.exp(-min(LIMIT * float(noise[place]) / a_pixel, 3.0))
    energy = a_pixel / hints.gains(clues)[place] * pixels
    more = (1.0, *([brightest / a_pixel] if brightest > a_pixel else []))
    tracks = {"rate": rate / unseen, "length": length, "readout_s": readout_s}
    guesses: list[Effect] = [
        effect.within(**tracks, energy=energy * f, charge=kind) for kind in KINDS for f in more
    ]
    if seen is None:
        return guesses
    length, rate, pixels = seen.tracks(1.0)
    energy = (
        (a_pixel + math.sqrt(2.0) * CERTAIN * float(noise[place]))
        / hints.gains(clues)[place]
        * pixels
    )
    tracks = {"rate": rate, "length": length, "readout_s": readout_s}
    return guesses + [
        effect.within(**tracks, energy=energy * f, charge=kind) for kind in STEPPED for f in more
    ]


@dataclass(frozen=True)
class _Clumps:
    """Clumps of pixels that stand out once."""

    count: float
    pixels: float  # in all of them
    exposed: float  # million pixels times seconds, or times frames where the exposure is unknown
    border: float  # length of the border over the area, 1/pixel
    readout_s: float  # time beyond the exposures in which hits came, s; it is in ``exposed``

    def tracks(self, crossed: float) -> tuple[float, float, float]:
        """Mean length, rate, and pixels a hit.

        A track of length l has 1 + ``crossed`` l pixels. The border cuts l/pi tracks a unit of
        length, for each track of an area of one: these count as more, and shorter, clumps.
        """
        mean = self.pixels / self.count
        cut = self.border / math.pi
        length = max((mean - 1.0) / max(crossed - cut * mean, 0.1 * crossed), 0.0)
        return length, self.count / self.exposed / (1.0 + cut * length), 1.0 + crossed * length


def _clumps(clues: Clues, hits: np.ndarray, quiet: np.ndarray) -> _Clumps | None:
    """What these settings show beyond the model; None where the sizes of clumps are not at hand."""
    rows: list[tuple[float, float, float, float]] = []
    high = np.asarray(clues.measured("transient_high"), float)
    for j in map(int, np.flatnonzero(quiet & np.isfinite(hits))):
        sizes, codes = (curve(clues, n, j) for n in ("transient_clumps", "histogram_counts"))
        if sizes is None or codes is None:
            continue
        share = min(hits[j] / max(high[j], 1.0), 1.0)
        seconds = clues.points[j].exposure_s
        pixels = share * float(sizes @ np.arange(sizes.size))
        area = float(codes.sum()) * 1e-6
        rows.append((share * float(sizes.sum()), pixels, area, 1.0 if seconds is None else seconds))
    if not rows:
        return None
    count, lit, area, exposures = np.array(rows).T
    readout_s = readout_time(count, area, exposures)
    exposed = float(area @ (exposures + readout_s))
    if not count.sum() or not exposed:
        return None
    height, width = clues.shape
    border = 2.0 * (height + width) / (height * width)
    return _Clumps(float(count.sum()), float(lit.sum()), exposed, border, readout_s)


def readout_time(count: np.ndarray, area: np.ndarray, seconds: np.ndarray) -> float:
    """Time beyond the exposures from the hits at each, s; 0 where it is not significant.

    By maximum likelihood, with the rate eliminated.

    Hits are Poisson about rate x ``area`` (million pixels times frames) x (``seconds`` + time), one
    number a setting.
    """
    longest = float(seconds.max())
    if np.ptp(seconds) <= 0.0 or not count.any():
        return 0.0

    def loss(log_time: float) -> float:
        exposed = seconds + math.exp(log_time)
        return float(count.sum() * np.log(area @ exposed) - count @ np.log(exposed))

    least, most = (math.log(share * longest) for share in (1e-4, 1.0))
    found = minimize_scalar(loss, bounds=(least, most), method="bounded")
    significant = 2.0 * (loss(least) - found.fun) > SIGN**2
    return math.exp(found.x) if significant else 0.0


def _by_share(clues: Clues, hits: np.ndarray, good: np.ndarray) -> tuple[float, float, float]:
    """Length, rate and pixels a hit from how many of the pixels touch; eight frames are assumed."""
    touching = np.maximum(excess(clues, "transient_adjacent"), 0)
    share = float(np.nansum(touching[good]) / np.sum(hits[good]))
    length = 0.5 if share < 0.3 else 1.0 + 4.0 * share
    pixels = 1.5 + length
    seconds = np.array([1.0 if p.exposure_s is None else p.exposure_s for p in clues.points])
    rate = np.sum(hits[good]) / pixels / (8 * np.sum(seconds[good]))
    return length, float(rate / (np.prod(clues.shape) * 1e-6)), pixels


def _charge(clues: Clues, setting: int, noise: float) -> tuple[float, bool]:
    """Mean charge of a pixel that is hit, DN, and whether hits go beyond what is counted.

    An exponential charge is as large beyond any cut as beyond nothing. Both frames of a difference,
    which is over sqrt 2, may be hit.
    """
    x, n = (curve(clues, f"difference_hist_{axis}", setting) for axis in "xn")
    if x is None or n is None:
        return PLAIN * noise, True
    far = np.abs(x) / noise
    beyond, ends = n[far > CERTAIN].sum(), n[far > REACH].sum()
    if beyond < FEWEST:
        return PLAIN * noise, True
    charge = math.sqrt(2.0) * noise * float(np.sum(n * np.maximum(far - CERTAIN, 0.0)) / beyond)
    return charge, bool(ends > MUCH * beyond)


def _brightest(clues: Clues, setting: int, hit: float) -> float:
    """Mean charge of as many of the brightest values as are hit, DN; 0 where none are at hand.

    Those at the highest code are censored there: of exponential charges the mean is the sum over
    the number of the others.
    """
    seen = histogram(clues, "histogram", setting)
    if seen is None or hit < 1.0:
        return 0.0
    codes, counts = seen
    above = np.cumsum(counts[::-1])[::-1] - counts  # values that are brighter
    taken = np.clip(hit - above, 0.0, counts)
    middle = codes[np.searchsorted(np.cumsum(counts), counts.sum() / 2.0)]
    return float(taken @ (codes - middle)) / max(hit - float(taken[-1]), 1.0)
