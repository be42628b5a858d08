"""Models of piezo actuators from measured records: hysteresis followed by fractional-order dynamics.

Read records, fit a model, assess its accuracy, run its inverse::

    import hysteron_models as hy

    loop, sweep = hy.read(["loop.csv", "sweep.csv"])
    stage = hy.Hammerstein(hysteresis="bouc-wen", dynamics="fractional").fit([loop, sweep], progress=True)
    print(stage.summary())
    prediction = stage.predict(hy.read("unseen.csv"), band=0.95)
    drive = stage.invert(reference, fs=10_000, limits=(0, 100)).u
    controller = stage.controller(10_000, limits=(0, 100))

All computation is by the library behind the command ``hysteron``: same numbers, model files and options.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from . import scorers
from ._errors import (
    ExportError,
    FileError,
    HysteronError,
    IdentifyError,
    MissingPackage,
    ModelError,
    OptionError,
    RegistryError,
)
from ._native import __version__
from .comparison import Comparison, choices, compare, compare_axes
from .design import Design, design
from .estimators import Branches, Estimator, Force, Hammerstein, Modes, Oscillator
from .excitation import excite, simulate_bench
from .model import Controller, Model, load
from .record import Content, Inspection, Record, contents, inspect, prepare, read, write
from .response import ExplainedResponse, frequency_response
from .results import Finding, FrequencyResponse, Inversion, Prediction, Realisation, Score, Tracking

if TYPE_CHECKING:
    from . import fleet, plots

__all__ = [
    "Branches",
    "Comparison",
    "Content",
    "Controller",
    "Design",
    "Estimator",
    "ExplainedResponse",
    "ExportError",
    "FileError",
    "Finding",
    "Force",
    "FrequencyResponse",
    "Hammerstein",
    "HysteronError",
    "IdentifyError",
    "Inspection",
    "Inversion",
    "MissingPackage",
    "Model",
    "ModelError",
    "Modes",
    "OptionError",
    "Oscillator",
    "Prediction",
    "Realisation",
    "Record",
    "RegistryError",
    "Score",
    "Tracking",
    "__version__",
    "choices",
    "compare",
    "compare_axes",
    "contents",
    "design",
    "excite",
    "fleet",
    "frequency_response",
    "inspect",
    "load",
    "plots",
    "prepare",
    "read",
    "scorers",
    "simulate_bench",
    "write",
]


def __getattr__(name: str) -> Any:
    """Plots and fleets are imported when first asked for: they need matplotlib, and pandas and SQLAlchemy."""
    if name in ("fleet", "plots"):
        import importlib

        return importlib.import_module(f".{name}", __name__)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
