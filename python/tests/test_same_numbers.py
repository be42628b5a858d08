"""Identified and simulated by the command and by this package: the same numbers, bit for bit."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

import hysteron_models as hy
import numpy as np
import pytest

RIG = ["simulated_nested_loops.csv", "simulated_sweep_1_90hz.csv"]
STACK = ["stack.csv"]

#: Records and options, by the names of this package; the flags of the command follow from them.
FITS: list[tuple[list[str], dict[str, Any]]] = [
    *[
        (RIG, {"dynamics": dynamics, **more})
        for dynamics, more in [
            ("integer", {}), ("integer", {"order": 1}), ("integer", {"order": 3}), ("modes", {"order": 4}),
            ("arx", {}), ("oe", {}), ("bj", {}), ("srivc", {}), ("none", {}),
            ("integer", {"creep": "fractional"}), ("integer", {"creep": "logarithmic"}),
            ("integer", {"creep": "kelvin-voigt", "creep_elements": 1}),
            ("integer", {"degree": 1}), ("integer", {"degree": 3}), ("integer", {"delay": 0.001}),
            ("integer", {"initial": "zero"}), ("integer", {"initial": "free"}), ("integer", {"drift": True}),
            ("integer", {"scheme": "tustin"}), ("integer", {"inter_sample": "hold"}),
            ("integer", {"inter_sample": "band-limited"}), ("integer", {"fixed": {"gamma": 0.0}}),
            ("integer", {"bounds": {"beta": (0.01, 3.0)}}), ("integer", {"n": 1.5}),
            ("integer", {"method": "two-step"}), ("fractional", {}), ("fractional-free-lowest", {}),
        ]
    ],
    *[
        (RIG, {"hysteresis": name, "elements": elements, "dynamics": "integer"})
        for name, elements in [
            ("prandtl-ishlinskii", 6), ("maxwell-slip", 4), ("one-sided-plays", 4), ("generalised-plays", 3),
            ("dead-zone-plays", 4), ("preisach", 4), ("rate-dependent-plays", 4),
        ]
    ],
    (RIG, {"hysteresis": "dahl", "dynamics": "integer"}),
    *[
        (STACK, {"hysteresis": name})
        for name in [
            "bouc-wen", "parallel-bouc-wen", "non-symmetric-bouc-wen", "song-der-kiureghian", "dahl", "duhem",
            "jiles-atherton",
        ]
    ],
    *[
        (STACK, {"hysteresis": name, "elements": elements})
        for name, elements in [
            ("prandtl-ishlinskii", 5), ("krasnoselskii-pokrovskii", 3), ("preisach", 4),
        ]
    ],
    *[
        (STACK, {"optimizer": name, "generations": 5, "population": 12})
        for name in ["de-abc", "abc", "de", "pso"]
    ],
    (STACK, {"optimizer": "cma-es", "generations": 5, "seed": 7}),
]  # fmt: skip


def _flags(options: dict[str, Any]) -> list[str]:
    flags: list[str] = []
    for name, value in options.items():
        if name == "fixed":
            flags += [word for n, v in value.items() for word in ("--fix", f"{n}={v}")]
        elif name == "bounds":
            flags += [word for n, (low, high) in value.items() for word in ("--bound", f"{n}={low}:{high}")]
        elif value is True:
            flags.append(f"--{name}")
        else:
            flags += [f"--{name.replace('_', '-')}", str(value)]
    return flags


def _without_provenance(model: dict[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in model.items() if key != "provenance"}


@pytest.mark.parametrize(
    ("names", "options"), FITS, ids=lambda value: str(value) if isinstance(value, dict) else ""
)
def test_command_and_package_agree(
    command: Path, bench: Path, tmp_path: Path, names: list[str], options: dict[str, Any]
) -> None:
    out = tmp_path / "model.json"
    records = [str(bench / name) for name in names]
    told = subprocess.run(
        [str(command), "identify", *records, "-o", str(out), "--json", "--least-fit", "0", *_flags(options)],
        capture_output=True, text=True,
    )  # fmt: skip
    stage = hy.Hammerstein(**options, least_fit=0)
    read = hy.read(records)
    assert told.returncode == 0, told.stderr
    stage.fit(read)
    printed = json.loads(told.stdout)
    printed.pop("model")
    assert printed == stage.result_
    assert _without_provenance(json.loads(out.read_text())) == _without_provenance(stage.model_.data)
    drive = records[-1]
    simulated = tmp_path / "y.csv"
    subprocess.run(
        [str(command), "simulate", str(out), drive, "-o", str(simulated)], check=True, capture_output=True
    )
    ours = stage.model_.simulate(hy.read(drive)).y
    theirs = hy.read(simulated, input="u", output="y").y
    assert np.array_equal(ours, theirs)


def _several_axes(seed: int, level: float) -> hy.Record:
    """Two periods of two resonances with two inputs and two outputs, simulated, under random multisines."""
    rng = np.random.default_rng(seed)
    rate, period = 1000.0, 1024
    lines = np.arange(1, 400)
    u = np.zeros((2, period))
    for axis in range(2):
        spectrum = np.zeros(period // 2 + 1, dtype=complex)
        spectrum[lines] = np.exp(2j * np.pi * rng.random(len(lines)))
        u[axis] = np.fft.irfft(spectrum, period)
        u[axis] *= level / u[axis].std()
    s = 2j * np.pi * np.fft.rfftfreq(period, 1 / rate)
    y = np.zeros((2, period // 2 + 1), dtype=complex)
    for frequency, shares in [(130.0, (1.0, 0.4)), (250.0, (0.5, -0.9))]:
        w = 2 * np.pi * frequency * (1 - 0.03 * level / 0.5)
        mode = w**2 / (s**2 + 0.06 * w * s + w**2)
        drive = sum(share * np.fft.rfft(u[k]) for k, share in enumerate(shares))
        y += np.outer(shares, mode * drive)
    outputs = 1000 * np.fft.irfft(y, period, axis=1) + rng.normal(0, 0.5, (2, period))
    twice = [np.tile(channel, 2) for channel in (*u, *outputs)]
    return hy.Record(dict(zip(["u1_V", "u2_V", "y1_nm", "y2_nm"], twice, strict=True)), fs=rate)


def _force() -> hy.Record:
    """Three periods of a mass on a spring with a hysteretic force, simulated."""
    rate, period = 1024.0, 1024
    t = np.arange(period) / rate
    u = 60 * sum(np.sin(2 * np.pi * f * t + f * f) for f in range(5, 40)) / 6
    y, v, z, out = 0.0, 0.0, 0.0, np.zeros(4 * period)
    h = 1 / (16 * rate)
    for k in range(4 * period):
        for _ in range(16):
            z += h * (5e3 * v - 1e3 * abs(v) * z - 5e2 * v * abs(z))
            v += h * (u[k % period] - 20 * v - 2.5e4 * y - z)
            y += h * v
        out[k] = y
    return hy.Record({"u_N": np.tile(u, 3), "y_mm": 1e3 * out[period:]}, fs=rate)


def _damper() -> hy.Record:
    """A damper with a spring, dry friction and a force that saturates, simulated."""
    t = np.arange(5000) / 1000
    x = np.minimum(t, 1.0) * (10 * np.sin(2 * np.pi * t) + 3 * np.sin(2 * np.pi * 4.3 * t))
    friction, force = 0.0, np.zeros_like(t)
    for k in range(1, len(t)):
        moved = x[k] - x[k - 1]
        friction += (moved - abs(moved) * friction) / 0.5
        force[k] = 2 * x[k] + 80 * friction
    return hy.Record({"u_mm": x, "y_N": force + 200 * np.tanh(np.gradient(x, t) / 10)}, fs=1000.0)


@pytest.mark.parametrize("kind", ["modes", "branches", "oscillator", "force"])
def test_other_kinds_agree(command: Path, tmp_path: Path, kind: str) -> None:
    axes = (["u1_V", "u2_V"], ["y1_nm", "y2_nm"])
    single = kind in ("oscillator", "force")
    if single:
        records = [_force() if kind == "oscillator" else _damper()]
        flags = ["--structure", kind]
        stage: hy.Estimator = hy.Oscillator(least_fit=0) if kind == "oscillator" else hy.Force(least_fit=0)
    else:
        records = [_several_axes(1, 0.1), _several_axes(2, 0.1), _several_axes(3, 0.5), _several_axes(4, 0.5)]
        flags = ["--inputs", ",".join(axes[0]), "--outputs", ",".join(axes[1])]
        if kind == "modes":
            flags += ["--modes", "2", "--steps", "1", "--plays", "2", "--iterations", "2"]
            stage = hy.Modes(*axes, modes=2, steps=1, plays=2, iterations=2, least_fit=0)
        else:
            flags += ["--structure", "hammerstein"]
            stage = hy.Branches(*axes, least_fit=0)
    paths = [tmp_path / f"r{k}.csv" for k in range(len(records))]
    for path, record in zip(paths, records, strict=True):
        record.save(path)
    out = tmp_path / "model.json"
    run = [str(command), "identify", *map(str, paths), "-o", str(out), "--json", "--least-fit", "0", *flags]
    told = subprocess.run(run, capture_output=True, text=True)
    assert told.returncode == 0, told.stderr
    stage.fit(hy.read(paths))
    printed = json.loads(told.stdout)
    printed.pop("model")
    assert printed == stage.result_
    assert _without_provenance(json.loads(out.read_text())) == _without_provenance(stage.model_.data)
    if not single:
        predicted, score = stage.predict(records[-1]), stage.scores(records[-1])
        assert isinstance(predicted, hy.Prediction) and isinstance(score, hy.Score)
        assert isinstance(predicted.offset, tuple) and len(predicted.offset) == 2
        assert score.offset == predicted.offset
        # The offset of each output is its own mean residual; the model is in µm.
        means = [1e-3 * records[-1][name].mean() for name in ("y1", "y2")]
        assert np.allclose(predicted.y.mean(axis=0), means, rtol=1e-9)
    if kind == "modes":
        t = np.arange(1024) / records[0].fs
        references = [0.01 * np.sin(2 * np.pi * 5 * t), np.zeros_like(t)]
        drives = stage.model_.decouple(references, limits=[(-0.2, 0.2)] * 2, periodic=True)
        assert drives.u.shape == drives.predicted.shape == drives.reference.shape == (2, 1024)
        assert np.abs(drives.u).max() <= 0.2 and np.isfinite(drives.predicted).all()
        written = ["--to", "c", "--name", "stage", "--inverse", "--range=-0.2:0.2,-0.1:0.2", "--level", "0.3"]
        run = [str(command), "export", str(out), *written, "--date", "none", "-o", str(tmp_path / "c")]
        subprocess.run(run, check=True)
        limits = [(-0.2, 0.2), (-0.1, 0.2)]
        names = hy.load(out).export(tmp_path / "p", name="stage", inverse=True, limits=limits, level=0.3)
        assert "stage_inverse.c" in names
        for name in names:
            # The hash of the model file is known to the command alone.
            ours, theirs = [
                [
                    line
                    for line in (tmp_path / folder / name).read_text().splitlines()
                    if "SHA-256" not in line
                ]
                for folder in ("p", "c")
            ]
            assert [x for x in ours if "0x" not in x] == [x for x in theirs if "0x" not in x], name
        with pytest.raises(hy.HysteronError, match="several axes"):
            stage.model_.export(tmp_path / "x", inverse=True, controller="feedforward-pi")
    simulated = tmp_path / "y.csv"
    subprocess.run([str(command), "simulate", str(out), str(paths[-1]), "-o", str(simulated)], check=True)
    ours = stage.model_.simulate(hy.read(paths[-1])).y
    theirs = hy.read(simulated)
    names = ["y"] if single else ["y1_nm", "y2_nm"]
    columns = [theirs["y"] if single else theirs[_name_in(theirs, n)] for n in names]
    assert np.array_equal(np.column_stack(columns).squeeze(), ours)


def test_structures_of_several_axes_are_compared_with_the_same_numbers(command: Path, tmp_path: Path) -> None:
    axes = (["u1_V", "u2_V"], ["y1_nm", "y2_nm"])
    records = [_several_axes(1, 0.1), _several_axes(2, 0.1), _several_axes(3, 0.5), _several_axes(4, 0.5)]
    paths = [tmp_path / f"r{k}.csv" for k in range(len(records))]
    for path, record in zip(paths, records, strict=True):
        record.save(path)
    names = ["modes1+linear", "modes2+linear"]
    flags = ["--inputs", ",".join(axes[0]), "--outputs", ",".join(axes[1]), "--candidates", ",".join(names)]
    run = [str(command), "compare", *map(str, paths), *flags, "--json"]
    told = subprocess.run(run, capture_output=True, text=True)
    assert told.returncode == 0, told.stderr
    found = hy.compare_axes(hy.read(paths), *axes, names)
    assert json.loads(told.stdout) == found.result
    assert found.preferred == "modes2+linear" and found.model is not None
    assert len(found.to_pandas()) == 2


def _name_in(record: hy.Record, name: str) -> str:
    """Name of an output in a written file: in the model's unit, µm for a length."""
    stem = name.split("_")[0]
    return next(n for n in record.channels if n in (stem, name))


def test_there_are_fifty_fits() -> None:
    assert len(FITS) >= 50
