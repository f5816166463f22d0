"""Unfiltered sensors with hot pixels in clusters, saturated, or clipped to darkness."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage
from unfiltered import KINDS, Clusters, clustered_sensor, series
from virtual_sensor import Traits, captures, from_stacks

from dnanalyze.detection import detect
from dnanalyze.detection.replaced import RULES, replaced
from dnanalyze.detection.verdict import NOT_SIGNIFICANT
from dnanalyze.loaders.captures import CaptureSet, Frame, OperatingPoint, Sensor, Setting


@pytest.mark.parametrize("law", ["exponential", "constant"])
def test_hot_pixels_in_clusters_are_no_correction(law):
    """Each with 2 to 4 others within one pixel, 3e-4 clusters a pixel."""
    traits = Traits(gain=1.0, white=65535.0)
    sensor = clustered_sensor(traits, Clusters(1.2e-3, 4.0, 1, law), (512, 512), 1)
    found = detect(captures(sensor, (65.0, 85.0), 3))
    assert found.kind == "none", found.evidence


def _plateau(celsius: float, frames: int, size: int = 320) -> np.ndarray:
    """Full pixels, a smooth pattern by blooming that follows the temperature, dark islands."""
    rng = np.random.default_rng([3, round(100 * celsius)])
    fields = np.random.default_rng(4).standard_normal((3, size, size))
    still, moving, islands = (ndimage.gaussian_filter(f, 2.0) for f in fields)
    level = 32700 + 4000 * still + 600 * (celsius - 3) * moving
    stack = level + 30 * rng.standard_normal((frames, size, size))
    edge = islands > np.quantile(islands, 0.985)
    depth = np.where(edge, (islands / np.quantile(islands, 0.985) - 1) * 2e5, 0.0)
    stack -= depth * (1 + 0.15 * rng.standard_normal(stack.shape))
    return np.clip(np.round(stack), 0, 65535).astype(np.uint16)


def test_a_full_well_plateau_below_the_top_of_the_scale_cannot_be_told():
    shape = (320, 320)
    settings = []
    for celsius, count in ((3.5, 1), (5.5, 1), (7.7, 2), (8.7, 1)):
        point = OperatingPoint(celsius, 20.0)
        loads = [lambda w, f=f: f if w is None else f[w.slices] for f in _plateau(celsius, count)]
        frames = tuple(Frame(f"{celsius}-{n}", point, load) for n, load in enumerate(loads))
        settings.append(Setting(point, frames))
    found = detect(CaptureSet("bloomed", Sensor(shape), tuple(settings)))
    assert found.kind == "none", found.evidence
    assert found.confidence == 0
    assert any("plateau" in text for text in found.ambiguous)


@pytest.mark.parametrize("share", [0.7, 0.97, 0.999])
def test_frames_mostly_at_the_lowest_code_hold_no_copies(share):
    """Dark islands of glow in frames whose offset lies too low."""
    rng = np.random.default_rng(5)
    glow = 40 * ndimage.gaussian_filter(rng.standard_normal((256, 256)), 6)

    def stack() -> np.ndarray:
        values = glow + rng.normal(0, 2.0, (6, 256, 256))
        return np.maximum(np.round(values - np.quantile(values, share)), 0).astype(np.uint16)

    found = detect(from_stacks({25.0: stack}, (256, 256), 6))
    assert found.kind == "none", found.evidence
    assert found.confidence == 0
    assert any("lowest code" in text for text in found.ambiguous)


def test_a_gradient_makes_no_more_sites_match_than_elsewhere():
    """Within a glow only the own ring lies at the pixel's level."""
    rng = np.random.default_rng(6)
    glow = 300 * np.exp(-np.add.outer(np.arange(200), np.arange(200)) / 60.0)
    frames = np.round(100 + glow + rng.normal(0, 0.7, (4, 200, 200))).astype(np.float32)
    found = replaced(frames, 1.0, 0.7)
    for rule in ("mean of 24", "mean of 8", "mean of above and below"):
        own, control = found.own[RULES.index(rule)], found.control[RULES.index(rule)]
        assert own < 1.5 * control + 5 * np.sqrt(control + 1)


def test_findings_that_do_not_count_say_why():
    sensor = clustered_sensor(
        Traits(gain=1.2, crosstalk=0.02, dark=20.0), Clusters(1e-3, 4.0, 1, "constant"),
        (192, 192), 2,
    )  # fmt: skip
    found = detect(captures(sensor, (25.0, 65.0), 6))
    assert found.kind == "none"
    small = [f for f in found.findings if f.p_value < 1e-12]
    assert small  # crosstalk smooths shot noise
    for f in found.findings:
        assert f.reason
        assert f.to_plain()["reason"] == f.reason
    assert all(f.reason != NOT_SIGNIFICANT for f in small)


@pytest.mark.long
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(300, 303))
def test_fresh_unfiltered_series_are_left_in_peace(kind, seed):
    made, said = series(kind, seed, largest=160)
    found = detect(made)
    assert found.kind == "none", (said, found.evidence)
