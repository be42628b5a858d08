#!/usr/bin/env python3
"""Changes the source in one place at a time and runs the tests of its crate: do they notice?

    scripts/mutants.py              the sample below, one after the other, those with a result left out
    scripts/mutants.py --most 20    no more than so many of them now
    scripts/mutants.py hysteron-rt  those of this crate
    scripts/mutants.py --nice 19 --jobs 1    in the background of other work
    scripts/mutants.py --sample     prints the sample
    scripts/mutants.py --table      prints the table of docs/trust.md
    scripts/mutants.py --missed     prints what no test noticed

The changes are those of cargo-mutants (`make mutants` installs it), drawn by SEED from the rooms below; what else
changes in a file draws no others. The commit that is checked out is taken, in a clone of its own, and must pass
unchanged first. The unit tests of the changed module run first, then all of them, then `tests/`, up to the first that
fails. Results are kept a line each in scripts/mutants.tsv: `caught`, `missed`, `timeout` (noticed too), `unviable`
(refused by the compiler).
"""

import argparse
import collections
import hashlib
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
WORK = ROOT / "target/mutants"
TREE, BUILD = WORK / "tree", WORK / "build"
TOOLS = ROOT / "target/tools"
KEPT = ROOT / "scripts/mutants.tsv"
SEED, SAMPLE = "1", 150
# Where the arithmetic is that everything else rests on.
ROOMS = {
    "crates/hysteron-rt/src": "hysteron-rt",
    "crates/hysteron-model/src/fractional": "hysteron-model, fractional",
    "crates/hysteron-model/src/dynamics": "hysteron-model, dynamics",
    "crates/hysteron-model/src/validate": "hysteron-model, validate",
    "crates/hysteron-optimize/src": "hysteron-optimize",
}
# Longest build, and longest run of the tests unchanged [s]; changed they may take so many times as long, and a minute.
MOST_S, SLOWER = 1800, 4


def tool(*arguments: str) -> str:
    command = [TOOLS / "bin/cargo-mutants", "mutants", *arguments]
    done = subprocess.run(command, cwd=TREE, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"error: cargo-mutants: {done.stderr.strip()}")
    return done.stdout


def git(*arguments: str, where: Path = TREE) -> str:
    command = ["git", "-C", where, *arguments]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()


def tree() -> None:
    """The clone, at the commit that is checked out."""
    commit = git("rev-parse", "HEAD", where=ROOT)
    if not TREE.exists():
        WORK.mkdir(parents=True, exist_ok=True)
        git("clone", "--quiet", "--shared", "--no-checkout", str(ROOT), str(TREE), where=ROOT)
    git("checkout", "--quiet", "--force", "--detach", commit)
    clean()


def clean() -> None:
    """As committed: without the change, and without the cases that property tests keep of a failure."""
    git("checkout", "--quiet", "--force", ".")
    git("clean", "--quiet", "-d", "--force")


def sample() -> dict[str, dict]:
    """Changes by name, without the lines that they are at."""
    files = [part for room in ROOMS for part in ("--file", f"{room}/**")]
    found: dict[str, dict] = {}
    again: collections.Counter[str] = collections.Counter()
    for mutant in json.loads(tool("--list", "--json", "--diff", *files)):
        function = (mutant.get("function") or {}).get("function_name", "")
        what = mutant["name"].split(": ", 1)[-1]
        what = what if function in what else f"{what} in {function}"
        name = f"{mutant['file']}: {what}"
        again[name] += 1
        name += f" ({again[name]})" if again[name] > 1 else ""
        found[name] = mutant
    drawn = sorted(found, key=lambda name: hashlib.sha256(f"{SEED} {name}".encode()).digest())[:SAMPLE]
    # By crate: its dependents are not built anew in between.
    return {name: found[name] for name in sorted(drawn)}


def results() -> dict[str, str]:
    """Result of a change, by name."""
    lines = KEPT.read_text(encoding="utf-8").splitlines() if KEPT.exists() else []
    return {name: result for result, _, name in (line.split("\t") for line in lines)}


def room_of(name: str) -> str:
    return next(room for folder, room in ROOMS.items() if name.startswith(f"{folder}/"))


def table() -> str:
    rows = ["| room | changes | refused by the compiler | noticed | not noticed |"]
    rows.append("| --- | --: | --: | --: | --: |")
    known = results()
    for room in [*ROOMS.values(), "in all"]:
        count = collections.Counter(r for name, r in known.items() if room in ("in all", room_of(name)))
        numbers = [count.total(), count["unviable"], count["caught"] + count["timeout"], count["missed"]]
        rows.append(f"| {room} | {' | '.join(map(str, numbers))} |")
    return "\n".join(rows)


def cargo(jobs: int, most_s: float, *arguments: str) -> str:
    """`passed`, `failed` or `timeout`, the end of what was said in target/mutants/said.log."""
    environment = {
        **os.environ,
        "CARGO_TARGET_DIR": str(BUILD),
        "CARGO_BUILD_JOBS": str(jobs),
        "RUST_TEST_THREADS": str(jobs),
        # One place changes: little is compiled anew, and less is linked.
        "CARGO_INCREMENTAL": "1",
        "CARGO_PROFILE_DEV_DEBUG": "0",
    }
    log = WORK / "said.log"
    with open(log, "wb") as said:
        process = subprocess.Popen(
            ["cargo", "test", "--locked", *arguments],
            cwd=TREE, env=environment, stdout=said, stderr=said, start_new_session=True,
        )  # fmt: skip
    end = time.monotonic() + most_s
    try:
        while process.poll() is None:
            # A test that failed says enough; the others of its program would go on.
            if b"... FAILED" in log.read_bytes():
                return "failed"
            if time.monotonic() > end:
                return "timeout"
            time.sleep(0.2)
        return "failed" if process.returncode else "passed"
    finally:
        # A test that does not end outlives its cargo.
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()


def stages(package: str, file: str | None) -> list[list[str]]:
    """Arguments of `cargo test`, the soonest done first; of all tests where no file is named."""
    targets = [["--lib"]]
    if any((TREE / "crates" / package / "tests").glob("**/*.rs")):
        targets.append(["--test", "*"])
    module = Path(file).relative_to(f"crates/{package}/src").parts[0].removesuffix(".rs") if file else "lib"
    return targets if module == "lib" else [["--lib", "--", f"{module}::"], *targets]


def tested(package: str, jobs: int, file: str | None, most_s: dict[str, float]) -> str:
    """`caught`, `missed`, `timeout` or `unviable`."""
    for stage in stages(package, file):
        target = stage[: stage.index("--")] if "--" in stage else stage
        built = cargo(jobs, MOST_S, "-p", package, *target, "--no-run")
        if built == "timeout":
            sys.exit(f"error: the tests of {package} are not built within {MOST_S} s")
        if built == "failed":
            return "unviable"
        ended = cargo(jobs, most_s.get(target[0], MOST_S), "-p", package, *stage)
        if ended != "passed":
            return {"failed": "caught"}.get(ended, ended)
    return "missed"


def pass_unchanged(package: str, jobs: int) -> dict[str, float]:
    """What fails without a change would notice any; once for a commit. Longest times of the tests when changed [s]."""
    passed = WORK / f"passed-{git('rev-parse', 'HEAD')}.json"
    known = json.loads(passed.read_text(encoding="utf-8")) if passed.exists() else {}
    if package not in known:
        known[package] = {}
        for target in stages(package, None):
            if cargo(jobs, MOST_S, "-p", package, *target, "--no-run") != "passed":
                sys.exit(f"error: the tests of {package} are not built, see {WORK / 'said.log'}")
            begun = time.monotonic()
            if cargo(jobs, MOST_S, "-p", package, *target) != "passed":
                sys.exit(f"error: {package} does not pass its tests unchanged, see {WORK / 'said.log'}")
            known[package][target[0]] = 60 + SLOWER * (time.monotonic() - begun)
        passed.write_text(json.dumps(known), encoding="utf-8")
    return known[package]


def take(name: str, mutant: dict, jobs: int) -> str:
    most_s = pass_unchanged(mutant["package"], jobs)
    begun = time.monotonic()
    diff = mutant["diff"]
    command = ["patch", "--quiet", "--no-backup-if-mismatch", str(TREE / mutant["file"])]
    try:
        subprocess.run(command, input=diff, text=True, check=True)
        result = tested(mutant["package"], jobs, mutant["file"], most_s)
    finally:
        clean()
    with open(KEPT, "a", encoding="utf-8") as kept:
        kept.write(f"{result}\t{time.monotonic() - begun:.0f}\t{name}\n")
    return result


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("crates", nargs="*", help="all, if none is given")
    parser.add_argument("--most", type=int, default=SAMPLE)
    parser.add_argument("--jobs", type=int, default=len(os.sched_getaffinity(0)))
    parser.add_argument("--nice", type=int, default=0)
    parser.add_argument("--sample", action="store_true")
    parser.add_argument("--table", action="store_true")
    parser.add_argument("--missed", action="store_true")
    options = parser.parse_args()
    if options.table:
        print(table())
        return
    if options.missed:
        print("\n".join(name for name, result in sorted(results().items()) if result == "missed"))
        return
    if not (TOOLS / "bin/cargo-mutants").exists():
        sys.exit("error: cargo-mutants is not installed\n  try: make mutants")
    os.nice(options.nice)
    # Ends what it started, and takes the change back.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit("stopped"))
    tree()
    drawn = sample()
    if options.sample:
        print("\n".join(drawn))
        return
    known = results()
    wanted = options.crates or {mutant["package"] for mutant in drawn.values()}
    left = [name for name in drawn if name not in known and drawn[name]["package"] in wanted][: options.most]
    for name in left:
        print(f"{take(name, drawn[name], options.jobs)}  {name}", flush=True)
    print(table())


if __name__ == "__main__":
    main()
