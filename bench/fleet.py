"""Fleets: devices per hour against the same loop with the command, what scheduling costs, and from these what a
million devices take.

    python bench/fleet.py HYSTERON [DEVICES]

HYSTERON is the command, built in the same profile as the package. All records are simulated. `make bench-python`
runs it.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "python/tests"))

import hysteron_models as hy
import simulated_fleet
from hysteron_models import fleet

CORES = 2
# Structure that both fit. Quasi-static: a quick fit, for which the cost of scheduling counts most.
STRUCTURE = {"hysteresis": "bouc-wen", "dynamics": "none"}
TRIVIAL = 2000
MILLION = 1_000_000


def records(folder, count):
    """Nested loops of each device, 3 s at 1 kHz."""
    folder.mkdir()
    drive = hy.excite(
        "nested_loops", fs=1000.0, high=10, frequency_hz=1.0, amplitudes=[1, 0.6, 0.3], periods_each=1
    )
    for number in range(count):
        record = hy.simulate_bench(drive, truth=simulated_fleet.of_device(number), seed=number)
        record.save(folder / f"simulated-{number:04d}.csv")
    return f"{folder}/*.csv"


def by_command(command, pattern, folder):
    """The loop that a shell would run: two commands at a time."""
    folder.mkdir()

    def one(path):
        options = [f"--{name}={value}" for name, value in STRUCTURE.items()]
        model = folder / f"{path.stem}.json"
        call = [command, "identify", path, "-o", model, "--seed=1", "--threads=1", *options]
        return subprocess.run(call, capture_output=True).returncode

    begun = time.perf_counter()
    with ThreadPoolExecutor(CORES) as pool:
        failed = sum(code != 0 for code in pool.map(one, sorted(Path(pattern).parent.glob("*.csv"))))
    return time.perf_counter() - begun, failed


def by_fleet(pattern, file, executor):
    """Wall time, time within the fits, failures."""
    estimator = hy.Hammerstein(**STRUCTURE, seed=1)
    begun = time.perf_counter()
    workers = CORES if executor is None else None
    table = fleet.calibrate(pattern, estimator, registry=file, executor=executor, workers=workers)
    wall = time.perf_counter() - begun
    return wall, float(table["seconds"].sum()), int((table["status"] != "ok").sum())


def trivial(folder):
    """Records that fail at once: what is left is the cost of a device that is no fit."""
    folder.mkdir()
    for number in range(TRIVIAL):
        (folder / f"{number}.csv").write_text(f"{number}\n")
    return f"{folder}/*.csv"


def main():
    # Here, since the own processes run the imports of this script.
    from distributed import Client, LocalCluster

    command, count = Path(sys.argv[1]).resolve(), int(sys.argv[2]) if len(sys.argv) > 2 else 60
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        pattern = records(folder / "records", count)
        sizes = [path.stat().st_size for path in Path(pattern).parent.iterdir()]
        print(f"{count} simulated devices, {sizes[0] / 1e3:.0f} kB each, {STRUCTURE}, {CORES} cores\n")
        print("| loop | devices per hour | wall | within fits | overhead | failed |")
        print("| --- | --- | --- | --- | --- | --- |")
        wall, failed = by_command(command, pattern, folder / "models")
        print(f"| command, {CORES} at a time | {3600 * count / wall:.0f} | {wall:.1f} s | – | – | {failed} |")
        overhead = {}
        wall, within, failed = by_fleet(pattern, folder / "own.sqlite", None)
        shares = 1 - within / (CORES * wall)
        print(
            f"| own processes | {3600 * count / wall:.0f} | {wall:.1f} s | {within / CORES:.1f} s "
            f"| {100 * shares:.1f} % | {failed} |"
        )
        with (
            LocalCluster(n_workers=CORES, threads_per_worker=1, dashboard_address=None) as cluster,
            Client(cluster) as client,
        ):
            wall, within, failed = by_fleet(pattern, folder / "dask.sqlite", client.get_executor())
            shares = 1 - within / (CORES * wall)
            print(
                f"| Dask | {3600 * count / wall:.0f} | {wall:.1f} s | {within / CORES:.1f} s "
                f"| {100 * shares:.1f} % | {failed} |"
            )
            fit_s = within / count
            nothing = trivial(folder / "nothing")
            for label, executor in (("own processes", None), ("Dask", client.get_executor())):
                wall = by_fleet(nothing, folder / f"{label}.sqlite", executor)[0]
                overhead[label] = wall / TRIVIAL
        again = time.perf_counter()
        by_fleet(pattern, folder / "own.sqlite", None)
        again = (time.perf_counter() - again) / count
        per_row = writing(folder)
        size = (folder / "many.sqlite").stat().st_size / TRIVIAL
        dask = overhead["Dask"]
        print(
            f"\na device without a fit: own processes {1e3 * overhead['own processes']:.2f} ms, "
            f"Dask {1e3 * dask:.2f} ms; writing a row {1e3 * per_row:.2f} ms, {size / 1e3:.1f} kB; "
            f"a device that is there already {1e3 * again:.2f} ms"
        )
        print(
            f"\na million devices: fits {MILLION * fit_s / 3600:.0f} core hours; the client is busy "
            f"{MILLION * dask / 3600:.1f} h with Dask, of these {MILLION * per_row / 3600:.1f} h writing; "
            f"registry {MILLION * size / 1e9:.1f} GB; one client feeds {fit_s / dask:.0f} cores"
        )


def writing(folder):
    """Time to write a row of a fit, alone [s]."""
    from hysteron_models.fleet import key, rows

    source, target = fleet.Registry(folder / "own.sqlite"), fleet.Registry(folder / "many.sqlite")
    some = rows.table(source).iloc[0]
    outcome = rows.outcome_of(source, some["key"])
    options = key.options_of(hy.Hammerstein(), {})
    begun = time.perf_counter()
    for number in range(TRIVIAL):
        known = {
            "key": f"{number:064x}", "record_sha256": "", "paths": json.dumps([str(number)]), "date": "",
            "operator": "", "notes": "", "program": key.PROGRAM, "options": options,
        }
        target.keep([({"name": str(number), "serial": ""}, known, replace(outcome, report=""))])
    return (time.perf_counter() - begun) / TRIVIAL


if __name__ == "__main__":
    os.environ.setdefault("DASK_LOGGING__DISTRIBUTED", "error")
    main()
