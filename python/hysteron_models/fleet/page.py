"""Report of a fleet: one page that works offline."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from sqlalchemy import func, select

from .. import _native
from .._errors import OptionError
from ..record import PathLike
from ..results import write_text
from .history import LEVEL as DRIFT_LEVEL
from .history import drifts, histories
from .region import LEVEL, outside
from .registry import Registry, opened
from .rows import latest_ids, parameter_table, table
from .schema import calibrations, devices

WORST = 9
# Panels of distributions at most; families with hundreds of weights have their own reports.
MOST_PARAMETERS = 24


def report(
    registry: Registry | str | PathLike,
    path: PathLike,
    *,
    title: str = "Fleet of devices",
    level: float = LEVEL,
    last: int = 10,
) -> None:
    """Write the page of a fleet: distributions of parameters, devices outside the region, drift over time,
    worst fits with their loops, failures, links to the reports of the fits.

    Args:
        registry: URL, path or open registry.
        path: file to write; links lead from its folder.
        title: title of the page.
        level: share of the fleet within the region; see :func:`outside`.
        last: earlier calibrations that drift compares with; see :func:`drift`.
    """
    kept = opened(registry)
    folder = Path(os.path.abspath(path)).parent
    latest = table(kept, latest=True)
    links = {row["device"]: _link(row["report"], folder) for row in _rows(latest)}
    parameters = parameter_table(kept, latest=False)
    with kept.engine.connect() as connection:
        count = connection.execute(select(func.count()).select_from(calibrations)).scalar_one()
    region, out = _region(kept, level, links)
    page = {
        "title": title,
        "sources": [f"Registry {kept.shown}"],
        "devices": [_device(row, links) for row in _rows(latest)],
        "calibrations": count,
        "distributions": _distributions(parameter_table(kept, latest=True)),
        "region": region,
        "outside": out,
        "drift": (
            f"The latest calibration of a device against up to {last} before, with the same options: changes "
            f"that chance makes in {100 * (1 - DRIFT_LEVEL):.0f} % of the devices without drift, or fewer."
        ),
        "drifts": _drifts(kept, parameters, last),
        "worst": _worst(kept, links),
    }
    write_text(path, _native.fleet_page(json.dumps(page)))


def _rows(frame: pd.DataFrame) -> list[dict[str, Any]]:
    return [{str(k): v for k, v in row.items()} for row in frame.to_dict("records")]


def _link(target: str, folder: Path) -> str:
    return os.path.relpath(target, folder) if target else ""


def _number(value: Any) -> float | None:
    return None if value is None or not np.isfinite(float(value)) else float(value)


def _device(row: dict[str, Any], links: dict[str, str]) -> dict[str, Any]:
    failed = row["status"] != "ok"
    return {
        "device": row["device"],
        "serial": row["serial"],
        "date": row["date"][:10],
        "reason": (row["reason"] or "failed") if failed else "",
        "rmse": _number(row["rmse"]),
        "fit_percent": _number(row["fit_percent"]),
        "unit": row["unit"],
        "report": links[row["device"]],
    }


def _distributions(latest: pd.DataFrame) -> list[dict[str, Any]]:
    known = latest[latest["std_error"].notna()]
    groups = [(key, rows) for key, rows in known.groupby(["name", "unit"], sort=False) if len(rows) > 1]
    return [
        {
            "name": str(name),
            "unit": str(unit),
            "values": [float(value) for value in rows["value"]],
            "std_error": _number(rows["std_error"].median()),
        }
        for (name, unit), rows in groups[:MOST_PARAMETERS]
    ]


def _region(registry: Registry, level: float, links: dict[str, str]) -> tuple[str, list[dict[str, Any]]]:
    try:
        found = outside(registry, level=level)
    except OptionError as error:
        return f"No region was drawn: {error}", []
    text = (
        f"{len(found)} of {found.attrs['devices']} devices lie outside the region that holds "
        f"{100 * level:g} % of a fleet like this one, robust distance {found.attrs['radius']:.2f}, "
        f"by {', '.join(found.attrs['parameters'])} (logarithms where of one sign). "
        f"Without any outlier, {100 * (1 - level):g} % would. "
        "The parameters that differ most follow with their distance from the median, in robust standard "
        "deviations."
    )
    rows = [{**row, "report": links.get(str(row["device"]), "")} for row in _rows(found)]
    return text, rows


def _drifts(registry: Registry, parameters: pd.DataFrame, last: int) -> list[dict[str, Any]]:
    found = []
    for row in _rows(drifts(registry, last=last)):
        history = histories(parameters, row["device"], row["parameter"]).tail(last + 1)
        dates = pd.to_datetime(history["date"], utc=True, format="ISO8601", errors="coerce")
        days = (dates - dates.min()).dt.total_seconds() / 86400
        found.append(
            {
                "device": row["device"],
                "parameter": row["parameter"],
                "unit": row["unit"],
                "days": [float(day) for day in days.fillna(0.0)],
                "values": [float(value) for value in history["value"]],
                "change_percent": _number(row["change_percent"]),
                "p": float(row["p"]),
            }
        )
    return found


def _worst(registry: Registry, links: dict[str, str]) -> list[dict[str, Any]]:
    query = (
        select(
            devices.c.name,
            *(calibrations.c[name] for name in ("rmse", "fit_percent", "input_unit", "unit", "curves")),
        )
        .join(devices, devices.c.id == calibrations.c.device_id)
        .where(calibrations.c.status == "ok", calibrations.c.curves.is_not(None))
        .where(calibrations.c.id.in_(latest_ids()))
        .order_by(calibrations.c.fit_percent, devices.c.name)
        .limit(WORST)
    )
    with registry.engine.connect() as connection:
        rows = list(connection.execute(query).mappings())
    found = []
    for row in rows:
        curves = json.loads(row["curves"])
        points = [
            point
            for point in zip(curves["u"], curves["measured"], curves["model"], strict=True)
            if None not in point
        ]
        u, measured, model = (
            (list(column) for column in zip(*points, strict=True)) if points else ([], [], [])
        )
        found.append(
            {
                "device": row["name"],
                "rmse": row["rmse"] or 0.0,
                "fit_percent": row["fit_percent"],
                "input_unit": row["input_unit"],
                "unit": row["unit"],
                "u": u,
                "measured": measured,
                "model": model,
                "report": links.get(row["name"], ""),
            }
        )
    return found
