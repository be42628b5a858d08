"""Talks to the Rust side, target/release/hysteron-bench."""

import json
import os
import pathlib
import subprocess

ROOT = pathlib.Path(__file__).resolve().parent.parent


class RustSide:
    def __init__(self):
        path = ROOT / "target" / "release" / "hysteron-bench"
        if not path.exists():
            raise SystemExit(f"error: {path} is missing\n  try: make bench, which builds it")
        self.process = subprocess.Popen([path], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def ask(self, task, **request):
        self.process.stdin.write(json.dumps({"task": task, **request}) + "\n")
        self.process.stdin.flush()
        line = self.process.stdout.readline()
        if not line:
            raise SystemExit(f"error: the Rust side stopped at '{task}' (its message is above)")
        return json.loads(line)

    def cpu_s(self):
        """Processor time of the Rust side so far [s], all threads."""
        fields = pathlib.Path(f"/proc/{self.process.pid}/stat").read_text().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
