"""What the live pictures of the page cost a fit, and how often they come.

    python bench/live_pictures.py target/release/hysteron [ROUNDS]

One server fits the measured example again and again, in turn with a page that listens and without one. The cost
is the ratio of the two times of a round; a round of two fits without a page gives the scatter of the machine.
"""

import json
import os
import shutil
import socket
import statistics
import subprocess
import sys
import tempfile
import threading
import time
import urllib.request
from pathlib import Path

RECORD = Path(__file__).parent.parent / "examples" / "piezo-p885-200hz" / "identification_1hz.csv"
# A search by a population: it has a better model to show in nearly every generation.
SCOUT = {"chaotic": {"iterates": 10, "chaos": "wrap", "keeps": "best"}}
DE_ABC = {"population": 25, "moved": "all", "limit": None, "scout": SCOUT}
OPTIONS = {"algorithm": {"de-abc": DE_ABC}, "generations": 40, "dynamics": "none"}
TASK = {"kind": "hammerstein", "options": OPTIONS}


class Page:
    """Listens to the events as a page does, and counts them while a fit runs."""

    def __init__(self, address):
        self.updates = self.pictures = 0
        self.stream = urllib.request.urlopen(f"{address}/api/v1/events")
        self.thread = threading.Thread(target=self.read, daemon=True)
        self.thread.start()

    def read(self):
        name = ""
        try:
            for line in self.stream:
                if line.startswith(b"event: "):
                    name = line[7:].strip()
                elif line.startswith(b"data: ") and name == b"live":
                    self.updates += 1
                    self.pictures += json.loads(line[6:])["latest"] is not None
        except (OSError, ValueError, AttributeError):
            return

    def leave(self):
        # The reader holds the lock of the stream: the connection is ended below it.
        self.stream.fp.raw._sock.shutdown(socket.SHUT_RDWR)
        self.thread.join()


def ask(address, path, body=None):
    data = None if body is None else json.dumps(body).encode()
    headers = {"Content-Type": "application/json"}
    with urllib.request.urlopen(urllib.request.Request(f"{address}/api/v1/{path}", data, headers)) as answer:
        return json.load(answer)


def fitted(address, listens):
    """Time of one fit [s], updates and pictures per second."""
    page = Page(address) if listens else None
    time.sleep(0.3)
    job = ask(address, "jobs", {"kind": "identify", "records": [RECORD.name], "task": TASK})
    while job["state"] in ("waiting", "running"):
        time.sleep(0.25)
        job = ask(address, f"jobs/{job['id']}")
    assert job["state"] == "done", job
    elapsed = job["elapsed_s"]
    if not page:
        return elapsed, 0.0, 0.0
    page.leave()
    return elapsed, page.updates / elapsed, page.pictures / elapsed


def main():
    command, rounds = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 10
    folder = tempfile.mkdtemp(prefix="hysteron-live-")
    shutil.copy(RECORD, folder)
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    server = subprocess.Popen([command, "app", folder, "--port", str(port)], stdout=subprocess.DEVNULL)
    address = f"http://127.0.0.1:{port}"
    try:
        for _ in range(100):
            try:
                ask(address, "workspace")
                break
            except OSError:
                time.sleep(0.05)
        fitted(address, False)
        quiet, ratios, scatter, updates, pictures = [], [], [], [], []
        for index in range(rounds):
            # In alternating order, so that what drifts falls on both sides.
            order = [False, True, False] if index % 2 == 0 else [True, False, False]
            times = {True: [], False: []}
            for listens in order:
                elapsed, of_updates, of_pictures = fitted(address, listens)
                times[listens].append(elapsed)
                if listens:
                    updates.append(of_updates)
                    pictures.append(of_pictures)
            quiet += times[False]
            ratios.append(times[True][0] / statistics.mean(times[False]))
            scatter.append(times[False][1] / times[False][0])
        middle = statistics.median
        print(f"a fit without a page: {middle(quiet):.2f} s (median of {len(quiet)}, {os.cpu_count()} cores)")
        print(f"with a page: {middle(ratios):.3f} of that time (median of {rounds} rounds, "
              f"{min(ratios):.3f} to {max(ratios):.3f})")
        print(f"without one, twice: {middle(scatter):.3f} ({min(scatter):.3f} to {max(scatter):.3f})")
        print(f"updates per second: {middle(updates):.1f}, with a new picture {middle(pictures):.1f}")
    finally:
        server.terminate()
        server.wait()
        shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    main()
