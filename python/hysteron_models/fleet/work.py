"""The calibration of one device in a worker: paths in, numbers out."""

from __future__ import annotations

import json
import math
import os
import time
from dataclasses import dataclass, field
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

import numpy as np

from .._errors import FileError, HysteronError
from ..estimators import Estimator
from ..record import Array, Record, read
from .key import hash_of

# Points of a loop that are kept for small pictures.
POINTS = 160


@dataclass(frozen=True)
class Task:
    """A calibration to do.

    Attributes:
        key: hash of record, options and program.
        record_sha256: hash of the record, as the client saw it.
        paths: files of the record.
        estimator: not fitted.
        reading: options of :func:`hysteron_models.read`.
        report: path of the report to write; ``""`` for none.
        name: name of the device, for the report.
    """

    key: str
    record_sha256: str
    paths: tuple[str, ...]
    estimator: Estimator
    reading: dict[str, Any]
    report: str = ""
    name: str = ""


@dataclass(frozen=True)
class Outcome:
    """Result of a calibration: what the registry keeps of it.

    Attributes:
        status: ``ok`` or ``failed``.
        reason: why it failed, or why there is no report.
        cause: of a failure: ``record``, which fails again, or ``machine``, which need not.
        parameters: rows of the table of parameters.
    """

    status: str
    reason: str = ""
    cause: str = ""
    kind: str | None = None
    model: str | None = None
    scores: str = "[]"
    findings: str = "[]"
    rmse: float | None = None
    fit_percent: float | None = None
    input_unit: str = ""
    unit: str = ""
    seconds: float | None = None
    report: str = ""
    curves: str | None = None
    finished: str = ""
    parameters: list[dict[str, Any]] = field(default_factory=list)

    def row(self) -> dict[str, Any]:
        """Columns of the table of calibrations."""
        columns = dict(vars(self))
        columns.pop("parameters")
        return columns


def now() -> str:
    """This moment in UTC, ISO 8601."""
    return datetime.now(timezone.utc).isoformat(timespec="seconds")


def plain(text: object) -> str:
    """Text that every database takes: no NUL, no lone surrogates of file names."""
    return str(text).replace("\0", "�").encode("utf-8", "backslashreplace").decode()


def failed(reason: object, cause: str) -> Outcome:
    """The outcome of a calibration that gave no model."""
    return Outcome("failed", plain(reason), cause, finished=now())


def calibrate_record(task: Task) -> Outcome:
    """Fit one device; whatever goes wrong, but an interrupt, is an outcome with its reason."""
    # Pools of threads that no option of a fit limits; its siblings have the other cores.
    os.environ.setdefault("RAYON_NUM_THREADS", "1")
    begun = time.perf_counter()
    try:
        records = read(list(task.paths), **task.reading)
        estimator = type(task.estimator)(**task.estimator.get_params())
        if getattr(estimator, "threads", 1) is None:
            estimator.set_params(threads=1)
        estimator.fit(records)
        outcome = _of_fit(estimator, records, task, begun)
    except HysteronError as error:
        outcome = failed(error, "record")
        if isinstance(error, FileError) and not _readable(task.paths):
            return failed(error, "machine")
    except (KeyboardInterrupt, SystemExit):
        raise
    except Exception as error:
        return failed(f"{type(error).__name__}: {error}", "machine")
    except BaseException as error:  # a panic of the library
        outcome = failed(f"{type(error).__name__}: {error}", "record")
    if hash_of(task.paths) != task.record_sha256:
        return failed("the record changed while it was calibrated", "machine")
    return outcome


def _readable(paths: tuple[str, ...]) -> bool:
    try:
        hash_of(paths)
    except OSError:
        return False
    return True


def _of_fit(estimator: Estimator, records: list[Record], task: Task, begun: float) -> Outcome:
    model = estimator.model_
    result = estimator.result_
    scores = estimator.scores_
    squares = sum(score.samples * score.rmse**2 for score in scores)
    samples = sum(score.samples for score in scores)
    fits = [score.fit_percent for score in scores if score.fit_percent is not None]
    rows = [
        {
            "block": p["of"],
            "name": p["name"],
            "value": _finite(p["value"]),
            "std_error": _finite(p["std_error"]),
            "unit": p["unit"],
            "held": bool(p["held"]),
        }
        for p in estimator.parameters()
    ]
    report, reason = task.report, ""
    if report:
        try:
            Path(report).parent.mkdir(parents=True, exist_ok=True)
            estimator.report(report, task.name)
        except (HysteronError, OSError) as error:
            report, reason = "", plain(f"no report was written: {error}")
    return Outcome(
        "ok",
        reason,
        kind=model.kind,
        model=model._native.to_json(),
        scores=json.dumps(result.get("records", [])),
        findings=json.dumps(result.get("findings", [])),
        rmse=_finite(math.sqrt(squares / samples)) if samples else None,
        fit_percent=_finite(min(fits)) if fits else None,
        input_unit=model.units[0],
        unit=scores[0].unit if scores else model.units[1],
        seconds=time.perf_counter() - begun,
        report=plain(report),
        curves=_curves(estimator, records[0]),
        finished=now(),
        parameters=rows,
    )


def _finite(value: float | None) -> float | None:
    return float(value) if value is not None and math.isfinite(value) else None


def _curves(estimator: Estimator, record: Record) -> str | None:
    """Drive, measured and simulated output of a record at some of its samples, six digits each."""
    try:
        prediction = estimator.model_.predict(record)
        drive = record.u
    except HysteronError:
        return None
    if prediction.measured is None or prediction.y.ndim != 1:
        return None
    kept = np.unique(np.linspace(0, len(drive) - 1, POINTS).astype(int))

    def digits(samples: Array) -> list[float | None]:
        return [_finite(float(f"{sample:.6g}")) for sample in samples[kept]]

    return json.dumps(
        {"u": digits(drive), "measured": digits(prediction.measured), "model": digits(prediction.y)}
    )
