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

from importlib import import_module
from typing import TYPE_CHECKING, Any

from .._errors import missing

if TYPE_CHECKING:
    from .calibration import calibrate
    from .devices import Device
    from .history import drift, drifts
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

# Imported when first asked for: a worker process, which also runs the imports of the script that started it,
# needs neither the database nor pandas, and so begins within a fraction of the time.
_MODULES = {
    "Device": "devices",
    "Registry": "registry",
    "calibrate": "calibration",
    "difference": "models",
    "drift": "history",
    "drifts": "history",
    "model": "models",
    "outside": "region",
    "report": "page",
}


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    try:
        module = import_module(f".{_MODULES[name]}", __name__)
    except ModuleNotFoundError as error:
        raise missing((error.name or "a package").partition(".")[0], "fleet", "a fleet") from None
    return getattr(module, name)
