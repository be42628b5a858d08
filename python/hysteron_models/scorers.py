"""Scorers over records, for ``cross_val_score`` and ``GridSearchCV``: larger is better."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, cast

from .record import Record

if TYPE_CHECKING:
    from .estimators import Estimator
    from .results import Score

__all__ = ["fit_percent", "neg_max_error", "neg_rmse"]


def _scores(estimator: Estimator, records: Sequence[Record]) -> list[Score]:
    return cast("list[Score]", estimator.scores(list(records)))


def fit_percent(estimator: Estimator, records: Sequence[Record], y: None = None) -> float:
    """Mean of 100 · (1 − ‖e‖₂/‖y − ȳ‖₂) over the records [%]."""
    found = _scores(estimator, records)
    return sum(score.fit_percent or 0.0 for score in found) / len(found)


def neg_rmse(estimator: Estimator, records: Sequence[Record], y: None = None) -> float:
    """Minus the RMSE over all samples, in the unit of the output."""
    found = _scores(estimator, records)
    samples = sum(score.samples for score in found)
    return float(-((sum(score.samples * score.rmse**2 for score in found) / samples) ** 0.5))


def neg_max_error(estimator: Estimator, records: Sequence[Record], y: None = None) -> float:
    """Minus the largest error of any record, in the unit of the output."""
    return -max(score.max_abs_error for score in _scores(estimator, records))
