"""The lines of docs/from-matlab.md run as they stand, at the root of the repository."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib as mpl
import pytest

ROOT = Path(__file__).parents[2]


def _run(block: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    page = (ROOT / "docs/from-matlab.md").read_text(encoding="utf-8")
    lines = page.split("```python\n")[1 + block].split("```")[0]
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    monkeypatch.chdir(tmp_path)
    mpl.use("Agg")
    names: dict[str, Any] = {}
    exec(lines, names)
    return names


def test_our_session_has_the_figures_of_the_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    names = _run(0, tmp_path, monkeypatch)
    assert f"{names['score'].fit_percent:.2f} %" == "98.98 %"
    assert {"stage.m", "stage_inverse.m", "stage_parameters.m"} <= set(names["files"])


@pytest.mark.filterwarnings("ignore")
def test_the_session_of_sysidentpy_has_the_figures_of_the_page(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("sysidentpy")
    names = _run(1, tmp_path, monkeypatch)
    error = names["root_relative_squared_error"](names["y"][4000:], names["free"])
    assert f"{100 * (1 - error):.2f} %" == "96.47 %"


@pytest.mark.filterwarnings("ignore")
def test_the_session_with_python_control_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("control")
    names = _run(2, tmp_path, monkeypatch)
    assert names["block"].dt == 1 / 2000 and names["margin"] > 1
    assert abs(names["step"].outputs[-1] - 1) < 0.05
