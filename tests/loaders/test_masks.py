"""Masked pixels are in no statistic, whoever masks them."""

import h5py
import numpy as np
import pytest
from astropy.io import fits
from PIL import Image

from dnanalyze import analyze
from dnanalyze.errors import InputError
from dnanalyze.loaders import load
from dnanalyze.loaders.masks import LEAST_PLACED, gaps_of, make_mask, read_mask

SHAPE = (128, 160)


@pytest.fixture(scope="module")
def frames():
    rng = np.random.default_rng(5)
    pattern = rng.normal(0, 2, SHAPE) + rng.normal(0, 1, SHAPE[1])
    blur = rng.normal(0, 3, (8, *SHAPE))
    noise = blur + 0.3 * np.roll(blur, 1, 2) + rng.normal(0, 0.5, (8, SHAPE[0], 1))
    return np.rint(200 + pattern + noise).astype(np.uint16)


def saved(folder, frames):
    folder.mkdir(exist_ok=True)
    for k, frame in enumerate(frames):
        np.save(folder / f"dark_20C_1s_{k}.npy", frame)
    return folder


def gaps():
    masked = np.zeros(SHAPE, bool)
    masked[40:48] = masked[:, 100:103] = True
    return masked


def dots(share):
    return np.random.default_rng(6).random(SHAPE) < share


def spoiled(frames, masked):
    out = frames.copy()
    out[:, masked] = np.random.default_rng(7).integers(0, 65535, (len(out), int(masked.sum())))
    return out


def test_gaps_are_in_no_statistic(tmp_path, frames):
    masked = gaps()
    own = load(saved(tmp_path / "a", spoiled(frames, masked)), mask=masked)
    assert own.sensor.shape == (120, 157)
    assert own.sensor.filled == 0
    assert own.notes == (
        "Masked by mask: 8 rows, 3 columns. Rows and columns that are masked are taken out.",
    )
    cut = frames[:, ~masked[:, 0]][:, :, ~masked[0]]
    theirs = analyze(load(saved(tmp_path / "b", cut))).settings[0]
    assert analyze(own).settings[0].values == theirs.values


@pytest.mark.parametrize("share", [5e-4, 0.05])
def test_single_pixels_are_in_no_statistic(tmp_path, frames, share):
    masked = dots(share)
    captures = load(saved(tmp_path / "a", spoiled(frames, masked)), mask=masked)
    found = analyze(captures).settings[0]
    stack = np.ma.masked_array(frames.astype(float), np.broadcast_to(masked, frames.shape))
    variance = stack.var(axis=0, ddof=1).mean()
    pattern = stack.mean(axis=0)
    inner = stack - stack.mean(axis=(1, 2), keepdims=True)
    still = inner.var(axis=0, ddof=1).mean()
    # a filled pixel stands for one that is masked: the mean over n pixels has a spread of sqrt(f/n)
    near = np.sqrt(share / masked.size)
    assert found.values["mean"].value == pytest.approx(stack.mean(), abs=10 * near)
    assert found.values["temporal_noise"].value == pytest.approx(np.sqrt(variance), rel=4 * near)
    assert found.values["s2_temporal"].value == pytest.approx(still, rel=8 * near)
    dsnu = np.sqrt(pattern.var() - still / len(frames))
    assert found.values["dsnu_1288"].value == pytest.approx(dsnu, rel=10 * near)
    assert found.values["frame_q0.99"].value == pytest.approx(
        np.quantile(stack.compressed(), 0.99) - np.median(stack.compressed()), abs=0.6
    )


def test_few_single_pixels_change_places_by_less_than_their_error(tmp_path, frames):
    masked = dots(5e-4)
    assert 0 < masked.mean() < LEAST_PLACED
    found = analyze(load(saved(tmp_path / "a", spoiled(frames, masked)), mask=masked)).settings[0]
    whole = analyze(load(saved(tmp_path / "b", frames))).settings[0]
    for name in (
        "temporal_corr_10",
        "temporal_row_mean_sd",
        "temporal_psd_0.35_0.5",
        "dsnu_1288_col",
    ):
        one, other = found.values[name], whole.values[name]
        assert one.value == pytest.approx(other.value, abs=max(other.se, 2e-3 * other.value)), name


def test_many_single_pixels_leave_no_statistic_of_places(tmp_path, frames):
    masked = dots(0.02)
    captures = load(saved(tmp_path / "a", spoiled(frames, masked)), mask=masked)
    assert "Neighbours, lines, spectra and shading are not measured." in captures.notes[0]
    found = analyze(captures).settings[0]
    assert not [n for n in found.values if "psd" in n or "_corr_" in n or "row_mean" in n]
    assert "of the pixels are masked" in found.missing["temporal_corr_10"]


def test_a_mosaic_keeps_its_colours(tmp_path, frames):
    masked = gaps() | dots(0.01)
    left = make_mask(masked, "x", 2)
    assert left.shape == (120, 156)
    rows, columns = np.divmod(left.targets, left.shape[1])
    from_rows, from_columns = np.divmod(left.sources, left.shape[1])
    np.testing.assert_array_equal(rows, from_rows)
    assert not ((columns - from_columns) % 2).any()
    assert not np.isin(left.sources, left.targets).any()


def test_a_mask_that_leaves_too_little_is_refused():
    with pytest.raises(InputError, match="too few in too few rows"):
        make_mask(np.ones(SHAPE, bool), "x")
    with pytest.raises(InputError, match="mask less than 20 %"):
        make_mask(dots(0.3), "x")


@pytest.mark.parametrize("suffix", [".npy", ".fits", ".h5", ".png", ".tif"])
def test_masks_of_every_format(tmp_path, suffix):
    masked, path = gaps(), tmp_path / f"mask{suffix}"
    if suffix == ".npy":
        np.save(path, masked)
    elif suffix == ".fits":
        fits.writeto(path, masked.astype(np.uint8))
    elif suffix == ".h5":
        with h5py.File(path, "w") as file:
            file["a/pixel_mask"] = masked.astype(np.uint32) * 8
            file["a/flatfield"] = np.ones(SHAPE)
    else:
        Image.fromarray(masked.astype(np.uint8) * 255).save(path)
    np.testing.assert_array_equal(read_mask(path), masked)


def test_a_mask_that_is_none_is_refused(tmp_path, frames):
    for name, text in (("a.npy", b"x"), ("b.txt", b"x"), ("c.fits", b"")):
        (tmp_path / name).write_bytes(text)
        with pytest.raises(InputError, match="mask"):
            read_mask(tmp_path / name)
    with pytest.raises(InputError, match="give a mask of the shape of the frames"):
        load(saved(tmp_path / "f", frames), mask=np.zeros((3, 3)))


def test_codes_of_gaps():
    counts = np.random.default_rng(0).poisson(3, (32, 32))
    for dtype, code in ((np.uint32, 2**32 - 1), (np.int32, -1), (np.uint16, 65535)):
        frame = counts.astype(dtype)
        assert gaps_of(frame) is None
        frame[10:14] = code
        np.testing.assert_array_equal(np.flatnonzero(gaps_of(frame).all(axis=1)), range(10, 14))
    frame = counts.astype(np.uint16)
    frame[5, 5] = frame[:, 9] = 65535
    assert gaps_of(frame) is None  # a saturated pixel and a saturated column
    assert gaps_of((counts - 100).astype(np.int32)) is None


def test_a_mask_beside_the_frames_is_told_by_name_and_content(tmp_path, frames):
    folder = saved(tmp_path / "a", frames)
    np.save(folder / "bad_pixels.npy", gaps().astype(np.uint16))
    np.save(folder / "dark_20C_1s_mask.npy", frames[0] + 1)  # a frame, whatever its name
    captures = load(folder, keep_outliers=True)
    assert captures.frame_count == 9
    assert captures.notes[0].startswith("Masked by ")
    assert "bad_pixels.npy: 8 rows, 3 columns." in captures.notes[0]
    dark = saved(tmp_path / "b", frames)
    fits.HDUList([fits.PrimaryHDU(), fits.ImageHDU(gaps().astype(np.uint8), name="BPM")]).writeto(
        dark / "bpm.fits"
    )
    assert load(dark).sensor.shape == (120, 157)


def test_one_mask_for_each_frame_of_a_stack(tmp_path, frames):
    masked = np.zeros(frames.shape, np.uint8)
    masked[0, 40:48] = masked[1, :, 100:103] = 1
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["data"], file["pixel_mask"] = frames, masked
    assert load(tmp_path).sensor.shape == (120, 157)
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["data"], file["pixel_mask"] = frames, masked[:, :9]
    assert "pixel_mask has the shape" in load(tmp_path).notes[0]
