"""What a statistic's misfit says in words: every template is filled in."""

import pytest

from dnanalyze.analyzers.catalogue import catalogue
from dnanalyze.comparator.words import listed, misfit, sentence, short_labels
from dnanalyze.loaders.captures import OperatingPoint


@pytest.mark.parametrize(
    ("measured", "simulated"), [(2.0, 1.0), (0.5, 1.0), (0.0, 1.0), (1.0, 0.0)]
)
def test_no_template_stays_open(measured, simulated):
    for info in catalogue().values():
        words = misfit(info, measured, simulated, measured - simulated)
        assert words
        assert "{" not in words, info.name


def test_what_the_model_does_not_determine_is_neither_more_nor_less():
    words = misfit(catalogue()["hot_halo"], -0.013, float("nan"), 6.0)
    assert "not determined in the frames of the model" in words
    assert "more" not in words


def test_ratio_and_difference_are_said():
    known = catalogue()
    assert "is 2.5 times the model's" in misfit(known["temporal_noise"], 2.5, 1.0, 9.0)
    assert "is 1.5 DN above the model's" in misfit(known["mean"], 65.5, 64.0, 9.0)
    assert "is 0.5 DN below the model's" in misfit(known["mean"], 63.5, 64.0, -9.0)


def test_a_sentence_has_size_and_place():
    row = {
        "measured": 65.5, "simulated": 64.0, "discrepancy": 12.0, "unit": "DN", "scale": "linear",
        "channel": None, "temperature_c": 25.0, "exposure_s": None,
    }  # fmt: skip
    said = sentence("mean", [row])
    assert "1.5 DN above" in said
    assert "12 sigma" in said
    assert "25 °C" in said


def test_a_place_where_the_statistic_lies_on_the_other_side_is_not_named():
    row = {
        "measured": 65.5, "simulated": 64.0, "unit": "DN", "scale": "linear", "channel": None,
        "exposure_s": None,
    }  # fmt: skip
    z = {25.0: 12.0, 45.0: -9.0, 65.0: 7.0}
    said = sentence("mean", [row | {"temperature_c": t, "discrepancy": z[t]} for t in z])
    assert said.endswith("at 25 °C, 65 °C")


def test_places_are_told_by_what_differs():
    series = [OperatingPoint(t, 0.05, 1.0) for t in (25.0, 45.0)]
    assert short_labels(series) == ["25 °C", "45 °C"]
    assert short_labels(series[:1]) == ["25 °C, 0.05 s, gain 1"]
    grid = [OperatingPoint(t, e) for t in (25.0, 45.0) for e in (0.1, 1.0)]
    assert listed(short_labels(grid)[:2]) == "25 °C, 0.1 s; 25 °C, 1 s"


def test_no_ratio_to_a_number_that_may_be_zero():
    """As 40 hot pixels against 2.2e-16, and against 1, whose error is 1."""
    known = catalogue()["hot_count_8"]
    assert (
        misfit(known, 40.0, 2.2e-16, 9.0) == f"{known.title}: 40 pixels measured, none in the model"
    )
    assert "40 pixels measured, 1 pixel in the model" in misfit(known, 40.0, 1.0, 9.0, 1.4)
    assert "is 1.6 times" not in misfit(known, 40.0, 25.0, 3.0, 1.4)
    assert misfit(known, 40.0, 25.0, 3.0, 1.4).startswith("1.6 times as many")
    assert "none measured, 33 pixels in the model" in misfit(known, 0.0, 33.0, -9.0, 1.4)
    row = {
        "measured": 40.0, "simulated": 2.2e-16, "discrepancy": 9.0, "floor": 1.4, "unit": "pixels",
        "scale": "root", "channel": None, "temperature_c": 25.0, "exposure_s": None,
    }  # fmt: skip
    said = sentence("hot_count_8", [row])
    assert said.endswith("40 pixels measured, none in the model (9 sigma) at 25 °C")


def test_thousands_are_written_out():
    known = catalogue()
    assert "1,230 DN above" in misfit(known["mean"], 1300.0, 65.4, 9.0)
    assert "is 1,200 times" in misfit(known["temporal_noise"], 1200.0, 1.0, 9.0)
