"""The same registry in a real PostgreSQL server: a throw-away cluster, run by a user who is not root."""

from __future__ import annotations

import glob
import os
import pwd
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from pathlib import Path
from typing import Any

import hysteron_models as hy
import pytest
import simulated_fleet
from hysteron_models import fleet
from simulated_fleet import ESTIMATOR, Serial, content
from sqlalchemy import create_engine, text
from test_fleet_registry import first_schema


def programs() -> Path | None:
    """Folder of the server's programs."""
    found = sorted(glob.glob("/usr/lib/postgresql/*/bin/initdb"))
    path = found[-1] if found else shutil.which("initdb")
    return Path(path).parent if path else None


class Server:
    """A cluster in a folder of its own, reached by a socket in it."""

    def __init__(self, folder: str) -> None:
        bin_folder = programs()
        if bin_folder is None:
            pytest.skip("no PostgreSQL server is installed: python/tests/install-tools.sh")
        self._bin, self._folder, self._data = bin_folder, folder, f"{folder}/data"
        self._as: dict[str, Any] = {}
        if os.getuid() == 0:
            # The server refuses root.
            names = {user.pw_name for user in pwd.getpwall()}
            user = pwd.getpwnam("postgres" if "postgres" in names else "nobody")
            os.chown(folder, user.pw_uid, user.pw_gid)
            os.chmod(folder, 0o755)
            self._as = {"user": user.pw_uid, "group": user.pw_gid, "extra_groups": []}
        self._run(
            "initdb", "-D", self._data, "-U", "hysteron", "--auth=trust", "--no-sync", "--encoding=UTF8"
        )
        self.start()

    def _run(self, program: str, *arguments: str) -> None:
        done = subprocess.run(
            [str(self._bin / program), *arguments],
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
            cwd=self._folder, timeout=120, **self._as,
        )  # fmt: skip
        assert done.returncode == 0, done.stdout

    def start(self) -> None:
        """Start, and wait until it answers."""
        options = f"-k {self._folder} -c listen_addresses= -c fsync=off"
        self._run("pg_ctl", "-D", self._data, "-l", f"{self._folder}/log", "-w", "-o", options, "start")

    def stop(self) -> None:
        """Stop at once."""
        self._run("pg_ctl", "-D", self._data, "-m", "immediate", "-w", "stop")

    def database(self, name: str) -> str:
        """URL of a new database."""
        main = create_engine(self._url("postgres"), isolation_level="AUTOCOMMIT")
        with main.connect() as connection:
            connection.execute(text(f'CREATE DATABASE "{name}"'))
        main.dispose()
        return self._url(name)

    def _url(self, database: str) -> str:
        return f"postgresql+psycopg://hysteron@/{database}?host={self._folder}"


@pytest.fixture(scope="module")
def server() -> Iterator[Server]:
    """A server for these tests."""
    pytest.importorskip("psycopg")
    # The path of a socket is short, and its folders are open to the server's user.
    with tempfile.TemporaryDirectory(prefix="hysteron-pg-") as folder:
        made = Server(folder)
        yield made
        made.stop()


@pytest.fixture(scope="module")
def records(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Records of six simulated devices and an empty one."""
    folder = tmp_path_factory.mktemp("fleet")
    simulated_fleet.write(folder, 6)
    (folder / "empty.csv").touch()
    return folder


def test_postgresql_holds_what_sqlite_holds(server: Server, records: Path, tmp_path: Path) -> None:
    urls = [server.database("same"), f"sqlite:///{tmp_path / 'fleet.sqlite'}"]
    tables = [fleet.calibrate(f"{records}/*.csv", ESTIMATOR, executor=Serial(), registry=url) for url in urls]
    assert content(urls[0]) == content(urls[1]) and len(content(urls[0])) == 7
    columns = ["device", "status", "reason", "rmse", "fit_percent", "key"]
    assert tables[0][columns].equals(tables[1][columns])
    again = fleet.calibrate(f"{records}/*.csv", ESTIMATOR, executor=Serial(), registry=urls[0])
    assert again.equals(tables[0])
    models = [fleet.model(url, "simulated-0001") for url in urls]
    assert not fleet.difference(*models).attrs["significant"]
    fleet.report(urls[0], tmp_path / "fleet.html")
    assert "simulated-0001" in (tmp_path / "fleet.html").read_text()


def test_the_first_schema_is_upgraded_there_too(server: Server) -> None:
    url = server.database("old")
    first_schema(url)
    kept = fleet.Registry(url)
    with kept.engine.connect() as connection:
        rows = connection.execute(text("SELECT status, cause FROM calibrations ORDER BY id")).all()
    assert [tuple(row) for row in rows] == [("ok", ""), ("failed", "machine")]
    kept.close()


def test_a_server_that_restarts_in_the_night_costs_no_row(server: Server, records: Path) -> None:
    url, calls = server.database("restarted"), []

    class Restarting(Serial):
        def submit(self, work: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
            calls.append(args)
            if len(calls) == 3:
                server.stop()
                server.start()
            return super().submit(work, *args, **kwargs)

    table = fleet.calibrate(f"{records}/sim*.csv", ESTIMATOR, executor=Restarting(), registry=url)
    assert list(table["status"]) == ["ok"] * 6


def test_a_server_that_is_not_there_is_an_error(tmp_path: Path) -> None:
    pytest.importorskip("psycopg")
    with pytest.raises(hy.RegistryError, match=r"No such file|connection"):
        fleet.Registry(f"postgresql+psycopg://me:secret@/fleet?host={tmp_path}")
