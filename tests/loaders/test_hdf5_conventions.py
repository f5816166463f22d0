"""NeXus, data exchange and photon counters: which datasets are frames, masks and metadata."""

import h5py
import numpy as np
import pytest

from dnanalyze import OperatingPoint
from dnanalyze.errors import InputError
from dnanalyze.loaders import load
from dnanalyze.loaders.captures import Window

SHAPE = (32, 40)


def stack(level, count=4, seed=0, dtype=np.uint16):
    rng = np.random.default_rng(seed)
    pattern = rng.normal(0, 3, SHAPE)
    return np.rint(level + pattern + rng.normal(0, 3, (count, *SHAPE))).astype(dtype)


def written(path, content, attributes=()):
    with h5py.File(path, "w") as file:
        for name, values in content.items():
            file[name] = values
        for name, key, value in attributes:
            file[name].attrs[key] = value
    return path


def test_data_exchange_has_its_dark_frames(tmp_path):
    file = written(
        tmp_path / "scan.h5",
        {
            "exchange/data": stack(3000, 6),
            "exchange/data_dark": stack(100, seed=1),
            "exchange/data_white": stack(8000, seed=2),
            "measurement/instrument/detector/exposure_time": 100.0,
        },
        [("measurement/instrument/detector/exposure_time", "units", "ms")],
    )
    captures = load(file)
    assert captures.frame_count == 4
    assert captures.settings[0].point == OperatingPoint(exposure_s=0.1)
    (note,) = captures.notes
    assert note.startswith("Taken as dark frames: exchange/data_dark; left out: exchange/data, ")
    np.testing.assert_array_equal(captures.settings[0].frames[2].read(), stack(100, seed=1)[2])


@pytest.mark.parametrize(("code", "dtype"), [(2**32 - 1, "u4"), (0, "u4"), (0, "?"), (0, "i1")])
def test_a_photon_counter_has_its_mask(tmp_path, code, dtype):
    data = np.random.default_rng(0).poisson(30, (6, *SHAPE)).astype(np.uint32)
    mask = np.zeros(SHAPE, np.uint32)
    mask[10:14] = 1
    data[:, mask > 0] = code
    file = written(
        tmp_path / "dark_000001.h5",
        {
            "entry/data/data": data,
            "entry/instrument/detector/detectorSpecific/pixel_mask": mask.astype(dtype),
            "entry/instrument/detector/count_time": 0.5,
            "entry/sample/temperature": 80.0,
        },
    )
    captures = load(file)
    assert captures.sensor.shape == (28, 40)
    assert captures.settings[0].point == OperatingPoint(exposure_s=0.5)
    frame = captures.settings[0].frames[1].read()
    np.testing.assert_array_equal(frame, data[1][mask[:, 0] == 0])


def test_gaps_without_a_mask_are_told(tmp_path):
    data = np.random.default_rng(0).poisson(30, (6, *SHAPE)).astype(np.uint32)
    data[:, 10:14] = 2**32 - 1
    captures = load(written(tmp_path / "dark.h5", {"entry/data/data": data}))
    assert captures.sensor.shape == (28, 40)
    assert captures.notes[0].startswith("No mask is stored; pixels at the largest value of uint32")


def test_groups_are_operating_points(tmp_path):
    content = {}
    for k, celsius in enumerate((20.0, 40.0)):
        content |= {
            f"point{k}/data": stack(100 + k, seed=k),
            f"point{k}/temperature": celsius,
            f"point{k}/detector/exposure_time": 0.1 * (k + 1),
        }
    captures = load(written(tmp_path / "all.h5", content | {"gain": 2.0}))
    assert [s.point for s in captures.settings] == [
        OperatingPoint(20.0, 0.1, 2.0),
        OperatingPoint(40.0, 0.2, 2.0),
    ]


def last(frames):
    return np.ascontiguousarray(np.moveaxis(frames, 0, -1))


@pytest.mark.parametrize("suffix", [".npy", ".npz", ".h5"])
@pytest.mark.parametrize("turned", [True, False])
def test_frames_last_are_told_by_their_likeness(tmp_path, suffix, turned):
    frames = stack(100, 12) if turned else stack(100, 60)[:, :, :20]
    values = last(frames) if turned else np.ascontiguousarray(frames)
    path = tmp_path / f"dark_20C_1s{suffix}"
    if suffix == ".npy":
        np.save(path, values)
    elif suffix == ".npz":
        np.savez_compressed(path, temperature_c=20.0, frames=values)
    else:
        written(path, {"data": values})
    captures = load(path)
    assert captures.frame_count == len(frames)
    assert any("The last axis counts the frames" in n for n in captures.notes) == turned
    found = [f.read() for f in captures.settings[0].frames]
    np.testing.assert_array_equal(found, frames)


def test_a_stack_whose_order_is_not_told_is_asked_for(tmp_path):
    values = np.random.default_rng(0).normal(100, 3, (40, 48, 16)).astype(np.float32)
    np.save(tmp_path / "dark.npy", values)
    with pytest.raises(InputError, match="set frame_axis: first or last in the sidecar"):
        load(tmp_path)
    for axis, count in (("first", 40), ("last", 16)):
        (tmp_path / "dnanalyze.yaml").write_text(f"frame_axis: {axis}\n")
        assert load(tmp_path).frame_count == count


def test_names_in_an_archive_mean_what_they_mean_in_hdf5(tmp_path):
    mask = np.zeros(SHAPE, bool)
    mask[:, 5] = True
    dark = stack(100, 4)
    np.savez(tmp_path / "a.npz", dark=dark, flat=stack(900, 4), bad_pixels=mask, exposure_s=0.5)
    captures = load(tmp_path)
    assert captures.settings[0].point == OperatingPoint(exposure_s=0.5)
    assert captures.notes[0] == "Taken as dark frames: dark; left out: flat."
    assert captures.frame_count == 4
    np.testing.assert_array_equal(
        captures.settings[0].frames[2].read(), np.delete(dark[2], 5, axis=1)
    )


@pytest.mark.parametrize("chunks", [(8, *SHAPE), (1, *SHAPE), (1, 2, 40), None])
def test_large_chunks_are_decoded_once_for_a_frame(tmp_path, chunks):
    frames = stack(100, 8)
    with h5py.File(tmp_path / "a.h5", "w") as file:
        packing = {"compression": "gzip"} if chunks else {}
        file.create_dataset("data", data=frames, chunks=chunks, **packing)
    captures = load(tmp_path)
    read = captures.settings[0].frames[3].load
    assert read.partial == (chunks in (None, (1, 2, 40)))
    np.testing.assert_array_equal(read(), frames[3])
    np.testing.assert_array_equal(read(Window(3, 9, 4, 20)), frames[3, 3:9, 4:20])


def test_a_hostile_stack_with_the_frames_last_is_refused_before_it_is_read(tmp_path):
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file.create_dataset("data", (300_000, 200_000, 1000), "u2", chunks=(512, 512, 8))
    with pytest.raises(InputError, match="hold no noise"):
        load(tmp_path)
