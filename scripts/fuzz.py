#!/usr/bin/env python3
"""Runs the entries of `fuzz/` in libFuzzer, with stable Rust.

    scripts/fuzz.py                          every entry for a minute, one on each processor
    scripts/fuzz.py --jobs 1 --nice 19       one at a time, in the background of other work
    scripts/fuzz.py --executions 5000000     each until it has had so many, those of earlier runs counted
    scripts/fuzz.py --executions 5000000 --total 100000000 --seconds 600 --built
                                             a campaign: the entries in turns of ten minutes, until each has
                                             had so many, then the faster half until there are so many in all
    scripts/fuzz.py --seconds 600 csv mat    two of them
    scripts/fuzz.py --keep                   adds what found new ways to the corpus that the tests replay
    scripts/fuzz.py --table                  prints the table of docs/trust.md

Inputs that were found collect in target/fuzz/inputs, those that broke a promise in target/fuzz/findings.
Executions, seconds and coverage are added up in fuzz/executions.json. Limits of an input: 10 s, 1 GiB.
"""

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
WORK = ROOT / "target/fuzz"
FUZZERS = WORK / "fuzzers"
COUNTS = ROOT / "fuzz/executions.json"
TRIPLE = "x86_64-unknown-linux-gnu"
# Values that are compared are not traced: of an execution of `csv` that took 38 %.
FLAGS = [
    "-Cpasses=sancov-module",
    "-Cllvm-args=-sanitizer-coverage-level=4",
    "-Cllvm-args=-sanitizer-coverage-inline-8bit-counters",
    "-Cllvm-args=-sanitizer-coverage-pc-table",
    "--cfg fuzzing",
    "-Cdebug-assertions",
]
# Longest input [bytes]: some more than those of the corpus need, as what is longer takes longer. A call of a model is
# five to nine bytes.
LONGEST = {
    "app": 512, "checkpoint": 512, "csv": 1024, "drive": 512, "exported-c": 256, "gcs": 1024, "hdf5": 10_500,
    "jpk": 1600, "lvm": 1024, "mat": 2048, "model": 4096, "model-numbers": 64, "npy": 512, "npz": 1536,
    "prepare": 1024, "response": 512, "runtime": 256, "tdms": 3072, "truth-and-plan": 1024, "xlsx": 5500,
}  # fmt: skip
# Feature of hysteron-fuzz that an entry needs, where it is not the readers and the models alone.
NEEDS = {
    "app": "app", "checkpoint": "checkpoint", "drive": "bench", "exported-c": "stages", "runtime": "stages",
    "truth-and-plan": "bench",
}  # fmt: skip
# Those that wait for another process or thread stay on one processor with it: a change there is a change of task,
# on another a wake-up.
WAITING = {"app", "exported-c"}
# A kept corpus stays small.
MOST_KEPT, MOST_BYTES = 60, 120_000


def build(entry: str) -> None:
    """The fuzzer of an entry; for this target alone, so that build scripts are not instrumented."""
    environment = {**os.environ, "RUSTFLAGS": " ".join(FLAGS), "HYSTERON_FUZZ": entry}
    command = ["cargo", "build", "--locked", "--profile", "fuzz", "--target", TRIPLE, "--target-dir", WORK]
    features = ",".join(filter(None, ["libfuzzer", NEEDS.get(entry)]))
    command += ["-p", "hysteron-fuzz", "--no-default-features", "--features", features]
    subprocess.run(command, check=True, cwd=ROOT, env=environment)
    FUZZERS.mkdir(exist_ok=True)
    built = FUZZERS / f".{entry}"
    shutil.copy(WORK / TRIPLE / "fuzz/hysteron-fuzz", built)
    # Another run may be executing the one of before.
    built.replace(FUZZERS / entry)


def entries() -> list[str]:
    text = (ROOT / "fuzz/src/lib.rs").read_text(encoding="utf-8")
    return re.findall(r'Entry \{ name: "([\w-]+)"', text)


def counts() -> dict[str, dict[str, int]]:
    return json.loads(COUNTS.read_text(encoding="utf-8")) if COUNTS.exists() else {}


def table() -> str:
    """Executions, seconds and coverage of every entry, as in docs/trust.md."""
    known = counts()
    rows = ["| entry | executions | seconds | edges covered |", "| --- | --: | --: | --: |"]
    for entry in entries():
        count = known.get(entry, {"executions": 0, "seconds": 0, "coverage": 0})
        numbers = (f"{count[name]:,}".replace(",", " ") for name in ("executions", "seconds", "coverage"))
        rows.append(f"| `{entry}` | {' | '.join(numbers)} |")
    total = [sum(count[name] for count in known.values()) for name in ("executions", "seconds")]
    rows.append(f"| in all | {' | '.join(f'{number:,}'.replace(',', ' ') for number in total)} | |")
    return "\n".join(rows)


lock = threading.Lock()


def add(entry: str, executions: int, seconds: int, coverage: int) -> None:
    with lock:
        known = counts()
        old = known.get(entry, {"executions": 0, "seconds": 0, "coverage": 0})
        known[entry] = {
            "executions": old["executions"] + executions,
            "seconds": old["seconds"] + seconds,
            "coverage": max(old["coverage"], coverage),
        }
        COUNTS.write_text(json.dumps(known, indent=1, sort_keys=True) + "\n", encoding="utf-8")


def run(entry: str, seconds: int | None, executions: int | None) -> bool:
    """Whether no promise was broken."""
    if executions is not None:
        executions -= counts().get(entry, {}).get("executions", 0)
        if executions <= 0:
            return True
    inputs, findings = WORK / "inputs" / entry, WORK / "findings" / entry
    inputs.mkdir(parents=True, exist_ok=True)
    findings.mkdir(parents=True, exist_ok=True)
    command = [
        FUZZERS / entry, inputs, ROOT / "fuzz/corpus" / entry, f"-max_len={LONGEST[entry]}",
        # By the clock: in the background of other work ten seconds of a processor last minutes.
        f"-timeout={10 if os.nice(0) == 0 else 600}",
        "-rss_limit_mb=1024", f"-artifact_prefix={findings}/", "-print_final_stats=1", "-reload=0",
        # Counting how often every edge was seen takes as long as half of the entries do.
        "-entropic=0", "-reduce_inputs=0",
    ]  # fmt: skip
    command += [f"-max_total_time={seconds}"] if seconds is not None else []
    command += [f"-runs={executions}"] if executions is not None else []
    if entry in WAITING and shutil.which("taskset"):
        command = ["taskset", "-c", str(max(os.sched_getaffinity(0))), *command]
    # What an entry writes goes to memory where it can.
    memory = {"TMPDIR": "/dev/shm"} if os.access("/dev/shm", os.W_OK) else {}
    log = WORK / f"{entry}.log"
    begun = time.monotonic()
    with open(log, "wb") as errors:
        process = subprocess.Popen(
            command, cwd=ROOT, env={**os.environ, **memory}, stdout=subprocess.DEVNULL, stderr=errors
        )
        _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    said = log.read_text(encoding="utf-8", errors="replace")
    executed = int((re.findall(r"stat::number_of_executed_units:\s*(\d+)", said) or [0])[-1])
    took = round(time.monotonic() - begun)
    coverage = int((re.findall(r"cov: (\d+)", said) or [0])[-1])
    add(entry, executed, took, coverage)
    cost = 1e6 * (used.ru_utime + used.ru_stime) / max(1, executed)
    print(
        f"{entry}: {executed} executions in {took} s, {cost:.0f} µs of a processor each, {coverage} edges", flush=True
    )
    if process.returncode:
        what = re.findall(r"(?m)^(?:thread .*panicked.*\n.*|.*ERROR: libFuzzer.*)$", said)
        print(f"  BROKEN, see {log}: {' '.join(what[:2])}", flush=True)
    return process.returncode == 0


def campaign(chosen: list[str], jobs: int, seconds: int, executions: int, total: int) -> bool:
    """Turns of all that are short of `executions`, then of the faster half until there are `total` in all."""
    broken: set[str] = set()

    def turn(entry: str, upto: int | None) -> None:
        if not run(entry, seconds, upto):
            broken.add(entry)

    def done(entry: str) -> int:
        return counts().get(entry, {}).get("executions", 0)

    with ThreadPoolExecutor(max(1, jobs)) as pool:
        while short := [e for e in chosen if e not in broken and done(e) < executions]:
            list(pool.map(lambda entry: turn(entry, executions), short))
        rate = {entry: done(entry) / max(1, counts().get(entry, {}).get("seconds", 0)) for entry in chosen}
        fast = sorted(chosen, key=rate.__getitem__)[len(chosen) // 2 :]
        while sum(map(done, entries())) < total and (left := [e for e in fast if e not in broken]):
            list(pool.map(lambda entry: turn(entry, None), left))
    return not broken


def keep(entry: str) -> None:
    """The smallest inputs that together find what all found, as far as they fit."""
    kept = ROOT / "fuzz/corpus" / entry
    with tempfile.TemporaryDirectory() as name:
        merged = Path(name)
        subprocess.run(
            [FUZZERS / entry, "-merge=1", merged, kept, WORK / "inputs" / entry],
            capture_output=True, cwd=ROOT, check=True,
        )  # fmt: skip
        there = {path.read_bytes() for path in kept.iterdir()}
        room = MOST_BYTES - sum(map(len, there))
        for path in sorted(merged.iterdir(), key=lambda path: path.stat().st_size):
            size = path.stat().st_size
            if path.read_bytes() not in there and len(there) < MOST_KEPT and size <= room:
                shutil.copy(path, kept / path.name[:12])
                there.add(path.read_bytes())
                room -= size


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("entries", nargs="*", help="all, if none is given")
    parser.add_argument("--seconds", type=int)
    parser.add_argument("--executions", type=int)
    parser.add_argument("--total", type=int, help="with --executions and --seconds: a campaign")
    parser.add_argument("--jobs", type=int, default=len(os.sched_getaffinity(0)))
    parser.add_argument("--nice", type=int, default=0, help="added to the niceness of the fuzzer")
    parser.add_argument("--built", action="store_true", help="fuzzers built before, not what the source is now")
    parser.add_argument("--keep", action="store_true")
    parser.add_argument("--table", action="store_true")
    options = parser.parse_args()
    if options.table:
        print(table())
        return
    chosen = options.entries or entries()
    unknown = set(chosen) - set(entries())
    if unknown:
        sys.exit(
            f"error: no entry is called {', '.join(sorted(unknown))}\n  there are: {', '.join(entries())}"
        )
    for entry in chosen if not options.built else []:
        build(entry)
    os.nice(options.nice)
    if options.keep:
        for entry in chosen:
            keep(entry)
        return
    if options.total:
        if not (options.executions and options.seconds):
            sys.exit("error: --total goes with --executions and --seconds")
        fine = campaign(chosen, options.jobs, options.seconds, options.executions, options.total)
        sys.exit(0 if fine else 1)
    seconds = options.seconds or (None if options.executions else 60)
    with ThreadPoolExecutor(max(1, options.jobs)) as pool:
        fine = list(pool.map(lambda entry: run(entry, seconds, options.executions), chosen))
    known = counts()
    print(f"in all: {sum(count['executions'] for count in known.values())} executions")
    sys.exit(0 if all(fine) else 1)


if __name__ == "__main__":
    main()
