import numpy as np
import pytest
from readout_bench import added, frames, line_clues

from dnanalyze.loaders.captures import Window
from dnanalyze.model.effects.row_noise import TOGETHER, RowNoise


def test_rows_scatter_by_sigma_anew_in_every_frame():
    d = added(RowNoise(0.7), count=3, shape=(8192, 6))
    r = d[:, :, 0]
    np.testing.assert_allclose(d, np.broadcast_to(r[:, :, None], d.shape), atol=1e-4)
    assert r.var() == pytest.approx(0.49, rel=5 * np.sqrt(2 / r.size))
    for pair in (np.corrcoef(r)[np.triu_indices(3, 1)], [np.corrcoef(r[0, 1:], r[0, :-1])[0, 1]]):
        assert np.abs(pair).max() < 5 / np.sqrt(r.shape[1])


def test_mean_over_frames_keeps_one_over_k_of_the_power():
    r = added(RowNoise(1.0), count=8, shape=(4096, 2))[:, :, 0]
    assert r.mean(axis=0).var() == pytest.approx(1 / 8, rel=5 * np.sqrt(2 / 4096))


def test_guess_from_power_in_differences():
    (effect,) = RowNoise.guess(line_clues("temporal_rows", 4.0 + 256 * 0.49, 4.0))
    assert effect.sigma == pytest.approx(0.7, rel=1e-6)
    assert RowNoise.guess(line_clues("pattern_rows", 90.0, 4.0)) == []


def test_guess_of_rows_that_are_converted_together():
    v = np.arange(1, 129) / 256
    # of 2 x 1 rows: 1 + cos, beside the pixels; exactly as expected, of 8 frames
    power = 4.0 + 256 * 0.49 * (1.0 + np.cos(2.0 * np.pi * v))
    curves = {
        "temporal_row_spectrum": [power], "row_spectrum_f": [v], "frame_means": [np.zeros(8)],
    }  # fmt: skip
    given = line_clues("temporal_rows", 4.0 + 256 * 0.49, 4.0, curves=curves)
    given.seen["temporal_row_mean_explained"] = np.sqrt(4.0 / 256)
    (found,) = RowNoise.guess(given)
    assert found.together == "2x1"
    assert found.sigma == pytest.approx(0.7, rel=1e-6)


@pytest.mark.parametrize("serial", [(0.3, 0.0), (-0.3, 0.0), (0.0, 0.3), (-0.1, 0.25)])
def test_rows_are_correlated_as_stated_with_two_neighbours_and_no_others(serial):
    r = added(RowNoise(0.7, *serial), count=3, shape=(8192, 6))[:, :, 0]
    assert r.var() == pytest.approx(0.49, rel=6 * np.sqrt(2 / r.size))
    wanted = (*serial, 0.0, 0.0)
    for lag, expected in enumerate(wanted, 1):
        seen = np.mean(r[:, lag:] * r[:, :-lag]) / r.var()
        assert seen == pytest.approx(expected, abs=6 / np.sqrt(r.size))


@pytest.mark.parametrize("share", [0.3, 1.0])
def test_even_and_odd_columns_have_rows_of_their_own_by_the_share_that_alternates(share):
    noise = RowNoise(0.7, serial=0.3, alternating=share)
    d = added(noise, count=3, shape=(8192, 4))
    five = 6 / np.sqrt(d[:, :, 0].size)
    even, odd = d[:, :, ::2].mean(axis=2), d[:, :, 1::2].mean(axis=2)
    np.testing.assert_allclose(d[:, :, 0], even, atol=1e-4)
    for r in (even, odd):
        assert r.var() == pytest.approx(0.49, rel=2 * five)
        assert np.mean(r[:, 1:] * r[:, :-1]) / 0.49 == pytest.approx(0.3, abs=2 * five)
    assert np.mean(even * odd) / 0.49 == pytest.approx(1.0 - 2.0 * share, abs=2 * five)
    assert noise.inactive_parameters() == ("serial2", "tilt")


def test_a_tilted_row_has_a_linear_change_of_its_own():
    noise, width = RowNoise(0.7, tilt=0.5), 40
    d = added(noise, count=3, shape=(4096, width))
    five = 6 / np.sqrt(3 * 4096)
    place = (np.arange(width) + 0.5) / width - 0.5
    offset, slope = d.mean(axis=2), d @ place / (place @ place)
    np.testing.assert_allclose(d, offset[..., None] + slope[..., None] * place, atol=1e-4)
    assert offset.var() == pytest.approx(0.49, rel=2 * five)
    # rms of a ramp of half a unit to either side is sqrt(1 / 12) of its slope
    assert slope.var() / 12 == pytest.approx(0.49 * 0.25, rel=2 * five)
    assert np.corrcoef(offset.ravel(), slope.ravel())[0, 1] == pytest.approx(0.0, abs=five)
    assert d.var() == pytest.approx(noise.variance(None), rel=2 * five)


@pytest.mark.parametrize(
    ("together", "alike"),
    [("2x1", (0, 0, 1, 1, 2, 2, 3, 3)), ("4x1", (0,) * 4 + (1,) * 4), ("8x1", (0,) * 8),
     ("2x2", (0, 1, 0, 1, 2, 3, 2, 3)), ("4x2", (0, 1) * 4)],
)  # fmt: skip
def test_rows_that_are_converted_together_share_an_offset(together, alike):
    r = added(RowNoise(0.7, together=together), count=3, shape=(8192, 2))[:, :, 0]
    r = r.reshape(3, -1, 8)
    five = 6 / np.sqrt(r[:, :, 0].size)
    across = np.mean(r[:, 1:, 0] * r[:, :-1, -1]) / 0.49
    assert across == pytest.approx(0.0, abs=five)
    for row in range(1, 8):
        seen = np.mean(r[:, :, 0] * r[:, :, row]) / 0.49
        if alike[row] == alike[0]:
            np.testing.assert_allclose(r[:, :, 0], r[:, :, row], atol=1e-4)
        else:
            assert seen == pytest.approx(0.0, abs=five)


def test_groups_of_rows_may_be_correlated_too():
    r = added(RowNoise(0.7, serial=0.3, together="4x1"), count=3, shape=(8192, 2))[:, ::4, 0]
    five = 6 / np.sqrt(r.size)
    assert np.mean(r[:, 1:] * r[:, :-1]) / 0.49 == pytest.approx(0.3, abs=five)
    assert np.mean(r[:, 2:] * r[:, :-2]) / 0.49 == pytest.approx(0.0, abs=five)


@pytest.mark.parametrize("together", TOGETHER)
def test_a_window_has_the_rows_of_the_whole_frame(together):
    noise = RowNoise(0.7, 0.2, 0.3, 0.4, 0.5, together)
    whole = frames(noise, count=1, shape=(64, 6))
    for window in (Window(0, 9, 0, 6), Window(1, 20, 0, 6), Window(33, 64, 2, 5)):
        part = frames(noise, count=1, shape=(64, 6), window=window)
        rows, columns = slice(window.top, window.bottom), slice(window.left, window.right)
        np.testing.assert_allclose(part, whole[:, rows, columns], atol=1e-6)


def test_forms_are_those_that_a_row_has_not_yet():
    extras = ("serial", "serial2", "alternating", "tilt")
    forms = [tuple(getattr(f, n) for n in extras) for f in RowNoise(0.3).relatives()]
    assert set(forms) == {
        (0.2, 0, 0, 0), (-0.2, 0, 0, 0), (0, 0.2, 0, 0), (0, 0, 0.3, 0), (0, 0, 0, 0.3),
    }  # fmt: skip
    assert RowNoise(0.3).inactive_parameters() == extras
    assert [f.serial2 for f in RowNoise(0.3, 0.1).relatives()] == [0, 0]  # both others, not this
    assert len(RowNoise(0.3, alternating=0.2).relatives()) == 4
    assert RowNoise(0.3, 0.1, alternating=0.2, tilt=0.1).relatives() == []
