"""Records of a simulated device, and the command that is built beside the package."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import hysteron_models as hy
import numpy as np
import pytest

ROOT = Path(__file__).parents[2]
STACK = ROOT / "examples/piezo-p885-200hz/identification_1hz.csv"


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--renew-pictures", action="store_true", help="write the pictures that plots are compared with"
    )


def device(u: np.ndarray) -> np.ndarray:
    """Displacement [µm] of a simulated device, eight play operators and a line, for a drive [V]."""
    y = 1.7 * u
    for k in range(8):
        half, p = 0.15 + 0.25 * k, 0.0
        moved = np.empty_like(u)
        for i, v in enumerate(u):
            p = min(max(p, v - half), v + half)
            moved[i] = p
        y = y + 0.2 * 0.8**k * moved
    return y


@pytest.fixture(scope="session")
def loops() -> hy.Record:
    """Nested loops, simulated, with the noise of a sensor."""
    fs = 500.0
    u = np.concatenate([a * 5 * (1 - np.cos(2 * np.pi * np.arange(fs) / fs)) for a in (1.0, 0.6, 0.3)])
    noise = np.random.default_rng(1).normal(0, 0.005, len(u))
    return hy.Record(u, device(u) + noise, fs=fs, name="loops")


@pytest.fixture(scope="session")
def unseen() -> hy.Record:
    """A random drive, simulated, that no fit has seen."""
    fs = 500.0
    rng = np.random.default_rng(2)
    steps = rng.normal(0, 1, 1500)
    smooth = np.convolve(steps, np.hanning(100), mode="same")
    u = 5 + 3.5 * smooth / np.abs(smooth).max()
    u *= np.minimum(np.arange(len(u)) / 200, 1.0)
    return hy.Record(u, device(u) + rng.normal(0, 0.005, len(u)), fs=fs, name="unseen")


@pytest.fixture(scope="session")
def stage(loops: hy.Record) -> hy.Hammerstein:
    """Plays fitted to the loops."""
    return hy.Hammerstein("prandtl-ishlinskii", "none", elements=8).fit(loops)


@pytest.fixture(scope="session")
def stack() -> hy.Record:
    """The example record of a real piezo stack, its first four seconds."""
    return hy.read(STACK, stop=4.0)


@pytest.fixture(scope="session")
def command() -> Path:
    """The command, built in the same profile as the package."""
    given = os.environ.get("HYSTERON")
    path = Path(given) if given else ROOT / "target/debug/hysteron"
    if not path.exists():
        pytest.skip(f"{path} is not built: make test-python builds it")
    return path


@pytest.fixture(scope="session")
def bench(command: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with records of the simulated bench, written by the command."""
    folder = tmp_path_factory.mktemp("bench")
    plan = {
        "sample_rate_hz": 500, "loop_hz": 2, "loop_periods": 1.5, "sweep_end_hz": 90, "sweep_s": 1.2,
        "validation_hz": [20], "validation_s": 0.2, "nested_amplitudes": [1, 0.6, 0.3],
    }  # fmt: skip
    (folder / "plan.json").write_text(json.dumps(plan))
    rig = [str(command), "rig", "--out-dir", str(folder), "--seed", "1", "--plan", str(folder / "plan.json")]
    subprocess.run(rig, check=True, capture_output=True)
    lines = STACK.read_text().splitlines(keepends=True)
    (folder / "stack.csv").write_text("".join(lines[:801]))
    return folder
