"""Drive waveforms for an identification campaign."""

from __future__ import annotations

import json
from typing import Any

from . import _native
from .record import Record

__all__ = ["excite"]


def excite(
    kind: str,
    *,
    fs: float,
    high: float,
    low: float = 0.0,
    soft_start: float = 0.0,
    soft_end: float = 0.0,
    seed: int = 0,
    amplifier: dict[str, float] | None = None,
    **waveform: Any,
) -> Record:
    """Make a drive as a record with one channel.

    Args:
        kind: ``sine``, ``sines``, ``triangle``, ``nested_loops``, ``reversal_curves``, ``staircase``, ``raster``,
            ``decaying``, ``sweep``, ``multisine`` or ``random``.
        fs: sample rate [Hz].
        high: highest voltage [V].
        low: lowest voltage [V].
        soft_start: lead-in from 0 V [s].
        soft_end: lead-out to 0 V [s].
        seed: seed of what is random.
        amplifier: limits that are checked: ``low_v``, ``high_v``, ``slew_v_per_s``, ``current_a``, ``capacitance_f``.
        **waveform: numbers of the waveform, e.g. ``frequency_hz=1, periods=3`` of a sine.

    Raises:
        OptionError: a number that the waveform or the amplifier cannot have; it says which.
    """
    spec = {
        "sample_rate_hz": fs,
        "low_v": low,
        "high_v": high,
        "soft_start_s": soft_start,
        "soft_end_s": soft_end,
        "seed": seed,
        "waveform": {"kind": kind, **waveform},
    }
    native, _ = _native.excite(json.dumps({"spec": spec, "limits": amplifier}))
    return Record._of(native)
