"""Identified and simulated by the command and by this package: the same numbers, bit for bit."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

import hysteron_models as hy
import numpy as np
import pytest

RIG = ["simulated_nested_loops.csv", "simulated_sweep_1_90hz.csv"]
STACK = ["stack.csv"]

#: Records and options, by the names of this package; the flags of the command follow from them.
FITS: list[tuple[list[str], dict[str, Any]]] = [
    *[
        (RIG, {"dynamics": dynamics, **more})
        for dynamics, more in [
            ("integer", {}), ("integer", {"order": 1}), ("integer", {"order": 3}), ("modes", {"order": 4}),
            ("arx", {}), ("oe", {}), ("bj", {}), ("srivc", {}), ("none", {}),
            ("integer", {"creep": "fractional"}), ("integer", {"creep": "logarithmic"}),
            ("integer", {"creep": "kelvin-voigt", "creep_elements": 1}),
            ("integer", {"degree": 1}), ("integer", {"degree": 3}), ("integer", {"delay": 0.001}),
            ("integer", {"initial": "zero"}), ("integer", {"initial": "free"}), ("integer", {"drift": True}),
            ("integer", {"scheme": "tustin"}), ("integer", {"inter_sample": "hold"}),
            ("integer", {"inter_sample": "band-limited"}), ("integer", {"fixed": {"gamma": 0.0}}),
            ("integer", {"bounds": {"beta": (0.01, 3.0)}}), ("integer", {"n": 1.5}),
            ("integer", {"method": "two-step"}), ("fractional", {}), ("fractional-free-lowest", {}),
        ]
    ],
    *[
        (RIG, {"hysteresis": name, "elements": elements, "dynamics": "integer"})
        for name, elements in [
            ("prandtl-ishlinskii", 6), ("maxwell-slip", 4), ("one-sided-plays", 4), ("generalised-plays", 3),
            ("dead-zone-plays", 4), ("preisach", 4), ("rate-dependent-plays", 4),
        ]
    ],
    (RIG, {"hysteresis": "dahl", "dynamics": "integer"}),
    *[
        (STACK, {"hysteresis": name})
        for name in [
            "bouc-wen", "parallel-bouc-wen", "non-symmetric-bouc-wen", "song-der-kiureghian", "dahl", "duhem",
            "jiles-atherton",
        ]
    ],
    *[
        (STACK, {"hysteresis": name, "elements": elements})
        for name, elements in [
            ("prandtl-ishlinskii", 5), ("krasnoselskii-pokrovskii", 3), ("preisach", 4),
        ]
    ],
    *[
        (STACK, {"optimizer": name, "generations": 5, "population": 12})
        for name in ["de-abc", "abc", "de", "pso"]
    ],
    (STACK, {"optimizer": "cma-es", "generations": 5, "seed": 7}),
]  # fmt: skip


def _flags(options: dict[str, Any]) -> list[str]:
    flags: list[str] = []
    for name, value in options.items():
        if name == "fixed":
            flags += [word for n, v in value.items() for word in ("--fix", f"{n}={v}")]
        elif name == "bounds":
            flags += [word for n, (low, high) in value.items() for word in ("--bound", f"{n}={low}:{high}")]
        elif value is True:
            flags.append(f"--{name}")
        else:
            flags += [f"--{name.replace('_', '-')}", str(value)]
    return flags


def _without_provenance(model: dict[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in model.items() if key != "provenance"}


@pytest.mark.parametrize(
    ("names", "options"), FITS, ids=lambda value: str(value) if isinstance(value, dict) else ""
)
def test_command_and_package_agree(
    command: Path, bench: Path, tmp_path: Path, names: list[str], options: dict[str, Any]
) -> None:
    out = tmp_path / "model.json"
    records = [str(bench / name) for name in names]
    told = subprocess.run(
        [str(command), "identify", *records, "-o", str(out), "--json", "--least-fit", "0", *_flags(options)],
        capture_output=True, text=True,
    )  # fmt: skip
    stage = hy.Hammerstein(**options, least_fit=0)
    read = hy.read(records)
    assert told.returncode == 0, told.stderr
    stage.fit(read)
    printed = json.loads(told.stdout)
    printed.pop("model")
    assert printed == stage.result_
    assert _without_provenance(json.loads(out.read_text())) == _without_provenance(stage.model_.data)
    drive = records[-1]
    simulated = tmp_path / "y.csv"
    subprocess.run(
        [str(command), "simulate", str(out), drive, "-o", str(simulated)], check=True, capture_output=True
    )
    ours = stage.model_.simulate(hy.read(drive)).y
    theirs = hy.read(simulated, input="u", output="y").y
    assert np.array_equal(ours, theirs)


def test_there_are_fifty_fits() -> None:
    assert len(FITS) >= 50
