import json
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.report.plain import document, plain, to_json


class Kind(StrEnum):
    DPC = "dpc"


@dataclass
class Thing:
    value: float


def test_what_is_not_finite_becomes_null():
    raw = {"a": np.float32("nan"), "b": [np.inf, -np.inf, 1.5], "c": np.array([[1, 2], [3, 4]])}
    text = to_json(raw)
    assert json.loads(text) == {"a": None, "b": [None, None, 1.5], "c": [[1, 2], [3, 4]]}


def test_everything_that_results_hold_has_a_plain_form():
    raw = (Kind.DPC, Thing(np.float64(2)), Path("a/b"), OperatingPoint(25.0), {1}, True, None)
    assert plain(raw) == [
        "dpc",
        {"value": 2.0},
        "a/b",
        {"temperature_c": 25.0, "exposure_s": None, "gain": None, "channel": None},
        [1],
        True,
        None,
    ]
    with pytest.raises(TypeError):
        plain(object())


@given(st.recursive(st.floats() | st.integers() | st.text(), lambda x: st.lists(x, max_size=4)))
def test_any_numbers_make_valid_json(value):
    json.loads(to_json({"value": value}), parse_constant=pytest.fail)


def test_documents_begin_with_schema_captures_and_version():
    made = document("compare", "folder", error=1.0)
    assert list(made)[:3] == ["schema", "captures", "version"]
    assert made["schema"] == "dnanalyze/compare/1"
