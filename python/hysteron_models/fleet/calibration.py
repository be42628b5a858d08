"""``calibrate``: many devices, one estimator, any executor, one registry."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterator, Mapping
from concurrent.futures import Executor
from pathlib import Path
from typing import Any

import pandas as pd

from .._errors import OptionError
from ..estimators import Estimator, Hammerstein
from ..progress import Progress, shown
from ..record import PathLike
from .devices import Device, Devices, Naming, as_devices, date_of
from .key import PROGRAM, hash_of, key_of, options_of
from .registry import Registry
from .rows import finished_keys, outcome_of, rows_of
from .schedule import run
from .work import Outcome, Task, failed
from .workers import Workers
from .writer import Writer


def calibrate(
    records: Devices,
    estimator: Estimator | None = None,
    *,
    executor: Executor | None = None,
    registry: str | PathLike | Registry = "sqlite:///fleet.sqlite",
    reading: Mapping[str, Any] | None = None,
    device: Naming | None = None,
    reports: PathLike | None = None,
    workers: int | None = None,
    in_flight: int | None = None,
    retries: int = 3,
    patience: float = 600.0,
    progress: bool | Progress = False,
) -> pd.DataFrame:
    """Calibrate devices, each by a fit of its record, and keep every result.

    Each result is written as it comes, by this process alone. What the registry has under the same key,
    SHA-256 of record bytes, options and program version, is not fitted again: after a crash, the same call
    continues. A device that fails is a row with its reason, and is not tried again unless the machine was at
    fault (a worker that died, a file that could not be read).

    Args:
        records: pattern (``"night/*.csv"``), paths, mapping from device to path or paths, or a table with the
            column ``path`` and, if there are, ``device``, ``serial``, ``date``, ``operator``, ``notes``.
            Workers read the files under the same paths.
        estimator: what is fitted, ``Hammerstein()`` if not given. Each fit uses one thread, unless the
            estimator says otherwise; the result does not depend on it.
        executor: any ``concurrent.futures.Executor``: processes, loky, ``Client.get_executor()`` of Dask. Own
            processes if not given; a script then calls this under ``if __name__ == "__main__":``.
        registry: URL, path of a SQLite file, or an open registry.
        reading: options of :func:`hysteron_models.read`.
        device: name of a device by the path of its record; the file's name without extension if not given.
        reports: folder to which the workers write a report of each fit.
        workers: processes, where no executor is given; one a core if not given.
        in_flight: calibrations that are submitted and not finished, at most.
        retries: how often a calibration is repeated whose worker died while it ran alone.
        patience: time to wait for a registry that cannot be written, e.g. a full disk [s].
        progress: show a bar with the time left, or call ``progress(stage, fraction, None)``.

    Returns:
        One row a record, in the order given: ``device``, ``status`` (``ok`` or ``failed``), ``reason``,
        scores, and how to find it in the registry.

    Raises:
        OptionError: arguments that contradict each other.
        RegistryError: the registry cannot be read, or not be written for ``patience`` seconds.
    """
    if executor is not None and workers is not None:
        raise OptionError("workers is of the own processes: leave executor or workers out", code="workers")
    given = as_devices(records, device)
    kept = registry if isinstance(registry, Registry) else Registry(registry)
    try:
        night = _Night(given, estimator or Hammerstein(), kept, dict(reading or {}), reports, patience)
        with shown(progress) as told:
            night.told = told
            pool = Workers(executor, workers, in_flight)
            try:
                run(night.tasks(), pool, night.deliver, retries)
            finally:
                pool.close()
        return rows_of(kept, night.places)
    finally:
        if kept is not registry:
            kept.close()


class _Night:
    """One call of ``calibrate``: which calibrations there are to do, and where their outcomes go."""

    def __init__(
        self,
        devices: list[Device],
        estimator: Estimator,
        registry: Registry,
        reading: dict[str, Any],
        reports: PathLike | None,
        patience: float,
    ) -> None:
        self._devices, self._estimator, self._registry, self._reading = devices, estimator, registry, reading
        self._reports = None if reports is None else Path(os.path.abspath(reports))
        self._options = options_of(estimator, reading)
        self._writer = Writer(registry, patience)
        # Devices that wait for an outcome, by its key: records with the same bytes are fitted once.
        self._waiting: dict[str, list[tuple[Device, str | None]]] = {}
        self._known: dict[str, set[str]] = {}
        self.places: list[tuple[str, str]] = []
        self._done = self._failed = 0
        self.told: Progress | None = None

    def tasks(self) -> Iterator[Task]:
        """Calibrations to do; devices whose result is known are written on the way."""
        known = self._known = finished_keys(self._registry, self._options, PROGRAM)
        for device in self._devices:
            sha256, reason = _hash(device)
            key = key_of(sha256 or _of_unreadable(device), self._options)
            self.places.append((device.name, key))
            if sha256 is None:
                self._write(key, [(device, None)], failed(reason, "machine"))
            elif key in known:
                self._from_registry(device, sha256, key, has_row=device.name in known[key])
            elif key in self._waiting:
                self._waiting[key].append((device, sha256))
            else:
                self._waiting[key] = [(device, sha256)]
                report = (
                    ""
                    if self._reports is None
                    else str(self._reports / f"{_safe(device.name)}-{key[:12]}.html")
                )
                yield Task(key, sha256, device.paths, self._estimator, self._reading, report, device.name)

    def deliver(self, task: Task, outcome: Outcome) -> None:
        """Write an outcome for every device that waits for it."""
        devices = self._waiting.pop(task.key)
        self._write(task.key, devices, outcome)
        if outcome.cause != "machine":
            self._known[task.key] = {device.name for device, _ in devices}

    def _from_registry(self, device: Device, sha256: str, key: str, has_row: bool) -> None:
        if not has_row:
            outcome = outcome_of(self._registry, key)
            self._write(key, [(device, sha256)], outcome)
            return
        given = {
            "serial": device.serial,
            "operator": device.operator,
            "notes": device.notes,
            "date": device.date,
        }
        said = {column: text for column, text in given.items() if text}
        if said:
            serial = said.pop("serial", "")
            self._writer.write(lambda r: r.describe({"name": device.name, "serial": serial}, key, said))
        self._count(1, 0)

    def _write(self, key: str, devices: list[tuple[Device, str | None]], outcome: Outcome) -> None:
        rows = [
            (
                {"name": device.name, "serial": device.serial},
                {
                    "key": key,
                    "record_sha256": sha256,
                    "paths": json.dumps(device.paths),
                    "date": date_of(device),
                    "operator": device.operator,
                    "notes": device.notes,
                    "program": PROGRAM,
                    "options": self._options,
                },
                outcome,
            )
            for device, sha256 in devices
        ]
        self._writer.write(lambda registry: registry.keep(rows))
        self._count(len(rows), len(rows) if outcome.status == "failed" else 0)

    def _count(self, done: int, failures: int) -> None:
        self._done += done
        self._failed += failures
        if self.told is not None:
            stage = f"{self._done} of {len(self._devices)} devices"
            stage += f", {self._failed} failed" if self._failed else ""
            self.told(stage, self._done / len(self._devices), None)


def _hash(device: Device) -> tuple[str | None, str]:
    try:
        return hash_of(device.paths), ""
    except OSError as error:
        return None, f"{error.filename}: {error.strerror}" if error.filename else str(error)


def _of_unreadable(device: Device) -> str:
    text = "\n".join(("unreadable", device.name, *device.paths))
    return hashlib.sha256(text.encode("utf-8", "surrogateescape")).hexdigest()


def _safe(name: str) -> str:
    """A name of a file from that of a device."""
    return "".join(c if c.isalnum() or c in "-_." else "_" for c in name)[:80].lstrip(".") or "device"
