"""Comparison of structures by held-out error, and the names of all choices."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from . import _native
from ._errors import missing
from .estimators import _in_worker
from .model import Model
from .progress import Progress, shown
from .record import PathLike, Record, as_records, natives
from .results import write_text

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["Comparison", "choices", "compare", "compare_axes"]


@dataclass(frozen=True)
class Comparison:
    """Structures by their held-out error.

    Attributes:
        model: model of the preferred structure, from all records; ``None`` where it was stopped before.
        result: everything, as ``hysteron compare --json`` prints it.
    """

    model: Model | None
    result: dict[str, Any] = field(repr=False)
    _page: str = field(repr=False, default="")

    @property
    def preferred(self) -> str | None:
        """Name of the preferred structure."""
        found = self.result.get("preferred")
        return None if found is None else str(found)

    def to_pandas(self) -> pd.DataFrame:
        """One row a structure."""
        try:
            import pandas as pd
        except ImportError:
            raise missing("pandas", "pandas", "a DataFrame") from None
        return pd.json_normalize(self.result["candidates"], max_level=0)

    def report(self, path: PathLike) -> None:
        """Write the report, a page that works offline."""
        write_text(path, self._page)


def compare(
    records: Sequence[Record],
    candidates: Sequence[str] = (),
    *,
    quick: bool = False,
    time_limit: float | None = None,
    continued: bool = False,
    threads: int | None = None,
    progress: bool | Progress = False,
) -> Comparison:
    """Compare structures by the held-out error of their simulation.

    Args:
        records: records of one device, of different content.
        candidates: structures, ``"fractional+prandtl-ishlinskii"``; a search if none is given.
        quick: without candidates, one pass of the search through the commonest structures.
        time_limit: end the search after this many seconds with the candidates finished by then; they are
            timed and the preferred one is identified after that.
        continued: the records are consecutive parts of one run on one clock.
        threads: threads; all cores if not given.
        progress: as in ``fit``.
    """
    given = as_records(records)
    if threads is None and _in_worker():
        threads = 1
    with shown(progress) as told:
        text, page, model, interrupt = _native.compare(
            natives(given),
            list(candidates),
            quick,
            time_limit,
            continued,
            given[0]._input,
            given[0]._output,
            threads,
            told,
        )
    if interrupt is not None:
        raise interrupt
    return Comparison(None if model is None else Model(model), json.loads(text), page)


def compare_axes(
    records: Sequence[Record],
    inputs: Sequence[str],
    outputs: Sequence[str],
    candidates: Sequence[str] = (),
    *,
    threads: int | None = None,
    progress: bool | Progress = False,
) -> Comparison:
    """Compare structures of modes of several axes by the error on records held out, one of every level.

    Args:
        records: periodic records of one device, two or more at every level.
        inputs: names of the drives, in order.
        outputs: names of the axes, in order.
        candidates: structures, ``"linear"``, ``"polynomial"``, ``"plays6"``, ``"modes8+plays6"``; the usual
            four if none is given.
        threads: threads; all cores if not given.
        progress: as in ``fit``.
    """
    if threads is None and _in_worker():
        threads = 1
    with shown(progress) as told:
        text, page, model, interrupt = _native.compare_axes(
            natives(as_records(records)), list(inputs), list(outputs), list(candidates), threads, told
        )
    if interrupt is not None:
        raise interrupt
    return Comparison(None if model is None else Model(model), json.loads(text), page)


def choices() -> dict[str, dict[str, str]]:
    """Names that options of :class:`Hammerstein` take, each with a line about it."""
    found = json.loads(_native.choices())
    found.pop("kinds")
    return {option: dict(names) for option, names in found.items()}
