"""Fits, predictions, inverses, controllers, exports, pickles."""

from __future__ import annotations

import copy
import json
import pickle
import re
import subprocess
import sys
import threading
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path
from typing import Any, get_args

import hysteron_models as hy
import numpy as np
import pytest
from hysteron_models.model import ExportForm
from scipy import signal as scipy_signal


def test_a_fit_tells_parameters_findings_and_scores(stack: hy.Record) -> None:
    stage = hy.Hammerstein(seed=1).fit(stack)
    frame = stage.parameters_
    assert list(frame.columns[:5]) == ["value", "std_error", "lower", "upper", "unit"]
    assert frame.loc["linear", "value"] > 0 and frame.loc["linear", "unit"] == "µm/V"
    assert stage.scores_[0].rmse < 0.4 and stage.scores_[0].unit == "um"
    text = stage.summary()
    assert "[[Parameters]]" in text and "+/-" in text and "(held)" in text
    assert any(finding.kind == "advice" for finding in stage.findings_)


def test_unseen_records_are_predicted_within_the_band(
    stage: hy.Hammerstein, unseen: hy.Record, tmp_path: Path
) -> None:
    prediction = stage.predict(unseen, band=0.95)
    assert prediction.measured is not None and prediction.lower is not None and prediction.upper is not None
    assert np.sqrt(np.mean((prediction.measured - prediction.y) ** 2)) < 0.02 * np.ptp(prediction.measured)
    assert np.all(prediction.lower < prediction.upper) and prediction.start
    narrow = stage.predict(unseen, band=0.5)
    width = prediction.upper - prediction.lower
    assert np.all(narrow.upper - narrow.lower < width)
    # In the class, where the band is that of a normal distribution about the model's output.
    file = tmp_path / "class.json"
    file.write_text(json.dumps({**stage.model_.data, "misfit": None}))
    wide, narrow = (hy.load(file).predict(unseen, band=level) for level in (0.95, 0.5))
    ratio = (narrow.upper - narrow.lower) / (wide.upper - wide.lower)
    assert np.allclose(ratio, 0.674489750196 / 1.959963984540, rtol=1e-9)
    score = stage.scores(unseen)
    assert isinstance(score, hy.Score) and score.series is not None
    assert np.isclose(score.rmse, np.sqrt(np.mean(score.series["residual"] ** 2)), rtol=1e-12)
    assert np.allclose(score.series["y_model"], prediction.y)
    assert list(prediction.to_pandas().columns) == ["y", "lower", "upper", "measured"]
    alone = stage.model_.simulate(hy.Record({"u_V": unseen.u}, fs=unseen.fs))
    assert alone.measured is None and len(alone.y) == len(unseen)
    with pytest.raises(hy.IdentifyError, match="level between 0 and 1"):
        stage.predict(unseen, band=95)


def test_a_model_is_corrected_by_its_misfit_where_that_pays(
    loops: hy.Record, unseen: hy.Record, tmp_path: Path
) -> None:
    file = hy.Hammerstein("bouc-wen", "none").fit(loops).model_.data

    def of(misfit: dict[str, Any] | None) -> hy.Model:
        path = tmp_path / "model.json"
        path.write_text(json.dumps({**file, "misfit": misfit}))
        return hy.load(path)

    with pytest.raises(hy.ModelError, match="no device outside the model class"):
        of(None).scores(unseen, correct=True)
    with pytest.raises(hy.ModelError, match="gains nothing"):
        of({**file["misfit"], "left_out": 0.95}).predict(unseen, correct=True)
    model = of({**file["misfit"], "left_out": 0.5})
    plain, corrected = model.scores(unseen), model.scores(unseen, correct=True)
    assert isinstance(plain, hy.Score) and isinstance(corrected, hy.Score)
    assert corrected.rmse != plain.rmse and corrected.details["left_out"] == 0.5
    assert corrected.details["without_correction"]["rmse_um"] == plain.rmse
    prediction = model.predict(unseen, band=0.95, correct=True)
    assert corrected.series is not None and np.allclose(corrected.series["y_model"], prediction.y)
    with pytest.raises(hy.OptionError, match="run in parts"):
        model.scores([unseen], continued=True, correct=True)


def test_the_next_drive_is_better_than_a_loop_and_a_sweep(stage: hy.Hammerstein) -> None:
    found = hy.design(stage, "minor-loops", time=2.0, limits=(0, 10), slew=400.0, seed=3)
    drive = found.drive.u
    assert len(drive) == 2.0 * found.result["sample_rate_hz"]
    assert drive.min() >= 0 and drive.max() <= 10
    assert np.abs(np.diff(drive)).max() * found.result["sample_rate_hz"] <= 400.0
    frame = found.to_pandas()
    aim = frame[frame["aim"]]
    assert len(aim) == 1 and (aim["designed"] <= aim["usual"] * (1 + 1e-9)).all()
    assert (aim["designed"] < aim["now"]).all() and len(found.motion) > 0
    with pytest.raises(hy.IdentifyError, match="a drive of -1 s at 500 Hz"):
        hy.design(stage, "delay", time=-1.0)


def test_the_inverse_undoes_the_model(stage: hy.Hammerstein) -> None:
    t = np.arange(500) / 500
    reference = 8 + 4 * np.sin(2 * np.pi * 2 * t)
    found = stage.invert(reference, fs=500, limits=(0, 10))
    assert np.allclose(found.predicted, reference, atol=1e-9)
    drive = hy.Record({"u_V": found.u}, fs=500)
    assert np.ptp(stage.model_.simulate(drive, rest=0.0).y) == pytest.approx(8, abs=0.05)
    controller = stage.controller(500, limits=(0, 10))
    steps = [stage.controller(500, limits=(0, 10)).step(reference[0])]
    assert steps[0] == controller.run(reference)[0]
    assert controller.limits == (0, 10) and controller.fs == 500 and np.isfinite(controller.displacement)
    with pytest.raises(hy.ModelError):
        stage.invert(reference + 1e3, fs=500)


def test_a_loop_is_tracked_on_the_simulated_bench(stage: hy.Hammerstein) -> None:
    t = np.arange(2000) / 1000
    reference = 8 + 2 * np.sin(2 * np.pi * 5 * t)
    found = stage.track(reference, 1000, plant="model", controllers=["feedforward", "pi"], limits=(0, 10))
    assert set(found.displacements) == {"feedforward", "pi"} and len(found.t) == 2000
    with pytest.raises(hy.OptionError, match="plant"):
        stage.track(reference, 1000, plant="bench")  # type: ignore[arg-type]


def test_the_dynamic_block_is_a_state_space(bench: Path) -> None:
    records = hy.read([bench / "simulated_nested_loops.csv", bench / "simulated_sweep_1_90hz.csv"])
    stage = hy.Hammerstein(dynamics="integer").fit(records)
    response = stage.frequency_response([1.0, 10.0, 50.0])
    realised = stage.model_.realise(5000.0)
    z = np.exp(2j * np.pi * response.frequency_hz / realised.sample_rate_hz)
    eye = np.eye(len(realised.a))
    discrete = [
        (realised.c @ np.linalg.solve(w * eye - realised.a, realised.b) + realised.d)[0, 0] for w in z
    ]
    assert np.allclose(discrete, response.response, rtol=5e-3)
    assert np.allclose(realised.to_control()(z), discrete, rtol=1e-6)
    assert np.allclose(response.to_control().frdata.ravel(), response.response)
    # Step by step: the gain at rest is what a long step comes to.
    _, y, _ = scipy_signal.dlsim(realised.to_scipy(), np.ones(200_000))
    assert y[-1, 0] == pytest.approx(realised.summary["rest_gain"], rel=1e-3)


def test_models_are_saved_pickled_and_copied(
    stage: hy.Hammerstein, unseen: hy.Record, tmp_path: Path
) -> None:
    stage.save(tmp_path / "model.json")
    loaded = hy.load(tmp_path / "model.json")
    for again in (loaded, pickle.loads(pickle.dumps(stage)), copy.deepcopy(stage.model_)):
        model = again.model_ if isinstance(again, hy.Hammerstein) else again
        assert model == stage.model_
        assert np.array_equal(model.predict(unseen).y, stage.predict(unseen).y)
    stage.report(tmp_path / "report.html")
    assert "<svg" in (tmp_path / "report.html").read_text()
    names = stage.export(tmp_path / "c", name="stage", inverse=True, limits=(0, 10))
    assert {"stage.h", "stage.c"} <= set(names) and (tmp_path / "c/stage.c").exists()
    matlab = stage.export(tmp_path / "m", "matlab", name="stage", inverse=True, limits=(0, 10))
    assert {"stage.m", "stage_inverse.m"} <= set(matlab) and (tmp_path / "m/stage.m").exists()
    assert "stage_sfun.c" in stage.export(tmp_path / "s", "simulink", name="stage")
    pi = "feedforward-pi"
    around = stage.export(tmp_path / "l", name="stage", inverse=True, limits=(0, 10), controller=pi)
    assert "stage_controller.c" in around
    single = stage.export(
        tmp_path / "r", "rust", float_type="f32", name="stage", inverse=True, limits=(0, 10), controller=pi
    )
    assert {"src/controller.rs", "src/controller/law.rs"} <= set(single)
    with pytest.raises(hy.HysteronError, match="with the inverse"):
        stage.export(tmp_path / "y", name="stage", controller=pi)
    with pytest.raises(hy.OptionError, match="several axes"):
        stage.export(tmp_path / "y", name="stage", inverse=True, limits=[(0, 10), (0, 10)])
    with pytest.raises(hy.OptionError) as refused:
        stage.export(tmp_path / "x", "punched-cards")  # type: ignore[arg-type]
    offered = str(refused.value).partition("expected one of ")[2]
    assert re.findall("`(.*?)`", offered) == list(get_args(ExportForm))
    fresh, found = loaded.recalibrate(unseen)
    assert fresh.kind == "hammerstein" and "gain" in found


def test_structures_are_compared(bench: Path) -> None:
    names = ["simulated_nested_loops.csv", "simulated_sweep_1_90hz.csv", "simulated_20hz.csv"]
    records = [hy.read(bench / name) for name in names if (bench / name).exists()]
    found = hy.compare(records, ["integer2", "fractional"])
    assert found.preferred in ("integer2", "fractional") and found.model is not None
    assert len(found.to_pandas()) == 2


def test_a_comparison_that_cannot_rank_says_what_to_measure(stack: hy.Record) -> None:
    with pytest.raises(hy.IdentifyError, match="one experiment however often") as refused:
        hy.compare([stack], ["none", "integer2"])
    assert str(refused.value.hint).startswith("measure a sweep") and refused.value.code == "cannot-rank"


def test_unknown_names_list_the_choices(loops: hy.Record) -> None:
    with pytest.raises(hy.OptionError, match="expected one of auto, bouc-wen, prandtl-ishlinskii"):
        hy.Hammerstein("plays").fit(loops)
    with pytest.raises(hy.OptionError, match="optimiser"):
        hy.Hammerstein(optimizer="simplex").fit(loops)
    with pytest.raises(hy.OptionError, match="expected records, found ndarray"):
        hy.Hammerstein().fit([loops.u])  # type: ignore[list-item]
    with pytest.raises(hy.ModelError, match="not fitted"):
        hy.Hammerstein().predict(loops)
    assert "bouc-wen" in hy.choices()["hysteresis"]


def test_the_family_is_chosen_by_held_out_error_on_request(loops: hy.Record) -> None:
    found = hy.Hammerstein("auto", "none").fit(loops)
    chosen = found.result_["family"]["chosen"]
    assert found.result_["hysteresis"]["kind"] == chosen
    assert found.findings_[0].text.startswith(f"The hysteresis family is {chosen}")
    with pytest.raises(hy.OptionError, match="auto cannot have 4 elements"):
        hy.Hammerstein("auto", elements=4).fit(loops)


def test_progress_is_told_and_an_exception_in_it_stops_the_fit(loops: hy.Record) -> None:
    told: list[tuple[str, float, float | None]] = []
    hy.Hammerstein("preisach", "none", elements=8).fit(loops, progress=lambda *event: told.append(event))
    assert all(0 <= fraction <= 1 for _, fraction, _ in told)

    def stop(*_: object) -> None:
        raise RuntimeError("enough")

    stage = hy.Hammerstein("dead-zone-plays", "integer", optimizer="de-abc", generations=10**6)
    begun = time.monotonic()
    with pytest.raises(RuntimeError, match="enough"):
        stage.fit(loops, progress=stop)
    assert time.monotonic() - begun < 20
    if hasattr(stage, "model_"):
        assert stage.interrupted_


def test_ctrl_c_keeps_the_best_so_far(tmp_path: Path) -> None:
    script = f"""
import hysteron_models as hy, os, signal, threading, time
# Where the tests run behind a shell's &, SIGINT is ignored.
signal.signal(signal.SIGINT, signal.default_int_handler)
record = hy.read(
    {str(Path(__file__).parents[2] / "examples/piezo-p885-200hz/identification_1hz.csv")!r}, stop=4.0
)
stage = hy.Hammerstein(optimizer="de-abc", generations=10**7)
sent = []
def interrupt():
    time.sleep(0.5)
    sent.append(time.monotonic())
    os.kill(os.getpid(), signal.SIGINT)
def told(stage, fraction, cost):
    # The fit runs, and has something to keep.
    if cost is not None and not sent and threading.active_count() == 1:
        threading.Thread(target=interrupt).start()
try:
    stage.fit(record, progress=told)
except KeyboardInterrupt:
    print("stopped after", time.monotonic() - sent[0], stage.interrupted_, stage.model_.kind, flush=True)
"""
    told = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=120)
    words = told.stdout.split()
    assert words[:2] == ["stopped", "after"] and words[3:] == ["True", "hammerstein"], told
    assert float(words[2]) < 2.0, told.stdout


def _fitted(record: hy.Record) -> float:
    return float(hy.Hammerstein("prandtl-ishlinskii", "none", elements=4).fit(record).scores_[0].rmse)


def test_fits_run_in_pools_of_threads_and_of_processes(loops: hy.Record) -> None:
    alone = _fitted(loops)
    with ThreadPoolExecutor(2) as pool:
        assert list(pool.map(_fitted, [loops] * 2)) == [alone] * 2
    # Forked children have none of the threads that fitted above.
    with ProcessPoolExecutor(2) as pool:
        assert list(pool.map(_fitted, [loops] * 2)) == [alone] * 2


def test_importing_needs_numpy_alone() -> None:
    script = (
        "import sys, time; t = time.perf_counter(); import hysteron_models; t = time.perf_counter() - t; "
        "print(t, [m for m in ('pandas', 'matplotlib', 'sklearn', 'scipy', 'tqdm') if m in sys.modules])"
    )
    told = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    seconds, loaded = told.stdout.split(" ", 1)
    assert loaded.strip() == "[]" and float(seconds) < 2.0


def test_the_interpreter_goes_on_during_a_fit(loops: hy.Record) -> None:
    counted = [0]
    done = threading.Event()

    def count() -> None:
        while not done.is_set():
            counted[0] += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    begun = time.monotonic()
    hy.Hammerstein("preisach", "none", elements=8).fit(loops)
    elapsed = time.monotonic() - begun
    done.set()
    thread.join()
    assert counted[0] > 50 * elapsed


def test_a_drifted_device_is_followed(stage: hy.Hammerstein, unseen: hy.Record) -> None:
    drifted = hy.Record(unseen.u, 1.05 * unseen.y, fs=unseen.fs)
    model, found = stage.model_.adapt(drifted, noise=0.05)
    assert model is not None and found["fits"] in (True, False)
    gain = next(c for c in found["coefficients"] if c["term"] == "gain")
    assert gain["after"] == pytest.approx(1.05, abs=0.01)
    without, _ = stage.model_.adapt(drifted, noise=0.05, terms=["gain", "creep=0.5"])
    assert without is None


def test_the_bench_plays_a_multisine_whose_response_is_explained() -> None:
    drive = hy.excite(
        "multisine", fs=2000, high=10, period_s=1.0, periods=4, low_hz=1.0, high_hz=200.0, seed=3
    )
    record = hy.simulate_bench(drive, seed=1)
    assert len(record) == len(drive) and record.units == ("V", "um")
    found = hy.frequency_response(record, structures=["fractional", "integer"])
    assert len(found.measured.frequency_hz) > 50 and found.model is not None
    assert {row["name"].split()[0] for row in found.result["structures"]}
    with pytest.raises(hy.OptionError, match="expected one of fractional"):
        hy.frequency_response(record, structures=["poles"])


def test_other_units_of_the_same_quantity_are_those_of_the_model(
    stage: hy.Hammerstein, unseen: hy.Record
) -> None:
    in_nm = hy.Record({"u_mV": 1e3 * unseen.u, "y_nm": 1e3 * unseen.y}, fs=unseen.fs)
    prediction = stage.predict(in_nm)
    assert prediction.unit == "um" and prediction.measured is not None
    assert np.allclose(prediction.measured, unseen.y) and np.allclose(prediction.y, stage.predict(unseen).y)
    with pytest.raises(hy.ModelError, match="model's"):
        stage.predict(hy.Record(unseen.u, unseen.y, fs=unseen.fs, units=("V", "N")))


def test_a_run_in_parts_is_scored_from_the_start_that_is_given(
    stage: hy.Hammerstein, unseen: hy.Record
) -> None:
    whole = stage.scores(unseen, rest=2.0)
    half = len(unseen) // 2
    parts = [
        hy.Record(unseen.u[part], unseen.y[part], t=unseen.t[part], fs=unseen.fs)
        for part in (slice(None, half), slice(half, None))
    ]
    given = stage.scores(parts, continued=True, rest=2.0)
    chosen = stage.scores(parts, continued=True)
    assert isinstance(given, hy.Score) and isinstance(chosen, hy.Score) and isinstance(whole, hy.Score)
    assert given.start == whole.start != chosen.start
    assert given.rmse == pytest.approx(whole.rmse, rel=1e-3) and given.rmse != chosen.rmse
    with pytest.raises(hy.OptionError, match="exclude"):
        stage.scores(parts, continued=True, rest=0.0, settled=100)
