"""The registry: schemas, a full disk, and the command that reads the same file."""

from __future__ import annotations

import json
import os
import resource
import sqlite3
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import hysteron_models as hy
import pytest
import simulated_fleet
from alembic import command as alembic_command
from alembic.config import Config
from hysteron_models import fleet
from hysteron_models.fleet import registry as registry_module
from hysteron_models.fleet import schema
from simulated_fleet import ESTIMATOR, Serial, content
from sqlalchemy import create_engine, inspect, text


@pytest.fixture(scope="module")
def night(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A registry of three devices, one measured twice, and one that failed."""
    folder = tmp_path_factory.mktemp("night")
    paths = simulated_fleet.write(folder, 3)
    (folder / "empty.csv").touch()
    file = folder / "fleet.sqlite"
    for k, day in enumerate(("2026-01-01", "2026-02-01")):
        table = [
            fleet.Device("A", (str(paths[k]),), serial="17", date=day, operator="Li", notes="=1+1"),
            fleet.Device("B", (str(paths[2]),), date=day),
            fleet.Device("bad", (str(folder / "empty.csv"),), date=day),
        ]
        fleet.calibrate(table, ESTIMATOR, executor=Serial(), registry=file)
    return file


def test_the_tables_are_those_of_the_last_schema(tmp_path: Path) -> None:
    """Migrations and ``schema.py`` make the same columns."""
    migrated = fleet.Registry(tmp_path / "a.sqlite").engine
    made = create_engine(f"sqlite:///{tmp_path / 'b.sqlite'}")
    schema.METADATA.create_all(made)
    for table in schema.METADATA.tables:
        columns = [
            sorted((c["name"], str(c["type"]), c["nullable"]) for c in inspect(engine).get_columns(table))
            for engine in (migrated, made)
        ]
        assert columns[0] == columns[1], table
        indices = [sorted(str(i["name"]) for i in inspect(e).get_indexes(table)) for e in (migrated, made)]
        assert indices[0] == indices[1], table


def first_schema(url: str) -> None:
    """A registry of the first schema with a device that has a model and one that failed."""
    engine = create_engine(url)
    config = Config()
    config.set_main_option("script_location", str(registry_module.MIGRATIONS))
    with engine.begin() as connection:
        config.attributes["connection"] = connection
        alembic_command.upgrade(config, "0001")
        connection.execute(text("INSERT INTO devices (id, name) VALUES (1, 'old'), (2, 'older')"))
        for number, status in ((1, "ok"), (2, "failed")):
            connection.execute(
                text(
                    "INSERT INTO calibrations (id, device_id, key, paths, date, program, options, status, finished)"
                    " VALUES (:n, :n, :key, '[]', '2025-01-01', 'hysteron_models 0.0.1', '{}', :status, '')"
                ),
                {"n": number, "key": str(number) * 64, "status": status},
            )
    engine.dispose()


def test_the_first_schema_is_upgraded_and_keeps_its_rows(tmp_path: Path) -> None:
    url = f"sqlite:///{tmp_path / 'fleet.sqlite'}"
    first_schema(url)
    kept = fleet.Registry(url)
    with kept.engine.connect() as connection:
        rows = connection.execute(
            text("SELECT key, status, cause, curves FROM calibrations ORDER BY id")
        ).all()
        version = connection.execute(text("SELECT version_num FROM alembic_version")).scalar()
    assert [tuple(row) for row in rows] == [("1" * 64, "ok", "", None), ("2" * 64, "failed", "machine", None)]
    assert version == "0002"
    kept.close()
    fleet.Registry(url).close()


def test_a_newer_schema_and_other_files_are_refused(tmp_path: Path, command: Path) -> None:
    file = tmp_path / "fleet.sqlite"
    fleet.Registry(file).close()
    with sqlite3.connect(file) as connection:
        connection.execute("UPDATE alembic_version SET version_num = '0099'")
    with pytest.raises(hy.RegistryError, match=r"schema 0099.*up to 0002"):
        fleet.Registry(file)
    done = subprocess.run([command, "registry", "list", file], capture_output=True, text=True)
    assert done.returncode == 1 and "schema 0099" in done.stderr and "update hysteron" in done.stderr
    other = tmp_path / "other.sqlite"
    with sqlite3.connect(other) as connection:
        connection.execute("CREATE TABLE calibrations (x)")
    with pytest.raises(hy.RegistryError, match="another program"):
        fleet.Registry(other)
    (tmp_path / "text.sqlite").write_text("no database, but some text that is long enough for a header" * 20)
    for name, said in (("other.sqlite", "no tables"), ("text.sqlite", "not a database"), ("none", "No such")):
        done = subprocess.run([command, "registry", "list", tmp_path / name], capture_output=True, text=True)
        assert done.returncode == 1 and said in done.stderr, done.stderr
    assert not (tmp_path / "none").exists()
    with pytest.raises(hy.RegistryError, match="not a database"):
        fleet.Registry(tmp_path / "text.sqlite")


def told(command: Path, *arguments: object) -> Any:
    done = subprocess.run(
        [command, "registry", *map(str, arguments), "--json"], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_the_command_reads_what_python_wrote(night: Path, command: Path, tmp_path: Path) -> None:
    listed = told(command, "list", night)
    assert [(d["device"], d["status"], d["calibrations"]) for d in listed] == [
        ("A", "ok", 2), ("B", "ok", 1), ("bad", "failed", 1),
    ]  # fmt: skip
    assert listed[0]["date"] == "2026-02-01" and listed[0]["serial"] == "17"
    assert [d["device"] for d in told(command, "list", night, "--failed")] == ["bad"]
    table = fleet.calibrate(json.loads(json.dumps(listed[0]["paths"])), ESTIMATOR, executor=Serial(), registry=night,
                            device=lambda _: "A")  # fmt: skip
    assert listed[0]["rmse"] == table["rmse"][0] and listed[0]["key"] == table["key"][0]
    history = told(command, "show", night, "A")["calibrations"]
    assert [c["date"] for c in history] == ["2026-01-01", "2026-02-01"]
    parameters = {p["name"]: p["value"] for p in history[-1]["parameters"]}
    model = fleet.model(night, "A")
    assert parameters["alpha"] == model.data["hysteresis"]["parameters"]["alpha"]["value"]
    written = told(command, "export", night, "--out-dir", tmp_path / "models")
    assert [one["device"] for one in written] == ["A", "B"]
    assert hy.load(written[0]["path"]) == model


def test_both_say_the_same_difference(night: Path, command: Path) -> None:
    said = told(command, "diff", night, "A")
    found = fleet.difference(fleet.model(night, "A", back=1), fleet.model(night, "A"))
    assert [n["name"] for n in said["numbers"]] == list(found.index)
    assert said["joint"] == found.attrs["joint"] and said["significant"] == found.attrs["significant"]
    across = told(command, "diff", night, "A", "B")
    assert across["joint"]["degrees"] == 4
    done = subprocess.run([command, "registry", "diff", night, "B"], capture_output=True, text=True)
    assert done.returncode == 1 and "2 are needed" in done.stderr
    done = subprocess.run([command, "registry", "show", night, "' OR 1=1 --"], capture_output=True, text=True)
    assert done.returncode == 1 and "no device" in done.stderr
    with pytest.raises(hy.OptionError, match="no model of bad"):
        fleet.model(night, "bad")


CLIENT = """
import sys
from concurrent.futures import ThreadPoolExecutor
import simulated_fleet
from hysteron_models import fleet
fleet.calibrate(sys.argv[1], simulated_fleet.ESTIMATOR, executor=ThreadPoolExecutor(1), registry=sys.argv[2],
                patience=float(sys.argv[3]))
"""


def test_a_full_disk_is_waited_for_and_tears_no_row(tmp_path: Path) -> None:
    simulated_fleet.write(tmp_path / "records", 12)
    file, pattern = tmp_path / "fleet.sqlite", f"{tmp_path}/records/*.csv"
    fleet.Registry(file).close()
    arguments = [sys.executable, "-c", CLIENT, pattern, f"sqlite:///{file}", "60"]
    environment = os.environ | {"PYTHONPATH": os.path.dirname(__file__)}
    client = subprocess.Popen(arguments, env=environment, stderr=subprocess.PIPE, text=True)
    # No file of the client grows beyond this size, as on a disk without room.
    hard = resource.prlimit(client.pid, resource.RLIMIT_FSIZE)[1]
    resource.prlimit(client.pid, resource.RLIMIT_FSIZE, (file.stat().st_size + 300_000, hard))
    assert client.stderr is not None
    said = client.stderr.readline()
    assert "cannot be written" in said and "trying again" in said, said
    with sqlite3.connect(file) as connection:
        assert connection.execute("PRAGMA integrity_check").fetchone() == ("ok",)
        assert 0 < connection.execute("SELECT count(*) FROM calibrations").fetchone()[0] < 12
    resource.prlimit(client.pid, resource.RLIMIT_FSIZE, (hard, hard))
    assert client.wait(timeout=60) == 0
    assert len(content(f"sqlite:///{file}")) == 12


def test_a_disk_that_stays_full_ends_with_a_clear_error(tmp_path: Path) -> None:
    simulated_fleet.write(tmp_path / "records", 12)
    file, pattern = tmp_path / "fleet.sqlite", f"{tmp_path}/records/*.csv"
    fleet.Registry(file).close()
    size = file.stat().st_size + 300_000
    arguments = [sys.executable, "-c", CLIENT, pattern, f"sqlite:///{file}", "0.5"]
    environment = os.environ | {"PYTHONPATH": os.path.dirname(__file__)}
    client = subprocess.Popen(arguments, env=environment, stderr=subprocess.PIPE, text=True)
    resource.prlimit(client.pid, resource.RLIMIT_FSIZE, (size, -1))
    said = client.communicate(timeout=60)[1]
    assert client.returncode == 1 and "RegistryError" in said and "what it holds is whole" in said
    fleet.calibrate(pattern, ESTIMATOR, executor=Serial(), registry=file)
    assert len(content(f"sqlite:///{file}")) == 12


def test_a_reader_does_not_stop_the_writer(night: Path, tmp_path: Path) -> None:
    """A long read, as by ``registry list`` of a large fleet, is waited for."""
    file = tmp_path / "fleet.sqlite"
    file.write_bytes(night.read_bytes())
    reader = sqlite3.connect(file, check_same_thread=False)
    reader.execute("BEGIN")
    reader.execute("SELECT count(*) FROM calibrations").fetchone()
    release = threading.Timer(1.0, reader.close)
    release.start()
    begun = time.monotonic()
    path = simulated_fleet.write(tmp_path / "more", 1, first=7)[0]
    fleet.calibrate(path, ESTIMATOR, executor=Serial(), registry=file)
    assert time.monotonic() - begun > 0.5 and len(content(f"sqlite:///{file}")) == 5
