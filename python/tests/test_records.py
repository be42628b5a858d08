"""Records: arrays of any kind, files, errors that name the place."""

from __future__ import annotations

import pickle
from pathlib import Path

import hysteron_models as hy
import numpy as np
import pandas as pd
import pytest


def test_arrays_of_any_kind_are_taken() -> None:
    u = np.linspace(0, 1, 20)
    y = 2 * u
    plain = hy.Record(u, y, fs=100)
    strided = hy.Record(np.repeat(u, 2)[::2], np.column_stack([y, y])[:, 0], fs=100)
    listed = hy.Record(list(u), pd.Series(y), fs=100)
    for record in (strided, listed):
        assert np.array_equal(record.u, plain.u) and np.array_equal(record.y, plain.y)
    single = hy.Record(u.astype(np.float32), y.astype(np.float32)[:, None], fs=100)
    assert np.array_equal(single.u, u.astype(np.float32).astype(float)) and single.y.shape == (20,)
    assert np.allclose(plain.t, np.arange(20) / 100) and plain.fs == 100 and plain.units == ("V", "um")


def test_times_may_be_uneven_and_channels_many() -> None:
    t = np.array([0.0, 0.1, 0.25, 0.3, 0.7])
    columns = {"u_V": t, "y_nm": 2 * t, "T [degC]": 20 + t}
    record = hy.Record(columns, t=t, valid=[1, 1, 0, 1, 1], input="u", output="y")
    assert record.fs is None and np.array_equal(record.t, t)
    assert record.channels == {"u": "V", "y": "nm", "T": "degC"}
    assert np.array_equal(record["T"], 20 + t) and np.array_equal(record["y_nm"], 2 * t)
    assert not record.valid[2]
    frame = record.to_pandas()
    assert list(frame.columns) == ["u_V", "y_nm", "T_degC"] and frame.index.name == "t_s"
    with pytest.raises(KeyError, match="there are u, y, T"):
        record["z"]


def test_a_drive_below_a_threshold_counts_as_nothing(tmp_path: Path) -> None:
    u = np.array([-3.0, -1.0, 0.5, 2.0, 2.5])
    made = hy.Record(u, u, fs=10, dead_band=2)
    assert np.array_equal(made.u, [-3, 0, 0, 2, 2.5]) and np.array_equal(made.y, u)
    file = tmp_path / "valve.csv"
    hy.Record({"y_um": u, "u_mV": 1000 * u}, fs=10).save(file)
    read = hy.read(file, dead_zone=2)
    assert np.allclose(read.u, [-1, 0, 0, 0, 0.5]) and read.units == ("V", "um")
    assert np.allclose(pickle.loads(pickle.dumps(read)).u, read.u)
    assert [np.allclose(one.u, read.u) for one in hy.read([file, file], dead_zone=2)] == [True, True]
    with pytest.raises(hy.OptionError, match="not both"):
        hy.read(file, dead_band=1, dead_zone=1)
    with pytest.raises(hy.OptionError, match="positive threshold"):
        hy.read(file, dead_band=0)


def test_files_are_read_and_written(tmp_path: Path) -> None:
    u = np.sin(np.arange(200) / 10)
    record = hy.Record(u, 3 * u, fs=1000, start=0.5)
    for name in ("r.csv", "r.npz"):
        record.save(tmp_path / name)
        again = hy.read(tmp_path / name)
        assert np.array_equal(again.u, u) and np.array_equal(again.y, 3 * u) and again.fs == 1000
    part = hy.read([tmp_path / "r.csv", tmp_path / "r.npz"], start=0.55, stop=0.6)
    assert [len(one) for one in part] == [51, 51]
    kept = pickle.loads(pickle.dumps(part[0]))
    assert np.array_equal(kept.t, part[0].t) and np.array_equal(kept.y, part[0].y)
    prepared = hy.prepare(record, scale=["y=2um/um"], fs=500)
    assert prepared.fs == 500 and len(prepared) == 100


def test_errors_name_file_line_and_column(tmp_path: Path) -> None:
    path = tmp_path / "bad.csv"
    path.write_text("t_s,u_V,y_um\n0,1,2\n1,x,3\n")
    with pytest.raises(hy.FileError) as caught:
        hy.read(path)
    error = caught.value
    assert (error.code, error.file, error.line, error.column) == ("not-a-number", str(path), 3, 2)
    assert error.hint and "output=" in error.hint
    with pytest.raises(hy.FileError, match="No such file"):
        hy.read(tmp_path / "none.csv")


@pytest.mark.parametrize(
    ("u", "y", "how", "said"),
    [
        ([0, 1, np.nan], [0, 1, 2], {"fs": 1}, "NaN"),
        ([0, 1, np.inf], [0, 1, 2], {"fs": 1}, "inf"),
        ([0, 1], [0, 1, 2], {"fs": 1}, "3"),
        ([0], [0], {"fs": 1}, "1"),
        ([], [], {"fs": 1}, "0 samples|sample"),
        ([0, 1], [0, 1], {"fs": 0}, "rate"),
        ([0, 1], [0, 1], {"t": [1, 0]}, "t"),
        ([[0, 1], [2, 3]], [0, 1], {"fs": 1}, "shape"),
    ],
)
def test_bad_arrays_are_refused(u: list[float], y: list[float], how: dict[str, object], said: str) -> None:
    with pytest.raises(hy.HysteronError, match=said):
        hy.Record(u, y, **how)  # type: ignore[arg-type]


def test_inspection_says_what_to_measure(stack: hy.Record) -> None:
    found = hy.inspect(stack)
    assert "measure next" in str(found) and found.records[0]["sample_rate_hz"] == 200


def test_waveforms_name_what_is_wrong() -> None:
    drive = hy.excite("sweep", fs=1000, high=10, start_hz=1, end_hz=50, duration_s=2)
    assert len(drive) == 2000 and drive.u.min() >= 0 and drive.u.max() <= 10
    with pytest.raises(hy.OptionError, match="unknown field `frequency`, expected"):
        hy.excite("sine", fs=1000, high=10, frequency=1)
    with pytest.raises(hy.OptionError, match="high_v"):
        hy.excite("sine", fs=1000, high=-1, frequency_hz=1, periods=1)
