"""The same record in every format: the same samples, and the same model."""

from __future__ import annotations

from pathlib import Path

import hysteron_models as hy
import numpy as np
import pytest


def _write(record: hy.Record, path: Path) -> None:
    t, u, y = record.t, record.u, record.y
    columns = {"t_s": t, "u_V": u, "y_um": y}
    if path.suffix in (".csv", ".npz") or path.stem == "own":
        record.save(path)
    elif path.suffix == ".mat":
        scipy_io = pytest.importorskip("scipy.io")
        scipy_io.savemat(path, {"run": columns, "note": "text"}, do_compression=True)
    elif path.suffix == ".h5":
        h5py = pytest.importorskip("h5py")
        with h5py.File(path, "w") as file:
            for name, values in columns.items():
                file.create_dataset(f"run/{name}", data=values, compression="gzip", chunks=(100,))
    elif path.suffix == ".tdms":
        nptdms = pytest.importorskip("nptdms")
        with nptdms.TdmsWriter(path) as writer:
            writer.write_segment([nptdms.ChannelObject("run", n, values) for n, values in columns.items()])
    elif path.suffix == ".xlsx":
        openpyxl = pytest.importorskip("openpyxl")
        book = openpyxl.Workbook()
        book.active.append(list(columns))
        for row in zip(*(values.tolist() for values in columns.values()), strict=True):
            book.active.append(row)
        book.save(path)


@pytest.mark.parametrize("name", ["r.csv", "r.npz", "own.mat", "r.mat", "r.h5", "r.tdms", "r.xlsx"])
def test_a_format_gives_the_same_model(loops: hy.Record, tmp_path: Path, name: str) -> None:
    _write(loops, tmp_path / name)
    record = hy.read(tmp_path / name)
    assert record.fs == 500
    if name == "r.xlsx":
        # openpyxl writes 16 digits.
        assert np.allclose(record.u, loops.u, rtol=1e-15, atol=0) and np.allclose(
            record.y, loops.y, rtol=1e-15
        )
        return
    assert np.array_equal(record.u, loops.u) and np.array_equal(record.y, loops.y)
    fits = [hy.Hammerstein("prandtl-ishlinskii", "none", elements=4).fit(r) for r in (loops, record)]
    assert fits[0].result_["parameters"] == fits[1].result_["parameters"]


def test_what_a_file_holds_is_listed_and_chosen_by_path(loops: hy.Record, tmp_path: Path) -> None:
    scipy_io = pytest.importorskip("scipy.io")
    path = tmp_path / "runs.mat"
    signals = np.zeros(2, dtype=[("u", object), ("y", object)])
    for k in range(2):
        signals[k] = (loops.u[k:], loops.y[k:])
    scipy_io.savemat(path, {"signals": signals, "fs": 500.0, "who": "me"})
    held = {content.path: content for content in hy.contents(path)}
    assert held["signals(2).u"].shape == (1, len(loops) - 1) and held["who"].kind == "text"
    with pytest.raises(hy.FileError, match=r"signals\(2\)\.y"):
        hy.read(path)
    record = hy.read(path, input="signals(2).u", output="signals(2).y")
    assert np.array_equal(record.u, loops.u[1:]) and record.fs == 500
