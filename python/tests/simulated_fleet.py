"""Records of a simulated fleet: the program's bench with numbers that scatter from device to device.

python simulated_fleet.py FOLDER COUNT    writes them
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import hysteron_models as hy
import numpy as np
from hysteron_models import _native

# Quasi-static loops, fitted in a tenth of a second.
ESTIMATOR = hy.Hammerstein("bouc-wen", "none", n=1.0, delay=0.0, seed=1)


def drive(fs: float = 200.0) -> hy.Record:
    """Nested loops up to 10 V, one second."""
    return hy.excite("nested_loops", fs=fs, high=10, frequency_hz=2.0, amplitudes=[1, 0.6], periods_each=1)


def truth() -> dict[str, Any]:
    """Numbers of the bench."""
    _, text = _native.play(drive()._native, None, 0, 0, False)
    found: dict[str, Any] = json.loads(text)
    return found.get("truth", found)


def of_device(number: int, hysteresis: float = 1.0, gain: float = 1.0) -> dict[str, Any]:
    """Numbers of a device: gain and plays of the bench, each times a factor near 1."""
    rng = np.random.default_rng([2026, number])
    made = truth()
    plant = made["plant"]
    plant["linear_um_per_v"] *= gain * float(np.exp(rng.normal(0, 0.03)))
    plays = hysteresis * float(np.exp(rng.normal(0, 0.05)))
    for play in plant["plays"]:
        play["weight_um_per_v"] *= plays
    return made


def write(folder: Path, count: int, first: int = 0) -> list[Path]:
    """Write one record a device, all simulated."""
    folder.mkdir(parents=True, exist_ok=True)
    u, paths = drive(), []
    for number in range(first, first + count):
        path = folder / f"simulated-{number:04d}.csv"
        hy.simulate_bench(u, truth=of_device(number), seed=number).save(path)
        paths.append(path)
    return paths


if __name__ == "__main__":
    write(Path(sys.argv[1]), int(sys.argv[2]))
