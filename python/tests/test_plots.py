"""Plots: what they draw, and that axes given are axes returned."""

from __future__ import annotations

import hysteron_models as hy
import matplotlib.pyplot as plt
import numpy as np
import pytest


@pytest.fixture(autouse=True)
def closed() -> object:
    yield
    plt.close("all")


def test_axes_have_labels_with_units(stage: hy.Hammerstein, unseen: hy.Record) -> None:
    prediction = stage.predict(unseen, band=0.95)
    score = stage.scores(unseen)
    assert isinstance(score, hy.Score) and isinstance(prediction, hy.Prediction)
    drawn = [
        hy.plots.loop(unseen, prediction),
        hy.plots.time(prediction),
        hy.plots.residuals(score),
        hy.plots.residual_correlation(score),
        hy.plots.coverage(stage, unseen),
        *hy.plots.bode(stage.frequency_response(np.geomspace(1, 100, 20))),
    ]
    for ax in drawn:
        assert ax.get_ylabel(), ax
        ax.figure.canvas.draw()
    assert drawn[0].get_xlabel() == "input [V]" and drawn[0].get_ylabel() == "output [µm]"


def test_axes_given_are_returned(stage: hy.Hammerstein, unseen: hy.Record) -> None:
    _, ax = plt.subplots()
    assert hy.plots.time(stage.predict(unseen), ax=ax) is ax
    assert unseen.plot(ax=ax) is ax
    with pytest.raises(hy.OptionError, match="has two"):
        hy.plots.bode(stage.frequency_response(), axes=[ax])


def test_thinned_lines_keep_every_peak() -> None:
    from hysteron_models.plots import MOST_POINTS, _thin

    y = np.random.default_rng(0).normal(size=10 * MOST_POINTS + 7)
    y[12345], y[-1] = 50.0, -60.0
    x, kept = _thin(np.arange(len(y), dtype=float), y)
    assert len(kept) <= 1.1 * MOST_POINTS and kept.max() == 50.0 and kept.min() == -60.0
    assert np.all(np.diff(x) > 0) and np.array_equal(y[x.astype(int)], kept)


def test_convergence_and_comparison_are_drawn() -> None:
    ax = hy.plots.convergence([("a", 0.1, 1.0), ("b", 0.5, 0.1), ("c", 0.6, None)])
    assert ax.get_xlabel() == "work done [%]"
    with pytest.raises(hy.OptionError, match="no cost"):
        hy.plots.convergence([])


def test_pixels_stay_as_they_are(stage: hy.Hammerstein, unseen: hy.Record) -> None:
    """Two drawings of the same plot are one picture; another record is another."""

    def pixels(prediction: hy.Prediction) -> np.ndarray:
        ax = hy.plots.time(prediction)
        canvas = ax.figure.canvas
        canvas.draw()
        return np.asarray(canvas.buffer_rgba(), dtype=float)  # type: ignore[attr-defined]

    first, again = (pixels(stage.predict(unseen, band=0.95)) for _ in range(2))
    other = pixels(stage.predict(unseen))
    assert np.abs(first - again).mean() < 0.1 < np.abs(first - other).mean()
