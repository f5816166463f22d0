"""Captures to Statistics: each frame is read once, whatever the number of windows and planes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass, replace

import numpy as np

from dnanalyze.analyzers.accumulators.accumulated import Accumulated
from dnanalyze.analyzers.catalogue import FAMILIES
from dnanalyze.analyzers.estimators.saturation import of_maps
from dnanalyze.analyzers.estimators.wave_errors import widened
from dnanalyze.analyzers.families import spectrum
from dnanalyze.analyzers.families.trends import trends
from dnanalyze.analyzers.placed import abstained
from dnanalyze.analyzers.statistics import SATURATION, SettingStatistics, Statistics
from dnanalyze.analyzers.streaming import cache
from dnanalyze.analyzers.streaming.accumulation import Accumulation, make_plan, read_ahead
from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import CaptureSet, Frame, OperatingPoint, Sensor, Setting, Window
from dnanalyze.processors import cpu_count
from dnanalyze.progress import Progress

UNTHREADED_PIXELS = 1 << 18  # pixels up to which handing frames to threads costs more than it gives
NAMES = tuple(family.INFOS[0].family for family in FAMILIES)
SUBSETS = {spectrum.PATTERN_ALONE: "spectrum"}  # of a family, with less work
LEAST_SIDE = 8  # rows and columns of the smallest plane that can be analysed


def analyze(
    captures: CaptureSet,
    *,
    window: Window | None = None,
    workers: int | None = None,
    progress: Progress | None = None,
    scheduler: str | None = None,
    families: Sequence[str] = (),
    system_gain: float | None = None,
) -> Statistics:
    """Measure every statistic at every operating point, each with its standard error.

    Parameters
    ----------
    captures : CaptureSet
        Dark frames.
    window : Window, optional
        Part of the frame to analyse; on a mosaic its edges are moved inwards to even numbers.
    workers : int, optional
        Threads; the number of processors by default. The result does not depend on it.
    progress : callable, optional
        Called with (frames done, frames in all).
    scheduler : str, optional
        Address of a Dask scheduler whose workers read the frames, or "local" to start one here. A
        run that was interrupted goes on where it was, if the captures have a cache.
    families : sequence of str, optional
        Families of statistics that are wanted, such as ("level", "spectrum"); all by default.
        "pattern_spectrum" is the part of "spectrum" that needs the mean frame only, as in EMVA
        1288: one transform instead of one for each frame.
    system_gain : float, optional
        Overall system gain K, DN/e-, for the EMVA 1288 quantities in electrons (``.emva``); by
        default the recorded one, or that of photon transfer in the dark.

    Returns
    -------
    Statistics
        Values by name with standard errors, at each operating point and colour plane.

    Raises
    ------
    InputError
        A window outside the frame, or too small; frames of another shape than the sensor's; an
        unknown family; a gain that is not above 0.

    Examples
    --------
    >>> import dnanalyze
    >>> from dnanalyze.demo import tiny
    >>> captures = tiny()
    >>> statistics = dnanalyze.analyze(captures)
    >>> noise = statistics.settings[0].values["temporal_noise"]
    >>> noise.se < noise.value
    True
    """
    if system_gain is not None and not 0 < system_gain < float("inf"):
        raise InputError(f"system_gain {system_gain:g}: it must be above 0 DN/e-")
    (found,) = analyze_windows(
        captures, (window,), workers=workers, progress=progress, scheduler=scheduler,
        families=families,
    )  # fmt: skip
    return replace(found, captures=captures, system_gain=system_gain)


def analyze_windows(
    captures: CaptureSet,
    windows: Sequence[Window | None],
    *,
    workers: int | None = None,
    progress: Progress | None = None,
    errors: bool = True,
    scheduler: str | None = None,
    families: Sequence[str] = (),
) -> list[Statistics]:
    """`analyze` for several windows of the same frames, each frame read once.

    Where the captures' source names a cache, what it holds is not worked out again. ``None`` among
    the windows stands for the whole frame. Without ``errors`` only the values that
    are compared are sure to be there, and their standard errors mean nothing.
    """
    placed = [_placed(window, captures.sensor) for window in windows]
    wanted = _known(families)
    entry = cache.held(captures, placed, errors, wanted)
    statistics = entry.get(captures) if entry else None
    if statistics is not None:
        if progress is not None:
            progress(captures.frame_count, captures.frame_count)
        return statistics
    parts = [
        _Part(w, plane, errors, wanted) for w in placed for plane in _planes(w, captures.sensor)
    ]
    if scheduler is None:
        settings = _here(captures, parts, workers, progress)
    else:
        settings = _on_cluster(captures, parts, scheduler, progress, entry)
    statistics = _by_window(captures, placed, parts, settings)
    if entry:
        entry.put(statistics)
    return statistics


def _known(families: Sequence[str]) -> tuple[str, ...]:
    valid = (*NAMES, *SUBSETS)
    for name in families:
        if name not in valid:
            raise InputError(f"no family is called {name!r}; valid: {', '.join(valid)}")
    return tuple(name for name in valid if name in families)


def _here(
    captures: CaptureSet, parts: list[_Part], workers: int | None, progress: Progress | None
) -> list[list[SettingStatistics]]:
    """The statistics of every setting and part, read by this process."""
    outer = _outer([part.window for part in parts])
    out = []
    total, done = captures.frame_count, 0
    with ExitStack() as stack:
        pool = _pool(workers, outer, stack)
        for setting in captures.settings:
            fed = [replace(part) for part in parts]
            for number, frame in enumerate(_frames(setting, outer)):
                for part in fed:
                    part.add(part.cut(frame, outer), number, pool)
                done += 1
                if progress is not None:
                    progress(done, total)
            out.append([part.finish(setting.point, pool) for part in fed])
    return out


def _on_cluster(
    captures: CaptureSet,
    parts: list[_Part],
    scheduler: str,
    progress: Progress | None,
    entry: cache.Entry | None,
) -> list[list[SettingStatistics]]:
    """As `_here`, by the workers of a Dask cluster."""
    from dnanalyze.analyzers.streaming import distributed

    cut = distributed.Cut(_outer([part.window for part in parts]), parts)
    out: list[list[SettingStatistics]] = []
    before = 0
    with distributed.cluster(scheduler) as client:
        for number, setting in enumerate(captures.settings):
            saved = entry.path.with_suffix(f".{number}.run") if entry else None
            runs = distributed.Runs(client, setting.frames, cut, saved)
            for done in runs.merged():
                if progress is not None:
                    progress(before + done, captures.frame_count)
            before += len(setting.frames)
            assert runs.total is not None
            pairs = zip(runs.total, parts, strict=True)
            out.append([finish(a.finish(), setting.point, p.plane.name) for a, p in pairs])
    if entry:
        for saved in entry.path.parent.glob(entry.path.stem + ".*.run"):
            saved.unlink(missing_ok=True)
    return out


def _by_window(
    captures: CaptureSet,
    placed: list[Window],
    parts: list[_Part],
    settings: list[list[SettingStatistics]],
) -> list[Statistics]:
    out = []
    for window in placed:
        each = [
            statistics
            for setting in settings
            for part, statistics in zip(parts, setting, strict=True)
            if part.window == window
        ]
        each = [abstained(s, captures.sensor.filled) for s in each]
        told = parts[0].errors and not parts[0].families
        laws, rated = trends(each, captures.sensor) if told else ({}, each)
        out.append(Statistics(captures.name, captures.sensor, tuple(rated), laws))
    return out


def _pool(workers: int | None, outer: Window, stack: ExitStack) -> ThreadPoolExecutor | None:
    rows, columns = outer.shape
    if workers == 1 or rows * columns <= UNTHREADED_PIXELS:
        return None
    return stack.enter_context(ThreadPoolExecutor(workers or cpu_count()))


def _placed(window: Window | None, sensor: Sensor) -> Window:
    """The window inside the frame, on a mosaic at whole blocks of the colour filter."""
    whole = Window.whole(sensor.shape)
    if window is None:
        window = whole
    elif window != window.grown(0, sensor.shape) or min(window.shape) < 1:
        raise InputError(
            f"window {window.top}:{window.bottom}, {window.left}:{window.right}: it must lie "
            f"within rows 0:{sensor.shape[0]} and columns 0:{sensor.shape[1]}"
        )
    least = LEAST_SIDE
    if sensor.cfa is not None:
        window = Window(
            window.top + window.top % 2, window.bottom - window.bottom % 2,
            window.left + window.left % 2, window.right - window.right % 2,
        )  # fmt: skip
        least = 2 * LEAST_SIDE
    if min(window.shape) < least:
        rows, columns = window.shape
        raise InputError(
            f"{rows} x {columns} pixels are too few to analyse; {least} x {least} is the least"
        )
    return window


def _outer(windows: Sequence[Window]) -> Window:
    return Window(
        min(w.top for w in windows), max(w.bottom for w in windows),
        min(w.left for w in windows), max(w.right for w in windows),
    )  # fmt: skip


def _frames(setting: Setting, outer: Window) -> Iterator[np.ndarray]:
    """The frames of a setting, the next one being read while one is in use."""

    def reader(frame: Frame) -> Callable[[], np.ndarray]:
        def read() -> np.ndarray:
            pixels = frame.read(outer)
            if pixels.shape != outer.shape:
                raise InputError(
                    f"{frame.name}: its shape is not that of the other frames; "
                    "give the frames of each shape a folder of their own"
                )
            return pixels

        return read

    reads = [reader(frame) for frame in setting.frames]
    rows, columns = outer.shape
    yield from (
        (read() for read in reads) if rows * columns <= UNTHREADED_PIXELS else read_ahead(reads)
    )


@dataclass(frozen=True)
class _Plane:
    """A colour plane: its name and its place in the 2 x 2 block."""

    name: str = ""
    row: int = 0
    column: int = 0
    step: int = 1


def _planes(window: Window, sensor: Sensor) -> list[_Plane]:
    if sensor.cfa is None:
        return [_Plane()]
    periods = {len(sensor.cfa), *map(len, sensor.cfa)}
    if any(period % 2 for period in periods):
        raise InputError(
            "the colour filter has an odd period, and mosaics are analysed as 2 x 2 planes; state "
            "no cfa in the sidecar to analyse the frame as a whole"
        )
    names = _plane_name if periods == {2} else _phase_name
    return [_Plane(names(sensor.cfa, r, c), r, c, 2) for r in range(2) for c in range(2)]


def _phase_name(cfa: tuple[tuple[str, ...], ...], row: int, column: int) -> str:
    """Of a larger mosaic: row and column in the 2 x 2 block.

    Dark charge does not pass the filter; circuits are shared by 2 x 2 pixels or fewer.
    """
    return f"{row}{column}"


def _plane_name(cfa: tuple[tuple[str, ...], ...], row: int, column: int) -> str:
    """Gr and Gb for the greens beside red and beside blue, else the filter's own name."""
    name = cfa[row][column]
    if name == "G":
        return {"R": "Gr", "B": "Gb"}.get(cfa[row][1 - column], "G")
    return name


@dataclass
class _Part:
    """One window and plane of the setting being read."""

    window: Window
    plane: _Plane
    errors: bool = True
    families: tuple[str, ...] = ()
    accumulation: Accumulation | None = None
    waiting: tuple[np.ndarray, ...] = ()

    def cut(self, frame: np.ndarray, outer: Window) -> np.ndarray:
        rows, columns = self.window.within(outer)
        plane = frame[rows, columns][
            self.plane.row :: self.plane.step, self.plane.column :: self.plane.step
        ]
        return np.ascontiguousarray(plane)

    def add(self, frame: np.ndarray, number: int, pool: ThreadPoolExecutor | None) -> None:
        """The plan needs two frames, so that the first waits for the second."""
        if number == 0:
            self.waiting = (frame,)
            return
        if self.accumulation is None:
            self._begin(self.waiting[0], frame, pool)
        assert self.accumulation is not None
        self.accumulation.add(frame, number)

    def _begin(
        self, first: np.ndarray, second: np.ndarray | None, pool: ThreadPoolExecutor | None
    ) -> None:
        self.accumulation = Accumulation(make_plan(first, second, self.errors, self.families), pool)
        self.accumulation.add(first, 0)
        self.waiting = ()

    def finish(self, point: OperatingPoint, pool: ThreadPoolExecutor | None) -> SettingStatistics:
        if self.accumulation is None:
            self._begin(self.waiting[0], None, None)
        assert self.accumulation is not None
        complete, self.accumulation = self.accumulation.finish(), None
        return finish(complete, point, self.plane.name, pool)


def finish(
    acc: Accumulated,
    point: OperatingPoint,
    plane: str = "",
    pool: ThreadPoolExecutor | None = None,
) -> SettingStatistics:
    """The families' values of accumulated frames; with a pool, several families at a time."""
    out = SettingStatistics(point, plane, acc.frames, acc.plan.shape, {})
    run = map if pool is None else pool.map
    acc.prepare(run)
    asked = {SUBSETS.get(name, name) for name in acc.plan.families or NAMES}
    wanted = [f for name, f in zip(NAMES, FAMILIES, strict=True) if name in asked]
    # the longest first, so that the others run beside it
    begun = sorted(wanted, key=lambda family: family is not spectrum)
    results = dict(zip(begun, run(lambda family: family.finish(acc), begun), strict=True))
    for family in wanted:
        result = results[family]
        out.values.update(result.values)
        out.curves.update(result.curves)
        out.missing.update(result.missing)
    out.missing.update(_saturated(acc))
    return replace(out, values=widened(out.values, acc.frames)) if acc.plan.errors else out


def _saturated(acc: Accumulated) -> dict[str, str]:
    """The reason why level and noise are not the sensor's, where most pixels are saturated.

    Not looked for in simulated frames (no errors wanted), parts of the statistics, or values that
    are no codes.
    """
    if not (acc.plan.errors and acc.plan.integer) or acc.plan.families:
        return {}
    seen = of_maps(
        acc.maps.low, acc.temporal_variance, acc.frames, acc.values.centres, acc.values.counts
    )
    if not seen.most:
        return {}
    return {
        SATURATION: f"clipped or saturated: {seen.words()}; excluded from the laws over temperature"
    }
