"""Fleets: any executor, killed workers, failed devices, a second run."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import hysteron_models as hy
import pandas as pd
import psutil
import pytest
import simulated_fleet
from hysteron_models import fleet
from simulated_fleet import ESTIMATOR, Serial, content


@pytest.fixture(scope="module")
def records(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Records of twenty simulated devices."""
    folder = tmp_path_factory.mktemp("fleet")
    simulated_fleet.write(folder, 20)
    return folder


class Nowhere(Executor):
    """Must not be used."""

    def submit(self, work: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        raise AssertionError("a calibration was submitted")


@pytest.fixture(scope="module")
def serial(records: Path, tmp_path_factory: pytest.TempPathFactory) -> str:
    """Registry of a serial run."""
    url = f"sqlite:///{tmp_path_factory.mktemp('serial') / 'fleet.sqlite'}"
    table = fleet.calibrate(f"{records}/*.csv", ESTIMATOR, executor=Serial(), registry=url)
    assert list(table["status"]) == ["ok"] * 20 and list(table["reason"]) == [""] * 20
    assert table["fit_percent"].min() > 95
    return url


def test_a_killed_worker_costs_no_device_and_no_bit(records: Path, serial: str, tmp_path: Path) -> None:
    url = f"sqlite:///{tmp_path / 'fleet.sqlite'}"
    killed = []

    def kill() -> None:
        while not killed:
            workers = [c for c in psutil.Process().children() if "spawn_main" in " ".join(c.cmdline())]
            if len(workers) == 2 and len(content(url)) >= 3:
                workers[0].send_signal(signal.SIGKILL)
                killed.append(workers[0].pid)
            time.sleep(0.02)

    fleet.Registry(url).close()
    killer = threading.Thread(target=kill, daemon=True)
    killer.start()
    stages: list[str] = []
    table = fleet.calibrate(
        f"{records}/*.csv",
        ESTIMATOR,
        registry=url,
        workers=2,
        progress=lambda stage, fraction, cost: stages.append(stage),
    )
    killer.join(timeout=10)
    assert killed and list(table["status"]) == ["ok"] * 20
    assert content(url) == content(serial)
    assert stages[-1] == "20 of 20 devices" and len(stages) == 20


def test_a_second_run_fits_nothing_and_returns_the_same_rows(records: Path, serial: str) -> None:
    first = fleet.calibrate(f"{records}/*.csv", ESTIMATOR, executor=Nowhere(), registry=serial)
    threads = ESTIMATOR.get_params() | {"threads": 2}
    again = fleet.calibrate(
        f"{records}/*.csv", hy.Hammerstein(**threads), executor=Nowhere(), registry=serial
    )
    assert first.equals(again)
    with pytest.raises(AssertionError, match="submitted"):
        fleet.calibrate(f"{records}/*.csv", hy.Hammerstein(seed=2), executor=Nowhere(), registry=serial)


def _loky() -> Executor:
    from loky import get_reusable_executor

    made: Executor = get_reusable_executor(max_workers=2)
    return made


def _processes() -> Executor:
    import multiprocessing

    return ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn"))


@pytest.mark.parametrize("make", [lambda: ThreadPoolExecutor(2), _processes, _loky])
def test_any_executor_gives_the_same_bits(
    make: Callable[[], Executor], records: Path, serial: str, tmp_path: Path
) -> None:
    url = f"sqlite:///{tmp_path / 'fleet.sqlite'}"
    with make() as executor:
        fleet.calibrate(f"{records}/*.csv", ESTIMATOR, executor=executor, registry=url)
    assert content(url) == content(serial)


@pytest.fixture
def cluster() -> Iterator[Any]:
    """Dask on this machine, two workers."""
    from distributed import Client, LocalCluster

    with (
        LocalCluster(
            n_workers=2, threads_per_worker=1, dashboard_address=None, protocol="tcp", silence_logs="ERROR"
        ) as made,
        Client(made) as client,
    ):
        yield client


def test_dask_gives_the_same_bits(cluster: Any, records: Path, serial: str, tmp_path: Path) -> None:
    url = f"sqlite:///{tmp_path / 'fleet.sqlite'}"
    cluster.run(_find_tests, os.path.dirname(__file__))
    executor = cluster.get_executor()
    fleet.calibrate(f"{records}/*.csv", ESTIMATOR, executor=executor, registry=url)
    assert content(url) == content(serial)


def _find_tests(folder: str) -> None:
    import sys

    sys.path.insert(0, folder)


class Deadly(hy.Hammerstein):
    """Ends its process for the record of one device, as a bad driver or a lack of memory does."""

    def fit(self, records: Any, y: None = None, **how: Any) -> Any:
        first = records if isinstance(records, hy.Record) else records[0]
        if "0004" in first.name:
            os._exit(3)
        return super().fit(records, y, **how)


def test_a_record_that_ends_its_workers_is_one_failed_row(records: Path, tmp_path: Path) -> None:
    url = f"sqlite:///{tmp_path / 'fleet.sqlite'}"
    deadly = Deadly(**ESTIMATOR.get_params())
    table = fleet.calibrate(
        sorted(records.iterdir())[:8], deadly, registry=url, workers=2, retries=1
    ).set_index("device")
    bad = table.loc["simulated-0004"]
    assert bad["status"] == "failed" and "worker ended 2 times" in bad["reason"] and bad["cause"] == "machine"
    assert (table.drop("simulated-0004")["status"] == "ok").all()


def test_an_executor_that_is_broken_fails_rows_and_not_the_night(records: Path, tmp_path: Path) -> None:
    url = f"sqlite:///{tmp_path / 'fleet.sqlite'}"
    given = sorted(records.iterdir())[:4]
    with ThreadPoolExecutor(1) as closed:
        pass
    table = fleet.calibrate(given, ESTIMATOR, executor=closed, registry=url)
    assert list(table["status"]) == ["failed"] * 4 and "shutdown" in table["reason"][0]
    table = fleet.calibrate(given, ESTIMATOR, executor=Serial(), registry=url)
    assert list(table["status"]) == ["ok"] * 4


def test_bad_records_are_rows_with_reasons(records: Path, tmp_path: Path) -> None:
    url = f"sqlite:///{tmp_path / 'fleet.sqlite'}"
    (tmp_path / "empty.csv").touch()
    (tmp_path / "text.csv").write_text("t_s,u_V,y_um\n0,1,2\n1,x,3\n")
    (tmp_path / "none.csv").write_text("")
    good = sorted(records.iterdir())[0]
    given = [tmp_path / "empty.csv", tmp_path / "text.csv", tmp_path / "missing.csv", tmp_path, good]
    table = fleet.calibrate(given, ESTIMATOR, executor=Serial(), registry=url)
    assert list(table["status"]) == ["failed"] * 4 + ["ok"]
    assert list(table["cause"]) == ["record", "record", "machine", "machine", ""]
    assert all(table["reason"][:4]) and "line 3" in table["reason"][1]
    assert "No such file" in table["reason"][2]
    # The file comes: one row, of the same device.
    (tmp_path / "missing.csv").write_bytes(good.read_bytes())
    table = fleet.calibrate(given, ESTIMATOR, executor=Serial(), registry=url)
    assert list(table["status"]) == ["failed", "failed", "ok", "failed", "ok"]
    assert len(content(url)) == 5


def test_a_record_that_changes_during_the_fit_is_not_kept(records: Path, tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(sorted(records.iterdir())[0].read_bytes())

    class Changing(Serial):
        def submit(self, work: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
            path.write_bytes(sorted(records.iterdir())[1].read_bytes())
            return super().submit(work, *args, **kwargs)

    url = f"sqlite:///{tmp_path / 'fleet.sqlite'}"
    table = fleet.calibrate(path, ESTIMATOR, executor=Changing(), registry=url)
    assert (table["status"][0], table["cause"][0]) == ("failed", "machine")
    assert "changed" in table["reason"][0]


def test_tables_name_devices_and_the_same_bytes_are_fitted_once(records: Path, tmp_path: Path) -> None:
    url = f"sqlite:///{tmp_path / 'fleet.sqlite'}"
    path = sorted(records.iterdir())[0]
    (tmp_path / "copy.csv").write_bytes(path.read_bytes())
    table = pd.DataFrame(
        {
            "path": [path, tmp_path / "copy.csv"],
            "device": ["A '; DROP TABLE devices; --", "<b>B</b>"],
            "serial": ["17", None],
            "date": ["2026-11-28", pd.Timestamp("2026-11-28T20:00", tz="Europe/Berlin")],
            "notes": ["warm-up \0 short", float("nan")],
        }
    )
    submitted = []

    class Counting(Serial):
        def submit(self, work: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
            submitted.append(args)
            return super().submit(work, *args, **kwargs)

    found = fleet.calibrate(table, ESTIMATOR, executor=Counting(), registry=url)
    assert len(submitted) == 1 and list(found["status"]) == ["ok", "ok"]
    assert list(found["device"]) == list(table["device"]) and list(found["serial"]) == ["17", ""]
    assert list(found["date"]) == ["2026-11-28", "2026-11-28T19:00:00+00:00"]
    assert found["rmse"][0] == found["rmse"][1]
    table.loc[0, "notes"] = "measured again"
    found = fleet.calibrate(table, ESTIMATOR, executor=Nowhere(), registry=url)
    assert found["notes"][0] == "measured again" and found["serial"][0] == "17"


def test_arguments_that_cannot_be_meant_are_refused(records: Path, tmp_path: Path) -> None:
    url = f"sqlite:///{tmp_path / 'fleet.sqlite'}"
    for given, said in [
        (f"{tmp_path}/*.none", "no file matches"),
        ([], "no device"),
        ([tmp_path / "a/loop.csv", tmp_path / "b/loop.csv"], "device="),
        (pd.DataFrame({"file": ["a"]}), "found file"),
        (pd.DataFrame({"path": ["a"], "date": ["yesterday"]}), "ISO 8601"),
        ([3], "expected a path"),
    ]:
        with pytest.raises(hy.OptionError, match=said):
            fleet.calibrate(given, ESTIMATOR, executor=Nowhere(), registry=url)
    named = fleet.calibrate(
        [tmp_path / "a/loop.csv", tmp_path / "b/loop.csv"],
        ESTIMATOR,
        executor=Nowhere(),
        registry=url,
        device=lambda path: Path(path).parent.name,
    )
    assert list(named["device"]) == ["a", "b"]
    with pytest.raises(hy.OptionError, match="sqlite:///"):
        fleet.calibrate(records, ESTIMATOR, executor=Nowhere(), registry="mysql://host/fleet")


def test_what_is_not_installed_is_named() -> None:
    script = (
        "import sys; sys.modules['sqlalchemy'] = None\n"
        "import hysteron_models as hy\n"
        "try: hy.fleet.calibrate\n"
        "except hy.MissingPackage as error: print(error)"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert "needs sqlalchemy: install it with  pip install 'hysteron-models[fleet]'" in done.stdout
