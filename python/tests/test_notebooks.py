"""The notebooks of the documentation run from their first cell to their last, and give what they were kept
with."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import pytest

nbformat = pytest.importorskip("nbformat")
pytest.importorskip("nbclient")

import notebooks  # noqa: E402

PATHS = sorted(notebooks.FOLDER.glob("*.ipynb"))
#: Share by which a number may differ on another machine.
SHARE = 0.01


@pytest.mark.parametrize("path", PATHS, ids=lambda path: path.stem)
def test_a_notebook_gives_what_it_was_kept_with(path: Path) -> None:
    executed = notebooks.run(path)
    assert notebooks.differences(nbformat.read(path, 4), executed, SHARE) == []
    for cell in executed.cells:
        if cell.cell_type == "code" and "hy.plots." in cell.source:
            assert any("image/png" in output.get("data", {}) for output in cell.outputs), cell.source


@pytest.mark.parametrize("path", PATHS, ids=lambda path: path.stem)
def test_a_notebook_is_kept_small_and_without_its_machine(path: Path) -> None:
    assert path.stat().st_size < 400_000
    cells = [cell for cell in nbformat.read(path, 4).cells if cell.cell_type == "code"]
    assert all(cell.execution_count for cell in cells)
    assert any("image/png" in output.get("data", {}) for cell in cells for output in cell.outputs)
    said = "".join(text for cell in cells for text in notebooks.texts(cell))
    for folder in (str(Path.home()), "/tmp/", str(notebooks.FOLDER.parents[1]), "site-packages"):
        assert folder == "/" or folder not in said, folder


def _kept(text: str) -> Any:
    cell = nbformat.v4.new_code_cell("print(fit)", outputs=[nbformat.v4.new_output("stream", text=text)])
    return nbformat.v4.new_notebook(cells=[cell])


def test_another_number_another_word_and_a_missing_line_are_told() -> None:
    kept = _kept("fit 98.6 %\nstart: rest\n")
    assert notebooks.differences(kept, copy.deepcopy(kept), 0.0) == []
    assert notebooks.differences(kept, _kept("fit  98.7 %\nstart: rest\n"), SHARE) == []
    for other in (
        "fit 90.6 %\nstart: rest\n",
        "fit 98.6 %\nstart: settled\n",
        "fit 98.6 %\n",
        "fit -98.6 %\nstart: rest\n",
    ):
        assert notebooks.differences(kept, _kept(other), SHARE), other
