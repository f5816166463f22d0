"""The notebooks run from the first cell to the last, and hold the output that they show."""

import json
import warnings

import docs_tree as tree
import pytest

NOTEBOOKS = sorted((tree.DOCS / "notebooks").glob("*.ipynb"))


@pytest.mark.slow  # .ci/run runs them
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs(path):
    pytest.importorskip("nbclient", reason="needs the extra test")
    pytest.importorskip("ipykernel", reason="needs the extra test")
    with warnings.catch_warnings():  # those of the notebook's own machinery
        warnings.simplefilter("ignore")
        book = tree.script("make_notebooks").run(path)  # raises where a cell fails
    kinds = [out.output_type for cell in book.cells for out in cell.get("outputs", ())]
    assert "error" not in kinds
    pictures = [out for c in book.cells for out in c.get("outputs", ()) if "image/png" in str(out)]
    assert pictures


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_holds_its_output(path):
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    code = [cell for cell in cells if cell["cell_type"] == "code"]
    assert sum(bool(cell["outputs"]) for cell in code) > len(code) / 2
    assert path.stat().st_size < 500_000
