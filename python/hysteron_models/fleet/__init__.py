"""Fleets of actuators: calibrate many devices, keep every result, compare devices with each other and with
themselves.

    from hysteron_models import Hammerstein, fleet

    stage = Hammerstein("bouc-wen", "none")
    table = fleet.calibrate("records/*.csv", stage, registry="sqlite:///fleet.sqlite")
    fleet.outside("sqlite:///fleet.sqlite")             # devices outside the fleet's 99 % region
    fleet.drift("sqlite:///fleet.sqlite", "A-0017")     # the latest calibration against the ten before
    fleet.report("sqlite:///fleet.sqlite", "fleet.html")

Needs the extra ``fleet``: pandas, SQLAlchemy, Alembic, Dask.
"""

from __future__ import annotations

from .._errors import missing

try:
    import alembic  # noqa: F401
    import pandas  # noqa: F401
    import sqlalchemy  # noqa: F401
except ImportError as error:
    raise missing((error.name or "a package").partition(".")[0], "fleet", "a fleet") from None

from .calibration import calibrate
from .devices import Device
from .drift import drift, drifts
from .models import difference, model
from .page import report
from .region import outside
from .registry import Registry

__all__ = [
    "Device",
    "Registry",
    "calibrate",
    "difference",
    "drift",
    "drifts",
    "model",
    "outside",
    "report",
]
