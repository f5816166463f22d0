"""Run the notebooks in place and keep their output: ``python docs/make_notebooks.py``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

FOLDER = Path(__file__).resolve().parent / "notebooks"
LIMIT_S = 600  # a cell; a whole notebook takes less than a minute on two free cores


def main() -> None:
    """Run all notebooks."""
    import nbformat

    for path in sorted(FOLDER.glob("*.ipynb")):
        nbformat.write(run(path), path)
        print(f"written: {path}")


def run(path: Path) -> Any:
    """The notebook with the output of its cells; raises where a cell fails."""
    import nbformat
    from nbclient import NotebookClient

    book = nbformat.read(path, as_version=4)
    client = NotebookClient(
        book, timeout=LIMIT_S, kernel_name="python3", resources={"metadata": {"path": FOLDER}}
    )
    client.execute()
    for cell in book.cells:
        cell.metadata.pop("execution", None)  # times of the run
    return book


if __name__ == "__main__":
    main()
