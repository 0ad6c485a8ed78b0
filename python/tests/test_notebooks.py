"""The notebooks, executed."""

import pathlib

import pytest

pytest.importorskip("matplotlib")
pytest.importorskip("ipykernel")
nbformat = pytest.importorskip("nbformat")
nbclient = pytest.importorskip("nbclient")

FOLDER = pathlib.Path(__file__).parent.parent / "notebooks"
NAMES = ["paper_example", "own_mechanism", "identification", "robot"]

WARNINGS_FAIL = "import hamiltonian_adjoint, warnings; warnings.simplefilter('error', hamiltonian_adjoint.MotionWarning)"


def test_no_notebook_is_forgotten():
    assert sorted(NAMES) == sorted(path.stem for path in FOLDER.glob("*.ipynb"))


@pytest.mark.parametrize("name", NAMES)
def test_a_notebook(name):
    notebook = nbformat.read(FOLDER / f"{name}.ipynb", as_version=4)
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert not any(cell.outputs or cell.execution_count for cell in cells), "notebooks are stored without outputs"
    notebook.cells.insert(0, nbformat.v4.new_code_cell(WARNINGS_FAIL))
    nbclient.NotebookClient(notebook, timeout=120, resources={"metadata": {"path": str(FOLDER)}}).execute()
    assert sum("image/svg+xml" in output.get("data", {}) for cell in cells for output in cell.outputs) >= 2
