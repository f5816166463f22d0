"""A frame unlike the others of its operating point: shifted, flipped, lit, noisier, torn.

Every frame is compared with the pixelwise median of its operating point, in strips of rows. What is
compared needs no model: the noise about that median, the likeness of its fine pattern to that of
the others, the scatter of its row and column means, and its level.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from dnanalyze.loaders.moved import Move
from dnanalyze.robust import robust_deviation

FEWEST = 3  # frames, of which one can be told from two
REFERENCE = 33  # frames of the median: their noise adds 1.5 / 33 to a variance
CAP = 3.0  # robust sigmas: hits on 1 % of the pixels raise the noise by 4 %
PATTERN_CAP = 4.0  # robust sigmas: a hot pixel counts no more, so that many pixels decide
ALARM = 1e-4  # chance that a frame like the others is called odd, over all that is asked of it
FULL = 8  # frames; what matters grows as 1 / frames below them, as the scatter is less well known
STRIP_DEGREES = 15  # degrees of freedom of a scatter over 16 strips
QUARTER = 0.74  # lower quartile of a mean square of 15 degrees of freedom
# Factors by which a median deviation of 3 to 9 values is too small (Croux and Rousseeuw 1992).
SMALL_SAMPLE_FACTORS = {3: 1.495, 4: 1.363, 5: 1.206, 6: 1.200, 7: 1.140, 8: 1.129, 9: 1.107}
MEDIAN_WORTH = 0.37  # degrees of freedom of a median deviation, for each of a mean square
# Below these a frame changes the figures of its operating point little, whatever the significance:
NOISE = 2 * np.log(1.2)  # variance 1.44 times: the noise of 8 frames moves by 3 %
LIKENESS = 0.3  # of the fine pattern
STRIP_NOISE, STRIP_LIKENESS = 2 * np.log(1.5), 0.5  # of a sixteenth of the frame
LINES = 2 * np.log(2.0)  # line means scatter twice as much, ...
LINE_SHARE = 0.01  # ... and that is 1 % of the variance of the pixels
LEVEL = 0.01  # of the noise: the error of a median over thousands of pixels
STEADY = 0.1  # of the noise: a level that scatters by less adds 1 % to its variance
CHANGING = 0.05  # share of the pixels that change: .95^1000 is the chance that a strip does not
ODD_SHARE = 1 / 3  # of the frames; if more are odd, there is no rest that they are unlike


@dataclass
class Peers:
    """The samples of one operating point's frames, gone through one by one.

    Parameters
    ----------
    strips : int
        Strips, one below the other, of which a sample consists.
    """

    strips: int
    _waiting: list[np.ndarray] = field(default_factory=list)
    _middle: np.ndarray | None = None
    _pattern: np.ndarray | None = None
    _scale: tuple[float, float] = (0.0, 0.0)
    _known: dict[tuple[int, bytes], int] = field(default_factory=dict)
    _repeated: dict[int, int] = field(default_factory=dict)
    _rows: list[_Row] = field(default_factory=list)
    _count: int = 0
    _changing: bool = False

    def add(self, sample: np.ndarray) -> None:
        """Take in the next frame's sample, (rows, columns)."""
        cut = sample.reshape(self.strips, -1, sample.shape[1])
        for number, strip in enumerate(cut):
            digest = hashlib.blake2b(strip.tobytes(), digest_size=12).digest()
            first = self._known.setdefault((number, digest), self._count)
            if first != self._count:
                self._repeated.setdefault(self._count, first)
        self._count += 1
        values = cut.astype(np.float32)
        if self._middle is None:
            self._waiting.append(values)
            if len(self._waiting) == REFERENCE:
                self._compare()
        else:
            self._rows.append(self._row(values))

    def finish(self) -> Seen:
        """What was seen of each frame; the samples are forgotten."""
        if self._middle is None and len(self._waiting) >= FEWEST:
            self._compare()
        self._middle = self._pattern = None
        self._waiting = []
        return Seen(self._rows, self._repeated if self._changing else {})

    def _compare(self) -> None:
        """The median and the summed pattern of the frames that wait, and what each is to them.

        Frames that repeat a part of another are no part of these, for they share its noise.
        """
        waiting, self._waiting = self._waiting, []
        own = [k for k in range(len(waiting)) if k not in self._repeated]
        if len(own) > 1:
            self._changing = float(np.mean(waiting[own[0]] != waiting[own[1]])) > CHANGING
        if len(own) < FEWEST:
            return
        stack = np.stack([waiting[k] for k in own])
        # of frames at one level, else the median would be the frame of the middle level
        moved = np.median(stack - stack[0], axis=(1, 2, 3), keepdims=True)
        middle = self._middle = np.median(stack - moved, axis=0)
        spread = float(np.median([_spread(_level(y - middle)[1]) for y in stack]))
        fine = [_fine(y) for y in stack]
        reach = float(np.median([_spread(e) for e in fine]))
        self._scale = spread, reach
        clipped = {k: self._clipped(e) for k, e in zip(own, fine, strict=True)}
        share = np.float32(1 / (len(own) - 1))
        pattern = np.sum(list(clipped.values()), axis=0) * share
        self._pattern = pattern * np.float32(1 - 1 / len(own))
        self._rows = [
            self._row(y, pattern - share * clipped[k], clipped[k]) if k in clipped else self._row(y)
            for k, y in enumerate(waiting)
        ]

    def _row(
        self, y: np.ndarray, pattern: np.ndarray | None = None, own: np.ndarray | None = None
    ) -> _Row:
        assert self._middle is not None
        assert self._pattern is not None
        level, d = _level(y - self._middle)
        spread = _spread(d)
        np.clip(d, -CAP * self._scale[0], CAP * self._scale[0], out=d)
        tiny = 1e-9 * self._scale[0] ** 2
        of_strips = d.mean(axis=(1, 2), keepdims=True)
        d -= of_strips
        own = self._clipped(_fine(y)) if own is None else own
        product = own * (self._pattern if pattern is None else pattern)
        return _Row(
            level,
            spread,
            float(np.var(of_strips)) + tiny,
            _by_strip(np.abs(d)) ** 2 + tiny,
            _by_strip(product),
            float(np.var(d.mean(axis=2))) + tiny,
            float(np.var(d.mean(axis=(0, 1)))) + tiny,
        )

    def _clipped(self, fine: np.ndarray) -> np.ndarray:
        """The fine pattern of a frame, without that of whole columns."""
        reach = PATTERN_CAP * self._scale[1]
        out = np.clip(fine, -reach, reach)
        return out - out.mean(axis=(0, 1))


@dataclass(frozen=True)
class _Row:
    """One frame: level and noise, DN; variance of the means of strips; squared mean deviation and
    likeness of each, DN^2; variance of the means of rows within strips, and of columns.
    """

    level: float
    spread: float
    smooth: float
    noise: np.ndarray
    likeness: np.ndarray
    rows: float
    columns: float


@dataclass(frozen=True)
class Seen:
    """What was seen of the frames of one operating point."""

    frames: list[_Row]
    repeated: dict[int, int]

    def questions(self) -> dict[str, Question]:
        """What is asked of each frame; empty where there are too few frames."""
        if not self.frames:
            return {}
        noise = np.log([r.noise for r in self.frames])
        out = {
            "noise": Question.of_strips(noise, NOISE),
            "strip noise": Question.of_each_strip(noise, STRIP_NOISE),
        }
        like = np.array([r.likeness for r in self.frames])
        usual, by_strip = float(np.median(like.mean(axis=1))), np.median(like, axis=0)
        if usual > 0:
            out["likeness"] = replace(
                Question.of_strips(like / usual, LIKENESS), most=1.0, lack=True
            )
        if by_strip.min() > 0:
            each = Question.of_each_strip(like / by_strip, STRIP_LIKENESS)
            out["strip likeness"] = replace(each, most=1.0, lack=True)
        levels = np.array([r.level for r in self.frames])
        # where the pedestal wanders from frame to frame it may do so within one
        steady = robust_deviation(levels) < STEADY * np.exp(np.median(noise) / 2)
        for name in ("rows", "columns", *(("smooth",) if steady else ())):
            values = np.array([getattr(r, name) for r in self.frames])
            heavy = values - np.median(values) > LINE_SHARE * np.exp(np.median(noise))
            out[name] = Question(np.log(values), 0.0, LINES, heavy=heavy, degrees=0)
        return out


@dataclass(frozen=True)
class Question:
    """One number of each frame, and from which deviation it matters.

    Parameters
    ----------
    values : ndarray
        (frames,), or (frames, strips).
    error : float
        Standard error that pixels alone make.
    least : float
        Deviation that matters.
    most : float
        Deviation of a frame that has nothing in common with the others.
    lack : bool
        Only what is too small is odd: near copies share their noise, which raises the likeness of
        both.
    heavy : ndarray of bool, optional
        Frames of which it matters.
    degrees : int
        Degrees of freedom of ``error``.
    """

    values: np.ndarray
    error: float
    least: float
    most: float = np.inf
    lack: bool = False
    heavy: np.ndarray | None = None
    degrees: int = STRIP_DEGREES

    @classmethod
    def of_strips(cls, values: np.ndarray, least: float) -> Question:
        """The mean over the strips."""
        return cls(values.mean(axis=1), cls._strip_error(values) / values.shape[1] ** 0.5, least)

    @classmethod
    def of_each_strip(cls, values: np.ndarray, least: float) -> Question:
        """Each strip by itself."""
        return cls(values, cls._strip_error(values), least)

    @staticmethod
    def _strip_error(values: np.ndarray) -> float:
        """Scatter over the strips of what like frames differ by: the quieter pairs are like."""
        pairs = np.concatenate([values - np.roll(values, k, axis=0) for k in (1, 2)])
        squares = pairs.var(axis=1, ddof=1) / 2
        return float(np.sqrt(np.quantile(squares, 0.25, method="lower") / QUARTER))

    @property
    def scatter(self) -> float:
        """Robust scatter over the frames."""
        few = SMALL_SAMPLE_FACTORS.get(len(self.values), 1.0)
        return few * robust_deviation(self.values - np.median(self.values, axis=0), 0.0)

    def odd(self, scatter: float, limit: float) -> np.ndarray:
        """Which frames deviate by more than ``limit`` of the scatter, and by what matters."""
        error = max(self.error, self.scatter, scatter)
        least = self.least * max(1.0, FULL / len(self.values))
        if limit * self.error > least or least > self.most:
            return np.zeros(len(self.values), bool)
        off = self.values - np.median(self.values, axis=0)
        off = -off if self.lack else np.abs(off)
        far = (off > limit * error) & (off > least)
        far = far.any(axis=1) if far.ndim > 1 else far
        return far if self.heavy is None else far & self.heavy


def odd_frames(seen: Sequence[Seen]) -> list[dict[int, list[str]]]:
    """The odd frames of each operating point: number to what is asked and was odd.

    The scatter of frames is that of the operating point or the usual one, whichever is larger; with
    as many degrees of freedom as that has, the limit is the quantile of Student's t that ``ALARM``
    asks for.
    """
    asked = [s.questions() for s in seen]
    out: list[dict[int, list[str]]] = [{} for _ in seen]
    for number, one in enumerate(seen):
        out[number] = {frame: ["repeated"] for frame in one.repeated}
    names = dict.fromkeys(name for questions in asked for name in questions)
    tests = sum(max(q[n].values[0].size for q in asked if n in q) for n in names)
    for name in names:
        told = [q.get(name) for q in asked]
        scatter = float(np.median([q.scatter for q in told if q is not None]))
        frames = sum(len(q.values) - 1 for q in told if q is not None)
        for number, question in enumerate(told):
            if question is None:
                continue
            limit = _limit(question.degrees + MEDIAN_WORTH * frames, tests)
            for frame in np.flatnonzero(question.odd(scatter, limit)).tolist():
                out[number].setdefault(frame, []).append(name)
    for number, one in enumerate(seen):
        for apart in _levels_apart(one, set(out[number])):
            out[number].setdefault(apart, []).append("level")
    return out


def too_many(odd: int, frames: int) -> bool:
    """Whether so many frames are odd that there is no rest."""
    return odd > ODD_SHARE * frames


def reason(seen: Seen, frame: int, asked: Sequence[str], move: Move | None, like: str) -> str:
    """What is odd of a frame, in words.

    Parameters
    ----------
    seen : Seen
    frame : int
    asked : sequence of str
        What was odd, from `odd_frames`.
    move : Move, optional
        How its pattern lies to that of the others, where that was found.
    like : str
        Name of the frame of which it repeats a part.
    """
    if "repeated" in asked:
        return f"a part of it is that of {like}"
    said = []
    spread = np.array([r.spread for r in seen.frames])
    usual = float(np.median(spread))
    ratio = float(spread[frame]) / usual
    if move is not None:
        said.append(move.words())
    elif not {"likeness", "strip likeness"}.isdisjoint(asked):
        where = "" if "likeness" in asked else "in a part of it "
        said.append(f"{where}its fixed pattern is not that of the others")
    if "noise" in asked and (move is None or ratio > 2):
        said.append(f"{ratio:.2g} times their noise")
    elif "strip noise" in asked and not said:
        said.append("in a part of it the noise is another")
    levels = np.array([r.level for r in seen.frames])
    off = float(levels[frame] - np.median(levels))
    if "level" in asked or (move is None and abs(off) > usual):
        said.append(f"{abs(off):.3g} DN {'above' if off > 0 else 'below'} them")
    if not said:
        profiles = {"rows": "rows", "columns": "columns", "smooth": "shading"}
        named = [word for name, word in profiles.items() if name in asked]
        said.append(f"its {' and '.join(named)} differ from theirs")
    return ", ".join(said)


def _levels_apart(seen: Seen, left: set[int]) -> list[int]:
    """Frames whose level alone lies apart from steady levels; none where the others drift.

    Each against the mean and scatter of the others, which for independent levels is Student's t.
    """
    from scipy.special import stdtr

    kept = [k for k in range(len(seen.frames)) if k not in left]
    levels = np.array([seen.frames[k].level for k in kept])
    noise = float(np.median([r.spread for r in seen.frames])) if kept else 0.0
    if len(kept) < FEWEST + 1:
        return []
    worst = int(np.argmax(np.abs(levels - np.median(levels))))
    others = np.delete(levels, worst)
    off = abs(levels[worst] - others.mean())
    spread = float(others.std(ddof=1)) * np.sqrt(1 + 1 / len(others))
    degrees = len(others) - 1
    chance = 2 * len(kept) * stdtr(degrees, -off / max(spread, LEVEL * noise))
    # independent levels differ by twice their variance, those that drift by less
    steady = spread < noise and np.var(others) <= np.mean(np.diff(others) ** 2)
    return [kept[worst]] if off > noise and steady and chance < ALARM else []


def _limit(degrees: float, tests: int) -> float:
    from scipy.special import stdtrit

    return float(-stdtrit(degrees, ALARM / 2 / tests))


def _level(d: np.ndarray) -> tuple[float, np.ndarray]:
    middle = np.float32(np.median(d))
    return float(middle), d - middle


def _fine(y: np.ndarray) -> np.ndarray:
    """Each pixel less the mean of those two columns away, which have its colour."""
    return y[..., 2:-2] - np.float32(0.5) * (y[..., 4:] + y[..., :-4])


def _spread(d: np.ndarray) -> float:
    """Robust sigma: the 90 % quantile of the size, or the root mean square of few codes."""
    size = np.abs(d)
    found = float(np.quantile(size, 0.9)) / 1.645
    return found or float(np.sqrt(np.mean(d * d, dtype=np.float64)))


def _by_strip(values: np.ndarray) -> np.ndarray:
    return np.asarray(values.mean(axis=(1, 2), dtype=np.float64))
