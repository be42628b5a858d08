"""What the kinds of faults share: commands, records, files."""

import json
import math
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any

QUIET: dict[str, Any] = {
    "stdin": subprocess.DEVNULL,
    "stdout": subprocess.DEVNULL,
    "stderr": subprocess.DEVNULL,
}


@dataclass
class Job:
    """A command that writes files."""

    program: str
    line: str
    outputs: list[str]
    share: int

    @property
    def name(self) -> str:
        """Short: the command and what tells it from its like."""
        words = self.line.split()
        telling = {"--to": 1, "--inverse": 0, "--generations": 1, "--report": 0}
        more = [
            words[k + after] for k, word in enumerate(words) for key, after in telling.items() if word == key
        ]
        return " ".join([words[0], *more])

    def arguments(self) -> list[str]:
        return [self.program, *self.line.split()]


class Table:
    """What was tried, and what came of it."""

    def __init__(self) -> None:
        self.failed = 0
        print("| fault | of | tried | found |\n| --- | --- | --- | --- |")

    def row(self, fault: str, of: str, tried: str, failed: str) -> None:
        self.failed += bool(failed)
        print(f"| {fault} | {of} | {tried} | {'BROKEN: ' + failed if failed else 'kept'} |", flush=True)


def record(path: Path, frequency_hz: float) -> None:
    """A simulated loop."""
    lines = ["t_s,u_V,y_um"]
    for k in range(600):
        t = k / 200
        phase = 2 * math.pi * frequency_hz * t
        u = (5 - 5 * math.cos(phase)) * min(1.0, k / 20)
        lines.append(f"{t},{u},{2 * u + 0.03 * u * u - math.sin(phase) + 0.001 * (k * 7919 % 13 - 6)}")
    path.write_text("\n".join(lines) + "\n")


def started(arguments: list[str], place: Path) -> subprocess.Popen[bytes]:
    return subprocess.Popen(arguments, cwd=place, **QUIET)


def run(arguments: list[str], place: Path) -> str:
    """What a command that must succeed prints."""
    done = subprocess.run(arguments, cwd=place, stdin=subprocess.DEVNULL, capture_output=True, timeout=300)
    if done.returncode != 0:
        said = done.stderr.decode(errors="replace").strip()[-400:]
        raise AssertionError(f"{' '.join(arguments[1:])}: exit {done.returncode}: {said}")
    return done.stdout.decode()


def content(place: Path, names: list[str]) -> dict[str, bytes]:
    """The files of these names, and those in folders of these names."""
    found = {}
    for name in names:
        path = place / name
        files = [path] if path.is_file() else sorted(p for p in path.rglob("*") if p.is_file())
        found.update({str(file.relative_to(place)): file.read_bytes() for file in files})
    return {name: text for name, text in found.items() if ".tmp" not in name}


def whole(name: str, text: bytes | None) -> Any:
    """What must be the same in every run; an error where the file is torn."""
    if text is None:
        return None
    if name.endswith("m.json"):
        model = json.loads(text)
        del model["provenance"]
        return model
    if name.endswith(".html"):
        if not text.startswith(b"<!") or not text.rstrip().endswith(b"</html>"):
            raise AssertionError(f"{name} is no whole page")
        return True
    return text
