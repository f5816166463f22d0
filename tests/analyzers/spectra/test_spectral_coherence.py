"""Whether a line is one wave over the field, against what blocks in and out of step must give."""

from __future__ import annotations

import numpy as np
import pytest

from dnanalyze.analyzers.spectra.coherence import in_step
from dnanalyze.analyzers.spectra.modes import power_of
from dnanalyze.analyzers.spectra.peaks import largest_peak

SHAPE = (192, 256)
ROW, COLUMN = np.indices(SHAPE)


def _wave(u, v, phase=0.3):
    return np.sin(2 * np.pi * (u * COLUMN + v * ROW) + phase)


def _white(seed):
    return np.random.default_rng(seed).standard_normal(SHAPE)


@pytest.mark.parametrize("off", [0.0, 0.25, 0.5, -0.4])
def test_a_wave_is_in_step_wherever_between_two_modes_it_lies(off):
    u, v = (40 + off) / SHAPE[1], (20 + off) / SHAPE[0]
    share, _ = in_step([_wave(u, v)], 40 / SHAPE[1], 20 / SHAPE[0])
    assert share > 0.99


@pytest.mark.parametrize("ratio", [30.0, 100.0, 1000.0])
def test_under_noise_the_share_is_that_of_the_line_and_its_error_holds(ratio):
    amplitude = np.sqrt(4 * ratio / (SHAPE[0] * SHAPE[1]))  # a line of power A^2 N / 4
    found = np.array(
        [in_step([_white(k) + amplitude * _wave(0.21, 0.13)], 0.21, 0.13) for k in range(40)]
    )
    share, error = found.T
    expected = (ratio + 1) / (ratio + 16)
    assert np.mean(share) == pytest.approx(expected, abs=0.03)  # the best of two modes adds to it
    assert np.std(share) < 1.5 * np.mean(error)


def test_noise_alone_is_a_sixteenth_and_the_best_near_it():
    found = [in_step([_white(k)], 0.21, 0.13)[0] for k in range(40)]
    assert 1 / 16 < np.mean(found) < 4 / 16


@pytest.mark.parametrize("images", [1, 3])
def test_phases_of_their_own_do_not_matter_from_image_to_image(images):
    phases = np.linspace(0.0, 5.0, images)
    share, _ = in_step([_wave(0.1, 0.2, p) for p in phases], 0.1, 0.2)
    assert share > 0.99


def test_rings_a_chirp_and_a_patch_are_out_of_step():
    rings = np.cos(2 * np.pi * np.hypot(ROW - 20, COLUMN - 300) / 9.0)
    chirp = np.cos(2 * np.pi * (0.05 + 0.1 * COLUMN / SHAPE[1]) * COLUMN + 0.8 * ROW)
    patch = _wave(0.1, 0.2) * ((ROW < 96) & (COLUMN < 128))
    for image in (rings, chirp, patch):
        image = image + 0.1 * _white(5)
        peak = largest_peak(power_of(image.astype(np.float32)), SHAPE, 1.0)
        share, error = in_step([image], peak.u, peak.v)
        assert share < 0.6
        assert share + 5 * error < 1.0


def test_of_nothing_nothing_is_told():
    assert np.isnan(in_step([np.zeros(SHAPE)], 0.1, 0.2)).all()
