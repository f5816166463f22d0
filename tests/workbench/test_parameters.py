"""Rows of the model's parameters, without a browser."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

pytest.importorskip("panel")

import panel as pn
from bokeh.document import Document

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.laws import TableLaw
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import built_in
from dnanalyze.workbench.page.context import Context
from dnanalyze.workbench.page.model import TABLE, Model
from dnanalyze.workbench.page.parameters import ParameterRow, TableRow
from dnanalyze.workbench.page.style import LIGHT
from dnanalyze.workbench.sliders import sliders

# Panel announces another name for the argument ``button_type``
pytestmark = pytest.mark.filterwarnings("ignore::PendingDeprecationWarning")


def pane(points: int) -> Model:
    """The pane of a model whose read noise has a number for each operating point."""
    at = tuple(OperatingPoint(25.0 + 20.0 * n, 0.1) for n in range(points))
    sigma = TableLaw(at, tuple(1.0 + n for n in range(points))) if points > 1 else 1.0
    model = NoiseModel((built_in()["read_noise"](sigma=sigma),), 64.0, at[0])
    session = SimpleNamespace(
        present=SimpleNamespace(model=model), known=built_in(), removed=(), history=object(),
        sliders=lambda: sliders(model, {}, set()),
    )  # fmt: skip
    made = Model(Context(session, LIGHT, Document()))
    made.update("history")
    return made


def texts(made: Model) -> str:
    return " ".join(str(shown.object) for shown in made.view.select(pn.pane.HTML))


def label(row: ParameterRow) -> str:
    return str(row.label.object)


@pytest.mark.parametrize("points", [2, TABLE - 1])
def test_few_operating_points_share_the_name_and_each_has_a_row(points):
    made = pane(points)
    rows = [made._rows[f"read_noise.sigma[{n}]"] for n in range(points)]
    for n, row in enumerate(rows):
        assert f"{25 + 20 * n}\u00a0°C" in label(row)
        assert "sigma" not in label(row)
        assert "DN" not in label(row).partition(">")[2]  # the unit stands in the heading
    assert texts(made).count("<b>sigma</b>") == 1
    assert f"DN at {points} operating points" in texts(made)


def test_many_operating_points_share_a_plot_and_a_row():
    made = pane(TABLE)
    table = made._tables["read_noise.sigma[]"]
    assert isinstance(table, TableRow)
    assert "read_noise.sigma[0]" not in made._rows
    assert "25\u00a0°C" in label(table.row)
    assert "sigma" not in label(table.row)


def test_one_number_keeps_its_name_and_its_unit():
    row = pane(1)._rows["read_noise.sigma"]
    assert "sigma" in label(row)
    assert "DN" in label(row).partition(">")[2]
