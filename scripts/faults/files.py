"""Faults of files: disks, folders, pipes, devices, clocks, other writers."""

import os
import resource
import shutil
import signal
import subprocess
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from common import QUIET, Table, content, run, whole

# Commands with OUT where their output goes.
TO_FILE = [
    "identify loop.csv --degree 2 --dynamics none -o OUT.json",
    "identify loop.csv --degree 2 --dynamics none -o new.json --report OUT.html",
    "compare loop.csv sweep.csv --candidates none+degree1,none -o OUT.json",
    "recalibrate kept.json loop.csv -o OUT.json",
    "adapt kept.json loop.csv -o OUT.json",
    "inspect loop.csv --plot OUT.svg",
    "prepare loop.csv -o OUT.csv",
    "prepare loop.csv -o OUT.npz",
    "prepare loop.csv -o OUT.mat",
    "simulate kept.json loop.csv -o OUT.csv",
    "validate kept.json loop.csv -o OUT.csv",
    "validate kept.json loop.csv --report OUT.html",
    "invert kept.json reference.csv -o OUT.csv --range 0:10",
    "track kept.json reference.csv --plant model --controller feedforward -o OUT.csv",
    "excite sine --frequency 1 --sample-rate 5000 --high 10 -o OUT.csv",
]
TO_FOLDER = [
    "export kept.json --to c --sample-rate 1000 --out-dir OUT",
    "export kept.json --to rust --sample-rate 1000 --out-dir OUT",
    "export kept.json --to matlab --sample-rate 1000 --out-dir OUT",
    "rig --plan plan.json --out-dir OUT",
    "identify loop.csv --degree 2 --dynamics none -o new.json --figures OUT",
]
TO_OUTPUT = [
    "inspect loop.csv",
    "validate kept.json loop.csv --json",
    "realise kept.json --sample-rate 1000",
    "schema",
    "completions bash",
    "export --help",
    "identify loop.csv --degree 2 --dynamics none -o new.json",
    "rig --plan plan.json --out-dir new",
]
INPUTS = ["loop.csv", "sweep.csv", "kept.json", "reference.csv", "plan.json"]


class Place:
    """A folder of inputs, and the command."""

    def __init__(self, folder: Path, program: str) -> None:
        self.folder, self.program = folder, program
        loop = (folder / "loop.csv").read_text().splitlines()
        reference = [",".join((line.split(",")[0], line.split(",")[2])) for line in loop]
        (folder / "reference.csv").write_text("\n".join(reference) + "\n")
        (folder / "plan.json").write_text(
            '{"sample_rate_hz": 1000, "loop_hz": 5, "loop_periods": 2, "sweep_s": 0.5, "sweep_start_hz": 5, '
            '"sweep_end_hz": 50, "validation_hz": []}'
        )

    def fill(self, place: Path) -> Path:
        """The inputs, copied to a new folder."""
        shutil.rmtree(place, ignore_errors=True)
        place.mkdir()
        for name in INPUTS:
            shutil.copy(self.folder / name, place)
        return place

    def ends(self, line: str, place: Path, seconds: float = 60) -> tuple[int, str]:
        """Exit code and what is said; no panic, no word of temporary files."""
        done = subprocess.run(
            [self.program, *line.split()], cwd=place, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE, timeout=seconds,
        )  # fmt: skip
        said = done.stderr.decode(errors="replace")
        plain(line, done.returncode, said)
        return done.returncode, said

    def refused(self, line: str, place: Path, seen: Path) -> None:
        """Exit code 1 and a message; everything in the folder `seen` is as it was."""
        before = everything(seen)
        code, said = self.ends(line, place)
        if code != 1 or "error: " not in said:
            raise AssertionError(f"{line}: exit {code}: {said[-300:]}")
        after = everything(seen)
        if after != before:
            changed = {name for name in before.keys() | after.keys() if before.get(name) != after.get(name)}
            raise AssertionError(f"{line}: changed, though refused: {sorted(changed)}")


def plain(line: str, code: int, said: str) -> None:
    if "panicked" in said or ".tmp" in said or code < 0 or code == 101:
        raise AssertionError(f"{line}: exit {code}: {said[-400:]}")


def everything(folder: Path) -> dict[str, bytes]:
    """The files in a folder, but for the state of a search: that it stays is meant."""
    files = (path for path in folder.rglob("*") if path.is_file() and path.name != "filling")
    files = (path for path in files if not path.name.endswith(".searches.json"))
    return {str(path.relative_to(folder)): path.read_bytes() for path in files}


@contextmanager
def mounted(folder: Path, size_kb: int) -> Iterator[bool]:
    """A small disk at `folder`, where this user may mount one."""
    folder.mkdir(exist_ok=True)
    mount = ["mount", "-t", "tmpfs", "-o", f"size={size_kb}k", "tmpfs", str(folder)]
    done = subprocess.run(mount, **QUIET).returncode == 0
    try:
        yield done
    finally:
        if done:
            subprocess.run(["umount", str(folder)], check=True)


def disk_full(place: Place) -> str:
    """Every output on a disk with 8, 0 kB of room, an older version there or not."""
    folder, tried = place.folder / "full", 0
    with mounted(folder, 600) as is_mounted:
        if not is_mounted:
            return limited(place)
        for old in (False, True):
            for line in TO_FILE + TO_FOLDER:
                for path in folder.iterdir():
                    shutil.rmtree(path) if path.is_dir() else path.unlink()
                work = place.fill(place.folder / "work")
                out = folder / "out"
                if old and line in TO_FILE:
                    Path(str(out) + suffix(line)).write_bytes(b"older")
                with (folder / "filling").open("wb", buffering=0) as filling:
                    try:
                        while True:
                            filling.write(b"0" * 4096)
                    except OSError:
                        pass
                with_new = line.replace("new.json", str(folder / "new.json"))
                place.refused(with_new.replace("OUT", str(out)), work, folder)
                tried += 1
    return f"{tried} commands, on a tmpfs without room (ENOSPC)"


def suffix(line: str) -> str:
    return next(word for word in line.split() if word.startswith("OUT")).removeprefix("OUT")


def limited(place: Place) -> str:
    """As on a full disk, by a limit on the size of files."""

    def small() -> None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (512, 512))

    for line in TO_FILE + TO_FOLDER:
        work = place.fill(place.folder / "work")
        before = everything(work)
        done = subprocess.run(
            [place.program, *line.replace("OUT", "out").split()], cwd=work, stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, preexec_fn=small, timeout=60,
        )  # fmt: skip
        said = done.stderr.decode(errors="replace")
        plain(line, done.returncode, said)
        if done.returncode != 1 or everything(work) != before:
            raise AssertionError(
                f"{line}: exit {done.returncode}, files {sorted(everything(work))}: {said[-300:]}"
            )
    return f"{len(TO_FILE + TO_FOLDER)} commands, with files of at most 512 bytes (EFBIG)"


def read_only(place: Place) -> str:
    """Every output in a folder that nobody may write to."""
    folder = place.folder / "readonly"
    with mounted(folder, 100) as is_mounted:
        if is_mounted:
            subprocess.run(["mount", "-o", "remount,ro", str(folder)], check=True)
        else:
            folder.chmod(0o500)
        for line in TO_FILE + TO_FOLDER:
            work = place.fill(place.folder / "work")
            place.refused(line.replace("OUT", str(folder / "out")), work, work)
        if not is_mounted:
            folder.chmod(0o700)
    return f"{len(TO_FILE + TO_FOLDER)} commands"


def no_parent(place: Place) -> str:
    """Every output file in a folder that is not there."""
    for line in TO_FILE:
        work = place.fill(place.folder / "work")
        place.refused(line.replace("OUT", "no/such/out"), work, work)
    return f"{len(TO_FILE)} commands"


def device_full(place: Place) -> str:
    """`/dev/full` as the output, and as standard output."""
    for line in TO_FILE:
        work = place.fill(place.folder / "work")
        if suffix(line) in (".json", ".html", ".csv"):
            place.refused(line.replace("OUT" + suffix(line), "/dev/full"), work, work)
    for line in TO_OUTPUT:
        prints = run([place.program, *line.split()], place.fill(place.folder / "work")) != ""
        work = place.fill(place.folder / "work")
        with open("/dev/full", "wb") as full:
            done = subprocess.run(
                [place.program, *line.split()], cwd=work, stdout=full, stderr=subprocess.PIPE, timeout=60
            )
        said = done.stderr.decode(errors="replace")
        plain(line, done.returncode, said)
        if done.returncode == 0 and prints:
            raise AssertionError(f"{line}: exit 0 though nothing could be printed")
    return f"{len(TO_FILE + TO_OUTPUT)} commands"


def closed_pipe(place: Place) -> str:
    """Standard output, or both, closed by who reads them (`| head -0`)."""
    for line in TO_OUTPUT:
        for both in (False, True):
            work = place.fill(place.folder / "work")
            reading, writing = os.pipe()
            os.close(reading)
            process = subprocess.Popen(
                [place.program, *line.split()], cwd=work, stdin=subprocess.DEVNULL, stdout=writing,
                stderr=writing if both else subprocess.PIPE,
            )  # fmt: skip
            os.close(writing)
            said = process.communicate(timeout=60)[1] or b""
            plain(line, process.returncode, said.decode(errors="replace"))
    return f"{len(TO_OUTPUT)} commands, standard error too"


def fifo(place: Place) -> str:
    """A FIFO as the input and as the output: it works, or is refused with a message."""
    works = 0
    for line in [
        "inspect FIFO",
        "validate kept.json FIFO",
        "prepare FIFO -o out.csv",
        "validate FIFO loop.csv",
    ]:
        work = place.fill(place.folder / "work")
        pipe = work / "fifo.csv"
        os.mkfifo(pipe)
        source = "kept.json" if line.startswith("validate FIFO") else "loop.csv"
        feeding = threading.Thread(target=feed, args=(pipe, (work / source).read_bytes()), daemon=True)
        feeding.start()
        code, said = place.ends(line.replace("FIFO", "fifo.csv"), work, 20)
        works += code == 0
        if code not in (0, 1) or (code == 1 and "error: " not in said):
            raise AssertionError(f"{line}: exit {code}: {said[-300:]}")
        let_go(pipe, feeding)
    for line in TO_FILE:
        if suffix(line) not in (".json", ".csv"):
            continue
        work = place.fill(place.folder / "work")
        pipe = work / ("out" + suffix(line))
        run([place.program, *line.replace("OUT", "straight").split()], work)
        os.mkfifo(pipe)
        found: list[bytes] = []
        reading = threading.Thread(target=drain, args=(pipe, found), daemon=True)
        reading.start()
        code, said = place.ends(line.replace("OUT", "out"), work, 30)
        if not pipe.is_fifo():
            raise AssertionError(f"{line}: the FIFO was replaced")
        if code == 0:
            reading.join(10)
            written = (work / f"straight{suffix(line)}").read_bytes()
            if not found or not same(suffix(line), found[0], written):
                raise AssertionError(f"{line}: the FIFO carries something else than the file")
            works += 1
        elif "error: " not in said:
            raise AssertionError(f"{line}: exit {code}: {said[-300:]}")
        else:
            let_go(pipe, None)
            reading.join(10)
    return f"4 inputs, {sum(suffix(line) in ('.json', '.csv') for line in TO_FILE)} outputs; {works} work"


def feed(pipe: Path, text: bytes) -> None:
    with suppress(BrokenPipeError):
        pipe.write_bytes(text)


def drain(pipe: Path, found: list[bytes]) -> None:
    found.append(pipe.read_bytes())


def let_go(pipe: Path, feeding: threading.Thread | None) -> None:
    """Ends a thread that waits for the other end of the pipe."""
    if feeding is None:
        os.close(os.open(pipe, os.O_RDWR | os.O_NONBLOCK))
        return
    while feeding.is_alive():
        reading = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
        time.sleep(0.01)
        os.close(reading)


def same(kind: str, left: bytes, right: bytes) -> bool:
    return whole("m.json", left) == whole("m.json", right) if kind == ".json" else left == right


def two_writers(place: Place) -> str:
    """Two commands write one file at once: it is that of the one or of the other."""
    waves = [f"excite sine --frequency {f} --sample-rate 20000 --high 10 -o OUT" for f in (1, 2)]
    exports = [
        f"export kept.json --to c --sample-rate {f} --name m --date 2026-01-01 --out-dir OUT"
        for f in (1000, 2000)
    ]
    for pair in (waves, exports):
        work = place.fill(place.folder / "work")
        expected: list[dict[str, bytes]] = []
        for number, line in enumerate(pair):
            run([place.program, *line.replace("OUT", f"out{number}").split()], work)
            files = content(work, [f"out{number}"])
            expected.append({name.replace(f"out{number}", "out"): text for name, text in files.items()})
        for _ in range(20):
            both = [
                subprocess.Popen([place.program, *line.replace("OUT", "out").split()], cwd=work, **QUIET)
                for line in pair
            ]
            codes = [process.wait(60) for process in both]
            found = content(work, ["out"])
            if codes.count(0) == 0:
                raise AssertionError(f"neither of two writers: {codes}")
            for name in expected[0]:
                if found.get(name) not in (expected[0][name], expected[1][name]):
                    raise AssertionError(f"{name} is neither the one writer's nor the other's")
            if any(".tmp" in str(path) for path in work.rglob("*")):
                raise AssertionError("temporary files stay")
    return "20 pairs of drives, 20 of exports"


def future(place: Place) -> str:
    """The clock was set back: every file is of the year 2100."""
    for line in TO_FILE:
        work = place.fill(place.folder / "work")
        run([place.program, *line.replace("OUT", "straight").split()], work)
        for name in [*INPUTS, f"straight{suffix(line)}"]:
            os.utime(work / name, (4102444800, 4102444800))
        run([place.program, *line.replace("OUT", "out").split()], work)
        run([place.program, *line.replace("OUT", "straight").split()], work)
        for name in ("out", "straight"):
            found, again = ((work / f"{n}{suffix(line)}").read_bytes() for n in ("out", name))
            if suffix(line) in (".json", ".csv") and not same(suffix(line), found, again):
                raise AssertionError(f"{line}: another result")
    return f"{len(TO_FILE)} commands, inputs and older outputs of the year 2100"


FAULTS: list[tuple[str, str, Callable[[Place], str]]] = [
    ("disk full", "files and folders", disk_full),
    ("file size limited", "files and folders", limited),
    ("read-only folder", "files and folders", read_only),
    ("no parent", "files", no_parent),
    ("/dev/full", "files, standard output", device_full),
    ("closed pipe", "standard output", closed_pipe),
    ("FIFO", "inputs and outputs", fifo),
    ("two writers", "a file, a folder", two_writers),
    ("clock set back", "files", future),
]


def all_of_them(folder: Path, program: str, table: Table) -> None:
    """Tries every one."""
    place = Place(folder, program)
    for fault, of, attempt in FAULTS:
        tried, failed = "", ""
        try:
            tried = attempt(place)
        except (AssertionError, subprocess.TimeoutExpired, OSError) as e:
            failed = str(e)
        table.row(fault, of, tried, failed)
