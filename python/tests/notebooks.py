"""Runs the notebooks of the documentation; `python python/tests/notebooks.py [NAME…]` keeps their outputs."""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path
from typing import Any

import nbclient
import nbformat

FOLDER = Path(__file__).parents[2] / "docs/notebooks"
NUMBER = re.compile(r"[-−+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def run(path: Path) -> Any:
    """The notebook, executed in its folder from its first cell to its last."""
    os.environ.pop("MPLBACKEND", None)
    notebook = nbformat.read(path, 4)
    where = {"metadata": {"path": str(FOLDER)}}
    client = nbclient.NotebookClient(
        notebook,
        timeout=600,
        kernel_name="python3",
        resources=where,
        record_timing=False,
        coalesce_streams=True,
    )
    client.execute()
    return notebook


def texts(cell: Any) -> list[str]:
    """What a cell printed, and its result as text; not what stands for a picture."""
    found = []
    for output in cell.get("outputs", []):
        data = output.get("data", {})
        if "image/png" not in data:
            found.append(output.get("text", "") or data.get("text/plain", ""))
    return found


def differences(kept: Any, executed: Any, share: float) -> list[str]:
    """Lines of text that differ: in words, or in a number by more than a share of it."""
    found = []
    for old, new in zip(kept.cells, executed.cells, strict=True):
        before, after = ("".join(texts(cell)).splitlines() for cell in (old, new))
        if len(before) != len(after):
            found.append(f"{len(before)} lines became {len(after)}:\n{old.source}")
            continue
        found += [f"{a!r} became {b!r}" for a, b in zip(before, after, strict=True) if not _same(a, b, share)]
    return found


def _same(a: str, b: str, share: float) -> bool:
    words = [" ".join(NUMBER.sub("#", line).split()) for line in (a, b)]
    if words[0] != words[1]:
        return False
    numbers = ([float(n.replace("−", "-")) for n in NUMBER.findall(line)] for line in (a, b))
    return all(abs(x - y) <= share * max(abs(x), abs(y)) for x, y in zip(*numbers, strict=True))


def keep(path: Path) -> None:
    """Run a notebook and write it with its outputs, without what changes from run to run or tells of the
    machine."""
    notebook = run(path)
    notebook.metadata.pop("language_info", None)
    for number, cell in enumerate(notebook.cells):
        cell.id = f"cell-{number}"
        kept = {key: cell.metadata[key] for key in ("tags",) if key in cell.metadata}
        cell.metadata = nbformat.from_dict(kept)
    beside = path.with_suffix(".tmp")
    nbformat.write(notebook, beside)
    beside.replace(path)
    print(f"{path.name}: {path.stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    for name in sys.argv[1:] or sorted(path.stem for path in FOLDER.glob("*.ipynb")):
        keep(FOLDER / f"{name}.ipynb")
