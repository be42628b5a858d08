"""What h5py reads from HDF5 files that it writes, and files in the layout of MATLAB 7.3.

python hdf5.py FOLDER writes the files into FOLDER and FOLDER/expected.json.
"""

import sys
from pathlib import Path

import expected

try:
    import h5py
    import numpy as np
except ImportError as missing:
    expected.skip(missing)

folder = Path(sys.argv[1])
random = np.random.default_rng(1)
cases = []

TYPES = ["f2", "f4", "f8", "i1", "i2", "i4", "i8", "u1", "u2", "u4", "u8", "?"]
LAYOUTS = [
    {},
    {"chunks": (4,)},
    {"chunks": (5,), "compression": "gzip"},
    {"chunks": (3,), "compression": "gzip", "shuffle": True, "fletcher32": True},
]


def numbers(dtype, count):
    kind = np.dtype(dtype)
    if kind.kind == "f":
        return random.normal(size=count).astype(dtype)
    if kind.kind == "b":
        return random.normal(size=count) > 0
    info = np.iinfo(kind)
    native = kind.newbyteorder("=")
    return random.integers(info.min, info.max, count, dtype=native, endpoint=True).astype(dtype)


count = 0
for order in "<>":
    for dtype in TYPES:
        for layout in LAYOUTS:
            count += 1
            name = f"own_{count}.h5"
            columns = []
            with h5py.File(folder / name, "w", libver=["earliest", "latest"][count % 2]) as file:
                whole = dtype if dtype == "?" else order + dtype
                for path, shape in [("v", (9,)), ("run/u", (9, 1)), ("run/deep/y", (1, 9))]:
                    values = numbers(whole, 9)
                    how = dict(layout)
                    if "chunks" in how:
                        how["chunks"] = tuple(min(how["chunks"][0], n) for n in shape)
                    data = file.create_dataset(path, data=values.reshape(shape), **how)
                    unit = None
                    if path != "v":
                        data.attrs["units"] = unit = "um"
                    columns.append(expected.column(path, values, unit))
                file["run/note"] = "text"
                file["complex"] = np.zeros(9, dtype=complex)
                file["rate"] = 3.0
            cases.append({"file": name, "columns": columns})

for index in range(8):
    name = f"matlab_{index}.mat"
    with h5py.File(folder / name, "w", userblock_size=512) as file:
        u, y = numbers("f8", 7), numbers("f8", 7)
        shape = [(1, 7), (7, 1)][index % 2]
        record = file.create_group("rec")
        record.attrs["MATLAB_class"] = np.bytes_("struct")
        for field, values in [("u", u), ("y", y)]:
            record[field] = values.reshape(shape)
            record[field].attrs["MATLAB_class"] = np.bytes_("double")
        record["note"] = np.frombuffer("text".encode("utf-16-le"), "u2").reshape(4, 1)
        record["note"].attrs["MATLAB_class"] = np.bytes_("char")
        file.create_group("#refs#")["a"] = u
    with open(folder / name, "r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file".ljust(124) + bytes([0, 2]) + b"IM")
    cases.append({"file": name, "columns": [expected.column("rec.u", u), expected.column("rec.y", y)]})

expected.write(folder, cases)
