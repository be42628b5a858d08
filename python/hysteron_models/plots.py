"""Plots of records, fits and models by matplotlib, in the look of the reports; each takes and returns axes.

Colours are those of Okabe and Ito, distinct with any colour vision, the pale ones darkened to a contrast of
3:1 as in the reports; lines differ in dash as well where two cross.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import wraps
from itertools import groupby
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

import numpy as np

from . import _native
from ._errors import OptionError, missing

try:
    import matplotlib as mpl
    import matplotlib.pyplot as plt
    from cycler import cycler
except ImportError:
    raise missing("matplotlib", "plot", "a plot") from None

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from .comparison import Comparison
    from .estimators import Estimator
    from .record import Array, Record
    from .results import FrequencyResponse, Prediction, Score

__all__ = [
    "bode",
    "comparison",
    "convergence",
    "coverage",
    "loop",
    "residual_correlation",
    "residuals",
    "style",
    "time",
]

INK, BLUE, VERMILLION, GREEN = "#1b1f23", "#0072b2", "#d55e00", "#009e73"
GREY = "#858e96"
_CYCLE = [BLUE, VERMILLION, GREEN, "#b87f00", "#b9608f", "#3a97d0"]
#: Samples beyond which a line is thinned to the minimum and maximum of each stretch.
MOST_POINTS = 20_000

_STYLE: dict[str, Any] = {
    "axes.prop_cycle": cycler(color=_CYCLE),
    "axes.edgecolor": GREY,
    "axes.labelcolor": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e3e6e9",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "axes.titlesize": "medium",
    "legend.frameon": False,
    "legend.fontsize": "small",
    "lines.linewidth": 1.2,
    "xtick.color": INK,
    "ytick.color": INK,
    "figure.constrained_layout.use": True,
    "figure.figsize": (6.4, 4.0),
    "savefig.dpi": 200,
}


@contextmanager
def style() -> Iterator[None]:
    """Draw within this block in the look of the reports."""
    # Only what is changed is put back: a notebook's backend may become interactive at the first figure.
    before = {name: mpl.rcParams[name] for name in _STYLE}
    mpl.rcParams.update(_STYLE)
    try:
        yield
    finally:
        mpl.rcParams.update(before)


P = ParamSpec("P")
T = TypeVar("T")


def _styled(draw: Callable[P, T]) -> Callable[P, T]:
    """Draw in the look of the reports whatever the user's own settings are."""

    @wraps(draw)
    def drawn(*args: P.args, **kwargs: P.kwargs) -> T:
        with style():
            return draw(*args, **kwargs)

    return drawn


def _axes(ax: Axes | None) -> Axes:
    if ax is not None:
        return ax
    made: Axes = plt.subplots()[1]
    return made


def _unit(symbol: str) -> str:
    shown = {"um": "µm", "urad": "µrad", "us": "µs", "": "–"}.get(symbol, symbol)
    return shown.replace("um/", "µm/")


def _thin(x: Array, y: Array) -> tuple[Array, Array]:
    """Keep minimum and maximum of each stretch, in their order, so that no peak is lost."""
    stretch = int(np.ceil(2 * len(x) / MOST_POINTS))
    if stretch <= 1:
        return x, y
    whole = len(x) // stretch * stretch
    blocks = y[:whole].reshape(-1, stretch)
    ends = np.sort(np.column_stack([blocks.argmin(axis=1), blocks.argmax(axis=1)]), axis=1)
    kept = (ends + stretch * np.arange(len(blocks))[:, None]).reshape(-1)
    kept = np.append(kept, np.arange(whole, len(x)))
    return x[kept], y[kept]


@_styled
def loop(record: Record, prediction: Prediction | None = None, ax: Axes | None = None, **line: Any) -> Axes:
    """Draw the hysteresis loop, output over input; with a prediction, the model's over the measured one."""
    ax = _axes(ax)
    drive, unit = record.units
    ax.plot(record.u, record.y, **{"color": BLUE, "label": "measured", **line})
    if prediction is not None:
        ax.plot(record.u, prediction.y, color=VERMILLION, ls="--", label="model")
        ax.legend()
    ax.set(xlabel=f"input [{_unit(drive)}]", ylabel=f"output [{_unit(unit)}]", title=record.name)
    return ax


@_styled
def time(prediction: Prediction, ax: Axes | None = None) -> Axes:
    """Draw a prediction over time, with the measurement and its band."""
    ax = _axes(ax)
    if prediction.measured is not None:
        ax.plot(*_thin(prediction.t, prediction.measured), color=BLUE, label="measured")
    if prediction.y.ndim == 2:
        for k, y in enumerate(prediction.y.T):
            ax.plot(*_thin(prediction.t, y), label=f"output {k + 1}")
    else:
        ax.plot(*_thin(prediction.t, prediction.y), color=VERMILLION, ls="--", label="model")
    if prediction.lower is not None and prediction.upper is not None:
        level = "" if prediction.level is None else f"{100 * prediction.level:g} % "
        every = max(1, len(prediction.t) // MOST_POINTS)
        ax.fill_between(
            prediction.t[::every],
            prediction.lower[::every],
            prediction.upper[::every],
            color=VERMILLION,
            alpha=0.2,
            lw=0,
            label=f"{level}band",
        )
        # The data set the scale: a band wider than that is cut off.
        shown = [y for y in (prediction.measured, prediction.y) if y is not None]
        low, high = min(np.nanmin(y) for y in shown), max(np.nanmax(y) for y in shown)
        margin = (high - low) or 1.0
        bottom, top = ax.get_ylim()
        ax.set_ylim(max(bottom, low - margin), min(top, high + margin))
    ax.set(xlabel="time [s]", ylabel=f"output [{_unit(prediction.unit)}]", title=prediction.name)
    ax.legend()
    return ax


def _residual(score: Score) -> Record:
    if score.series is None:
        raise OptionError("scores of a fit hold no samples: score the record with model.scores(record)")
    if "residual" not in score.series.channels:
        raise OptionError("this plot is of a model of one output; score.series holds the residual of each")
    return score.series


@_styled
def residuals(score: Score, ax: Axes | None = None) -> Axes:
    """Draw the residual of a record over time: measured less model."""
    ax = _axes(ax)
    series = _residual(score)
    ax.axhline(0.0, color=GREY, lw=0.8)
    ax.plot(*_thin(series.t, series["residual"]), color=GREEN)
    title = f"{score.record}: RMSE {score.rmse:.3g} {_unit(score.unit)}"
    ax.set(xlabel="time [s]", ylabel=f"residual [{_unit(score.unit)}]", title=title)
    return ax


@_styled
def residual_correlation(score: Score, ax: Axes | None = None) -> Axes:
    """Draw the autocorrelation of the residual, with the 99 % bounds of white noise: the test of
    ``validate``."""
    series = _residual(score)
    found = _native.residual_correlation(series._native, score.skip)
    if found is None:
        raise OptionError(
            f"{score.record}: the residual vanishes or has fewer than 50 samples", code="residual"
        )
    first, correlation, bound = found
    ax = _axes(ax)
    ax.axhspan(-bound, bound, color=GREY, alpha=0.3, lw=0, label="99 % of white noise")
    ax.vlines(first + np.arange(len(correlation)), 0.0, correlation, color=GREEN, lw=1.5)
    ax.axhline(0.0, color=GREY, lw=0.8)
    ax.set(xlabel="lag [samples]", ylabel="autocorrelation of the residual", title=score.record)
    ax.legend()
    return ax


@_styled
def bode(
    response: FrequencyResponse, axes: Sequence[Axes] | None = None, label: str = "dynamic block"
) -> Sequence[Axes]:
    """Draw magnitude and phase over frequency, with the 95 % band of a measured response whose scatter is
    known.

    ``axes``: two of them; a response drawn into those of another gets another colour.
    """
    if axes is None:
        _, made = plt.subplots(2, 1, sharex=True, figsize=(6.4, 5.2))
        axes = list(made)
    if len(axes) != 2:
        raise OptionError("axes: a Bode plot has two, magnitude and phase")
    magnitude, phase = axes
    colour = _CYCLE[len(magnitude.lines) % len(_CYCLE)]
    frequency, gain, angle = response.frequency_hz, response.magnitude, response.phase_deg
    magnitude.loglog(frequency, gain, color=colour, label=label)
    phase.semilogx(frequency, angle, color=colour, label=label)
    if response.std_dev is not None:
        # Half of the variance is in magnitude, half in phase.
        half = 1.96 * response.std_dev / np.sqrt(2)
        turn = np.degrees(np.arctan2(half, gain))
        band: dict[str, Any] = {"color": colour, "alpha": 0.2, "lw": 0, "label": "95 % band"}
        magnitude.fill_between(frequency, np.maximum(gain - half, 1e-3 * gain), gain + half, **band)
        phase.fill_between(frequency, angle - turn, angle + turn, **band)
    unit = response.unit.replace("um", "µm").replace("_per_", "/") or "–"
    magnitude.set(ylabel=f"magnitude [{unit}]", title="Frequency response")
    phase.set(xlabel="frequency [Hz]", ylabel="phase [°]")
    magnitude.legend()
    return axes


@_styled
def convergence(history: Sequence[tuple[str, float, float | None]], ax: Axes | None = None) -> Axes:
    """Draw the best cost over the share of the work done, from the progress reports of
    ``fit(…, progress=…)``.

    Collect it with ``history = []`` and ``fit(records, progress=lambda *told: history.append(told))``.
    """
    ax = _axes(ax)
    told = [(stage, fraction, cost) for stage, fraction, cost in history if cost is not None]
    if not told:
        raise OptionError("the fit ended before it reported a cost")
    # Each stage has its own cost function.
    for stage, events in groupby(told, key=lambda event: event[0]):
        share, cost = np.array([event[1:] for event in events], dtype=float).T
        ax.semilogy(100 * share, cost, marker=".", drawstyle="steps-post", label=stage)
    if len(ax.lines) <= 6:
        ax.legend()
    ax.set(xlabel="work done [%]", ylabel="best RMSE", title="Convergence")
    return ax


@_styled
def comparison(found: Comparison, ax: Axes | None = None) -> Axes:
    """Draw the held-out error of every structure, the best first."""
    rows = sorted(
        (row for row in found.result["candidates"] if row["error"] is not None), key=lambda row: row["error"]
    )
    if ax is None:
        _, ax = plt.subplots(figsize=(6.4, 1.0 + 0.32 * len(rows)))
    names = [str(row["name"]) for row in rows]
    colours = [VERMILLION if name == found.preferred else BLUE for name in names]
    deviations = [row["error_std_error"] or 0.0 for row in rows]
    ax.barh(names, [row["error"] for row in rows], xerr=deviations, color=colours, ecolor=INK, capsize=2)
    ax.axvline(found.result["noise_floor"], color=GREY, ls=":", label="noise floor")
    ax.invert_yaxis()
    ax.set(xlabel=f"RMSE on records not fitted to [{found.result['output_unit']}]")
    ax.set_title(f"Structures, preferred: {found.preferred}")
    ax.legend()
    return ax


@_styled
def coverage(
    estimator: Estimator,
    records: Record | Sequence[Record],
    levels: Sequence[float] = (0.5, 0.68, 0.8, 0.9, 0.95, 0.99),
    ax: Axes | None = None,
) -> Axes:
    """Draw the coverage of the band of a measurement over its level; on the diagonal it is nominal."""
    from .record import as_records

    ax = _axes(ax)
    for k, record in enumerate(as_records(records)):
        shares = []
        for level in levels:
            predicted = estimator.predict(record, band=level)
            assert not isinstance(predicted, list)
            measured, lower, upper = predicted.measured, predicted.lower, predicted.upper
            if measured is None or lower is None or upper is None:
                raise OptionError(f"{record.name} has no measured output")
            inside = (lower <= measured) & (measured <= upper)
            shares.append(100 * float(inside[record.valid].mean()))
        ax.plot(
            [100 * level for level in levels],
            shares,
            marker="o",
            label=record.name,
            color=_CYCLE[k % len(_CYCLE)],
        )
    ax.plot([0, 100], [0, 100], color=GREY, ls=":", label="bands hold")
    low = 100 * min(levels) - 10
    ax.set(xlabel="level of the band [%]", ylabel="samples within [%]", xlim=(low, 101), ylim=(low, 101))
    ax.set_title("Coverage")
    ax.legend()
    return ax
