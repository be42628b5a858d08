"""What SciPy reads from MAT files: those that it writes, and those of MATLAB in its own tests.

python mat.py FOLDER writes the files into FOLDER and FOLDER/expected.json.
"""

import shutil
import sys
from pathlib import Path

import expected

try:
    import numpy as np
    import scipy.io
    import scipy.io.matlab
except ImportError as missing:
    expected.skip(missing)

folder = Path(sys.argv[1])
random = np.random.default_rng(1)
cases = []

TYPES = ["f8", "f4", "i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8"]


def numbers(dtype, count):
    if np.dtype(dtype).kind == "f":
        return random.normal(size=count).astype(dtype)
    info = np.iinfo(dtype)
    return random.integers(info.min, info.max, count, dtype=dtype, endpoint=True)


def vectors(path, value, found):
    """Columns of numbers in what scipy read, by the paths of their places."""
    if not isinstance(value, np.ndarray):
        return
    if isinstance(value, scipy.io.matlab.MatlabFunction | scipy.io.matlab.MatlabObject):
        return
    if value.dtype.names:
        cells = value.ravel(order="F")
        for index, record in enumerate(cells):
            place = path if len(cells) == 1 else f"{path}({index + 1})"
            for field in value.dtype.names:
                vectors(f"{place}.{field}", record[field], found)
    elif value.dtype == object:
        for index, cell in enumerate(value.ravel(order="F")):
            vectors(f"{path}{{{index + 1}}}", cell, found)
    elif value.dtype.kind in "iufb":
        long = [n for n in value.shape if n != 1]
        if len(long) == 1 and long[0] > 1:
            found.append((path, value.ravel(order="F")))


def add(name):
    held = scipy.io.loadmat(folder / name, squeeze_me=False, struct_as_record=True, chars_as_strings=False)
    found = []
    for variable, value in held.items():
        if not variable.startswith("__"):
            vectors(variable, value, found)
    columns = [expected.column(path, values) for path, values in found if np.isfinite(values).all()]
    if columns:
        cases.append({"file": name, "columns": columns})


count = 0
for version in ["4", "5"]:
    for compressed in [False, True] if version == "5" else [False]:
        for oned in ["row", "column"]:
            for dtype in TYPES:
                if version == "4" and dtype in ("i1", "u4", "i8", "u8"):
                    continue
                count += 1
                name = f"own_{count}.mat"
                held = {"t_s": np.arange(9) / 10, "u_V": numbers(dtype, 9), "y_um": numbers("f8", 9)}
                options = {"do_compression": compressed} if version == "5" else {}
                scipy.io.savemat(folder / name, held, format=version, oned_as=oned, **options)
                add(name)
for index in range(12):
    count += 1
    name = f"own_{count}.mat"
    inner = {"u": numbers("f8", 7), "y": numbers("f4", 7), "note": "text", "deep": {"v_V": numbers("i2", 7)}}
    several = np.zeros(3, dtype=[("values", object), ("unit", object)])
    for k in range(3):
        several[k] = (numbers("f8", 5 + k), "um")
    cells = np.empty(2, dtype=object)
    cells[:] = [numbers("f8", 4), inner]
    held = {
        "rec": inner, "signals": several, "runs": cells, "c": numbers("f8", 4) * 1j,
        "yes": numbers("f8", 6) > 0,
    }
    oned_as = ["row", "column"][index // 2 % 2]
    scipy.io.savemat(folder / name, held, do_compression=bool(index % 2), oned_as=oned_as)
    add(name)

own = Path(scipy.io.matlab.__file__).parent / "tests/data"
skipped = []
for path in sorted(own.glob("*.mat")) if own.exists() else []:
    if path.stem == "nasty_duplicate_fieldnames":
        # Two fields of one name: refused by us, the second one given another name by SciPy.
        continue
    shutil.copy(path, folder / path.name)
    try:
        add(path.name)
    except Exception as e:  # Version 7.3 and files that are damaged on purpose.
        skipped.append(f"{path.name}: {e}")

expected.write(folder, cases)
