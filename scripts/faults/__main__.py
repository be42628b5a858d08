"""Breaks the command at random instants and in every other way that a machine knows; nothing may be lost.

    python3 scripts/faults target/debug/hysteron                      500 kills, then every other fault
    python3 scripts/faults target/debug/hysteron --kills 12           a rehearsal
    python3 scripts/faults … --fleet target/python/bin/python         the fleet too, with that package
    python3 scripts/faults … --seed 7 --only export                   one kind again, with the same instants

After a kill (SIGKILL) every file is whole, as it was or as it is to be; the same command, resumed where it
left something to resume from, ends with the bytes of a run that nobody killed. Exits with 1 where that is not
so.
"""

import argparse
import json
import os
import random
import shutil
import signal
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import files
from app import AppKills
from common import Job, Table, content, record, run, started, whole
from fleet import FleetKills

FORMS = ("c", "rust", "matlab", "simulink")
SEARCH = "--degree 2 --optimizer de --population 8 --seed 3 --threads 1"


def jobs(program: str) -> list[Job]:
    """What is killed, with the files that it makes and the share of the kills."""
    short = f"identify loop.csv {SEARCH} --generations 150 -o m.json --report r.html"
    # Long enough to keep its state on the way.
    long = f"identify loop.csv {SEARCH} --generations 12000 -o m.json"
    compare = "compare loop.csv sweep.csv --candidates none+degree1,none,integer1 -o m.json"
    export = "export kept.json --out-dir code --sample-rate 1000 --date 2026-01-01"
    exports = [Job(program, f"{export} --to {form}", ["code"], 3) for form in FORMS]
    inverse = Job(program, f"{export} --to c --inverse --range 0:10", ["code"], 3)
    return [
        Job(program, short, ["m.json", "r.html"], 10),
        Job(program, long, ["m.json"], 3),
        Job(program, compare, ["m.json"], 7),
        *exports,
        inverse,
    ]


class Kills:
    """Kills of one command."""

    def __init__(self, folder: Path, job: Job) -> None:
        self.job, self.name, self.share = job, job.name, job.share
        self.folder, self.count, self.resumed, self.changed = folder, 0, 0, 0
        straight = self.prepared("straight", old=False)
        begun = time.monotonic()
        run(job.arguments(), straight)
        self.took = time.monotonic() - begun
        self.expected = content(straight, job.outputs)
        # What an older version of the outputs holds.
        self.old = {name: b"\x00older" if name.endswith((".json", ".html")) else text
                    for name, text in self.expected.items()}  # fmt: skip

    def prepared(self, name: str, old: bool) -> Path:
        """A folder with the inputs, and what an earlier command left in the place of the outputs."""
        place = self.folder / name
        shutil.rmtree(place, ignore_errors=True)
        place.mkdir()
        for source in ("loop.csv", "sweep.csv", "kept.json"):
            shutil.copy(self.folder / source, place)
        if old:
            for name, text in self.old.items():
                path = place / name
                path.parent.mkdir(parents=True, exist_ok=True)
                # Its mark, without which the command does not replace it, and something else behind it.
                path.write_bytes(text if text.startswith(b"\x00") else text + b"\n")
        return place

    def kill(self, rng: random.Random) -> None:
        """Kill it once, look, go on."""
        old = rng.random() < 0.5
        place = self.prepared("killed", old)
        process = started(self.job.arguments(), place)
        time.sleep(rng.uniform(0, 1.1) * self.took)
        process.kill()
        process.wait()
        self.count += 1
        before = {
            name: (text if text.startswith(b"\x00") else text + b"\n") for name, text in self.old.items()
        }
        self.look(place, before if old else {})
        kept = place / "m.searches.json"
        more = []
        if kept.exists():
            json.loads(kept.read_bytes())
            more = ["--resume", "m.searches.json"]
            self.resumed += 1
        run([*self.job.arguments(), *more], place)
        found = content(place, self.job.outputs)
        for name, text in self.expected.items():
            if whole(name, found.get(name)) != whole(name, text):
                raise AssertionError(f"{name} differs from the one of a run that was not killed, in {place}")

    def look(self, place: Path, before: dict[str, bytes]) -> None:
        """Every file is whole, as it was or as it is to be."""
        for source in ("loop.csv", "sweep.csv", "kept.json"):
            if (place / source).read_bytes() != (self.folder / source).read_bytes():
                raise AssertionError(f"{source} has changed, in {place}")
        found = content(place, self.job.outputs)
        for name, old in before.items():
            if name not in found:
                raise AssertionError(f"{name} is lost, in {place}")
            if found[name] == old:
                continue
            self.is_new(name, found[name], place)
        if not before and found:
            for name, text in found.items():
                self.is_new(name, text, place)
            missing = set(self.expected) - set(found)
            if missing and "code" in self.job.outputs:
                raise AssertionError(f"the new folder lacks {missing}, in {place}")
        self.changed += any(found.get(name) != old for name, old in before.items()) or (
            not before and bool(found)
        )

    def is_new(self, name: str, text: bytes, place: Path) -> None:
        if whole(name, text) != whole(name, self.expected[name]):
            raise AssertionError(f"{name} is torn, in {place}")


def killed(kinds: list[Any], count: int, rng: random.Random, table: Table) -> None:
    """All kills, divided by the shares."""
    shares = sum(kind.share for kind in kinds)
    left, left_shares = count, shares
    for kind in kinds:
        own = round(left * kind.share / left_shares)
        left, left_shares = left - own, left_shares - kind.share
        begun, failed = time.monotonic(), ""
        try:
            while kind.count < own:
                kind.kill(rng)
        except Exception as e:  # noqa: BLE001  (one kind that fails does not hide the others)
            failed = f"{type(e).__name__}: {e}"
        told = f"{kind.count} kills, {kind.changed} after the new files stood, {kind.resumed} resumed"
        table.row("kill", kind.name, f"{told}, {time.monotonic() - begun:.0f} s", failed)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("program", type=Path)
    parser.add_argument("--kills", type=int, default=500)
    parser.add_argument("--seed", type=int, default=int.from_bytes(os.urandom(3), "little"))
    parser.add_argument("--fleet", type=Path, help="a Python with hysteron_models")
    parser.add_argument("--only", help="commands that begin so")
    given = parser.parse_args()
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    program = str(given.program.resolve())
    print(f"seed {given.seed}", flush=True)
    rng, table = random.Random(given.seed), Table()
    folder = Path(tempfile.mkdtemp(prefix="faults-"))
    record(folder / "loop.csv", 1.0)
    record(folder / "sweep.csv", 7.0)
    run([program, *"identify loop.csv --degree 2 --dynamics none -o kept.json".split()], folder)

    def is_wanted(name: str) -> bool:
        return given.only is None or name.startswith(given.only)

    makers: list[tuple[str, Callable[[], Any]]] = [
        (job.name, lambda job=job: Kills(folder, job)) for job in jobs(program)
    ]
    makers.append(("app", lambda: AppKills(folder, program)))
    if given.fleet:
        makers.append(("fleet", lambda: FleetKills(folder, str(given.fleet.absolute()))))
    killed([make() for name, make in makers if is_wanted(name)], given.kills, rng, table)
    if given.only is None:
        files.all_of_them(folder, program, table)
    if table.failed:
        print(f"{table.failed} promises broken; the files are in {folder}")
        sys.exit(1)
    shutil.rmtree(folder)
    print("nothing was lost")


if __name__ == "__main__":
    main()
