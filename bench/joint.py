"""The joint fit of a 3 s loop and a 10 s sweep at 10 kHz, from CSV files to a model file, beside the same
algorithm in numpy, scipy and numba and beside scipy's differential evolution; and how its evaluations grow
with samples, records and threads."""

import json
import os
import subprocess
import time

import numpy as np

from peers import joint
from rust_side import ROOT

RATE_HZ = 10_000.0
HYSTERON = ROOT / "target" / "release" / "hysteron"

# The article's class and the denominator of its Eq. 13, gain 1 at zero frequency, 5 nm of noise.
TRUTH = {
    "plant": {
        "kind": "bouc_wen_fractional",
        "polynomial": [3.2, -0.02], "alpha": 1.1, "beta": 0.35, "gamma": 0.08, "n": 1.0,
        "numerator": [{"coefficient": 5.2589e6, "order": 0.0}],
        "denominator": [
            {"coefficient": 5.2589e6, "order": 0.0}, {"coefficient": 3081.0, "order": 1.0523},
            {"coefficient": 1.0, "order": 2.0384},
        ],
        "delay_s": 1.2e-4,
    },
    "sensor": {"noise_um": 0.005, "adc": None},
}


def clocks():
    """Wall-clock and processor time of this process [s]."""
    return time.perf_counter(), time.process_time()


def since(start):
    return {"wall_s": time.perf_counter() - start[0], "cpu_s": time.process_time() - start[1]}


def command(*words):
    """Runs hysteron in a process of its own; what it prints, and its wall-clock and processor time [s]."""
    start = time.perf_counter()
    process = subprocess.Popen(
        [HYSTERON, *map(str, words)], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    )
    text = process.stdout.read()
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise SystemExit(f"error: hysteron {words[0]} failed with exit code {process.returncode}")
    return text, {"wall_s": time.perf_counter() - start, "cpu_s": used.ru_utime + used.ru_stime}


def read_columns(file):
    """Drive and output of a record."""
    lines = (line for line in file.read_text().splitlines() if not line.startswith("#"))
    next(lines)
    table = np.loadtxt(lines, delimiter=",", usecols=(-2, -1))
    return np.ascontiguousarray(table.T)


def make_records(folder, short, truth):
    """Measures on the simulated bench; the arrays of the CSV files beside them, as raw doubles."""
    plan = {"sample_rate_hz": RATE_HZ, "validation_hz": []}
    if short:
        plan |= {"loop_periods": 1.0, "sweep_s": 2.0}
    (folder / "truth.json").write_text(json.dumps(truth))
    (folder / "plan.json").write_text(json.dumps(plan))
    made = folder / "records"
    command(
        "rig", "--truth", folder / "truth.json", "--plan", folder / "plan.json", "--out-dir", made,
        "--seed", 1,
    )
    files = sorted(made.glob("*.csv"), key=lambda file: "sweep" in file.stem)
    arrays = []
    for file, name in zip(files, ("loop", "sweep")):
        u, y = read_columns(file)
        u.tofile(folder / f"{name}_u")
        y.tofile(folder / f"{name}_y")
        arrays.append((u, y))
    return files, arrays


def ours(files, folder, options, runs):
    """identify in a process of its own: the fastest run, and what it found."""
    best = None
    for _ in range(runs):
        text, took = command("identify", *files, *options, "-o", folder / "model.json", "--json")
        if best is None or took["wall_s"] < best["wall_s"]:
            best = took
    found = json.loads(text)
    best["evaluations"] = {search["step"]: search["evaluations"] for search in found["searches"]}
    powers = ("linear", "quadratic", "cubic", "quartic", "quintic")
    best["degree"] = len([p for p in found["parameters"] if p["name"] in powers])
    best["parameters"] = {p["name"]: p["value"] for p in found["parameters"]}
    return best


def searched(parameters, names):
    """Ours in the symbols of the search: memory is that of alpha = 1, gamma that of alpha > 0."""
    alpha = parameters["alpha"]
    own = {"gamma": np.sign(alpha) * parameters["gamma"]}
    own |= {name: parameters[name] / alpha for name in names if name.startswith("memory")}
    return [float(own.get(name, parameters.get(name))) for name in names]


def bench(rust, folder, quick, short=False):
    files, arrays = make_records(folder, quick or short, TRUTH)
    result = {"samples": [len(u) for u, _ in arrays]}
    runs = 1 if quick else 5
    result["hysteron, fractional"] = found = ours(files, folder, ["--dynamics", "fractional"], runs)
    result["hysteron, default"] = ours(files, folder, [], runs)
    degree = found["degree"]
    problem = {"directory": str(folder), "sample_rate_hz": RATE_HZ, "degree": degree}
    whole, thin = (rust.ask("joint_problem", **problem, reduced=reduced) for reduced in (False, True))
    names = [r["name"] for r in whole["ranges"]]

    def common(x):
        """The cost that all are compared by, worked out by the Rust side on all samples."""
        return rust.ask("joint_cost", problem=problem | {"reduced": False}, x=list(map(float, x)))["cost"]

    for name in ("hysteron, fractional", "hysteron, default"):
        own = result[name]
        if all(p in own["parameters"] for p in names) and own["degree"] == degree:
            own["cost"] = common(searched(own["parameters"], names))

    start = clocks()
    small = [dict(u=u[:64], y=y[:64], weight=1.0, factor=factor) for (u, y), factor in zip(arrays, (1, 2))]
    warm = joint.Joint(small, whole["ranges"], RATE_HZ, degree)
    warm.jacobian(warm.to_unit(whole["starts"][0]))
    result["compilation"] = since(start)

    def peer(described):
        factors = [round(len(u) / n) for (u, _), n in zip(arrays, described["samples"])]
        records = [
            dict(u=u, y=y, weight=w, factor=f) for (u, y), w, f in zip(arrays, described["weights"], factors)
        ]
        return joint.Joint(records, described["ranges"], RATE_HZ, degree), factors

    # The same number of starts as ours needed at least: its first three agree in the usual case.
    starts = whole["starts"][:3]
    begin = clocks()
    all_samples, _ = peer(whole)
    best = all_samples.fit([all_samples.to_unit(start) for start in starts])
    result["numpy, all samples"] = since(begin) | {
        "evaluations": all_samples.evaluations, "jacobians": all_samples.jacobians, "starts": len(starts),
        "cost": common(all_samples.from_unit(best.x)), "own_cost": all_samples.cost(best.x),
    }
    begin = clocks()
    reduced, factors = peer(thin)
    polished, _ = peer(whole)
    first = reduced.fit([reduced.to_unit(start) for start in starts])
    best = polished.fit([first.x])
    result["numpy, thinned records first"] = since(begin) | {
        "evaluations": reduced.evaluations + polished.evaluations,
        "jacobians": reduced.jacobians + polished.jacobians,
        "starts": len(starts), "factors": factors, "cost": common(polished.from_unit(best.x)),
    }
    middle = all_samples.from_unit(all_samples.to_unit(starts[0]))
    difference = abs(all_samples.cost(all_samples.to_unit(starts[0])) / common(middle) - 1.0)
    if not difference < 1e-6:
        raise SystemExit(
            f"error: the peer's cost differs from ours by {difference:.1e}: not the same problem"
        )
    result["agreement"] = difference

    seconds = 3.0 if quick or short else 60.0
    u, y = arrays[0]
    plain = joint.Plain(all_samples, np.ptp(y) / np.ptp(u), np.abs(u).max(), np.ptp(y))
    unit = [(0.0, 1.0)] * len(names)
    for name, cost, bounds in (
        ("differential evolution, all parameters searched", plain.cost, plain.bounds),
        ("differential evolution, linear ones eliminated", lambda t: all_samples.cost(np.asarray(t)), unit),
    ):
        cost(np.mean(bounds, axis=1))
        run = joint.evolve(cost, bounds, seconds)
        whole_run = run["whole_run"] / max(run["evaluations"], 1)
        run["extrapolated_s"] = run["seconds"] * whole_run
        run["extrapolated_cpu_s"] = run["cpu_s"] * whole_run
        result[name] = run
    return result


def scaling(rust, quick):
    """Evaluations over samples, records and threads. The longest record has no Jacobian: it would need
    5 GB."""
    samples = [1_000, 10_000] if quick else [10**k for k in range(3, 8)]
    rows = []
    for n in samples:
        repetitions = max(2, min(40, 2_000_000 // n))
        answer = rust.ask(
            "joint_times", samples=n, records=1, threads=[1, 2], repetitions=repetitions,
            jacobian=n <= 1_000_000,
        )
        rows.append({"samples": n, "records": 1} | answer)
    total = 2**15 if quick else 2**17
    for records in [1, 4] if quick else [2**k for k in range(7)]:
        n = total // records
        answer = rust.ask(
            "joint_times", samples=n, records=records, threads=[1, 2], repetitions=3 if quick else 15,
            jacobian=True,
        )
        rows.append({"samples": n, "records": records} | answer)
    return rows
