"""Plots: what they draw, and that axes given are axes returned."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

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
    with pytest.raises(hy.OptionError, match="reported a cost"):
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


@pytest.mark.parametrize("skip", [0.0, 1.5])
def test_the_residual_is_tested_as_validate_does(
    command: Path, stage: hy.Hammerstein, unseen: hy.Record, tmp_path: Path, skip: float
) -> None:
    stage.save(tmp_path / "model.json")
    unseen.save(tmp_path / "unseen.csv")
    run = [
        str(command),
        "validate",
        str(tmp_path / "model.json"),
        str(tmp_path / "unseen.csv"),
        "--skip",
        str(skip),
    ]
    printed = subprocess.run(run, capture_output=True, text=True, check=True)
    words = r"autocorrelation leaves its 99 % bounds at (\d+) of (\d+) lags \(largest (\S+) at lag (\d+)\)"
    told = re.search(words, printed.stdout + printed.stderr)
    assert told, printed
    score = stage.scores(unseen, skip=skip)
    assert isinstance(score, hy.Score)
    ax = hy.plots.residual_correlation(score)
    segments = [collection.get_segments() for collection in ax.collections]  # type: ignore[attr-defined]
    bars = [bar for each in segments for bar in each]
    lags, heights = [int(bar[0][0]) for bar in bars], np.array([bar[1][1] for bar in bars])
    bound = ax.patches[0].get_bbox().y1  # type: ignore[attr-defined]
    assert bound == pytest.approx(2.5758 / np.sqrt(score.samples), rel=1e-4)
    largest = int(np.abs(heights).argmax())
    assert lags == list(range(1, int(told[2]) + 1)) and lags[largest] == int(told[4])
    assert np.sum(np.abs(heights) > bound) == int(told[1])
    assert f"{heights[largest]:.3f}" == told[3].replace("−", "-")


def test_too_few_samples_for_a_test_are_refused(stage: hy.Hammerstein, unseen: hy.Record) -> None:
    score = stage.scores(hy.Record(unseen.u[:40], unseen.y[:40], fs=unseen.fs))
    assert isinstance(score, hy.Score)
    with pytest.raises(hy.OptionError, match="fewer than 50 samples"):
        hy.plots.residual_correlation(score)


def test_responses_in_one_plot_are_told_apart_and_bands_are_drawn() -> None:
    frequency = np.array([1.0, 10.0, 100.0])
    response = np.array([1.0, 0.9, 0.5 - 0.5j])
    axes = hy.plots.bode(
        hy.FrequencyResponse(frequency, response, np.full(3, 0.1), "um_per_V"), label="measured"
    )
    assert hy.plots.bode(hy.FrequencyResponse(frequency, 0.9 * response), axes=axes, label="model") is axes
    assert len({line.get_color() for line in axes[0].lines}) == 2 and len(axes[0].collections) == 1
    upper = axes[0].collections[0].get_paths()[0].vertices[:, 1].max()
    assert upper == pytest.approx(1.0 + 1.96 * 0.1 / np.sqrt(2))
    turn = np.degrees(np.arctan(1.96 * 0.1 / np.sqrt(2) / np.sqrt(0.5)))
    assert axes[1].collections[0].get_paths()[0].vertices[:, 1].min() == pytest.approx(-45.0 - turn)
