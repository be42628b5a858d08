"""Exceptions of the package, and remedies in terms of its arguments."""

from __future__ import annotations

import json
from typing import Any

_REMEDIES = {
    "choose-columns": 'name them with input="…" and output="…"',
    "choose-response": 'choose one with response="…"',
    "give-sample-rate": "give the sample rate with fs=…",
    "resample": (
        "resample it with hy.prepare(record, fs=…), or give fs=… where the stamps are only badly written"
    ),
    "continue-run": "take the records as parts of one run with continued=True",
    "cut-otherwise": "keep another part: start=…, stop=…, where=…, turns=…",
    "give-start": "rest=… or settled=… say otherwise",
    "score-all": "skip=0 scores them",
    "give-period": "give the length of a period with period=…",
    "name-dynamic-record": "add a record that carries dynamics",
    "drive-range": "give another range of the drive with limits=(low, high)",
    "drive-rate": "allow a higher rate of the drive with slew=…",
    "creep-that-ends": 'identify with creep="kelvin-voigt"',
    "narrow-band": "take points between two frequencies only",
    "other-hysteresis": 'choose another family with hysteresis="…"',
    "fit-jointly": 'leave method and dynamics="arx" ("oe", "bj", "srivc") out',
    "no-dynamics": 'choose dynamics="none", or resample with hy.prepare(record, fs=…)',
    "search-longer": "allow more generations=…, or leave optimizer out",
    "give-exponent": "give the exponent with which modes follow the level: exponent=…",
}


def in_arguments(advice: dict[str, Any]) -> str:
    """Express a remedy of the library in arguments of this package."""
    do = advice.get("do", "")
    if do == "choose-column":
        example = advice.get("example")
        return f'choose the column with {advice.get("role", "input").replace("-", "_")}="{example or "…"}"'
    if do == "scale-column":
        return f'say what it means: scale=["{advice["column"]}=2.5um/V"]'
    if do == "several-axes":
        return f"identify all actuators together: inputs={advice['inputs']}, outputs={advice['outputs']}"
    if do == "dead-band":
        return f"read the record with dead_{'zone' if advice['excess'] else 'band'}={advice['threshold']}"
    if do == "widen":
        return f'widen its range: bounds={{"{advice["parameter"]}": (low, high)}}'
    if do == "hold":
        return f'hold it: fixed={{"{advice.get("parameter") or "name"}": value}}'
    return _REMEDIES.get(do, "")


def with_arguments(text: str, advice: str | None) -> str:
    """Append the remedy to a statement."""
    hint = in_arguments(json.loads(advice)) if advice else ""
    return f"{text} ({hint})" if hint else text


class HysteronError(Exception):
    """Base class of the package's exceptions.

    Attributes:
        code: names of the error, from the outside in, e.g. ``"not-a-number"``.
        file: the file it is about, if any.
        line: the line in it, from 1.
        column: the column in it, from 1.
        hint: remedy, or ``None``.
    """

    def __init__(
        self,
        message: str,
        *,
        code: str = "",
        file: str | None = None,
        line: int | None = None,
        column: int | None = None,
        advice: str | None = None,
        hint: str | None = None,
    ) -> None:
        self.code = code
        self.file = file
        self.line = line
        self.column = column
        self.hint = hint or ((in_arguments(json.loads(advice)) or None) if advice else None)
        super().__init__(f"{message} ({self.hint})" if self.hint else message)


class FileError(HysteronError):
    """A file cannot be read or written."""


class ModelError(HysteronError):
    """A record or a model cannot be used as asked."""


class IdentifyError(HysteronError):
    """No model was identified."""


class ExportError(HysteronError):
    """A model cannot be exported."""


class OptionError(HysteronError, ValueError):
    """An option is invalid."""


class RegistryError(HysteronError):
    """A registry of calibrations cannot be read or written."""


class MissingPackage(HysteronError, ImportError):
    """A package that is an extra of this one is not installed."""


def missing(package: str, extra: str, purpose: str) -> MissingPackage:
    """Make the exception for an extra that is not installed."""
    return MissingPackage(
        f"{purpose} needs {package}: install it with  pip install 'hysteron-models[{extra}]'",
        code="missing-package",
    )
