"""Files in the layout of MATLAB 7.3, by h5py and by hdf5storage, and what mat73 and hdf5storage read from
them.

python matlab73.py FOLDER writes the files into FOLDER and FOLDER/expected.json.
"""

import sys
import warnings
from dataclasses import dataclass
from pathlib import Path

import expected

try:
    import h5py
    import hdf5storage
    import mat73
    import numpy as np
except ImportError as missing:
    expected.skip(missing)

folder = Path(sys.argv[1])
random = np.random.default_rng(73)
cases = []
CLASSES = {
    "double": "f8",
    "single": "f4",
    "int8": "i1",
    "uint8": "u1",
    "int16": "i2",
    "uint16": "u2",
    "int32": "i4",
    "uint32": "u4",
    "int64": "i8",
    "uint64": "u8",
}


@dataclass
class Structures:
    """An array of structures: dicts of the same keys."""

    elements: list


@dataclass
class Empty:
    """An empty array of a class."""

    kind: str


class Matlab:
    """A file that is filled as MATLAB fills it: cells and elements of arrays of structures stand
    in #refs#."""

    def __init__(self, file):
        self.file = file
        self.names = 0

    def referred(self, value):
        name = f"#refs#/r{self.names}"
        self.names += 1
        self.put(self.file, name, value)
        return self.file[name].ref

    def references(self, values, group, name):
        refs = np.array([self.referred(value) for value in values], dtype=h5py.ref_dtype)
        return group.create_dataset(name, data=refs.reshape(-1, 1), dtype=h5py.ref_dtype)

    def put(self, group, name, value):
        if isinstance(value, dict):
            own = group.create_group(name)
            own.attrs["MATLAB_class"] = np.bytes_("struct")
            for key, inner in value.items():
                self.put(own, key, inner)
        elif isinstance(value, Structures):
            own = group.create_group(name)
            own.attrs["MATLAB_class"] = np.bytes_("struct")
            for key in value.elements[0]:
                self.references([element[key] for element in value.elements], own, key)
        elif isinstance(value, list):
            own = self.references(value, group, name)
            own.attrs["MATLAB_class"] = np.bytes_("cell")
        elif isinstance(value, Empty):
            own = group.create_dataset(name, data=np.zeros(2, "u8"))
            own.attrs["MATLAB_class"] = np.bytes_(value.kind)
            own.attrs["MATLAB_empty"] = np.uint8(1)
        elif isinstance(value, str):
            letters = np.frombuffer(value.encode("utf-16-le"), "u2").reshape(-1, 1)
            own = group.create_dataset(name, data=letters)
            own.attrs["MATLAB_class"] = np.bytes_("char")
            own.attrs["MATLAB_int_decode"] = np.int32(2)
        else:
            column = value.reshape(1, -1) if random.integers(2) else value.reshape(-1, 1)
            own = group.create_dataset(name, data=column.astype("u1") if value.dtype == "?" else column)
            kind = next((kind for kind, dtype in CLASSES.items() if value.dtype == dtype), "logical")
            own.attrs["MATLAB_class"] = np.bytes_(kind)
            if kind == "logical":
                own.attrs["MATLAB_int_decode"] = np.int32(1)
        own.attrs["H5PATH"] = np.bytes_(group.name)


def marked(path):
    """The header that MATLAB writes in front of the HDF5 file."""
    with open(path, "r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + bytes([0, 2]) + b"IM")


def numbers(dtype=None):
    dtype = dtype or list(CLASSES.values())[random.integers(len(CLASSES))]
    if np.dtype(dtype).kind == "f":
        return random.normal(size=6).astype(dtype)
    info = np.iinfo(dtype)
    return random.integers(info.min, info.max, 6, dtype=dtype, endpoint=True)


def leaves(value, path):
    """Paths of the arrays of numbers in a value, as they are written in MATLAB, and the arrays."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from leaves(inner, f"{path}.{key}" if path else key)
    elif isinstance(value, Structures):
        for index, element in enumerate(value.elements, 1):
            many = len(value.elements) > 1
            yield from leaves(element, f"{path}({index})" if many else path)
    elif isinstance(value, list):
        for index, inner in enumerate(value, 1):
            yield from leaves(inner, f"{path}{{{index}}}")
    elif isinstance(value, np.ndarray):
        yield path, value


def same(own, read):
    """Whether mat73 reads the same numbers in the same places."""
    if isinstance(own, Structures):
        # As a list of structures, or as a structure of lists.
        if isinstance(read, dict):
            return all(same([element[key] for element in own.elements], read[key]) for key in own.elements[0])
        return same(own.elements, read)
    if isinstance(own, dict):
        return all(same(inner, read[key]) for key, inner in own.items())
    if isinstance(own, list):
        return len(own) == len(read) and all(same(a, b) for a, b in zip(own, read))
    return np.array_equal(own, np.ravel(read)) if isinstance(own, np.ndarray) else True


def arrays(value):
    """The arrays of numbers in a value, wherever they stand."""
    if isinstance(value, Structures):
        value = value.elements
    if isinstance(value, (dict, list)):
        inner = value.values() if isinstance(value, dict) else value
        return sorted(array for one in inner for array in arrays(one))
    return [(value.dtype.str, value.tobytes())] if isinstance(value, np.ndarray) else []


def add(path, tree, refused=()):
    columns = [expected.column(path, values) for path, values in leaves(tree, "")]
    cases.append({"file": path.name, "columns": columns, "refused": list(refused)})


def signals(count):
    elements = [{"values": numbers("f8"), "gain": numbers(), "label": "drive"} for _ in range(count)]
    return Structures(elements)


TREES = [
    lambda: {"rec": {"u": numbers(), "y": numbers(), "note": "loop"}, "ok": random.normal(size=6) > 0},
    lambda: {"signals": signals(3), "x": numbers("f8")},
    lambda: {"scope": {"signals": signals(2), "ramp": numbers("f8")}},
    lambda: {"runs": [numbers(), numbers(), "note", numbers()], "y_um": numbers("f8")},
    lambda: {"runs": [{"u": numbers(), "y": numbers()}, {"u": numbers(), "y": numbers()}]},
    lambda: {"deep": [[numbers(), [numbers(), {"a": [numbers()]}]], signals(2)]},
    lambda: {
        "s": Structures([{"in": {"c": [numbers(), numbers()]}} for _ in range(4)]), "u_V": numbers("f8")
    },
    lambda: {"long": [numbers() for _ in range(30)]},
]
EMPTY = {"none": Empty("double"), "cells": Empty("cell"), "records": Empty("struct"), "text": Empty("char")}
for index in range(60):
    tree = TREES[index % len(TREES)]()
    path = folder / f"h5py_{index}.mat"
    libver = ["earliest", "latest"][index // len(TREES) % 2]
    with h5py.File(path, "w", userblock_size=512, libver=libver) as file:
        matlab = Matlab(file)
        for name, value in (tree | EMPTY).items():
            matlab.put(file, name, value)
    marked(path)
    assert same(tree, mat73.loadmat(path)), path
    add(path, tree, refused=EMPTY)


def stored(value):
    """A value as hdf5storage takes it: cells are arrays of objects, arrays of structures have named
    fields."""
    if isinstance(value, dict):
        return {key: stored(inner) for key, inner in value.items()}
    if isinstance(value, Structures):
        names = list(value.elements[0])
        array = np.empty(len(value.elements), dtype=[(name, object) for name in names])
        for index, element in enumerate(value.elements):
            array[index] = tuple(stored(element[name]) for name in names)
        return array
    if isinstance(value, list):
        cells = np.empty(len(value), dtype=object)
        for index, inner in enumerate(value):
            cells[index] = stored(inner)
        return cells
    return value


for index in range(48):
    tree = TREES[index % len(TREES)]()
    path = folder / f"hdf5storage_{index}.mat"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        hdf5storage.savemat(str(path), stored(tree), format="7.3", oned_as=["row", "column"][index % 2])
    # mat73 gives rows of cells as lists within lists.
    assert arrays(tree) == arrays(mat73.loadmat(path)), path
    add(path, tree)
expected.write(folder, cases)
