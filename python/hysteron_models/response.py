"""Measured frequency responses, and the structures fitted to them."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from . import _native
from .model import Model
from .record import PathLike, Record, natives
from .results import FrequencyResponse, write_text

__all__ = ["ExplainedResponse", "frequency_response"]


@dataclass(frozen=True)
class ExplainedResponse:
    """A measured frequency response and the structures fitted to it.

    Attributes:
        measured: the response, in the band that was fitted.
        model: the best structure that a model file can hold, without hysteresis; ``None`` where none can.
        result: every structure with its parameters and errors, as ``hysteron frequency-response --json``
            prints it.
    """

    measured: FrequencyResponse
    model: Model | None
    result: dict[str, Any] = field(repr=False)
    _page: str = field(repr=False, default="")

    def report(self, path: PathLike) -> None:
        """Write the report, a page that works offline."""
        write_text(path, self._page)


def frequency_response(
    source: Record | Sequence[Record] | PathLike,
    *,
    structures: Sequence[str] = (),
    modes: int | None = None,
    band: tuple[float, float] | None = None,
    period: float | None = None,
    settling: int | None = None,
    response: str | None = None,
    over: str | None = None,
) -> ExplainedResponse:
    """Estimate the frequency response of periodic records, or read one, and fit structures to it.

    Args:
        source: records of a multisine of at least two periods, or a file with a measured response.
        structures: ``fractional``, ``integer``, ``power-law``, ``loss-angle``, ``modes``; if none is given,
            the structures usual for this kind of response.
        modes: number of resonances of ``modes``.
        band: frequencies [Hz] that are fitted; without it, those above the noise.
        period: length of a period of the records [s].
        settling: periods at the beginning that are left out.
        response: which response of the file.
        over: response that it is divided by.
    """
    path: PathLike | None = None
    records: list[Record] = []
    if isinstance(source, Record):
        records = [source]
    elif isinstance(source, str | os.PathLike):
        path = source
    else:
        records = list(source)
    first = records[0] if records else None
    points, text, page, native = _native.explain_response(
        natives(records),
        path,
        json.dumps({"period_s": period, "settling_periods": settling}),
        list(structures),
        modes,
        band,
        first._input if first else None,
        first._output if first else None,
        response,
        over,
    )
    frequency, real, imaginary, std_dev, unit = points
    measured = FrequencyResponse(frequency, real + 1j * imaginary, std_dev, unit)
    return ExplainedResponse(measured, None if native is None else Model(native), json.loads(text), page)
