"""A night with faults: Dask with four workers, 500 simulated devices, two workers and the client killed at random
moments, the disk full once. At the end exactly 500 rows, bit-identical to those of a serial run.

    python fleet_faults.py [--devices 500] [--seed N]

``make test-fleet`` runs it. It exits with 1 where a row is missing, doubled or different.
"""

from __future__ import annotations

import argparse
import os
import random
import resource
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import simulated_fleet
from hysteron_models import fleet
from simulated_fleet import ESTIMATOR, Serial, content

WORKERS = 4
# Room at first, for each device: about a third of what its row takes [kB].
ROOM_KB = 25
DEADLINE_S = 900.0


class Disk:
    """A disk that is full at first: a small tmpfs where that can be mounted, else a limit on the size of files."""

    def __init__(self, folder: Path, devices: int) -> None:
        self.folder, self._room_kb = folder, ROOM_KB * devices
        folder.mkdir()
        mount = ["mount", "-t", "tmpfs", "-o", f"size={self._room_kb}k", "tmpfs", str(folder)]
        self.mounted = subprocess.run(mount, capture_output=True).returncode == 0
        self.kind = (
            f"a tmpfs of {self._room_kb} kB (ENOSPC)"
            if self.mounted
            else "a limit on the size of files (EFBIG)"
        )

    def limit(self, client: subprocess.Popen[str]) -> None:
        """Apply to a client that was just started."""
        if not self.mounted:
            resource.prlimit(client.pid, resource.RLIMIT_FSIZE, (self._room_kb << 10, -1))

    def make_room(self, client: subprocess.Popen[str]) -> None:
        """Let files grow again."""
        if self.mounted:
            subprocess.run(
                ["mount", "-o", f"remount,size={20 * self._room_kb}k", str(self.folder)], check=True
            )
        else:
            resource.prlimit(client.pid, resource.RLIMIT_FSIZE, (-1, -1))

    def close(self) -> None:
        """Unmount."""
        if self.mounted:
            subprocess.run(["umount", str(self.folder)], check=True)


def rows(file: Path) -> int:
    """Rows in the registry at this moment."""
    if not file.exists():
        return 0
    connection = sqlite3.connect(f"file:{file}?mode=ro", uri=True, timeout=30)
    try:
        return int(connection.execute("SELECT count(*) FROM calibrations").fetchone()[0])
    except sqlite3.OperationalError:  # no tables yet
        return 0
    finally:
        connection.close()


def until(reached: Callable[[], bool], what: str) -> None:
    """Wait."""
    end = time.monotonic() + DEADLINE_S
    while not reached():
        if time.monotonic() > end:
            sys.exit(f"failed: {what} was not reached in {DEADLINE_S:.0f} s")
        time.sleep(0.02)


def client(scheduler: str, pattern: str, url: str) -> None:
    """The process that is killed and restarted."""
    from distributed import Client

    with Client(scheduler_file=scheduler) as connected:
        connected.wait_for_workers(1)
        executor = connected.get_executor()
        table = fleet.calibrate(pattern, ESTIMATOR, executor=executor, registry=url, patience=300.0)
        print(f"{len(table)} rows, {(table['status'] == 'ok').sum()} ok", flush=True)


def night(folder: Path, count: int, rng: random.Random) -> bool:
    """Run it; whether the registry is that of the serial run."""
    records = folder / "records"
    simulated_fleet.write(records, count)
    pattern, serial = f"{records}/*.csv", f"sqlite:///{folder / 'serial.sqlite'}"
    begun = time.monotonic()
    fleet.calibrate(pattern, ESTIMATOR, executor=Serial(), registry=serial)
    print(f"serial run: {count} simulated devices in {time.monotonic() - begun:.0f} s", flush=True)

    disk = Disk(folder / "disk", count)
    file, scheduler = disk.folder / "fleet.sqlite", folder / "scheduler.json"
    dask = [sys.executable, "-m", "dask"]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    own: list[subprocess.Popen[Any]] = [
        subprocess.Popen(
            [*dask, "scheduler", "--port", "0", "--no-dashboard", "--scheduler-file", str(scheduler)], **quiet
        )
    ]
    until(scheduler.exists, "the scheduler")
    limits = ["--nthreads", "1", "--no-nanny", "--no-dashboard", "--memory-limit", "0"]
    workers = [
        subprocess.Popen([*dask, "worker", "--scheduler-file", str(scheduler), *limits], cwd=folder, **quiet)
        for _ in range(WORKERS)
    ]
    own += workers

    def start() -> subprocess.Popen[str]:
        arguments = [sys.executable, __file__, "--client", str(scheduler), pattern, f"sqlite:///{file}"]
        started = subprocess.Popen(arguments, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        own.append(started)
        return started

    def at(low: float, high: float) -> int:
        return int(count * rng.uniform(low, high))

    try:
        begun = time.monotonic()
        running = start()
        disk.limit(running)
        for number, (low, high) in enumerate([(0.03, 0.2), (0.45, 0.6)]):
            moment = at(low, high)
            if number == 1:
                assert running.stderr is not None
                said = next((line for line in running.stderr if "cannot be written" in line), "")
                print(f"disk full after {rows(file)} rows, on {disk.kind}: {said.strip()}", flush=True)
                if not said:
                    return False
                time.sleep(rng.uniform(1, 4))
                disk.make_room(running)
            until(lambda moment=moment: rows(file) >= moment, f"{moment} rows")  # type: ignore[misc]
            time.sleep(rng.uniform(0, 0.3))
            workers[number].send_signal(signal.SIGKILL)
            print(f"worker {number + 1} of {WORKERS} killed after {rows(file)} rows", flush=True)
        moment = at(0.65, 0.9)
        until(lambda: rows(file) >= moment, f"{moment} rows")
        running.send_signal(signal.SIGKILL)
        running.wait()
        left = rows(file)
        print(f"client killed after {left} rows, and started again", flush=True)
        running = start()
        said, errors = running.communicate(timeout=DEADLINE_S)
        print(f"client: {said.strip()}; {time.monotonic() - begun:.0f} s in all", flush=True)
        if running.returncode != 0:
            print(errors)
            return False
        found, expected = content(f"sqlite:///{file}"), content(serial)
        same = sum(found.get(place) == row for place, row in expected.items())
        print(f"{len(found)} rows in the registry, {same} bit-identical to the serial run", flush=True)
        return len(found) == count == same
    finally:
        for process in own:
            if process.poll() is None:
                process.kill()
            process.wait()
        disk.close()


def main() -> None:
    """Command line."""
    if sys.argv[1:2] == ["--client"]:
        client(*sys.argv[2:5])
        return
    parser = argparse.ArgumentParser()
    parser.add_argument("--devices", type=int, default=500)
    parser.add_argument("--seed", type=int, default=int.from_bytes(os.urandom(4)))
    given = parser.parse_args()
    print(f"seed {given.seed}", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        good = night(Path(folder), given.devices, random.Random(given.seed))
    print("passed" if good else "failed")
    sys.exit(not good)


if __name__ == "__main__":
    main()
