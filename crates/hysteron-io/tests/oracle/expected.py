"""What the oracle scripts have in common: the numbers that a file holds, for the tests of the readers."""

import json
import sys

#: Exit code of a script whose modules are not installed.
SKIPPED = 77


def skip(missing):
    print(missing, file=sys.stderr)
    sys.exit(SKIPPED)


def column(path, values, unit=None, sample_rate_hz=None):
    """A column: its doubles by their bits, so that no text rounds them."""
    import numpy as np

    bits = np.ascontiguousarray(values).astype("<f8").view("<u8").ravel()
    return {"path": path, "unit": unit, "sample_rate_hz": sample_rate_hz, "bits": [int(b) for b in bits]}


def write(folder, cases):
    (folder / "expected.json").write_text(json.dumps(cases))
