"""Devices and their records: from paths, a pattern, a mapping or a table."""

from __future__ import annotations

import glob
import os
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from datetime import date, datetime, timezone
from pathlib import Path
from typing import Any, TypeAlias

import pandas as pd

from .._errors import OptionError
from ..record import PathLike
from .work import plain

COLUMNS = ("path", "device", "serial", "date", "operator", "notes")
Naming: TypeAlias = Callable[[str], str]


@dataclass(frozen=True)
class Device:
    """A device with a record of it.

    Attributes:
        name: name of the device.
        paths: files of the record; several are fitted together.
        serial: serial number.
        date: date of the measurement, ISO 8601; that of the first file if empty.
        operator: who measured.
        notes: the operator's notes.
    """

    name: str
    paths: tuple[str, ...]
    serial: str = ""
    date: str = ""
    operator: str = ""
    notes: str = ""


Devices: TypeAlias = PathLike | Mapping[str, Any] | pd.DataFrame | Iterable[Any]


def as_devices(given: Devices, naming: Naming | None = None) -> list[Device]:
    """The devices of a glob pattern, a path, paths, a mapping from names to paths, a table, or themselves.

    Raises:
        OptionError: no device; a table without a column ``path``; records that would get one name by
            accident.
    """
    if isinstance(given, pd.DataFrame):
        found = _of_table(given, naming)
    elif isinstance(given, Mapping):
        found = [_device(str(name), paths) for name, paths in given.items()]
    else:
        if isinstance(given, str | os.PathLike):
            given = _matching(os.fspath(given))
        items = list(given)
        found = [item for item in items if isinstance(item, Device)]
        if found and len(found) < len(items):
            raise OptionError("records: expected devices or paths, found both", code="records")
        found = found or _of_paths(items, naming)
    if not found:
        raise OptionError("records: no device is given", code="records")
    return found


def _matching(pattern: str) -> list[str]:
    if not glob.has_magic(pattern):
        return [pattern]
    found = sorted(path for path in glob.glob(pattern, recursive=True) if not os.path.isdir(path))
    if not found:
        raise OptionError(f"records: no file matches {pattern}", code="records")
    return found


def _of_paths(paths: list[Any], naming: Naming | None) -> list[Device]:
    texts = [_path(path) for path in paths]
    if naming is not None:
        return [_device(naming(text), text) for text in texts]
    names = [Path(text).stem for text in texts]
    twice = [name for name, count in Counter(names).items() if count > 1]
    if twice:
        raise OptionError(
            f"records: {Counter(names)[twice[0]]} files are called {twice[0]}: name them with device=…, "
            "e.g. device=lambda path: Path(path).parent.name, or by a table with a column device",
            code="records",
        )
    return [_device(name, text) for name, text in zip(names, texts, strict=True)]


def _of_table(table: pd.DataFrame, naming: Naming | None) -> list[Device]:
    unknown = [str(name) for name in table.columns if name not in COLUMNS]
    if "path" not in table.columns or unknown:
        what = f"found {', '.join(unknown)}" if unknown else "there is no path"
        raise OptionError(f"records: a table has the columns {', '.join(COLUMNS)}; {what}", code="records")
    found = []
    for row in table.to_dict("records"):
        paths = row["path"]
        first = paths if isinstance(paths, str | os.PathLike) else next(iter(paths))
        name = _text(row.get("device"))
        if not name:
            name = naming(_path(first)) if naming else Path(_path(first)).stem
        more = {column: _text(row.get(column)) for column in ("serial", "operator", "notes")}
        found.append(_device(name, paths, date=_date(row.get("date")), **more))
    return found


def _device(name: str, paths: Any, **more: str) -> Device:
    single = isinstance(paths, str | os.PathLike)
    texts = (_path(paths),) if single else tuple(_path(path) for path in paths)
    if not name or not texts:
        raise OptionError("records: a device has a name and a path", code="records")
    return Device(plain(name), texts, **{column: plain(text) for column, text in more.items()})


def _path(path: Any) -> str:
    if not isinstance(path, str | os.PathLike):
        raise OptionError(f"records: expected a path, found {type(path).__name__}", code="records")
    text = os.fspath(path)
    return os.path.abspath(text.decode() if isinstance(text, bytes) else text)


def _text(value: Any) -> str:
    if value is None or (isinstance(value, float) and value != value) or value is pd.NaT or value is pd.NA:
        return ""
    return str(value)


def _date(value: Any) -> str:
    if isinstance(value, datetime):
        return "" if value is pd.NaT else _utc(value)
    if isinstance(value, date):
        return value.isoformat()
    text = _text(value)
    if not text:
        return ""
    try:
        return (
            _utc(datetime.fromisoformat(text.replace("Z", "+00:00")))
            if "T" in text or ":" in text
            else (date.fromisoformat(text).isoformat())
        )
    except ValueError:
        raise OptionError(f"date: expected ISO 8601, e.g. 2026-11-28, found {text}", code="date") from None


def _utc(moment: datetime) -> str:
    """A moment without a zone counts as UTC."""
    aware = moment if moment.tzinfo else moment.replace(tzinfo=timezone.utc)
    return aware.astimezone(timezone.utc).isoformat(timespec="seconds")


def date_of(device: Device) -> str:
    """Date of the measurement, else that of the first file; empty where it cannot be told."""
    if device.date:
        return device.date
    try:
        changed = os.stat(device.paths[0]).st_mtime
    except OSError:
        return ""
    return datetime.fromtimestamp(changed, timezone.utc).isoformat(timespec="seconds")
