"""Rows of the registry as Python objects and tables."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pandas as pd
from sqlalchemy import Select, func, select, tuple_

from .._errors import RegistryError
from .registry import Registry
from .schema import calibrations, devices, parameters
from .work import Outcome

# Keys in one query: SQLite takes some ten thousand variables.
AT_ONCE = 500
COLUMNS = (
    devices.c.name.label("device"),
    devices.c.serial,
    calibrations.c.date,
    calibrations.c.status,
    calibrations.c.reason,
    calibrations.c.cause,
    calibrations.c.kind,
    calibrations.c.rmse,
    calibrations.c.fit_percent,
    calibrations.c.unit,
    calibrations.c.seconds,
    calibrations.c.operator,
    calibrations.c.notes,
    calibrations.c.report,
    calibrations.c.record_sha256,
    calibrations.c.program,
    calibrations.c.finished,
    calibrations.c.key,
)


def finished_keys(registry: Registry, options: str, program: str) -> dict[str, set[str]]:
    """Devices by the keys of calibrations that need not be done again."""
    query = (
        select(calibrations.c.key, devices.c.name)
        .join(devices, devices.c.id == calibrations.c.device_id)
        .where(calibrations.c.options == options, calibrations.c.program == program)
        .where(calibrations.c.cause != "machine")
    )
    known: dict[str, set[str]] = {}
    with registry.engine.connect() as connection:
        for key, name in connection.execute(query):
            known.setdefault(key, set()).add(name)
    return known


def outcome_of(registry: Registry, key: str) -> Outcome:
    """Outcome of a calibration that was done."""
    names = [name for name in Outcome.__dataclass_fields__ if name != "parameters"]
    with registry.engine.connect() as connection:
        query = select(calibrations).where(calibrations.c.key == key, calibrations.c.cause != "machine")
        row = connection.execute(query.limit(1)).mappings().first()
        if row is None:
            raise RegistryError(f"{registry.shown} has no calibration {key}", code="no-calibration")
        own = (
            select(parameters).where(parameters.c.calibration_id == row["id"]).order_by(parameters.c.position)
        )
        found = [dict(p) for p in connection.execute(own).mappings()]
    for parameter in found:
        del parameter["calibration_id"], parameter["position"]
    return Outcome(**{name: row[name] for name in names}, parameters=found)


def rows_of(registry: Registry, places: list[tuple[str, str]]) -> pd.DataFrame:
    """Calibrations by device and key, in this order."""
    found: dict[tuple[str, str], dict[str, Any]] = {}
    with registry.engine.connect() as connection:
        for k in range(0, len(places), AT_ONCE):
            some = places[k : k + AT_ONCE]
            query = _joined().where(tuple_(devices.c.name, calibrations.c.key).in_(some))
            for row in connection.execute(query).mappings():
                found[row["device"], row["key"]] = dict(row)
    return _frame(found[place] for place in places)


def table(registry: Registry, device: str | None = None, latest: bool = False) -> pd.DataFrame:
    """Calibrations by device and date, of one device or of all; ``latest``: the last of each device."""
    query = _joined().order_by(devices.c.name, calibrations.c.date, calibrations.c.id)
    if device is not None:
        query = query.where(devices.c.name == device)
    if latest:
        query = query.where(calibrations.c.id.in_(latest_ids()))
    with registry.engine.connect() as connection:
        return _frame(dict(row) for row in connection.execute(query).mappings())


def latest_ids() -> Select[Any]:
    """Numbers of the latest calibration of each device: by date, then by the order of writing."""
    order = func.row_number().over(
        partition_by=calibrations.c.device_id, order_by=(calibrations.c.date.desc(), calibrations.c.id.desc())
    )
    ranked = select(calibrations.c.id, order.label("place")).subquery()
    return select(ranked.c.id).where(ranked.c.place == 1)


def _joined() -> Select[Any]:
    return select(*COLUMNS).join(devices, devices.c.id == calibrations.c.device_id)


def _frame(rows: Iterable[dict[str, Any]]) -> pd.DataFrame:
    return pd.DataFrame(list(rows), columns=[column.name for column in COLUMNS])


def parameter_table(registry: Registry, latest: bool, device: str | None = None) -> pd.DataFrame:
    """Parameters that were fitted, a row each: device, date, calibration, options, name, value, std_error."""
    query = (
        select(
            devices.c.name.label("device"),
            calibrations.c.id.label("calibration"),
            calibrations.c.date,
            calibrations.c.options,
            parameters.c.block,
            parameters.c.name,
            parameters.c.value,
            parameters.c.std_error,
            parameters.c.unit,
        )
        .select_from(parameters)
        .join(calibrations, calibrations.c.id == parameters.c.calibration_id)
        .join(devices, devices.c.id == calibrations.c.device_id)
        .where(parameters.c.held.is_(False), calibrations.c.status == "ok")
        # The memory that a record began with is not the device's.
        .where(parameters.c.block != "start")
        .order_by(devices.c.name, calibrations.c.date, calibrations.c.id, parameters.c.position)
    )
    if latest:
        query = query.where(calibrations.c.id.in_(latest_ids()))
    if device is not None:
        query = query.where(devices.c.name == device)
    with registry.engine.connect() as connection:
        found = [dict(row) for row in connection.execute(query).mappings()]
    columns = [column.name for column in query.selected_columns]
    frame = pd.DataFrame(found, columns=columns)
    return frame.astype({"value": float, "std_error": float})
