"""Every plot gives the picture on record; `pytest python/tests/test_pictures.py --renew-pictures` draws them
anew."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import hysteron_models as hy
import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.testing.compare import compare_images

PICTURES = Path(__file__).parent / "pictures"
#: Root mean square of the difference of two pictures, of 255. One letter that differs makes 1.5, a missing
#: curve 2.6.
TOLERANCE = 0.5

Draw = Callable[["Data", Figure], object]


class Data:
    """What the plots draw: a simulated device, and results that no fit has to find."""

    def __init__(self, stage: hy.Hammerstein, record: hy.Record) -> None:
        self.stage, self.record = stage, record
        banded = stage.predict(record, band=0.95)
        assert isinstance(banded, hy.Prediction)
        # Wide enough to be seen beside the curves.
        self.banded = replace(banded, lower=banded.y - 2, upper=banded.y + 2)
        score = stage.scores(record)
        assert isinstance(score, hy.Score)
        self.score = score
        frequency = np.geomspace(1, 1000, 60)
        resonance = 1 / (1 + 0.04j * frequency / 200 - (frequency / 200) ** 2)
        self.response = hy.FrequencyResponse(frequency, resonance, 0.1 * frequency**-0.3, "um_per_V")
        self.history = [("search", 0.1 * k, 2.0**-k) for k in range(6)] + [
            ("refine", 0.8, 0.02),
            ("refine", 1.0, 0.01),
        ]
        candidates = [
            {"name": name, "error": error, "error_std_error": 0.1 * error}
            for name, error in (("fractional", 0.2), ("integer2", 0.3), ("none", 0.9))
        ]
        result = {"candidates": candidates, "preferred": "integer2", "noise_floor": 0.1, "output_unit": "um"}
        self.comparison = hy.Comparison(None, result)


LEVELS = (0.5, 0.8, 0.95)
PLOTS: dict[str, Draw] = {
    "loop": lambda data, on: hy.plots.loop(data.record, ax=on.subplots()),
    "loop-and-model": lambda data, on: hy.plots.loop(data.record, data.banded, ax=on.subplots()),
    "time": lambda data, on: hy.plots.time(data.banded, ax=on.subplots()),
    "residuals": lambda data, on: hy.plots.residuals(data.score, ax=on.subplots()),
    "residual-correlation": lambda data, on: hy.plots.residual_correlation(data.score, ax=on.subplots()),
    "bode": lambda data, on: hy.plots.bode(data.response, axes=list(on.subplots(2, 1, sharex=True))),
    "convergence": lambda data, on: hy.plots.convergence(data.history, ax=on.subplots()),
    "comparison": lambda data, on: hy.plots.comparison(data.comparison, ax=on.subplots()),
    "coverage": lambda data, on: hy.plots.coverage(data.stage, data.record, LEVELS, ax=on.subplots()),
}


@pytest.fixture(scope="module")
def data(stage: hy.Hammerstein, unseen: hy.Record) -> Data:
    return Data(stage, unseen)


@pytest.fixture
def figure() -> Iterator[Figure]:
    """A figure of 400 × 300 points, in the fonts that come with matplotlib, whatever the user's settings
    are."""
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams["font.family"] = "DejaVu Sans"
        with hy.plots.style():
            made = plt.figure(figsize=(4, 3))
            yield made
            plt.close(made)


def _save(figure: Figure, path: Path) -> Path:
    figure.savefig(path, dpi=100, metadata={"Software": None})
    return path


def _difference(name: str, figure: Figure, folder: Path) -> str | None:
    drawn = _save(figure, folder / f"{name}.png")
    kept = folder / f"{name}-kept.png"
    kept.write_bytes((PICTURES / f"{name}.png").read_bytes())
    found = compare_images(str(kept), str(drawn), tol=TOLERANCE)
    return None if found is None else str(found)


@pytest.mark.parametrize("name", PLOTS)
def test_a_plot_gives_its_picture(
    name: str, data: Data, figure: Figure, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    PLOTS[name](data, figure)
    if request.config.getoption("--renew-pictures"):
        _save(figure, PICTURES / f"{name}.png")
    assert _difference(name, figure, tmp_path) is None


def test_every_plot_has_a_picture() -> None:
    drawn = {name for name in hy.plots.__all__ if name != "style"}
    assert drawn == {name.replace("-and-model", "").replace("-", "_") for name in PLOTS}
    assert {path.stem for path in PICTURES.glob("*.png")} == set(PLOTS)
    assert sum(path.stat().st_size for path in PICTURES.glob("*.png")) < 1_000_000


def _without_a_curve(ax: Axes) -> None:
    [*ax.patches, *ax.lines][-1].remove()


def _without_a_band(ax: Axes) -> None:
    ax.collections[-1].remove()


def _with_another_label(ax: Axes) -> None:
    label = ax.get_xlabel() or ax.get_ylabel()
    ax.set(**{"xlabel" if ax.get_xlabel() else "ylabel": label[:-1] + ")"})


def _with_another_title(ax: Axes) -> None:
    ax.set_title(ax.get_title()[:-1] + "o")


def _with_wider_lines(ax: Axes) -> None:
    for shape in [*ax.lines, *ax.patches, *ax.collections]:
        shape.set_linewidth(np.max(shape.get_linewidth()) + 0.4)


CHANGES = [_without_a_curve, _with_another_label, _with_another_title, _with_wider_lines]
BANDED = ["time", "residual-correlation", "bode", "comparison"]
CASES = [(name, change) for name in PLOTS for change in CHANGES] + [
    (name, _without_a_band) for name in BANDED
]


@pytest.mark.parametrize(
    ("name", "change"), CASES, ids=lambda case: case if isinstance(case, str) else case.__name__
)
def test_a_plot_that_is_changed_is_told_from_its_picture(
    name: str, change: Callable[[Axes], None], data: Data, figure: Figure, tmp_path: Path
) -> None:
    PLOTS[name](data, figure)
    change(figure.axes[0])
    assert _difference(name, figure, tmp_path) is not None
