"""Have these raw frames been filtered? Read once, ask every question, give one verdict."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import nullcontext
from dataclasses import replace

import numpy as np

from dnanalyze.analyzers.estimators.saturation import saturation
from dnanalyze.detection import evidence_cache
from dnanalyze.detection.estimate import effect_of, estimate, tail_bounds
from dnanalyze.detection.evidence import SATURATED, VIEWS, ViewEvidence, gather, listed
from dnanalyze.detection.results import Detection, Finding
from dnanalyze.detection.sample import SMALLEST, Group, across, groups, read
from dnanalyze.detection.series import suppression_series
from dnanalyze.detection.verdict import ask, decide, settled
from dnanalyze.executors import in_order
from dnanalyze.loaders.captures import CaptureSet
from dnanalyze.progress import Progress
from dnanalyze.significance import RARE

WORKERS = 2  # groups in memory at a time
LIKE_CROSSTALK = ("rank_exceedance", "spectral_corner", "crosstalk_or_denoise")
CLOSE = 0.3  # of the limit, from which a significant effect is told


def detect(
    captures: CaptureSet,
    *,
    alpha: float = RARE,
    progress: Progress | None = None,
    executor: Executor | None = None,
) -> Detection:
    """Look for hidden defect-pixel correction, denoise and temporal denoise.

    What the tests need is kept where the statistics are (see `analyze`), if the captures have a
    cache.

    Parameters
    ----------
    captures : CaptureSet
        Dark frames. A temperature series of several frames each gives the highest power, a single
        frame the lowest.
    alpha : float
        Chance of a false alarm over all questions together, for exchangeable pixels; limits on
        effect sizes guard against sensors whose pixels are not.
    progress : callable, optional
        ``progress(done, total)`` after each setting.
    executor : concurrent.futures.Executor, optional
        Reads and tests the operating points; by default threads of this process.

    Returns
    -------
    Detection
        What was found, with every test behind it.

    Examples
    --------
    >>> import dnanalyze
    >>> from dnanalyze.demo import tiny
    >>> captures = tiny()
    >>> dnanalyze.detect(captures).filtered
    False
    """
    entry = evidence_cache.entry_of(captures)
    evidence = evidence_cache.read(entry) if entry else None
    if evidence is None:
        evidence = _with_lists(
            _same_well(_gather(groups(captures), progress, executor)), across(captures)
        )
        if entry:
            evidence_cache.write(entry, evidence)
    asked = ask(evidence, alpha)
    kind, flags = decide(asked)
    also = _also(kind, asked)
    estimated = estimate(kind, flags, evidence) if flags else None
    return Detection(
        captures,
        filtered=kind != "none",
        kind=kind,
        confidence=_confidence(flags, evidence),
        estimate=estimated,
        also=also,
        findings=settled(asked, kind, flags, also, alpha),
        evidence=_words(flags),
        ambiguous=_ambiguous(kind, asked, evidence, alpha),
        tail=tail_bounds(estimated, evidence) if estimated and kind == "dpc" else (),
        effect=effect_of(kind, estimated, evidence) if estimated else {},
        series=suppression_series(evidence),
    )


def _gather(
    frame_groups: list[Group], progress: Progress | None, executor: Executor | None
) -> list[ViewEvidence]:
    evidence: list[ViewEvidence] = []
    with ThreadPoolExecutor(WORKERS) if executor is None else nullcontext(executor) as pool:
        found = in_order(pool, _of_group, [(group,) for group in frame_groups])
        for done, part in enumerate(found, 1):
            evidence += part
            if progress is not None:
                progress(done, len(frame_groups))
    return evidence


def _of_group(group: Group) -> list[ViewEvidence]:
    stack = read(group)
    ends = saturation(stack, group.repeats)
    seen = [gather(group, stack, view, ends) for view in VIEWS]
    return [s for s in seen if s is not None]


def _same_well(evidence: list[ViewEvidence]) -> list[ViewEvidence]:
    """A full well is the sensor's: where it shows at one setting of a gain it holds at the others,
    whose frames may be too few to show it.
    """

    def readout(e: ViewEvidence) -> tuple[float | None, str | None]:
        return e.point.gain, e.point.channel

    wells: dict[tuple[float | None, str | None], float] = {}
    for e in evidence:
        if e.saturation.plateau:
            wells[readout(e)] = min(e.saturation.high, wells.get(readout(e), np.inf))
    return [e.beyond(wells.get(readout(e), np.inf)) for e in evidence]


def _with_lists(evidence: list[ViewEvidence], series: Group | None) -> list[ViewEvidence]:
    """The first of each view with the sites that are replaced at all settings."""
    if series is None or not evidence:
        return evidence
    full = {e.point for e in evidence if e.clipped > SATURATED}
    frames = tuple(f for f in series.frames if f.point not in full)
    if len(frames) < 3:
        return evidence
    stack = read(replace(series, frames=frames))
    sites = {view: listed(stack, view) for view in VIEWS}
    return [replace(e, listed=sites.pop(e.view, None)) for e in evidence]


def _confidence(flags: Sequence[Finding], evidence: list[ViewEvidence]) -> float:
    """One minus the corrected p-value; for "none", the share of settings fit for the tests."""
    if flags:
        return float(np.clip(1 - min(f.holm for f in flags), 0.0, 0.9999))
    fit = [e.usable and e.temporal and not e.full and e.fine for e in evidence]
    return float(np.mean(fit)) if fit else 0.0


def _also(kind: str, asked: Sequence[Finding]) -> tuple[str, ...]:
    """Other kinds with flags, but a denoise and a correction, which bring those of each other."""
    hidden = {"dpc", "denoise"} if kind in ("dpc", "denoise") else {kind}
    return tuple(sorted({f.kind for f in asked if f.flagged} - hidden))


def _words(flags: Sequence[Finding]) -> tuple[str, ...]:
    """The strongest finding of each test, in words."""
    strongest: dict[str, Finding] = {}
    for f in sorted(flags, key=lambda f: (-min(f.score, 1e3), f.holm)):
        strongest.setdefault(f.test, f)
    said = []
    for f in strongest.values():
        within = " within a colour" if f.view == "planes" else ""
        where = "All operating points" if f.everywhere else f.evidence.point.label()
        said.append(f"{where}{within}: {f.words}.")
    return tuple(said)


def _ambiguous(
    kind: str, asked: Sequence[Finding], evidence: list[ViewEvidence], alpha: float
) -> tuple[str, ...]:
    """What these frames do not tell."""
    said = []
    soft = [
        f for f in asked
        if f.test in LIKE_CROSSTALK and f.view == "frame" and f.counts and f.holm < alpha
        and CLOSE < f.score <= 1
    ]  # fmt: skip
    if kind in ("none", "temporal_denoise") and soft:
        said.append(
            "The noise of neighbouring pixels is correlated, not more than by charge crosstalk: "
            "crosstalk and weak linear smoothing are not distinguishable here. A colder operating "
            "point, where read noise is the largest noise, distinguishes them."
        )
    if kind == "denoise":
        said.append("A defect-pixel correction before the denoise is not distinguishable from it.")
    if not evidence:
        said.append(f"Frames of fewer than {SMALLEST} rows or columns are too small for the tests.")
    elif not any(e.usable for e in evidence):
        said.append(
            "Frames that do not differ, or with more than 10 % of the pixels clipped or saturated: "
            "the tests of noise do not apply."
        )
    elif not any(e.temporal for e in evidence):
        lists = "" if any(e.listed for e in evidence) else " and static replacement"
        said.append(f"Single frames: temporal filters{lists} are not detectable.")
    said += _saturated(evidence)
    coarse = {e.point.label() for e in evidence if not e.fine}
    if coarse:
        said.append(
            f"Noise below the quantization step at {'; '.join(sorted(coarse))}: a weak filter is "
            "not detectable there."
        )
    return tuple(said)


def _saturated(evidence: list[ViewEvidence]) -> list[str]:
    """Where pixels are clipped or saturated, and what that leaves out."""
    said = []
    for e in evidence:
        if e.view != "frame" or e.clipped < SATURATED:
            continue
        left = "no test applies" if e.full else "the tests of noise do not apply"
        words = (
            e.saturation.words() or f"{100 * e.clipped:.0f} % of the pixels at an end of the scale"
        )
        said.append(f"{e.point.label()}: {words}; {left}.")
    return said
