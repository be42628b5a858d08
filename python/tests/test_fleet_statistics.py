"""Region, drift and difference, and the page that shows them."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import hysteron_models as hy
import numpy as np
import pandas as pd
import pytest
from hysteron_models import _native, fleet
from hysteron_models.fleet.region import robust_distances
from scipy import stats
from simulated_fleet import ESTIMATOR, Serial, drive, of_device


def test_tails_and_quantiles_are_those_of_scipy() -> None:
    for degrees in (1, 2.5, 7, 60, 900):
        for x in (0.01, 1.0, 8.0, 100.0, 1000.0):
            expected = stats.chi2.sf(x, degrees)
            assert _native.chi_square_tail(x, degrees) == pytest.approx(expected, rel=1e-10, abs=1e-290)
            expected = 2 * stats.t.sf(x, degrees)
            assert _native.student_tail(x, degrees) == pytest.approx(expected, rel=1e-10)
        for p in (0.01, 0.5, 0.99, 0.999999):
            found = _native.chi_square_quantile(p, degrees)
            assert found == pytest.approx(stats.chi2.ppf(p, degrees), rel=1e-10)


def test_a_region_holds_the_share_it_promises_and_outliers_do_not_widen_it() -> None:
    rng = np.random.default_rng(1)
    root = rng.normal(size=(4, 4)) * [1, 10, 0.1, 1]
    outside, found = [], []
    for _ in range(40):
        z = rng.normal(size=(500, 4)) @ root + 3
        limit = _native.chi_square_quantile(0.99, 4)
        outside.append(float((robust_distances(z)[0] > limit).mean()))
        # A tenth of the devices are from another lot.
        z[:50] += 8 * root.sum(axis=0)
        squared, rank = robust_distances(z)
        assert rank == 4
        found.append((squared[:50] > limit).mean())
    # Nominal 1 %; the estimated centre and scatter cost some tenths.
    assert 0.007 < np.mean(outside) < 0.016, np.mean(outside)
    assert min(found) == 1.0


def test_the_region_of_a_small_fleet_is_wider() -> None:
    from hysteron_models.fleet.region import _widening

    rng = np.random.default_rng(3)
    limit = _native.chi_square_quantile(0.99, 4)
    squared = [robust_distances(rng.normal(size=(40, 4)))[0] for _ in range(300)]
    raw = np.concatenate(squared)
    assert (raw > limit).mean() > 0.03
    assert 0.007 < (raw / _widening(40, 4, 0.99) > limit).mean() < 0.013
    assert _widening(5000, 4, 0.99) < 1.15


def test_parameters_that_follow_from_others_do_not_count_twice() -> None:
    rng = np.random.default_rng(2)
    z = rng.normal(size=(300, 2))
    squared, rank = robust_distances(np.column_stack([z, z @ [1.0, 2.0]]))
    assert rank == 2
    assert np.corrcoef(squared, robust_distances(z)[0])[0, 1] > 0.95


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Forty simulated devices; one with 60 % more hysteresis, one that loses a tenth of its gain over a year."""
    folder = tmp_path_factory.mktemp("lab")
    u, devices = drive(), []

    def measured(name: str, truth: dict[str, Any], seed: int, date: str) -> None:
        path = folder / f"{name[:6]}-{date}.csv"
        hy.simulate_bench(u, truth=truth, seed=seed).save(path)
        devices.append(fleet.Device(name, (str(path),), date=date))

    for k in range(38):
        measured(f"D{k:02}", of_device(k), k, "2026-01-01")
    measured("wide", of_device(99, hysteresis=1.6), 99, "2026-01-01")
    for month in range(1, 12):
        gain = 1.0 if month < 11 else 0.9
        measured("tired", of_device(50, gain=gain), 500 + month, f"2026-{month:02}-01")
        measured("steady <b>1</b>", of_device(51), 600 + month, f"2026-{month:02}-01")
    file = folder / "fleet.sqlite"
    fleet.calibrate(devices, ESTIMATOR, executor=Serial(), registry=file, reports=folder / "reports")
    return file


def test_the_device_with_other_hysteresis_is_outside(lab: Path) -> None:
    found = fleet.outside(lab, level=0.999)
    assert found["device"][0] == "wide" and found["distance"][0] > 2 * found.attrs["radius"]
    assert found.attrs["devices"] == 41 and "alpha" in found.attrs["parameters"]
    with pytest.raises(hy.OptionError, match="needs 5 devices"):
        fleet.outside(Path(lab).with_name("none.sqlite"))
    with pytest.raises(hy.OptionError, match="no beat"):
        fleet.outside(lab, parameters=["beat"])


def test_drift_is_seen_where_there_is_some(lab: Path) -> None:
    tired = fleet.drift(lab, "tired").set_index("parameter")
    assert tired["significant"].any() and set(tired["count"]) == {10}
    gain = tired.loc["linear"]
    assert -13 < gain["change_percent"] < -5 and gain["degrees"] == 9
    assert not fleet.drift(lab, "steady <b>1</b>")["significant"].any()
    assert set(fleet.drifts(lab)["device"]) == {"tired"}
    with pytest.raises(hy.OptionError, match="two calibrations"):
        fleet.drift(lab, "D00")


def test_drift_is_students_t_of_the_latest_value() -> None:
    from hysteron_models.fleet.history import _change

    old = pd.DataFrame({"value": [1.0, 1.2, 0.9, 1.1], "std_error": [0.01] * 4})
    new = pd.Series({"device": "A", "name": "x", "unit": "", "value": 1.6, "std_error": 0.01})
    found = _change(new, old)
    t, p = stats.ttest_1samp(old["value"] - 1.6, 0.0)
    # A single new value: the deviation of a prediction, not of a mean.
    ratio = np.sqrt((1 / 4) / (1 + 1 / 4))
    assert found["t"] == pytest.approx(-t * ratio) and found["degrees"] == 3
    assert found["p"] == pytest.approx(2 * stats.t.sf(abs(t) * ratio, 3)) and p < found["p"]


def test_the_page_of_a_fleet_shows_all_of_it_and_runs_nothing(lab: Path, tmp_path: Path) -> None:
    page = lab.with_name("fleet.html")
    fleet.report(lab, page, title="Night <script>alert(1)</script>")
    html = page.read_text()
    assert "<script>alert(1)" not in html and "steady &lt;b&gt;1&lt;/b&gt;" in html and "<b>1</b>" not in html
    for text in ("wide", "tired", "Worst fits", "41 devices, 61 calibrations", "robust distance"):
        assert text in html, text
    links = re.findall(r'<a href="([^"#]+)"', html)
    assert len(links) > 41
    for link in links:
        from urllib.parse import unquote

        assert (lab.parent / unquote(link)).exists(), link
    assert "http://" not in html.replace("http://www.w3.org", "") and html.count("<svg") >= 3, html.count(
        "<svg"
    )
    fleet.report(f"sqlite:///{tmp_path / 'empty.sqlite'}", tmp_path / "empty.html")
    assert "No region was drawn" in (tmp_path / "empty.html").read_text()
