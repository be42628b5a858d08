"""Records of a simulated fleet: the program's bench with numbers that scatter from device to device.

python simulated_fleet.py write FOLDER COUNT       writes them
python simulated_fleet.py calibrate PATTERN URL    calibrates them one after another, into a registry
python simulated_fleet.py content URL              prints what a registry holds, but for times
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from concurrent.futures import Executor, Future
from pathlib import Path
from typing import Any

import hysteron_models as hy
import numpy as np
from hysteron_models import _native, fleet
from hysteron_models.fleet import schema
from sqlalchemy import select

# Quasi-static loops, fitted in a tenth of a second.
ESTIMATOR = hy.Hammerstein("bouc-wen", "none", n=1.0, delay=0.0, seed=1)

# Columns that differ between two runs with the same results.
CHANGING = ("id", "device_id", "seconds", "finished", "report")


class Serial(Executor):
    """Runs at once, in this thread."""

    def submit(self, work: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        future: Future[Any] = Future()
        future.set_result(work(*args, **kwargs))
        return future


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


def content(url: str) -> dict[str, Any]:
    """Everything that a registry holds of each device, but for times and numbers of rows."""
    registry = fleet.Registry(url)
    found: dict[str, Any] = {}
    with registry.engine.connect() as connection:
        names = {row.id: row.name for row in connection.execute(select(schema.devices))}
        parameters: dict[int, list[Any]] = {}
        for row in connection.execute(select(schema.parameters).order_by(schema.parameters.c.position)):
            parameters.setdefault(row.calibration_id, []).append(tuple(row)[1:])
        for row in connection.execute(select(schema.calibrations)).mappings():
            kept = {name: row[name] for name in row if name not in CHANGING}
            if row["model"]:
                model = json.loads(row["model"])
                del model["provenance"]["created"]
                kept["model"] = json.dumps(model)
            place = names[row["device_id"]], row["key"]
            assert place not in found
            found[place] = {**kept, "parameters": parameters.get(row["id"], [])}
    registry.close()
    return found


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["write", folder, count]:
            write(Path(folder), int(count))
        case ["calibrate", pattern, url]:
            print("begins", flush=True)
            fleet.calibrate(pattern, ESTIMATOR, executor=Serial(), registry=url)
        case ["content", url]:
            for place, row in sorted(content(url).items()):
                print(place, row)
        case _:
            sys.exit(__doc__)
