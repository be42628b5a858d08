"""A fleet's client, killed and started again, on a registry in a file."""

import random
import subprocess
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
DEVICES = 12


class FleetKills:
    """Kills of the client."""

    name, share = "fleet", 4

    def __init__(self, folder: Path, python: str) -> None:
        self.folder, self.python = folder, python
        self.count = self.resumed = self.changed = 0
        self.ask("write", str(folder / "fleet"), str(DEVICES))
        begun = time.monotonic()
        client = self.client("straight")
        self.took = time.monotonic() - begun
        client.wait()
        self.took = time.monotonic() - begun
        self.expected = self.ask("content", self.url("straight"))

    def url(self, name: str) -> str:
        return f"sqlite:///{self.folder / name}.sqlite"

    def arguments(self, *words: str) -> list[str]:
        return [self.python, str(ROOT / "python/tests/simulated_fleet.py"), *words]

    def ask(self, *words: str) -> str:
        done = subprocess.run(self.arguments(*words), capture_output=True, text=True, timeout=300)
        if done.returncode != 0:
            raise AssertionError(f"{words}: {done.stderr[-400:]}")
        return done.stdout

    def client(self, name: str) -> subprocess.Popen[str]:
        """A client that has begun."""
        words = self.arguments("calibrate", f"{self.folder / 'fleet'}/*.csv", self.url(name))
        process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        assert process.stdout is not None
        process.stdout.readline()
        return process

    def kill(self, rng: random.Random) -> None:
        """Kill it at three instants, each time started again, and let it end."""
        for path in self.folder.glob("killed.sqlite*"):
            path.unlink()
        for _ in range(3):
            begun = time.monotonic()
            client = self.client("killed")
            left = self.took - (time.monotonic() - begun)
            time.sleep(max(0.0, rng.uniform(0, 0.6) * left))
            client.kill()
            client.wait()
            self.resumed += 1
        self.count += 3
        client = self.client("killed")
        if client.wait() != 0:
            raise AssertionError("the client that was not killed fails")
        if self.ask("content", self.url("killed")) != self.expected:
            raise AssertionError(f"other rows than without the kill, in {self.folder}")
