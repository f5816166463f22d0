"""Maps in files: read, named with a checksum, refused where they are no maps."""

import numpy as np
import pytest

from dnanalyze.errors import InputError
from dnanalyze.model.learned.field_map import FieldMap, map_bytes, read_map

RAMP = np.arange(24.0, dtype=np.float32).reshape(4, 6)


def test_a_map_comes_back_from_its_file(tmp_path):
    path = tmp_path / "map.npy"
    path.write_bytes(map_bytes(FieldMap(RAMP)))
    found = read_map(path)
    assert np.array_equal(found.array, RAMP)
    assert found == FieldMap(RAMP)
    assert hash(found) == hash(FieldMap(RAMP))
    assert FieldMap.from_plain(found.to_plain()) == found


def test_another_map_in_the_file_is_refused(tmp_path):
    path = tmp_path / "map.npy"
    path.write_bytes(map_bytes(FieldMap(RAMP)))
    plain = read_map(path).to_plain()
    path.write_bytes(map_bytes(FieldMap(RAMP + 1)))
    with pytest.raises(InputError, match="not the map that the model was written with"):
        FieldMap.from_plain(plain)


@pytest.mark.parametrize(
    "array",
    [RAMP[0], RAMP.astype(int), RAMP * np.float32(np.nan), RAMP + np.float32(1e7), RAMP[:0]],
)
def test_what_is_no_map_is_refused(tmp_path, array):
    path = tmp_path / "map.npy"
    np.save(path, array)
    with pytest.raises(InputError, match="map "):
        read_map(path)


def test_objects_text_and_missing_files_are_refused(tmp_path):
    objects = tmp_path / "objects.npy"
    np.save(objects, np.array([[{}]], object), allow_pickle=True)
    text = tmp_path / "text.npy"
    text.write_text("no numbers")
    cut = tmp_path / "cut.npy"
    cut.write_bytes(map_bytes(FieldMap(RAMP))[:90])
    for path in (objects, text, cut, tmp_path / "missing.npy", tmp_path):
        with pytest.raises(InputError, match="map "):
            read_map(path)


@pytest.mark.parametrize("raw", [None, "map.npy", {}, {"file": 3}, {"file": "a.npy", "size": 3}])
def test_what_names_no_map_is_refused(raw):
    with pytest.raises(InputError, match="map"):
        FieldMap.from_plain(raw)


def test_a_map_cannot_be_changed():
    with pytest.raises(ValueError, match="read-only"):
        FieldMap(RAMP.copy()).array[0, 0] = 1.0
