"""GCS arrays as controllers of Physik Instrumente give them, and what their numbers are.

python gcs.py FOLDER writes the files and FOLDER/expected.json. Where PIPython is installed, it reads each
file too, and must agree.
"""

import sys
from pathlib import Path

import expected

try:
    import numpy as np
except ImportError as missing:
    expected.skip(missing)
try:
    from pipython.pitools import readgcsarray
except ImportError:
    readgcsarray = None

folder = Path(sys.argv[1])
random = np.random.default_rng(18)
NAMES = [
    "Target Position of axis1",
    "Current Position of axis1",
    "Control Voltage of output chan 1",
    "DDL output of axis1",
]
cases = []
for separator in (32, 9, 59, 44):
    for count in (2, 3, 4):
        for digits in (6, 17):
            for front in ("", "GCS 2.0 controller\n[GCS_ARRAY]\n"):
                data = random.normal(scale=50, size=(64, count))
                lines = [
                    "# REM E-727.3CDA",
                    "# VERSION = 1 ",
                    "# TYPE = 1 ",
                    f"# SEPARATOR = {separator} ",
                    f"# DIM = {count} ",
                ]
                lines += ["# SAMPLE_TIME = 0.000050 ", f"# NDATA = {len(data)} "]
                lines += [f"# NAME{i} = {NAMES[i]} " for i in range(count)] + ["# ", "# END_HEADER "]
                rows = [chr(separator).join(f"{value:.{digits}g}" for value in row) + " " for row in data]
                path = folder / f"{len(cases)}.dat"
                path.write_text(front + "\n".join(lines + rows) + "\n")
                values = [[float(field) for field in row.strip().split(chr(separator))] for row in rows]
                columns = [list(column) for column in zip(*values)]
                if readgcsarray is not None:
                    header, read = readgcsarray(str(path))
                    assert read == columns, path
                    assert header["SAMPLE_TIME"] == 5e-5
                cases.append(
                    {
                        "file": path.name,
                        "columns": [
                            expected.column(NAMES[i], column, sample_rate_hz=1 / 5e-5)
                            for i, column in enumerate(columns)
                        ],
                    }
                )
expected.write(folder, cases)
if readgcsarray is None:
    print("PIPython is not installed: the numbers are those of the text", file=sys.stderr)
