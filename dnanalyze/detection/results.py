"""What `detect` answers."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from dnanalyze.detection.series import SuppressionSeries
from dnanalyze.loaders.captures import CaptureSet
from dnanalyze.result import Result

if TYPE_CHECKING:
    from dnanalyze.detection.evidence import ViewEvidence
    from dnanalyze.detection.replaced import Replaced

IN_JSON = (
    "test", "kind", "temperature_c", "p_value", "effect_size", "flagged", "view", "words", "limit",
    "reason",
)  # fmt: skip


@dataclass(frozen=True)
class Finding:
    """One test at one setting: what it found, and what that counts for.

    Parameters
    ----------
    test : str
    kind : str
        What it speaks for: "dpc", "denoise" or "temporal_denoise".
    temperature_c : float, optional
        C; None where unknown or where the test spans all temperatures.
    p_value : float
        Under the test's null, before the correction for many questions.
    effect_size : float
        0: as unfiltered; in the test's own unit (see docs/detection.md).
    flagged : bool
        Significant after the correction, and larger than any unfiltered sensor explains.
    view : str
        "frame", or "planes" of a 2x2 mosaic.
    words : str
        The evidence, in a sentence.
    limit : float
        Effect size that unfiltered sensors reach; infinite where the test does not speak alone.
    reason : str
        Why it is not flagged, in words; empty where it is.
    holm : float
        p-value after Holm's correction over all tests.
    counts : bool
        Its answer counts at this setting; elsewhere it is given for information.
    evidence : ViewEvidence
        That the test looked at.
    at : float
        Threshold, DN, or number of the rule, or memory that it points to.
    neighbours : int
        Among which a pixel stands out.
    slope : float
        Of the neighbours' maximum, in a rule of a slope and a bound.
    sites : Replaced, optional
        Sites that it rests on.
    """

    test: str
    kind: str
    temperature_c: float | None
    p_value: float
    effect_size: float
    flagged: bool = False
    view: str = "frame"
    words: str = ""
    limit: float = math.inf
    reason: str = ""
    holm: float = 1.0
    counts: bool = True
    evidence: ViewEvidence = field(default=cast("ViewEvidence", None), repr=False, compare=False)
    at: float = field(default=math.nan, compare=False)
    neighbours: int = 8
    slope: float = 1.0
    sites: Replaced | None = field(default=None, repr=False, compare=False)

    @property
    def everywhere(self) -> bool:
        """Over all settings."""
        return self.sites is not None and self.sites is self.evidence.listed

    @property
    def score(self) -> float:
        """Effect size over what unfiltered sensors reach."""
        return self.effect_size / self.limit

    def to_plain(self) -> dict[str, Any]:
        """As in the JSON report."""
        return _plain({name: getattr(self, name) for name in IN_JSON})


@dataclass(frozen=True)
class FilterEstimate:
    """What the filter seems to be.

    Parameters
    ----------
    subkind : str
        dpc: "dynamic", "clamp", "ratio", "static"; denoise: "gaussian", "median",
        "edge_preserving", "some_rows"; temporal_denoise: "recursive".
    view : str
        "frame", or "planes": it works within a colour.
    threshold_dn, threshold_sigma, ratio : float, optional
        Of a dynamic correction: the excess above the neighbours' maximum, or above ``ratio`` times
        it, from which no pixel stands out.
    level_dn : float, optional
        From where a ratio is measured, DN.
    neighbours : int, optional
        8 or 24.
    replacement : str, optional
        Rule that the replaced sites obey.
    site_ppm : float, optional
        Replaced sites found, per million.
    strength : float, optional
        denoise: share of high-frequency power removed; temporal: the memory.
    from_temperature_c : float, optional
        Lowest temperature at which it shows, C.
    """

    subkind: str
    view: str = "frame"
    threshold_dn: float | None = None
    threshold_sigma: float | None = None
    ratio: float | None = None
    level_dn: float | None = None
    neighbours: int | None = None
    replacement: str | None = None
    site_ppm: float | None = None
    strength: float | None = None
    from_temperature_c: float | None = None


@dataclass(frozen=True)
class TailBound:
    """Hot pixels before correction, in one setting."""

    temperature_c: float | None
    level_dn: float  # excess above the neighbours' maximum, DN
    ppm_seen: float  # isolated pixels beyond it that are left
    # Bounds of what there was: what the survivors beside other hot pixels imply, and with the
    # replaced sites that may or may not have been hot.
    ppm_lower: float
    ppm_upper: float


@dataclass(frozen=True, repr=False)
class Detection(Result):
    """Whether the raw frames were filtered, and how.

    Parameters
    ----------
    captures : CaptureSet
        The frames that were tested.
    filtered : bool
        A filter was found.
    kind : str
        "none", "dpc", "denoise" or "temporal_denoise".
    confidence : float
        0 to 1: one minus the corrected p-value of the verdict; for "none" the share of the tests
        that had the power to find something.
    estimate : FilterEstimate, optional
        Parameters of the filter.
    also : tuple of str
        Further kinds with flagged findings of their own.
    findings : tuple of Finding
        Every test at every operating point.
    evidence : tuple of str
        Sentences, in the order of significance.
    ambiguous : tuple of str
        What these frames do not distinguish.
    tail : tuple of TailBound
        Where a correction was found.
    effect : dict
        {"dpc" | "denoise" | "temporal_denoise": parameters} that reproduces the filter in a model;
        empty for none.
    series : SuppressionSeries, optional
        Suppression of high frequencies over temperature, for the figure.
    """

    captures: CaptureSet = field(compare=False)
    filtered: bool
    kind: str
    confidence: float
    estimate: FilterEstimate | None = None
    also: tuple[str, ...] = ()
    findings: tuple[Finding, ...] = ()
    evidence: tuple[str, ...] = ()
    ambiguous: tuple[str, ...] = ()
    tail: tuple[TailBound, ...] = ()
    effect: dict[str, dict[str, Any]] = field(default_factory=dict)
    series: SuppressionSeries | None = None

    def _brief(self) -> str:
        what = self.kind if self.filtered else "no filter found"
        return f"{self.captures.name}, {what}, confidence {self.confidence:.3g}"

    def to_plain(self) -> dict[str, Any]:
        """Return what the JSON report holds; numbers are finite or null.

        Returns
        -------
        dict
            By key; see the documentation of ``detect``.
        """
        return {
            "filtered": self.filtered,
            "kind": self.kind,
            "subkind": self.estimate.subkind if self.estimate else None,
            "confidence": _finite(self.confidence),
            "also": list(self.also),
            "estimate": _plain(vars(self.estimate)) if self.estimate else None,
            "findings": [f.to_plain() for f in self.findings],
            "evidence": list(self.evidence),
            "ambiguous": list(self.ambiguous),
            "tail": [_plain(vars(t)) for t in self.tail],
            "effect": self.effect,
            "series": _plain(vars(self.series)) if self.series else None,
        }


def _plain(raw: dict[str, Any]) -> dict[str, Any]:
    return {k: v if isinstance(v, (str, bool)) else _finite(v) for k, v in raw.items()}


def _finite(value: Any) -> Any:
    if value is None:
        return None
    if isinstance(value, np.ndarray):
        return [_finite(v) for v in value]
    return float(value) if np.isfinite(value) else None
