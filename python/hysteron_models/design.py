"""Design of the next drive, by the information that its record will carry."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from . import _native
from ._errors import missing
from .estimators import Estimator
from .model import Model
from .progress import Progress, shown
from .record import Record, as_records, natives

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["Design", "design"]

Purpose = Literal["delay", "resonance", "creep", "minor-loops", "prediction"]


@dataclass(frozen=True)
class Design:
    """The next drive.

    Attributes:
        drive: the drive as a record with one channel, from rest and back to it.
        motion: drive along which the output is to be predicted; empty for the other purposes.
        result: everything else, as ``hysteron design --json`` prints it: segments, standard errors now, after
            this drive and after a loop and a sweep of the same length.
    """

    drive: Record
    motion: NDArray[np.float64] = field(repr=False)
    result: dict[str, Any] = field(repr=False)

    @property
    def usual_repetitions(self) -> float | None:
        """Times that a loop and a sweep of the same length must be repeated to reach the same; ``None`` where
        they cannot."""
        found = self.result.get("usual_repetitions")
        return None if found is None else float(found)

    def to_pandas(self) -> pd.DataFrame:
        """Standard errors: one row a quantity."""
        try:
            import pandas as pd
        except ImportError:
            raise missing("pandas", "pandas", "a DataFrame") from None
        return pd.DataFrame(self.result["expected"]).set_index("name")


def design(
    basis: Model | Estimator | Record | Sequence[Record],
    purpose: Purpose,
    *,
    time: float,
    limits: tuple[float, float] | None = None,
    slew: float | None = None,
    fs: float | None = None,
    highest: float | None = None,
    noise: float | None = None,
    resonance: float | None = None,
    seed: int = 0,
    progress: bool | Progress = False,
) -> Design:
    """Design the drive after whose record the model is known best for a purpose.

    Args:
        basis: a model with the covariance of its numbers, a fitted estimator, or the records so far, which
            are identified first.
        purpose: ``delay``, ``resonance``, ``creep``, ``minor-loops`` or ``prediction``.
        time: length of the drive [s].
        limits: lowest and highest voltage; those of the records if not given.
        slew: largest rate of the drive, per second; that of the records if not given.
        fs: sample rate [Hz]; that of the records if not given.
        highest: highest frequency excited [Hz]; that of the records or 1.5 times the resonance if not given.
        noise: standard deviation of the noise, in the unit of the output; the residual of the fit if not
            given.
        resonance: where a resonance is expected that the model does not have [Hz].
        seed: seed of random phases and levels.
        progress: as in ``fit``.

    Raises:
        IdentifyError: no covariance in the model, or options out of range.
    """
    options = {
        "purpose": purpose,
        "time_s": time,
        "range": limits,
        "slew_per_s": slew,
        "sample_rate_hz": fs,
        "highest_hz": highest,
        "noise": noise,
        "resonance_hz": resonance,
        "seed": seed,
    }
    if isinstance(basis, Estimator):
        basis = basis.model_
    model, records = (basis, []) if isinstance(basis, Model) else (None, as_records(basis))
    channels = (records[0]._input, records[0]._output) if records else (None, None)
    with shown(progress) as told:
        drive, motion, text = _native.design(
            json.dumps(options),
            None if model is None else model._native,
            natives(records),
            *channels,
            told,
        )
    result = json.loads(text)
    return Design(Record({"u_V": drive}, fs=result["sample_rate_hz"]), motion, result)
