"""What the page wrote down of what was done, as a script for a shell and for Python: both repeat it."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import time
import urllib.parse
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import hysteron_models as hy
import numpy as np
import pytest


class Page:
    """The interface of a running `hysteron app`."""

    def __init__(self, url: str) -> None:
        self.url = url.strip().rstrip("/") + "/api/v1/"

    def ask(self, method: str, path: str, body: Any = None, raw: bytes | None = None) -> Any:
        data = raw if raw is not None else None if body is None else json.dumps(body).encode()
        kind = "application/octet-stream" if raw is not None else "application/json"
        request = urllib.request.Request(self.url + path, data, {"Content-Type": kind}, method=method)
        with urllib.request.urlopen(request, timeout=300) as answer:
            text = answer.read()
        return (
            json.loads(text)
            if text and answer.headers["Content-Type"].startswith("application/json")
            else text
        )

    def identified(self, request: dict[str, Any]) -> None:
        job = self.ask("POST", "jobs", {"kind": "identify", **request})
        for _ in range(600):
            job = self.ask("GET", f"jobs/{job['id']}")
            if job["state"] not in ("waiting", "running"):
                break
            time.sleep(0.1)
        assert job["state"] == "done", job


@pytest.fixture
def page(command: Path, tmp_path: Path) -> Iterator[tuple[Page, Path]]:
    folder = tmp_path / "page"
    server = subprocess.Popen(
        [command, "app", folder, "--port", "0"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    )
    assert server.stdout is not None
    try:
        yield Page(server.stdout.readline()), folder
    finally:
        server.terminate()
        server.wait(10)


def do(page: Page, loops: hy.Record, unseen: hy.Record, folder: Path) -> None:
    """One of each operation that the history keeps."""
    for record in (loops, unseen):
        record.save(folder / f"{record.name}.csv")
    task = {"kind": "hammerstein", "options": {"dynamics": "none", "degree": {"given": 1}}}
    page.identified({"records": ["loops.csv"], "task": task, "model": "stage.json"})
    page.identified({"records": ["loops.csv"], "task": task, "start": "stage.json", "model": "again.json"})
    page.ask("POST", "models/stage.json/scores", {"records": ["unseen.csv"], "skip_s": 0.1})
    simulated = {"records": ["unseen.csv"], "options": {"band": "measurement"}, "save": "simulated.csv"}
    page.ask("POST", "models/stage.json/simulate", simulated)
    recalibrated = {"records": ["unseen.csv"], "save": "today.json", "options": {"least_fit_percent": 50.0}}
    page.ask("POST", "models/stage.json/recalibrate", recalibrated)
    adapted = {"record": "unseen.csv", "save": "adapted.json", "options": {"terms": ["gain"], "noise": 0.01}}
    page.ask("POST", "models/stage.json/adapt", adapted)
    page.ask("POST", "models/stage.json/realise", {"options": {"sample_rate_hz": 1000.0}})
    options = {"scales": ["y=2um/um"], "detrend": ["y"], "sample_rate_hz": 250.0}
    page.ask("POST", "prepare", {"records": ["loops.csv"], "options": options, "save": "prepared.csv"})
    waveform = {"kind": "sine", "frequency_hz": 1.0, "periods": 1.0}
    drive = {"sample_rate_hz": 500.0, "low_v": 3.0, "high_v": 9.0, "waveform": waveform}
    reference = {"from": "waveform", "specification": drive}
    page.ask("POST", "models/stage.json/follow", {"reference": reference, "save": "drive.csv"})
    ahead = {"reference": {"from": "record", "id": "drive-reference.csv"}, "inverse": {"preview": 3}}
    page.ask("POST", "models/stage.json/follow", {**ahead, "save": "ahead.csv"})
    options = {"controllers": ["uncompensated", "feedforward"]}
    played = {"reference": ahead["reference"], "on_model": True, "options": options, "save": "track.csv"}
    page.ask("POST", "models/stage.json/track", played)
    designed = {"options": {"purpose": "minor-loops", "time_s": 2.0}, "save": "next.csv"}
    page.ask("POST", "models/stage.json/design", designed)
    page.ask("GET", "models/stage.json/download?as=c&inverse=true&accuracy=0.001&name=axis")


@pytest.mark.parametrize("language", ["shell", "python"])
def test_a_script_repeats_what_was_done(
    page: tuple[Page, Path], loops: hy.Record, unseen: hy.Record, command: Path, language: str
) -> None:
    served, folder = page
    do(served, loops, unseen, folder)
    script = served.ask("GET", "history")[language]
    names = (
        "identify",
        "simulate",
        "recalibrate",
        "adapt",
        "realise",
        "prepare",
        "invert",
        "track",
        "design",
    )
    for name in (*names, "export"):
        assert re.search(rf"\b{name}\b" if language == "shell" else rf"{name}\(|\.fit\(", script), script
    again = folder.parent / "again"
    again.mkdir()
    for name in ("loops.csv", "unseen.csv", "drive-reference.csv"):
        shutil.copy(folder / name, again)
    if language == "shell":
        (again / "script.sh").write_text(script)
        (again / "bin").mkdir()
        (again / "bin/hysteron").symlink_to(command)
        run = ["sh", "-e", "script.sh"]
        environment = {**os.environ, "PATH": f"{again / 'bin'}:{os.environ['PATH']}"}
    else:
        (again / "script.py").write_text(script)
        run, environment = [sys.executable, "script.py"], dict(os.environ)
    done = subprocess.run(run, cwd=again, env=environment, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, f"{script}\n{done.stderr}"
    for name in ("stage.json", "again.json", "today.json", "adapted.json"):
        first, second = (json.loads((at / name).read_text()) for at in (folder, again))
        for block in ("hysteresis", "linear", "offset"):
            assert first.get(block) == second.get(block), f"{name}: {block}\n{script}"
    written = ["simulated.csv", "drive.csv", "ahead.csv"] if language == "shell" else []
    for name in ("prepared.csv", *written):
        first, second = (hy.read(at / name) for at in (folder, again))
        # The rate of a reference that is read again comes from its stamps.
        np.testing.assert_allclose(first.y, second.y, rtol=1e-12)
    if language == "shell":
        played = "y_feedforward"
        np.testing.assert_allclose(*(hy.read(at / "track.csv")[played] for at in (folder, again)), rtol=1e-12)
    assert hy.read(folder / "next.csv")["u"].tolist() == hy.read(again / "next.csv")["u"].tolist()
    assert any((again / "axis").glob("*.c")), sorted(path.name for path in again.iterdir())
    assert urllib.parse.urlparse(served.url).hostname == "127.0.0.1"
