"""The paper's figures, small: what they show, and the closed form that one of them draws."""

import importlib.util
import math

import docs_tree as tree
import numpy as np
import pytest


@pytest.fixture
def figures(monkeypatch):
    path = tree.ROOT / "benchmarks" / "paper_figures.py"
    spec = importlib.util.spec_from_file_location("paper_figures", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    monkeypatch.setattr(module, "SHAPE", (128, 128))
    monkeypatch.setattr(module, "FRAMES", 2)
    monkeypatch.setattr(module, "TEMPERATURES", (25.0, 85.0))
    return module


def test_each_figure_is_drawn_and_saved(figures, tmp_path):
    for make, panels in (
        (figures.correction, 5),
        (figures.over_temperature, 3),
        (figures.model, 4),
    ):
        figure = make()
        assert len([a for a in figure.axes if a.get_label() != "<colorbar>"]) == panels
        figure.savefig(tmp_path / "figure.png", dpi=40)
        assert (tmp_path / "figure.png").stat().st_size > 5000


def test_dpc_alone_takes_high_frequencies_from_warm_frames(figures):
    """The ratio of an unfiltered frame is 1 within 5 sigma of its sampling error."""
    modes = 128 * 128 * 0.5 * math.pi * (figures.MID[1] ** 2 - figures.MID[0] ** 2)
    error = math.sqrt(
        1 / modes
    )  # the middle band has by far the fewest modes; both part and frames repeat
    ratios = {}
    for label in ("correction off", "DPC on"):
        filtered, _ = figures.KINDS[label]
        made = figures.generate(
            figures.SENSOR, figures.HOT | filtered, (128, 128), (25.0, 85.0), 2, 3
        )
        ratios[label] = [figures._ratio(c) for c in figures._radial(made)]
    np.testing.assert_allclose(ratios["correction off"], 1.0, atol=5 * error)
    assert ratios["DPC on"][0] == pytest.approx(1.0, abs=5 * error)
    assert ratios["DPC on"][1] < 0.8


def test_closed_form_is_a_plateau_at_low_frequency(figures):
    mu, delta, phi, sigma = 1.0, 0.6, 0.05, 0.02
    low, lower = figures._closed_form(mu, delta, phi, sigma, np.array([0.01, 0.001]))
    q, square = math.exp(delta**2), math.exp(2 * mu + delta**2)
    plateau = square * (q - 1) + 9 * sigma**2 * square * q
    assert lower == pytest.approx(plateau, rel=1e-4)
    assert low == pytest.approx(plateau, rel=0.01)
