"""Progress of long computations: by tqdm where it is installed, else a line every ten seconds."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

Progress = Callable[[str, float, float | None], object]


@contextmanager
def shown(progress: bool | Progress) -> Iterator[Progress | None]:
    """Give the callback of ``(stage, fraction, cost)``: none for ``False``, a bar for ``True``, else
    ``progress``."""
    if progress is False:
        yield None
    elif callable(progress):
        yield progress
    else:
        try:
            from tqdm.auto import tqdm
        except ImportError:
            yield _Lines()
            return
        with tqdm(total=100, unit="%", leave=False, bar_format="{l_bar}{bar}| {elapsed}<{remaining}") as bar:
            yield _Bar(bar)


class _Bar:
    def __init__(self, bar: Any) -> None:
        self._bar = bar

    def __call__(self, stage: str, fraction: float, cost: float | None) -> None:
        self._bar.set_description_str(
            stage if cost is None else f"{stage}, best RMSE {cost:.5g}", refresh=False
        )
        self._bar.update(round(100 * fraction, 1) - self._bar.n)


class _Lines:
    def __init__(self) -> None:
        self._begun = self._last = time.monotonic()

    def __call__(self, stage: str, fraction: float, cost: float | None) -> None:
        now = time.monotonic()
        if now - self._last < 10.0:
            return
        self._last = now
        left = f", {(now - self._begun) * (1 - fraction) / fraction:.0f} s left" if fraction > 0 else ""
        best = "" if cost is None else f", best RMSE {cost:.5g}"
        print(f"{100 * fraction:.0f} %, {stage}{best}{left}", file=sys.stderr, flush=True)
