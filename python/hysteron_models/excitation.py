"""Drive waveforms for an identification campaign, and a simulated bench that plays them."""

from __future__ import annotations

import json
from typing import Any

from . import _native
from .record import Record

__all__ = ["excite", "simulate_bench"]


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
        kind: ``sine``, ``sines``, ``triangle``, ``nested_loops``, ``reversal_curves``, ``staircase``,
            ``raster``, ``decaying``, ``sweep``, ``multisine`` or ``random``.
        fs: sample rate [Hz].
        high: highest voltage [V].
        low: lowest voltage [V].
        soft_start: lead-in from 0 V [s].
        soft_end: lead-out to 0 V [s].
        seed: random seed.
        amplifier: limits that are checked: ``low_v``, ``high_v``, ``slew_v_per_s``, ``current_a``,
            ``capacitance_f``.
        **waveform: numbers of the waveform, e.g. ``frequency_hz=1, periods=3`` of a sine.

    Raises:
        OptionError: a number that is invalid for the waveform or the amplifier.
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


def simulate_bench(
    drive: Record,
    *,
    truth: dict[str, Any] | None = None,
    seed: int = 0,
    stream: int = 0,
    with_truth: bool = False,
) -> Record:
    """Play a drive on the simulated bench and return the simulated measurement.

    Args:
        drive: a record with one channel, uniformly sampled.
        truth: true parameters, as ``hysteron rig`` writes them; those of the bench if not given.
        seed: seed of the sensor's noise.
        stream: number of the record in its campaign: records of one seed differ in noise by their streams.
        with_truth: add the true displacement and the output of the hysteresis.
    """
    native, _ = _native.play(
        drive._native, None if truth is None else json.dumps(truth), seed, stream, with_truth
    )
    return Record._of(native, "u", "y")
