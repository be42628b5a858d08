"""The server of the page, killed in the midst of a job or an upload, and started again."""

import json
import random
import shutil
import subprocess
import time
import urllib.error
import urllib.request
from pathlib import Path
from typing import Any

from common import whole

ENDED = ("done", "failed", "stopped", "interrupted")
SWARM = {"population": 20, "inertia": 0.7, "cognitive": 1.5, "social": 1.5, "velocity_clamp": 0.5}
OPTIONS = {"algorithm": {"pso": SWARM}, "generations": 200, "degree": {"given": 2}}
JOB = {
    "kind": "identify",
    "records": ["loop.csv"],
    "model": "m.json",
    "task": {"kind": "hammerstein", "options": OPTIONS},
}


class Server:
    """`hysteron app` on a folder."""

    def __init__(self, program: str, folder: Path) -> None:
        arguments = [program, "app", str(folder), "--port", "0"]
        self.process = subprocess.Popen(
            arguments, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
        )
        assert self.process.stdout is not None
        self.url = self.process.stdout.readline().strip()

    def ask(self, method: str, path: str, body: Any = None) -> Any:
        data = body if isinstance(body, bytes) else None if body is None else json.dumps(body).encode()
        request = urllib.request.Request(f"{self.url}api/v1/{path}", data, method=method)
        request.add_header("content-type", "application/json")
        with urllib.request.urlopen(request, timeout=30) as answer:
            text = answer.read()
        return json.loads(text) if text else None

    def kill(self) -> None:
        self.process.kill()
        self.process.wait()

    def ended(self, job: int) -> Any:
        """The job when it has ended."""
        end = time.monotonic() + 120
        while time.monotonic() < end:
            found = self.ask("GET", f"jobs/{job}")
            if found["state"] in ENDED:
                return found
            time.sleep(0.02)
        raise AssertionError(f"job {job} does not end")


class AppKills:
    """Kills of the server."""

    name, share = "app: job", 10

    def __init__(self, folder: Path, program: str) -> None:
        self.folder, self.program = folder, program
        self.count = self.resumed = self.changed = 0
        place = self.prepared("app-straight")
        server = Server(program, place)
        begun = time.monotonic()
        server.ask("POST", "jobs", JOB)
        job = server.ended(1)
        self.took = time.monotonic() - begun
        server.kill()
        if job["state"] != "done":
            raise AssertionError(f"the job of the straight run: {job}")
        self.expected = whole("m.json", (place / "m.json").read_bytes())

    def prepared(self, name: str) -> Path:
        place = self.folder / name
        shutil.rmtree(place, ignore_errors=True)
        place.mkdir()
        shutil.copy(self.folder / "loop.csv", place)
        return place

    def kill(self, rng: random.Random) -> None:
        """Kill it once, start it again, resume."""
        place = self.prepared("app-killed")
        server = Server(self.program, place)
        server.ask("POST", "jobs", JOB)
        time.sleep(rng.uniform(0, 1.1) * self.took)
        server.kill()
        self.count += 1
        if (place / "loop.csv").read_bytes() != (self.folder / "loop.csv").read_bytes():
            raise AssertionError(f"the record has changed, in {place}")
        for path in place.glob("*.json"):
            json.loads(path.read_bytes())
        stood = (place / "m.json").exists()
        self.changed += stood
        server = Server(self.program, place)
        try:
            job = server.ended(1)
            if job["state"] == "interrupted":
                self.resumed += 1
                server.ask("POST", "jobs/1/resume", {})
                job = server.ended(1)
                # The state of before, until the job has begun again.
                end = time.monotonic() + 60
                while job["state"] == "interrupted" and time.monotonic() < end:
                    job = server.ended(1)
            if job["state"] != "done":
                raise AssertionError(
                    f"job 1 is {job['state']} after the kill, in {place}: {job.get('problem')}"
                )
            models = [model["id"] for model in server.ask("GET", "models")]
            if "m.json" not in models or whole("m.json", (place / "m.json").read_bytes()) != self.expected:
                raise AssertionError(f"another model than without the kill, in {place}")
        finally:
            server.kill()
