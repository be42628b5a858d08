"""How long a stop takes: Ctrl-C (SIGINT) at several instants of every command that computes for long.

    python3 scripts/faults/stops.py target/release/hysteron             every command, three instants or five
    python3 scripts/faults/stops.py target/release/hysteron compare     those whose line begins so

Prints the longest time from the signal to the end, and the processor time in between by thread, which other
work on the machine does not lengthen. Exits with 1 where that is above a second.
"""

import argparse
import math
import os
import random
import resource
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

FAMILIES = (
    "auto", "bouc-wen", "prandtl-ishlinskii", "parallel-bouc-wen", "non-symmetric-bouc-wen", "song-der-kiureghian",
    "dahl", "duhem", "maxwell-slip", "one-sided-plays", "rate-dependent-plays", "activated-plays", "dead-zone-plays",
    "generalised-plays", "krasnoselskii-pokrovskii", "preisach", "preisach-density", "jiles-atherton", "takacs",
)  # fmt: skip
LONGEST_S = 1.0
# Instants of the signals [s], and on the long record, which takes some seconds to be read.
INSTANTS, ON_LONG = (0.3, 1.5, 4.0), (0.5, 4.0, 10.0, 20.0, 40.0)


def lines() -> list[str]:
    fits = [f"identify loop.csv sweep.csv --hysteresis {family} -o m.json" for family in FAMILIES]
    return [
        *fits,
        "identify loop.csv sweep.csv --dynamics fractional -o m.json --report r.html",
        "identify loop.csv sweep.csv --structure oscillator -o m.json",
        "compare loop.csv sweep.csv fast.csv -o m.json --report r.html",
        "identify long.csv --least-fit 0 -o m.json",
        "identify long.csv --dynamics none --hysteresis prandtl-ishlinskii --least-fit 0 -o m.json",
        "compare long.csv -o m.json",
        "inspect long.csv",
        "validate kept.json long.csv",
        "simulate kept.json long.csv -o out.csv",
        "adapt kept.json long.csv -o m.json",
        "invert kept.json reference.csv -o out.csv",
        "track kept.json reference.csv --plant rig",
        "design loop.csv sweep.csv --for prediction --time 10s -o next.csv",
        "realise kept.json --sample-rate 100000",
        "export kept.json --to c --inverse --range 0:10 --sample-rate 20000 --out-dir code",
        "optimizers",
    ]


def record(path: Path, samples: int, rate_hz: float, phase: str) -> None:
    """A simulated device: one relaxing state ahead of a resonance at 60 Hz, noise."""
    noise, z, x, v, last = random.Random(path.name), 0.0, 0.0, 0.0, 0.0
    omega = 2 * math.pi * 60
    with open(path, "w", encoding="utf-8") as out:
        print("t_s,u_V,y_um", file=out)
        for k in range(samples):
            t = k / rate_hz
            angle = 2 * math.pi * (2 * t if phase == "loop" else 2 * t + 4 * t * t % 4000)
            u = 5 - 5 * math.cos(angle)
            z += 0.3 * (u - last) - 0.2 * abs(u - last) * z
            last = u
            for _ in range(4):
                v += (omega * omega * (1.5 * u - z - x) - 0.2 * omega * v) / (4 * rate_hz)
                x += v / (4 * rate_hz)
            print(f"{t:.6f},{u:.6f},{x + noise.gauss(0, 0.002):.6f}", file=out)


def listening() -> None:
    """A command in the background of a shell ignores SIGINT; one of a terminal does not."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def stopped(program: str, line: str, after_s: float, place: Path) -> tuple[float, float] | None:
    """Seconds from the signal to the end, and of a processor; `None` where the command had ended before."""
    quiet = subprocess.DEVNULL
    process = subprocess.Popen(
        [program, *line.split()], cwd=place, stdin=quiet, stdout=quiet, stderr=quiet, preexec_fn=listening
    )
    time.sleep(after_s)
    if process.poll() is not None:
        return None
    ticks = Path(f"/proc/{process.pid}/stat").read_text().rsplit(")", 1)[1].split()[11:13]
    used = sum(map(int, ticks)) / os.sysconf("SC_CLK_TCK")
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    begun = time.monotonic()
    process.send_signal(signal.SIGINT)
    process.wait()
    took = time.monotonic() - begun
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    whole = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return took, max(0.0, whole - used) / len(os.sched_getaffinity(0))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("beginning", nargs="?", default="")
    parser.add_argument("--samples", type=int, default=5_000_000, help="of the long record")
    parser.add_argument("--fitted", type=int, default=4000, help="samples of the records that are fitted")
    options = parser.parse_args()
    program = str(Path(options.program).resolve())
    slow = 0
    with tempfile.TemporaryDirectory() as name:
        place = Path(name)
        for record_name, samples, rate_hz, phase in [
            ("loop.csv", options.fitted, 1000.0, "loop"),
            ("sweep.csv", options.fitted, 1000.0, "sweep"),
            ("fast.csv", options.fitted, 1000.0, "fast"),
            ("reference.csv", 20_000, 1000.0, "loop"),
        ]:
            record(place / record_name, samples, rate_hz, phase)
        made = "identify loop.csv sweep.csv --dynamics integer --least-fit 0 -o kept.json"
        subprocess.run([program, *made.split()], cwd=place, check=True, capture_output=True)
        # As many samples as asked, of loop and sweep again and again: of a loop alone nothing can be compared.
        body = [row for name in ("loop", "sweep") for row in (place / f"{name}.csv").read_text().splitlines()[1:]]
        if any(" long.csv" in line and line.startswith(options.beginning) for line in lines()):
            with open(place / "long.csv", "w", encoding="utf-8") as out:
                print("t_s,u_V,y_um", file=out)
                for k in range(options.samples):
                    print(f"{k / 1000:.3f},{body[k % len(body)].split(',', 1)[1]}", file=out)
        print("| command | stops | longest [s] | of a processor, by thread [s] |\n| --- | --: | --: | --: |")
        for line in filter(lambda line: line.startswith(options.beginning), lines()):
            instants = ON_LONG if " long.csv" in line else INSTANTS
            found = [stopped(program, line, after, place) for after in instants]
            times = [both for both in found if both is not None]
            longest = max((took for took, _ in times), default=0.0)
            used = max((used for _, used in times), default=0.0)
            slow += used > LONGEST_S
            mark = " **slow**" if used > LONGEST_S else ""
            print(f"| `{line}` | {len(times)} | {longest:.2f} | {used:.2f}{mark} |", flush=True)
    sys.exit(1 if slow else 0)


if __name__ == "__main__":
    main()
