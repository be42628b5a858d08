"""The Python example of README.md runs as it stands, at the root of the repository."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import hysteron_models as hy
import pytest

ROOT = Path(__file__).parents[2]


def test_the_example_of_the_readme_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    example = (ROOT / "README.md").read_text(encoding="utf-8").split("```python\n")[1].split("```")[0]
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {}
    exec(example, names)
    assert len(names["drive"]) == 3 and all(names["drive"] >= 0) and all(names["drive"] <= 3.6)
    assert len(names["prediction"].lower) == 8027
    assert names["controller"].step(-100.0) <= 3.6
    assert hy.load("model.json").kind == "hammerstein"
