"""What a description prints, tabulates, draws and writes."""

import json
import math

import matplotlib.pyplot as plt
import numpy as np
import pytest
from made_description import EFFECT, description

import dnanalyze
from dnanalyze.errors import InputError
from dnanalyze.model.noise_model import NoiseModel, load_model
from dnanalyze.model.registry import catalogue
from dnanalyze.model.simulator import Simulator


def test_summary_document_table_and_figure():
    found = description()
    text = found.summary()
    assert "Fixed rings" in text
    assert "periodic_pattern" in text
    assert max(map(len, text.splitlines())) <= 80
    plain = found.to_dict()
    assert plain["schema"] == "dnanalyze/describe/1"
    assert plain["composite"]["where"] == "rings"
    assert plain["nearest"][0]["effect"] == "periodic_pattern"
    json.dumps(plain, allow_nan=False)
    assert list(found.to_dataframe()["name"]) == ["period"]
    assert len(found.plot()) == 3
    plt.close("all")
    assert "Fixed rings" in found._repr_html_()
    assert repr(found).startswith("<Description: folder, described")


def test_the_headline_says_what_the_structure_does():
    from dnanalyze.report.words import describe_headline

    assert "model error falls from 2.1 to 0.9" in describe_headline(description())
    assert describe_headline(description(verdict="possible")).startswith("Possible, not supported")


def test_the_written_file_draws_the_frames_of_the_model(tmp_path):
    found = description()
    found.save(tmp_path / "m.yaml")
    (tmp_path / "own.py").write_text(found.source())
    point = dnanalyze.OperatingPoint(25.0, 1.0, 1.0)
    drawn = [
        Simulator(load_model(tmp_path / "m.yaml", known), (40, 44)).frame(point, 1)
        for known in (None, catalogue((tmp_path / "own.py",)))
    ]
    np.testing.assert_array_equal(*drawn)


def test_nothing_is_written_of_nothing():
    from dataclasses import replace

    nothing = replace(description(), effect=None, model=NoiseModel(()), error_after=math.nan)
    with pytest.raises(InputError, match="there is no structure"):
        nothing.source()
    assert nothing.to_dict()["error_after"] is None


def test_a_model_with_a_composite_effect_is_refused():
    from dnanalyze.demo import tiny

    with pytest.raises(InputError, match="it already has the effect 'composite'"):
        dnanalyze.describe(tiny(), NoiseModel((EFFECT,), 64.0))


def test_an_effect_of_the_catalogue_that_explains_as_much_is_preferred():
    from dnanalyze.description.nearest import Nearest, as_good

    near = [Nearest("cfa_mismatch", 0.91, ""), Nearest("column_taps", math.nan, "")]
    assert as_good(near, 0.9) == "cfa_mismatch"
    assert as_good(near, 0.7) is None
    assert as_good([], 0.9) is None
