"""Records: read from files of any format, made of arrays, prepared, inspected, written."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._errors import OptionError, in_arguments, missing

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

Array = NDArray[np.float64]
PathLike = str | os.PathLike[str]

__all__ = ["Content", "Inspection", "Record", "contents", "inspect", "prepare", "read", "write"]


def as_samples(values: ArrayLike, name: str) -> Array:
    """Contiguous vector in double precision; strided, float32, pandas and lists are accepted."""
    array = np.ascontiguousarray(values, dtype=np.float64)
    if array.ndim == 2 and 1 in array.shape:
        array = array.reshape(-1)
    if array.ndim != 1:
        raise OptionError(f"{name}: expected one list of samples, found shape {array.shape}", code="shape")
    return array


class Record:
    """Measured channels on a time base; never changed in place.

    Args:
        u: samples of the input, or a mapping from names with units (``"u_V"``) to samples of any number of
            channels.
        y: samples of the output; ``None`` for a drive alone.
        fs: sample rate [Hz].
        t: times [s], increasing; they need not be uniform.
        units: units of input and output.
        valid: which samples count; all, if not given.
        name: a name for messages and reports.
        start: time of the first sample [s], with ``fs``.
        input: which channel is the input, where that is not clear from the names.
        output: which channel is the output.
        rate: which channel is the measured rate of the input, for a model of the kind ``force``.
        dead_band: threshold below which the input counts as 0, in its unit: ``u`` is then what counts.
        dead_zone: the same, where a larger input counts by what exceeds the threshold.

    Raises:
        ModelError: samples that are not finite, arrays of different lengths, decreasing times.
        OptionError: arguments that contradict each other.
    """

    def __init__(
        self,
        u: ArrayLike | Mapping[str, ArrayLike],
        y: ArrayLike | None = None,
        *,
        fs: float | None = None,
        t: ArrayLike | None = None,
        units: tuple[str, str] = ("V", "um"),
        valid: ArrayLike | None = None,
        name: str = "record",
        start: float = 0.0,
        input: str | None = None,
        output: str | None = None,
        rate: str | None = None,
        dead_band: float | None = None,
        dead_zone: float | None = None,
    ) -> None:
        if isinstance(u, Mapping):
            if y is not None:
                raise OptionError("give y within the mapping of channels", code="channels")
            channels = [
                (*_native.split_header(header), as_samples(samples, header)) for header, samples in u.items()
            ]
        else:
            channels = [("u", units[0], as_samples(u, "u"))]
            if y is not None:
                channels.append(("y", units[1], as_samples(y, "y")))
        times = None if t is None else as_samples(t, "t")
        mask = None if valid is None else np.ascontiguousarray(valid, dtype=np.bool_)
        native = _native.Record(name, channels, fs, start, times, mask)
        native = _counted(native, input, output, dead_band, dead_zone)
        self._native = native if rate is None else native.with_rate(rate)
        self._input, self._output, self._rate = input, output, rate

    @classmethod
    def _of(
        cls,
        native: _native.Record,
        input: str | None = None,
        output: str | None = None,
        rate: str | None = None,
    ) -> Record:
        made = cls.__new__(cls)
        made._native = native if rate is None else native.with_rate(rate)
        made._input, made._output, made._rate = input, output, rate
        return made

    @property
    def name(self) -> str:
        """Name, usually that of the file."""
        return self._native.name

    @property
    def path(self) -> str | None:
        """Path of the file it was read from."""
        return self._native.path

    @property
    def fs(self) -> float | None:
        """Sample rate [Hz]; ``None`` where it is not uniform or not known."""
        return self._native.sample_rate_hz

    @property
    def t(self) -> Array:
        """Times [s]; numbers of samples where there are none."""
        times = self._native.times()
        return np.arange(len(self), dtype=np.float64) if times is None else times

    @property
    def has_times(self) -> bool:
        """Whether ``t`` is in seconds."""
        return self._native.has_times

    @property
    def channels(self) -> dict[str, str]:
        """Unit of every channel by its name."""
        return dict(self._native.channels)

    @property
    def valid(self) -> NDArray[np.bool_]:
        """Which samples count."""
        mask = self._native.valid()
        return np.ones(len(self), dtype=np.bool_) if mask is None else mask

    def _selected(self) -> tuple[int, int]:
        return self._native.select(self._input, self._output)

    @property
    def u(self) -> Array:
        """Samples of the input, in the unit of its column."""
        channels = self._native.channels
        return self._native.samples(0 if len(channels) == 1 else self._selected()[0])

    @property
    def y(self) -> Array:
        """Samples of the output, in the unit of its column."""
        return self._native.samples(self._selected()[1])

    @property
    def units(self) -> tuple[str, str]:
        """Units of ``u`` and ``y``."""
        channels = self._native.channels
        if len(channels) == 1:
            return channels[0][1], ""
        first, second = self._selected()
        return channels[first][1], channels[second][1]

    def __getitem__(self, name: str) -> Array:
        """Samples of a channel by its name, with or without its unit."""
        found = [k for k, (n, unit) in enumerate(self._native.channels) if name in (n, f"{n}_{unit}")]
        if len(found) != 1:
            known = ", ".join(self.channels)
            raise KeyError(f"no one channel of {self.name} is called {name}: there are {known}")
        return self._native.samples(found[0])

    def __len__(self) -> int:
        return len(self._native)

    def __repr__(self) -> str:
        columns = ", ".join(f"{n} [{unit}]" if unit else n for n, unit in self._native.channels)
        rate = f"{self.fs:g} Hz" if self.fs else ("uneven stamps" if self.has_times else "no times")
        return f"<Record {self.name}: {len(self)} samples, {rate}; {columns}>"

    def __reduce__(self) -> tuple[Any, ...]:
        return _rebuilt, (self._state(),)

    def _state(self) -> dict[str, Any]:
        native = self._native
        return {
            "name": native.name,
            "channels": [(n, unit, native.samples(k)) for k, (n, unit) in enumerate(native.channels)],
            "fs": native.sample_rate_hz,
            "t": native.times(),
            "valid": native.valid(),
            "input": self._input,
            "output": self._output,
            "rate": self._rate,
        }

    def to_pandas(self) -> pd.DataFrame:
        """Channels as columns ``name_unit`` over time [s]."""
        try:
            import pandas as pd
        except ImportError:
            raise missing("pandas", "pandas", "a DataFrame") from None
        columns = {
            (f"{n}_{unit}" if unit else n): self._native.samples(k)
            for k, (n, unit) in enumerate(self._native.channels)
        }
        return pd.DataFrame(columns, index=pd.Index(self.t, name="t_s" if self.has_times else "sample"))

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the loop, output over input; see :mod:`hysteron_models.plots`."""
        from . import plots

        return plots.loop(self, ax=ax)

    def save(self, path: PathLike) -> None:
        """Write the record, see :func:`write`."""
        write(path, self)


def as_records(records: Record | Sequence[Record]) -> list[Record]:
    """The records given, at least one."""
    given = [records] if isinstance(records, Record) else list(records)
    for one in given:
        if not isinstance(one, Record):
            raise OptionError(
                f"expected records, found {type(one).__name__}: make one with hy.Record(u, y, fs=…) or "
                "hy.read(path)",
                code="no-record",
            )
    if not given:
        raise OptionError("no record is given", code="no-record")
    return given


def natives(records: Sequence[Record]) -> list[_native.Record]:
    """The records as the library takes them."""
    return [record._native for record in records]


def _rebuilt(state: dict[str, Any]) -> Record:
    times, fs = state["t"], state["fs"]
    uniform = fs is not None and times is not None
    start = float(times[0]) if uniform else 0.0
    given = None if uniform else times
    native = _native.Record(state["name"], state["channels"], fs, start, given, state["valid"])
    return Record._of(native, state["input"], state["output"], state["rate"])


def _counted(
    native: _native.Record,
    input: str | None,
    output: str | None,
    dead_band: float | None,
    dead_zone: float | None,
) -> _native.Record:
    if dead_band is None and dead_zone is None:
        return native
    return native.with_dead_band(dead_band, dead_zone, input, output)


def _reading(
    time: str | None,
    input: str | None,
    output: str | None,
    fs: float | None,
    start: float | None,
    stop: float | None,
    where: str | Sequence[str],
    turns: str | None,
    rename: Mapping[str, str],
    drop: Sequence[str],
    max_bytes: int | None,
) -> str:
    options: dict[str, Any] = {
        "time": time,
        "input": input,
        "output": output,
        "sample_rate_hz": fs,
        "leave_out": list(drop),
        "cut": {"from_s": start, "to_s": stop},
    }
    if max_bytes is not None:
        options["max_bytes"] = max_bytes
    return json.dumps(
        {
            "options": options,
            "rename": [f"{old}={new}" for old, new in rename.items()],
            "conditions": [where] if isinstance(where, str) else list(where),
            "turns": turns,
        }
    )


@overload
def read(
    path: PathLike,
    *,
    time: str | None = ...,
    input: str | None = ...,
    output: str | None = ...,
    rate: str | None = ...,
    fs: float | None = ...,
    start: float | None = ...,
    stop: float | None = ...,
    where: str | Sequence[str] = ...,
    turns: str | None = ...,
    rename: Mapping[str, str] | None = ...,
    drop: Sequence[str] = ...,
    max_bytes: int | None = ...,
    dead_band: float | None = ...,
    dead_zone: float | None = ...,
) -> Record: ...
@overload
def read(
    path: list[PathLike] | tuple[PathLike, ...],
    *,
    time: str | None = ...,
    input: str | None = ...,
    output: str | None = ...,
    rate: str | None = ...,
    fs: float | None = ...,
    start: float | None = ...,
    stop: float | None = ...,
    where: str | Sequence[str] = ...,
    turns: str | None = ...,
    rename: Mapping[str, str] | None = ...,
    drop: Sequence[str] = ...,
    max_bytes: int | None = ...,
    dead_band: float | None = ...,
    dead_zone: float | None = ...,
) -> list[Record]: ...
def read(
    path: PathLike | list[PathLike] | tuple[PathLike, ...],
    *,
    time: str | None = None,
    input: str | None = None,
    output: str | None = None,
    rate: str | None = None,
    fs: float | None = None,
    start: float | None = None,
    stop: float | None = None,
    where: str | Sequence[str] = (),
    turns: str | None = None,
    rename: Mapping[str, str] | None = None,
    drop: Sequence[str] = (),
    max_bytes: int | None = None,
    dead_band: float | None = None,
    dead_zone: float | None = None,
) -> Record | list[Record]:
    """Read a record, or a list of records, of any format; the format is detected by the content.

    Args:
        path: a file, or a list of files.
        time: the time column, if it is not called ``t`` or ``time``.
        input: the input column, where that is not clear from the names.
        output: the output column.
        rate: the column of the measured rate of the input, for a model of the kind ``force``.
        fs: sample rate [Hz], where the file has no times or coarsely rounded ones.
        start: first time that is kept [s].
        stop: last time that is kept [s].
        where: conditions on columns for the samples kept: ``"segment=2..7"``, or several of these.
        turns: turning points of the drive between which samples are kept: ``"2:9"``.
        rename: new names of columns.
        drop: columns that are not read.
        max_bytes: largest file that is read.
        dead_band: threshold below which the input counts as 0, in its unit, as of a valve or an amplifier.
        dead_zone: the same, where a larger input counts by what exceeds the threshold.

    Raises:
        OptionError: both thresholds, or one that is not positive.
        FileError: with ``file``, ``line``, ``column`` and ``hint``.
    """
    options = _reading(time, input, output, fs, start, stop, where, turns, rename or {}, drop, max_bytes)

    def made(native: _native.Record, own: str | None, other: str | None) -> Record:
        return Record._of(_counted(native, own, other, dead_band, dead_zone), own, other, rate)

    if isinstance(path, str | os.PathLike):
        return made(*_native.read([path], options)[0])
    return [made(*found) for found in _native.read(list(path), options)]


@dataclass(frozen=True)
class Content:
    """A column or an array of a file: ``path``, ``shape``, ``unit``, and ``kind`` (``"numbers"``, ``"text"``,
    …)."""

    path: str
    shape: tuple[int, ...]
    unit: str | None
    kind: str


def contents(path: PathLike) -> list[Content]:
    """List what a file holds: the columns of a text, the arrays of MAT, HDF5, TDMS, XLSX, NPZ and JPK files.

    Any of the paths is what ``time``, ``input`` and ``output`` of :func:`read` take, as is the unambiguous
    end of one.
    """
    return [Content(**{**held, "shape": tuple(held["shape"])}) for held in json.loads(_native.contents(path))]


def write(path: PathLike, record: Record) -> None:
    """Write a record; the extension selects the format (CSV by default)."""
    _native.write(path, record._native)


def prepare(
    records: Record | Sequence[Record],
    *,
    scale: Sequence[str] = (),
    remove_mean: Sequence[str] = (),
    detrend: Sequence[str] = (),
    fs: float | None = None,
) -> Record:
    """Join records by their times, then scale, remove means, then trends, then resample with an anti-alias
    filter.

    Args:
        records: one record, or several in the order of their times.
        scale: factors with units, ``"y=2.5um/V"``.
        remove_mean: columns whose mean is removed.
        detrend: columns whose linear trend is removed.
        fs: new sample rate [Hz].
    """
    given = as_records(records)
    options = {
        "scales": list(scale),
        "remove_mean": list(remove_mean),
        "detrend": list(detrend),
        "sample_rate_hz": fs,
    }
    native, _ = _native.prepare(natives(given), json.dumps(options))
    return Record._of(native, given[0]._input, given[0]._output, given[0]._rate)


class Inspection:
    """Contents of records, and what they determine together.

    Attributes:
        records: findings for each, as dictionaries.
        campaign: statements about all of them, and the record to measure next.
    """

    def __init__(self, found: dict[str, Any]) -> None:
        self.records: list[dict[str, Any]] = found["records"]
        self.campaign: dict[str, Any] = found["campaign"]

    def __str__(self) -> str:
        lines = []
        for record in self.records:
            lines.append(str(record.get("record", record.get("name", "record"))))
            for finding in record.get("findings", []):
                hint = in_arguments(finding["advice"]) if finding.get("advice") else ""
                lines.append(f"  {finding['text']}" + (f" ({hint})" if hint else ""))
        lines.append("together:")
        lines += [f"  {_statement(s)}" for s in self.campaign.get("statements", [])]
        if self.campaign.get("measure_next"):
            lines.append(f"  measure next: {self.campaign['measure_next']}")
        return "\n".join(lines)

    __repr__ = __str__


def _statement(statement: dict[str, Any]) -> str:
    return f"{statement['topic']}: {statement['text']}"


def inspect(records: Record | Sequence[Record]) -> Inspection:
    """Inspect records before any fit: rates, amplitudes, noise, delay, and what to measure next."""
    given = as_records(records)
    return Inspection(json.loads(_native.inspect(natives(given), given[0]._input, given[0]._output)))
