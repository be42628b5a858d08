"""`make bench`: hysteron beside numpy, scipy and numba on the same inputs, taking turns within one run.

Times of short work are minima (and medians) of wall-clock time over repetitions, one thread; times of long
work are processor time. The joint fit is in joint.py, that of plays in rich_families.py. Writes
bench/results.json and bench/results.md, and the tables of docs/benchmarks.md.
"""

import argparse
import json
import os
import pathlib
import platform
import re
import statistics
import sys
import tempfile
import time

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

try:
    import numba
    import numpy as np
    import scipy
except ImportError as missing:
    sys.exit(f"error: {missing.name} is not installed\n"
             "  try: make bench, which installs the peers into bench/.venv")

import joint
import rich_families
import tables
from peers import bouc_wen, fractional, identification
from rust_side import ROOT, RustSide


class Clock:
    """Wall-clock times of one contestant."""

    def __init__(self):
        self.seconds = []

    def run(self, work, repetitions=1):
        for _ in range(repetitions):
            start = time.perf_counter()
            result = work()
            self.seconds.append(time.perf_counter() - start)
        return result

    def take(self, answer):
        self.seconds += answer["seconds"]
        return answer["allocations"]

    def summary(self):
        return {
            "min_s": min(self.seconds), "median_s": statistics.median(self.seconds), "runs": len(self.seconds)
        }


def chirp(samples):
    """1 to 100 Hz, 10 kHz."""
    t = np.arange(samples) / fractional.RATE_HZ
    duration = samples / fractional.RATE_HZ
    return np.sin(2.0 * np.pi * (t + 49.5 * t * t / duration))


def check(what, difference, limit):
    """A comparison of times is worthless where the results differ."""
    if not difference <= limit:
        sys.exit(f"error: {what}: results differ by {difference:.2e}, more than {limit:.0e}")
    return difference


def bench_fractional(rust, folder, samples, turns, numba_too, recursion):
    u = chirp(samples)
    u.tofile(folder / "u")
    peer = fractional.Quadrature(u)
    clocks = {}

    def clock(name):
        return clocks.setdefault(name, Clock())

    rust.ask("plan_fractional", input=str(folder / "u"), scheme="tustin")
    contestants = {"numpy pair": peer.simulate, "numpy kept": peer.candidate}
    if numba_too:
        contestants |= {"numba pair": peer.simulate_by_numba, "numba kept": peer.candidate_by_numba}
    for work in contestants.values():
        work()
    allocations = 0
    for _ in range(turns):
        allocations += clock("hysteron pair").take(rust.ask("simulate", repetitions=3))
        allocations += clock("hysteron kept").take(rust.ask("candidate", repetitions=3))
        for name, work in contestants.items():
            clock(name).run(work, 2)
    result = {"samples": samples, "transform_length": peer.length, "allocations": allocations}
    rust.ask("write_output", path=str(folder / "y"))
    y = np.fromfile(folder / "y")
    largest = np.abs(y).max()
    for name, work in contestants.items():
        result.setdefault("agreement", {})[name] = check(name, np.abs(work() - y).max() / largest, 1e-8)
    if recursion:
        slow = fractional.Recursion(u)
        fractional.Recursion(u[:100]).simulate()
        rust.ask("plan_fractional", input=str(folder / "u"), scheme="grunwald-letnikov")
        for _ in range(3):
            clock("hysteron pair, Grünwald-Letnikov").take(rust.ask("simulate", repetitions=5))
            x = clock("numba recursion").run(slow.simulate)
        rust.ask("write_output", path=str(folder / "y"))
        y = np.fromfile(folder / "y")
        difference = np.abs(x - y).max() / np.abs(x).max()
        result["agreement"]["numba recursion"] = check("recursion", difference, 1e-8)
    result["times"] = {name: c.summary() for name, c in clocks.items()}
    return result


def scaling(rust, folder, sizes):
    rows = []
    for samples in sizes:
        turns = max(2, min(30, 2_000_000 // samples))
        rows.append(bench_fractional(rust, folder, samples, turns, False, False))
    return rows


# One set of parameters a law: about the same loop, counter-clockwise, as real stacks have.
LAWS = {
    1.0: {"alpha": 1.2, "beta": 0.35, "gamma": 0.08},
    2.0: {"alpha": 1.2, "beta": 0.10, "gamma": 0.02},
    1.5: {"alpha": 1.2, "beta": 0.19, "gamma": 0.04},
}
LINEAR = 3.0
METHODS = {"numba Euler": (bouc_wen.euler, 1), "numba Runge-Kutta 4": (bouc_wen.runge_kutta, 4)}


def bench_bouc_wen(rust, folder, samples, turns):
    rows = []
    for n, p in LAWS.items():
        for per_period in (20, 100, 1000):
            k = np.arange(samples)
            # Amplitude changes from period to period, so that minor loops are among it; turns fall on
            # samples.
            amplitude = 5.0 * (0.6 + 0.4 * np.cos(2.0 * np.pi * (k // per_period) / 7.0))
            u = amplitude * (1.0 - np.cos(2.0 * np.pi * k / per_period))
            u.tofile(folder / "u")
            short = 14 * per_period
            truth = bouc_wen.reference(u[:short], n=n, **p)
            stroke = np.ptp(LINEAR * u[:short] - truth)

            def error(z):
                return np.abs(z[:short] - truth).max() / stroke

            ours, euler, closed = Clock(), Clock(), Clock()
            z = np.empty_like(u)
            arguments = (p["alpha"], p["beta"], p["gamma"])
            request = {"input": str(folder / "u"), "output": str(folder / "v"), "linear": LINEAR, "n": n, **p}
            bouc_wen.euler(u[:10], *arguments, n, 1, z[:10])
            bouc_wen.exact_linear(u[:10], *arguments, z[:10])
            for _ in range(turns):
                allocations = ours.take(rust.ask("bouc_wen", repetitions=2, **request))
                euler.run(lambda: bouc_wen.euler(u, *arguments, n, 1, z), 2)
                if n == 1.0:
                    closed.run(lambda: bouc_wen.exact_linear(u, *arguments, z), 2)
            row = {"n": n, "samples_per_period": per_period, "allocations": allocations}
            row["hysteron"] = {"ns_per_sample": 1e9 * min(ours.seconds) / samples}
            row["hysteron"]["error"] = error(LINEAR * u - np.fromfile(folder / "v"))
            check(f"Bouc-Wen n = {n}", row["hysteron"]["error"], 1e-9)
            if n == 1.0:
                bouc_wen.exact_linear(u, *arguments, z)
                row["numba closed form"] = {
                    "ns_per_sample": 1e9 * min(closed.seconds) / samples, "error": error(z)
                }
            bouc_wen.euler(u, *arguments, n, 1, z)
            row["numba Euler"] = {"ns_per_sample": 1e9 * min(euler.seconds) / samples, "error": error(z)}
            for name, (method, order) in METHODS.items():
                for digits in (3, 6):
                    row[f"{name} to 1e-{digits}"] = to_accuracy(
                        method, order, u, arguments, n, short, error, digits
                    )
            rows.append(row)
    return rows


def to_accuracy(method, order, u, arguments, n, short, error, digits):
    """Fewest sub-steps that bring the error below 10^-digits of the stroke, and what a sample then costs."""
    goal = 10.0**-digits
    z = np.empty(short)

    def reached(substeps):
        method(u[:short], *arguments, n, substeps, z)
        return error(z) <= goal

    high = 1
    while not reached(high):
        high *= 2
        if high > 2**16:
            return {"substeps": None, "ns_per_sample": None}
    low = high // 2
    while high - low > max(1, high // 50):
        middle = (low + high) // 2
        low, high = (low, middle) if reached(middle) else (middle, high)
    # Runs of a few milliseconds, so that the best of them is not interrupted by other programs.
    clock = Clock()
    u = u[: max(200, min(len(u), 400_000 // high))]
    z = np.empty(len(u))
    clock.run(lambda: method(u, *arguments, n, high, z), 40)
    return {"substeps": high, "ns_per_sample": 1e9 * min(clock.seconds) / len(u)}


def bench_identification(rust, folder, generations, turns):
    rust.ask("campaign", directory=str(folder), seed=1)
    ask = {"directory": str(folder), "generations": generations, "seed": 1}

    def identify(algorithm, threads):
        runs = []
        for _ in range(turns):
            before = rust.cpu_s()
            answer = rust.ask("identify", algorithm=algorithm, threads=threads, **ask)
            answer["cpu_s"] = rust.cpu_s() - before
            runs.append(answer)
        best = min(runs, key=lambda run: run["cpu_s"])
        best["seconds"] = min(run["seconds"] for run in runs)
        return best

    result = {"generations": generations}
    result["hysteron de-abc, 1 thread"] = one = identify("de-abc", 1)
    result["hysteron de-abc, 2 threads"] = two = identify("de-abc", 2)
    if one["parameters"] != two["parameters"]:
        sys.exit("error: one and two threads identified different parameters")
    result["hysteron auto, 2 threads"] = identify("auto", 2)

    records = {name: np.fromfile(folder / name) for name in ("loop_u", "loop_y", "sweep_u", "sweep_y")}
    boxes = one["boxes"]
    static = identification.Static(records["loop_u"], records["loop_y"], boxes[0])
    static.cost(np.full(5, 0.5))
    start = time.process_time()
    found = identification.search(static, generations, 1)
    p = dict(zip(static.names, identification.from_unit(boxes[0], found.x)))
    z = np.empty_like(records["sweep_u"])
    bouc_wen.exact_linear(records["sweep_u"], p["alpha"], p["beta"], p["gamma"], z)
    v = p["linear"] * records["sweep_u"] + p["quadratic"] * records["sweep_u"] ** 2 - z
    dynamic = identification.Dynamic(v, records["sweep_y"], boxes[1])
    half = time.process_time()
    found2 = identification.search(dynamic, generations, 1)
    end = time.process_time()
    result["scipy"] = {
        "cpu_s": end - start, "static_s": half - start, "dynamic_s": end - half,
        "evaluations": [int(found.nfev), int(found2.nfev)], "cost": [float(found.fun), float(found2.fun)],
    }
    return result


def machine():
    model = re.search(r"model name\s*:\s*(.*)", pathlib.Path("/proc/cpuinfo").read_text())
    return {
        "processor": model.group(1) if model else platform.processor(),
        "cores": os.cpu_count(),
        "python": platform.python_version(),
        "numpy": np.__version__, "scipy": scipy.__version__, "numba": numba.__version__,
    }


def print_rich_families(quick):
    """The section alone; of the Rust side it needs the command line only."""
    before = os.getloadavg()[0]
    with tempfile.TemporaryDirectory() as folder:
        result = rich_families.bench(pathlib.Path(folder), quick)
    print(tables.rich_families_heading(result), tables.rich_families(result), sep="\n\n")
    print(f"\nLoad average {before:.1f} before and {os.getloadavg()[0]:.1f} after the run.")


def print_joint_fits(quick):
    """The two sections of joint fits alone."""
    rust, before = RustSide(), os.getloadavg()[0]
    for short in (False, True):
        with tempfile.TemporaryDirectory() as folder:
            result = joint.bench(rust, pathlib.Path(folder), quick, short)
        print(tables.joint_heading(result), tables.joint(result), sep="\n\n", end="\n\n")
    print(f"Load average {before:.1f} before and {os.getloadavg()[0]:.1f} after the run.")


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument(
        "--quick", action="store_true", help="small sizes, few repetitions, nothing written to docs"
    )
    arguments.add_argument(
        "--rich-families", action="store_true", help="that section alone: printed, written nowhere"
    )
    arguments.add_argument(
        "--joint-fits", action="store_true", help="these sections alone: printed, written nowhere"
    )
    asked = arguments.parse_args()
    quick = asked.quick
    if asked.rich_families:
        print_rich_families(quick)
        return
    if asked.joint_fits:
        print_joint_fits(quick)
        return

    def say(what):
        print(f"{what} …", file=sys.stderr, flush=True)

    rust = RustSide()
    result = {"machine": machine(), "load_before": os.getloadavg()[0], "quick": quick}
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        say("Eq. 13, 100 000 samples")
        size = 10_000 if quick else 100_000
        result["fractional"] = bench_fractional(rust, folder, size, 5 if quick else 60, True, True)
        say("Eq. 13, a thousand to ten million samples")
        sizes = [1_000, 10_000] if quick else [10**k for k in range(3, 8)]
        result["scaling"] = scaling(rust, folder, sizes)
        say("columns of a fit and their derivatives")
        result["columns"] = [
            {"scheme": scheme, "samples": size}
            | rust.ask("columns", samples=size, repetitions=5 if quick else 60, scheme=scheme)
            for scheme in ("tustin", "band-limited")
        ]
        say("Bouc-Wen operator")
        result["bouc_wen"] = bench_bouc_wen(rust, folder, 20_000, 3 if quick else 40)
        say("joint fit, from CSV files to a model file")
        (folder / "joint").mkdir()
        result["joint"] = joint.bench(rust, folder / "joint", quick)
        say("joint fit of short records")
        (folder / "short").mkdir()
        result["joint_short"] = joint.bench(rust, folder / "short", quick, short=True)
        say("plays, from CSV files to a model file")
        (folder / "rich").mkdir()
        result["rich_families"] = rich_families.bench(folder / "rich", quick)
        say("joint fit, a thousand to ten million samples")
        result["joint_scaling"] = joint.scaling(rust, quick)
        say("identification")
        result["identification"] = bench_identification(rust, folder, 5 if quick else 150, 1 if quick else 2)
    result["load_after"] = os.getloadavg()[0]
    text = tables.markdown(result)
    print(text)
    here = ROOT / ("target" if quick else "bench")
    (here / "results.json").write_text(json.dumps(result, indent=1) + "\n")
    (here / "results.md").write_text(text)
    if not quick:
        tables.write_into(ROOT / "docs" / "benchmarks.md", text)


if __name__ == "__main__":
    main()
