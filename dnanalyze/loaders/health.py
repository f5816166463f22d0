"""Frames that cannot be what they are taken for: copies, odd ones, one code, a moving level.

Each frame is seen through a few strips of rows, which formats that are stored plainly read alone;
what the strips make suspect of equality is confirmed on the full frames.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace

import numpy as np

from dnanalyze.errors import InputError
from dnanalyze.loaders.black_level import Level, doubted
from dnanalyze.loaders.captures import Frame, Setting, Window
from dnanalyze.loaders.checks import is_constant
from dnanalyze.loaders.moved import Move, find_move
from dnanalyze.loaders.odd_frames import FEWEST, Peers, Seen, odd_frames, reason, too_many
from dnanalyze.loaders.recording import FrameReader
from dnanalyze.loaders.taps import Step, find_steps
from dnanalyze.loaders.taps import words as taps_words
from dnanalyze.processors import cpu_count

SAMPLE = 1 << 16  # pixels: a mean level to .006 of the noise, a difference of frames to .3 %
STRIPS = 16  # all over the frame, so that noise of long range averages out as in the frame
DECODED = 1 << 29  # pixels decoded whole for the sake of their strips; 64 frames of 4K
AT_ONCE = 16  # samples in memory
ALONE = 0.99  # share of the pixels at one code from which the others tell no noise
FROZEN = 1 / 3  # of the usual difference of neighbours: a ninth of its variance
MOVED = 0.02  # share of the temporal variance that a moving level adds: 1 % of the noise
LEAST_MOVE = 8.0  # standard errors by which the level must move; the range of 1000 frames takes 6.5
TREND = 1e-3  # chance of a slope over time as steep as one that is called a drift
CAP = 5.0  # 90 % quantiles: what differs by more is a hit or a blinking pixel, and counts so much
NAMED = 3  # odd frames of an operating point that a note describes
COMPARED = 4  # frames whose mean shows the pattern that an odd one lacks
OF_TWO = 2 / np.sqrt(np.pi)  # mean |difference| of two frames over their noise, if it is normal


def examined(
    settings: Sequence[Setting], keep_outliers: bool = False, black_given: bool = False
) -> tuple[tuple[Setting, ...], tuple[str, ...]]:
    """The settings without copies and odd frames, and what their frames make suspect.

    Frames that cannot be read are left to whoever reads and refuses them, and so are constant
    ones, but for those among at least ``FEWEST`` others. Of frames that only decode whole as many
    are looked at as ``DECODED`` allows, the first of each setting.

    Parameters
    ----------
    settings : sequence of Setting
    keep_outliers : bool
        Whether frames unlike the others are kept, and told all the same.
    black_given : bool
        Whether the user states the black level, which then stays.

    Returns
    -------
    settings : tuple of Setting
    notes : tuple of str
        A sentence each.
    """
    most = _most_frames(settings)
    known: dict[bytes, Frame] = {}
    views = []
    findings = _Found(keep_outliers)
    for setting in settings:
        view, own = _View(setting), dict[bytes, Frame]()
        for frame, sample in _samples(setting.frames[:most]):
            if _constant(frame, sample):
                view.constant.append((frame, float(sample.flat[0])))
                continue
            digest = hashlib.blake2b(sample.tobytes(), digest_size=16).digest()
            first = own.setdefault(digest, frame)
            if first is not frame and _identical(first, frame):
                findings.copies.append((frame, first))
                view.left_out.add(id(frame))
                continue
            view.add(frame, sample)
            other = known.setdefault(digest, frame)
            # where nearly all pixels have one code, two frames may well be equal
            if other is not frame and view.code is None and _identical(other, frame):
                findings.elsewhere.append((frame, other))
        view.finish()
        views.append(view)
    for view, odd in zip(views, odd_frames([v.seen for v in views]), strict=True):
        findings.take_odd(view, odd)
    findings.taps = [v for v in views if v.steps_within]
    findings.frozen = [pair for view in views for pair in view.frozen()]
    findings.alone = [(v, code) for v in views if (code := v.code) is not None]
    findings.moving = [(v, *moved) for v in views if (moved := v.moved()) is not None]
    shown = [v for v in views if v.shows is not None]
    wrong, findings.black = doubted([v.shows for v in shown if v.shows], black_given)
    for k in wrong:
        shown[k].setting = replace(shown[k].setting, black_level=None)
    return tuple(view.kept() for view in views), findings.notes(len(views))


@dataclass
class _View:
    """The samples of one setting's frames, gone through one by one."""

    setting: Setting
    frames: list[Frame] = field(default_factory=list)
    constant: list[tuple[Frame, float]] = field(default_factory=list)
    left_out: set[int] = field(default_factory=set)  # by id
    steps: list[float] = field(default_factory=list)
    levels: list[float] = field(default_factory=list)
    errors: list[float] = field(default_factory=list)
    code: float | None = None
    first: np.ndarray | None = None
    last: np.ndarray | None = None
    peers: Peers | None = None
    seen: Seen = field(default_factory=lambda: Seen([], {}))
    shows: Level | None = None
    steps_within: list[Step] = field(default_factory=list)

    def add(self, frame: Frame, sample: np.ndarray) -> None:
        if not np.isfinite(sample).all():
            return
        if self.peers is None:
            self.peers = Peers(len(_strips(_unchecked(frame))))
        self.peers.add(sample)
        if self.first is None or self.last is None:
            self.first = sample
            windows = _strips(_unchecked(frame))
            cut = sample.reshape(len(windows), -1, sample.shape[1])
            region = _unchecked(frame).region
            tops = [region.top + w.top for w in windows]
            self.steps_within = find_steps(cut, tops, region.left + windows[0].left)
            low, middle, high = np.quantile(sample, (0.25, 0.5, 0.75))
            self.shows = Level(self.setting, float(middle), float(high - low) / 1.349)
            self.code = _code(frame, sample)
            self.levels.append(0.0)
        else:
            self.levels.append(_change(sample, self.first)[0])
            _, error, step = _change(sample, self.last)
            self.errors.append(error)
            self.steps.append(step)
        self.frames.append(frame)
        self.last = sample

    def finish(self) -> None:
        """The samples are forgotten."""
        if self.peers is not None:
            self.seen = self.peers.finish()
        self.first = self.last = self.peers = None

    def kept(self) -> Setting:
        """The setting without the frames that are left out."""
        frames = tuple(f for f in self.setting.frames if id(f) not in self.left_out)
        return replace(self.setting, frames=frames)

    def near(self) -> list[int]:
        """Frames that differ far less from the one before than the other neighbours do.

        Without those that are left out: an odd frame differs by more than any.
        """
        kept = [id(f) not in self.left_out for f in self.frames]
        steps = {k: s for k, s in enumerate(self.steps) if kept[k] and kept[k + 1]}
        return [
            k + 1
            for k, step in steps.items()
            if len(steps) > 1
            and step < FROZEN * np.median([s for other, s in steps.items() if other != k])
        ]

    def frozen(self) -> list[tuple[str, str]]:
        """Names of those that are kept, each with that of the one before."""
        return [(self.frames[k].name, self.frames[k - 1].name) for k in self.near()]

    def moved(self) -> tuple[float, float] | None:
        """By how much the level moves over the frames, DN, and how much noise alone moves it."""
        if not self.errors:
            return None
        noise = float(np.median(self.steps)) / OF_TWO
        levels = [
            x for x, f in zip(self.levels, self.frames, strict=True) if id(f) not in self.left_out
        ]
        span, error = float(np.ptp(levels)), float(np.median(self.errors))
        if span <= LEAST_MOVE * error:
            return None
        told = np.var(levels, ddof=1) > MOVED * noise**2 or _chance_of_slope(levels) < TREND
        return (span, error) if told else None


@dataclass
class _Found:
    """What was found, over all settings."""

    keep_outliers: bool = False
    odd: list[str] = field(default_factory=list)
    black: list[str] = field(default_factory=list)
    taps: list[_View] = field(default_factory=list)
    copies: list[tuple[Frame, Frame]] = field(default_factory=list)
    elsewhere: list[tuple[Frame, Frame]] = field(default_factory=list)
    frozen: list[tuple[str, str]] = field(default_factory=list)
    alone: list[tuple[_View, float]] = field(default_factory=list)
    moving: list[tuple[_View, float, float]] = field(default_factory=list)

    def take_odd(self, view: _View, odd: dict[int, list[str]]) -> None:
        """Leave out the odd frames of a setting, or tell why they stay."""
        near = {i for k in view.near() for i in (k - 1, k)}  # the median lies near both
        odd = {k: asked for k, asked in odd.items() if "repeated" in asked or k not in near}
        frames, label = len(view.frames), view.setting.point.label()
        fate = "kept as asked" if self.keep_outliers else "left out; --keep-outliers keeps"
        if view.constant and frames >= FEWEST:
            frame, value = view.constant[0]
            self.odd.append(
                f"{frame.name}{_more(view.constant)} at {label}: all pixels equal {value:g}, where "
                f"{frames} frames have noise; {fate} it."
            )
            if not self.keep_outliers:
                view.left_out.update(id(f) for f, _ in view.constant)
        if not odd:
            return
        if too_many(len(odd), frames):
            such = view.frames[min(odd)].name
            self.odd.append(
                f"{len(odd)} of {frames} frames at {label} are unlike the rest, such as {such}: "
                "two kinds of frames share one operating point, and none is left out; separate "
                "them."
            )
            return
        good = [f for k, f in enumerate(view.frames) if k not in odd]
        for number in sorted(odd)[:NAMED]:
            frame = view.frames[number]
            like = view.frames[view.seen.repeated.get(number, 0)].name
            move = _move(frame, good) if "likeness" in odd[number] else None
            text = reason(view.seen, number, odd[number], move, like)
            self.odd.append(
                f"{frame.name} is unlike the {len(good)} other frames at {label}: {text}; {fate} "
                "it."
            )
        if len(odd) > NAMED:
            self.odd.append(
                f"{len(odd) - NAMED} more frames at {label} are unlike the others: {fate} them."
            )
        if not self.keep_outliers:
            view.left_out.update(id(view.frames[k]) for k in odd)

    def notes(self, settings: int) -> tuple[str, ...]:
        return tuple(text for text in self._notes(settings) if text)

    def _notes(self, settings: int) -> Iterator[str]:
        if self.copies:
            a, b = self.copies[0]
            yield (
                f"{a.name} has the same pixels as {b.name}{_more(self.copies)}: identical frames "
                "count once."
            )
        yield from self.odd
        yield from self.black
        if self.taps:
            yield taps_words(self.taps[0].steps_within, self.taps[0].setting.point.label())
        if self.elsewhere:
            a, b = self.elsewhere[0]
            yield (
                f"{a.name} ({a.point.label()}) has the same pixels as {b.name} "
                f"({b.point.label()}){_more(self.elsewhere)}: one of the two operating points is "
                "wrong."
            )
        if self.frozen:
            frozen, before = self.frozen[0]
            yield (
                f"{frozen} hardly differs from {before}{_more(self.frozen)}: less than a third of "
                "what neighbouring frames differ by; copied, averaged or not read out anew."
            )
        if self.alone:
            view, code = self.alone[0]
            yield (
                f"In {len(self.alone)} of {settings} operating points 99 % of the pixels or more "
                f"have one code, {code:g} DN at {view.setting.point.label()}: their noise is "
                "clipped or below one step."
            )
        if self.moving:
            view, span, error = max(self.moving, key=lambda m: m[1] / m[2])
            yield (
                f"The mean level moves within {len(self.moving)} of {settings} operating points, "
                f"at {view.setting.point.label()} by {span:.3g} DN over {len(view.frames)} frames, "
                f"where the noise of the pixels explains {error:.1g} DN."
            )


def _more(pairs: Sequence[object]) -> str:
    return f", and so {len(pairs) - 1} more" if len(pairs) > 1 else ""


def _most_frames(settings: Sequence[Setting]) -> int:
    """Frames of each setting that are looked at."""
    loads = [f.load for s in settings for f in s.frames]
    whole = [x for x in loads if isinstance(x, FrameReader) and not x.partial]
    if not whole:
        return max(len(s.frames) for s in settings)
    rows, columns = whole[0].shape
    return max(2, DECODED // (rows * columns * len(settings)))


def _samples(frames: Sequence[Frame]) -> Iterator[tuple[Frame, np.ndarray]]:
    """Frames with their samples, several read at once; without those that cannot be read."""
    with ThreadPoolExecutor(min(AT_ONCE, cpu_count())) as pool:
        for begin in range(0, len(frames), AT_ONCE):
            some = frames[begin : begin + AT_ONCE]
            for frame, sample in zip(some, pool.map(_sample, some), strict=True):
                if sample is not None:
                    yield frame, sample


def _sample(frame: Frame) -> np.ndarray | None:
    """Strips of the frame, one below the other; None where it cannot be read."""
    reader = _unchecked(frame)
    windows = _strips(reader)
    try:
        if reader.partial:
            return np.concatenate([reader(w) for w in windows])
        whole = reader()
        return np.concatenate([whole[w.slices] for w in windows])
    except InputError:
        return None


def _strips(reader: FrameReader) -> list[Window]:
    rows, columns = reader.shape
    width = min(columns, SAMPLE // STRIPS)
    height = max(1, min(SAMPLE // STRIPS // width, rows // STRIPS))
    left = (columns - width) // 2
    tops = np.unique(np.linspace(0, rows - height, STRIPS).astype(int))
    return [Window(int(t), int(t) + height, left, left + width) for t in tops]


def _move(frame: Frame, others: Sequence[Frame]) -> Move | None:
    """How the pattern of a frame lies to the mean of some others."""
    try:
        pattern = np.mean([_unchecked(f)() for f in others[:COMPARED]], axis=0)
        return find_move(_unchecked(frame)(), pattern)
    except InputError:
        return None


def _unchecked(frame: Frame) -> FrameReader:
    """Its reader, without the checks that refuse a frame as a whole."""
    assert isinstance(frame.load, FrameReader)
    return replace(frame.load, checked=False)


def _constant(frame: Frame, sample: np.ndarray) -> bool:
    return is_constant(sample) and is_constant(_unchecked(frame)())


def _identical(a: Frame, b: Frame) -> bool:
    try:
        return bool(np.array_equal(_unchecked(a)(), _unchecked(b)()))
    except InputError:
        return False


def _code(frame: Frame, sample: np.ndarray) -> float | None:
    """The code of nearly all pixels of the sample and of the whole frame."""
    codes, counts = np.unique(sample, return_counts=True)
    most = int(np.argmax(counts))
    if counts[most] < ALONE * sample.size:
        return None
    share = np.mean(_unchecked(frame)() == codes[most])
    return float(codes[most]) if share >= ALONE else None


def _change(sample: np.ndarray, before: np.ndarray) -> tuple[float, float, float]:
    """Change of the level, its standard error, and the mean |difference| about it.

    The error is the largest of those from pixels, rows and columns: noise of lines is common to
    many pixels.
    """
    d = sample.astype(np.float64) - before
    middle = float(np.median(d))
    d -= middle
    reach = float(np.quantile(np.abs(d), 0.9))
    if reach > 0:
        np.clip(d, -CAP * reach, CAP * reach, out=d)
    rows, columns = d.shape
    variance = max(
        float(np.var(d)) / d.size,
        float(np.var(d.mean(axis=1))) / rows,
        float(np.var(d.mean(axis=0))) / columns,
    )
    return middle + float(d.mean()), float(np.sqrt(variance)), float(np.abs(d).mean())


def _chance_of_slope(levels: Sequence[float]) -> float:
    """Probability of a slope over time as steep as theirs, if they scattered independently."""
    if len(levels) < 3:
        return 1.0
    from scipy.special import stdtr

    time = np.arange(len(levels)) - (len(levels) - 1) / 2
    x = np.asarray(levels) - np.mean(levels)
    r = float(time @ x / np.sqrt((time @ time) * (x @ x)))
    degrees = len(levels) - 2
    return float(2 * stdtr(degrees, -abs(r) * np.sqrt(degrees / max(1 - r * r, 1e-12))))
