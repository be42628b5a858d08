"""Results of models and fits: findings, scores, predictions, drives, responses."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ._errors import in_arguments, missing
from .record import Array, PathLike, Record

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

__all__ = [
    "Finding",
    "FrequencyResponse",
    "Inversion",
    "Prediction",
    "Realisation",
    "Score",
    "Tracking",
    "per_output",
    "write_text",
]


@dataclass(frozen=True)
class Finding:
    """A statement about records, a fit or a model, with a remedy."""

    kind: str
    topic: str
    text: str
    hint: str = ""

    def __str__(self) -> str:
        return f"{self.kind}: {self.text}" + (f" ({self.hint})" if self.hint else "")

    @classmethod
    def _of(cls, found: dict[str, Any]) -> Finding:
        advice = found.get("advice")
        return cls(found["kind"], found["topic"], found["text"], in_arguments(advice) if advice else "")


def per_output(offsets: Sequence[float]) -> float | tuple[float, ...]:
    """The offset of one output; a tuple for several."""
    return offsets[0] if len(offsets) == 1 else tuple(offsets)


@dataclass(frozen=True)
class Score:
    """How well a model describes a record, simulated in free run: no measured output is used.

    Attributes:
        record: name or path of the record.
        rmse: root mean square of the error, in ``unit``.
        max_abs_error: largest error, in ``unit``.
        fit_percent: 100 · (1 − ‖e‖₂/‖y − ȳ‖₂); ``None`` for a constant record.
        unit: unit of the output.
        samples: samples that were scored.
        offset: sensor offset added to the simulation; one a sensor where there are several.
        start: initial state, in words.
        series: the samples: drive, ``y``, ``y_model``, ``residual``; ``None`` for scores of a fit.
        details: everything else, as ``hysteron validate --json`` prints it.
        skip: seconds at the start that were not scored.
    """

    record: str
    rmse: float
    max_abs_error: float
    fit_percent: float | None
    unit: str
    samples: int
    offset: float | tuple[float, ...]
    start: str = ""
    series: Record | None = field(default=None, repr=False, compare=False)
    details: dict[str, Any] = field(default_factory=dict, repr=False, compare=False)
    skip: float = 0.0

    @classmethod
    def _of(
        cls,
        record: str,
        figures: tuple[str, float, float, float | None, int, list[float]],
        start: str = "",
        series: Record | None = None,
        details: dict[str, Any] | None = None,
        skip: float | None = None,
    ) -> Score:
        unit, rmse, largest, fit, samples, offsets = figures
        offset = per_output(offsets)
        return cls(
            record, rmse, largest, fit, unit, samples, offset, start, series, details or {}, skip or 0.0
        )


@dataclass(frozen=True)
class Prediction:
    """Output of a model for a record.

    Attributes:
        t: times [s].
        y: output, in ``unit``, with ``offset``; one column an output where there are several.
        lower: lower end of the band at each sample, where one was asked for.
        upper: upper end.
        unit: unit of the output.
        start: initial state, in words.
        offset: sensor offset added to the output; one an output where there are several.
        measured: measured output, in ``unit``, of a model of one output.
        level: level of the band.
        remarks: remarks for the user.
        name: name of the record.
    """

    t: Array
    y: Array
    lower: Array | None
    upper: Array | None
    unit: str
    start: str
    offset: float | tuple[float, ...] = 0.0
    measured: Array | None = None
    level: float | None = None
    remarks: tuple[str, ...] = ()
    name: str = "record"

    def to_pandas(self) -> pd.DataFrame:
        """Columns over time [s]."""
        try:
            import pandas as pd
        except ImportError:
            raise missing("pandas", "pandas", "a DataFrame") from None
        outputs = self.y if self.y.ndim == 2 else self.y[:, None]
        several = outputs.shape[1] > 1
        columns = {(f"y{k + 1}" if several else "y"): outputs[:, k] for k in range(outputs.shape[1])}
        for name, values in (("lower", self.lower), ("upper", self.upper), ("measured", self.measured)):
            if values is not None and values.ndim == 1:
                columns[name] = values
        return pd.DataFrame(columns, index=pd.Index(self.t, name="t_s"))

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw it over time; see :func:`hysteron_models.plots.time`."""
        from . import plots

        return plots.time(self, ax=ax)


@dataclass(frozen=True)
class Inversion:
    """The drive (zero-order hold) with which the output follows a reference.

    Attributes:
        t: times [s].
        u: drive, in the unit of the input.
        predicted: output of the model for it.
        reference: reference, in the unit of the output.
        summary: predicted error, limits reached, bandwidth, as ``hysteron invert --json`` prints it.
        findings: reasons why the output does not follow.
    """

    t: Array
    u: Array
    predicted: Array
    reference: Array
    summary: dict[str, Any] = field(repr=False)
    findings: tuple[Finding, ...] = ()


@dataclass(frozen=True)
class Tracking:
    """Simulated tracking of a reference in closed loop.

    Attributes:
        t: times [s].
        reference: reference, in the unit of the output.
        drives: drive by the name of the controller.
        displacements: displacement by the name of the controller.
        summary: errors, bandwidths and margins of each, as ``hysteron track --json`` prints it.
    """

    t: Array
    reference: Array
    drives: dict[str, Array] = field(repr=False)
    displacements: dict[str, Array] = field(repr=False)
    summary: dict[str, Any] = field(repr=False)
    _page: str = field(repr=False, default="")

    def report(self, path: PathLike) -> None:
        """Write the report, a page that works offline."""
        write_text(path, self._page)


@dataclass(frozen=True)
class FrequencyResponse:
    """Response of the dynamic block with its delay, or a measured one.

    Attributes:
        frequency_hz: frequencies [Hz].
        response: complex gain at each.
        std_dev: standard deviation σ of each gain, σ² = E|error|²; that of a measured response of several
            periods or records, ``None`` elsewhere.
        unit: unit of the gain, as in ``um_per_V``; empty for the dynamic block.
    """

    frequency_hz: Array
    response: NDArray[np.complex128]
    std_dev: Array | None = None
    unit: str = ""

    @property
    def magnitude(self) -> Array:
        """Magnitude."""
        return np.abs(self.response)

    @property
    def phase_deg(self) -> Array:
        """Phase, unwrapped [degrees]."""
        return np.degrees(np.unwrap(np.angle(self.response)))

    def to_control(self) -> Any:
        """Convert to ``control.FrequencyResponseData``."""
        try:
            import control
        except ImportError:
            raise missing("python-control", "control", "a frequency response of python-control") from None
        return control.FRD(self.response, 2 * np.pi * self.frequency_hz)

    def plot(self, axes: Sequence[Axes] | None = None, label: str = "dynamic block") -> Sequence[Axes]:
        """Draw magnitude and phase; see :func:`hysteron_models.plots.bode`."""
        from . import plots

        return plots.bode(self, axes=axes, label=label)


@dataclass(frozen=True)
class Realisation:
    """The dynamic block at one sample rate, as a controller runs it: x⁺ = A x + B w, v = C x + D w.

    Attributes:
        a: state matrix.
        b: input matrix, n × 1.
        c: output matrix, 1 × n.
        d: direct gain, 1 × 1.
        sample_rate_hz: the rate [Hz].
        summary: sections, accuracy and what was checked, as ``hysteron realise --json`` prints it.
    """

    a: Array
    b: Array
    c: Array
    d: Array
    sample_rate_hz: float
    summary: dict[str, Any] = field(repr=False)

    def to_scipy(self) -> Any:
        """Convert to ``scipy.signal.StateSpace``."""
        try:
            from scipy import signal
        except ImportError:
            raise missing("scipy", "control", "a state space of scipy") from None
        return signal.StateSpace(self.a, self.b, self.c, self.d, dt=1.0 / self.sample_rate_hz)

    def to_control(self) -> Any:
        """Convert to ``control.StateSpace``."""
        try:
            import control
        except ImportError:
            raise missing("python-control", "control", "a state space of python-control") from None
        return control.ss(self.a, self.b, self.c, self.d, 1.0 / self.sample_rate_hz)


def write_text(path: PathLike, text: str) -> None:
    """Write a whole file, or none of it."""
    beside = f"{os.fspath(path)}.{os.getpid()}.tmp"
    try:
        with open(beside, "w", encoding="utf-8") as out:
            out.write(text)
        os.replace(beside, path)
    except BaseException:
        if os.path.exists(beside):
            os.remove(beside)
        raise
