"""Models of the registry: read back, compared."""

from __future__ import annotations

import json

import pandas as pd
from sqlalchemy import select

from .. import _native
from .._errors import OptionError
from ..model import Model
from ..record import PathLike
from .registry import Registry, opened
from .schema import calibrations, devices


def model(registry: Registry | str | PathLike, device: str, back: int = 0) -> Model:
    """Model of a device: of its latest calibration that succeeded, or of the one ``back`` before it.

    Raises:
        OptionError: the registry has no such model.
    """
    query = (
        select(calibrations.c.model)
        .join(devices, devices.c.id == calibrations.c.device_id)
        .where(devices.c.name == device, calibrations.c.status == "ok")
        .order_by(calibrations.c.date.desc(), calibrations.c.id.desc())
        .offset(back)
        .limit(1)
    )
    kept = opened(registry)
    with kept.engine.connect() as connection:
        text = connection.execute(query).scalar()
    if text is None:
        which = f"{back} before the latest" if back else "yet"
        raise OptionError(f"{kept.shown} has no model of {device} {which}", code="no-model")
    return Model(_native.Model.from_json(text))


def difference(first: Model, second: Model) -> pd.DataFrame:
    """Difference of two models of one structure, number by number, in combined standard errors.

    Returns:
        A row a number: ``first``, ``second``, ``in_standard_errors``, ``p``, ``significant`` (beyond three).
        The test of all numbers together, Wald's χ² with their covariances, is in ``.attrs["joint"]``, and in
        ``.attrs["significant"]`` whether the models differ. Both assume independent records.

    Raises:
        ModelError: models of different kinds, families or units.
    """
    text, significant = _native.difference_of(first._native, second._native)
    found = json.loads(text)
    table = pd.DataFrame(found["numbers"]).set_index("name")
    table.attrs = {"joint": found["joint"], "significant": significant}
    return table
