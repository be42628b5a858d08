"""Drift: the latest calibration of a device against those before."""

from __future__ import annotations

import numpy as np
import pandas as pd

from .. import _native
from .._errors import OptionError
from ..record import PathLike
from .registry import Registry, opened
from .rows import parameter_table

# With fewer earlier values, their scatter says too little.
FEWEST = 3
LEVEL = 0.99
COLUMNS = (
    "device", "parameter", "unit", "latest", "before", "count", "change_percent", "t", "degrees", "p",
    "significant",
)  # fmt: skip


def drift(
    registry: Registry | str | PathLike, device: str, *, last: int = 10, level: float = LEVEL
) -> pd.DataFrame:
    """The latest calibration of a device against its ``last`` ones before, parameter by parameter.

    t = (x − m)/(s √(1 + 1/n)) with mean m and variance s² of the n earlier values; Student's t with n − 1
    degrees of freedom. Standard errors do not enter: where the residual is systematic, as with most stacks,
    they say little about how well a calibration repeats. With fewer than three earlier values they are all
    there is: s² is their mean square, and t is normal. Calibrations with other options are left out.

    Args:
        registry: URL, path or open registry.
        device: its name.
        last: earlier calibrations that count, at most.
        level: a change is ``significant`` if the probability of a larger one in any of the parameters is
            below 1 − ``level`` (Bonferroni).

    Raises:
        OptionError: no calibration of this device succeeded, or only one.
    """
    table = parameter_table(opened(registry), latest=False, device=device)
    found = _of_device(table, last, level)
    if found is None:
        raise OptionError(f"{device}: drift needs two calibrations with the same options", code="no-history")
    return found


def drifts(registry: Registry | str | PathLike, *, last: int = 10, level: float = LEVEL) -> pd.DataFrame:
    """Changes of all devices that are significant, by their probability; see :func:`drift`.

    ``level`` holds for each device: of many devices without drift, a share 1 − ``level`` is listed.
    """
    table = parameter_table(opened(registry), latest=False)
    several = [_of_device(rows, last, level) for _, rows in table.groupby("device", sort=True)]
    found = [rows[rows["significant"]] for rows in several if rows is not None]
    if not found:
        return pd.DataFrame(columns=list(COLUMNS))
    return pd.concat(found).sort_values("p", kind="stable").reset_index(drop=True)


def histories(table: pd.DataFrame, device: str, parameter: str) -> pd.DataFrame:
    """``date`` and ``value`` of a parameter over the calibrations that drift compares."""
    own = table[(table["device"] == device) & (table["name"] == parameter)]
    return own[own["options"] == own["options"].iloc[-1]][["date", "value"]]


def _of_device(table: pd.DataFrame, last: int, level: float) -> pd.DataFrame | None:
    """``table``: parameters of one device by date."""
    if table.empty:
        return None
    options = table["options"].iloc[-1]
    table = table[table["options"] == options]
    order = list(dict.fromkeys(table["calibration"]))[-(last + 1) :]
    if len(order) < 2:
        return None
    table = table[table["calibration"].isin(order)]
    latest = table[table["calibration"] == order[-1]]
    rows = []
    for _, new in latest.iterrows():
        old = table[(table["name"] == new["name"]) & (table["calibration"] != order[-1])]
        if not old.empty:
            rows.append(_change(new, old))
    found = pd.DataFrame(rows, columns=list(COLUMNS))
    found["significant"] = found["p"] * len(found) < 1.0 - level
    return found


def _change(new: pd.Series[object], old: pd.DataFrame) -> dict[str, object]:
    values = old["value"].to_numpy()
    count, mean = len(values), float(np.mean(values))
    errors = np.square(np.append(old["std_error"].to_numpy(), float(new["std_error"])))
    known = float(np.nanmean(errors)) if np.isfinite(errors).any() else 0.0
    degrees = count - 1.0 if count >= FEWEST else np.inf
    variance = float(np.var(values, ddof=1)) if count >= FEWEST else known
    latest = float(new["value"])
    deviation = np.sqrt(variance * (1.0 + 1.0 / count))
    t = (latest - mean) / deviation if deviation > 0 else np.nan
    return {
        "device": new["device"],
        "parameter": new["name"],
        "unit": new["unit"],
        "latest": latest,
        "before": mean,
        "count": count,
        "change_percent": 100.0 * (latest / mean - 1.0) if mean else np.nan,
        "t": t,
        "degrees": degrees,
        "p": _native.student_tail(t, degrees),
    }
