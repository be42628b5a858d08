"""Writes the arrays of this folder and some HDF5 files; they were written with numpy 2 and h5py 3. The TDMS
files are some of ../oracle/tdms.py."""
import h5py
import numpy as np

t = np.arange(5) / 1000
u = np.array([0, 1.5, -2.5, 3.25, 4], dtype=">f4")
y = np.asfortranarray(np.arange(-1, 4, dtype=np.int16).reshape(5, 1))
valid = np.array([1, 1, 0, 1, 1], dtype=bool)
np.savez("numpy_savez.npz", u_V=u, y_um=y, valid=valid, fs=1000, note="bench 3")
np.savez_compressed("numpy_savez_compressed.npz", t_s=t, u_V=u, y_um=y, valid=valid)
kinds = np.dtype([("t_s", "f8"), ("valid", "?"), ("u_V", ">f4"), ("y_um", "i2")], align=True)
fields = np.zeros(5, dtype=kinds)
fields["t_s"], fields["u_V"], fields["y_um"], fields["valid"] = t, u, y[:, 0], valid
np.save("numpy_structured.npy", fields)

# Five periods of 2 Hz at 200 Hz, the output late by 0.1 rad.
angle = 2 * np.pi * 2 * np.arange(500) / 200
u, y = 50 - 50 * np.cos(angle), 10 - 10 * np.cos(angle - 0.1)
np.savez_compressed("loop.npz", u_V=u.astype("f4"), y_um=y.astype("f4"), fs=200)

# Links of HDF5: datasets and groups by two paths, a group within itself; a dataset that is never written.
with h5py.File("linked.h5", "w") as file:
    for name, values in [("t_s", np.arange(5) / 10), ("u_V", np.arange(5.0)), ("y_um", np.arange(5.0) ** 2)]:
        file[f"entry/{name}"] = values
        file[f"data/{name}"] = file[f"entry/{name}"]
    file["entry/self"] = file["entry"]
    file["entry/nowhere"] = h5py.SoftLink("/nowhere")
with h5py.File("ladder.h5", "w") as file:
    below = file.create_group("0")
    for step in range(1, 18):
        group = file.create_group(str(step))
        group["a"], group["b"], below = below, below, group
with h5py.File("unwritten.h5", "w") as file:
    for name in ("u_V", "y_um"):
        file.create_dataset(name, (2**28,), dtype="f8")
# Groups deeper than a reader follows.
with h5py.File("deep.h5", "w") as file:
    file["u_V"], file["y_um"] = np.arange(5.0), np.arange(5.0) ** 2
    file["/".join(f"g{level}" for level in range(40)) + "/w_V"] = np.arange(5.0)
# MATLAB's cells: one that refers to the array it stands in, one to nothing; and classes that are no arrays of
# numbers.
with h5py.File("cells_7.3.mat", "w", userblock_size=512) as file:
    refs = file.create_group("#refs#")
    classed = lambda data, name: data.attrs.__setitem__("MATLAB_class", np.bytes_(name))
    refs["a"] = np.arange(4.0).reshape(1, 4)
    classed(refs["a"], "double")
    inner = refs.create_group("b")
    classed(inner, "struct")
    inner["u"] = np.arange(4.0).reshape(1, 4)
    classed(inner["u"], "double")
    refs["d"] = np.array([0, 3], "u8")
    classed(refs["d"], "double")
    refs["d"].attrs["MATLAB_empty"] = np.uint8(1)
    cells = file.create_dataset("c", (4, 1), dtype=h5py.ref_dtype)
    classed(cells, "cell")
    again = inner.create_dataset("again", (1, 1), dtype=h5py.ref_dtype)
    classed(again, "cell")
    again[0, 0] = cells.ref
    cells[0, 0], cells[1, 0], cells[3, 0] = refs["a"].ref, inner.ref, refs["d"].ref
    for name, kind in [("f", "function_handle"), ("none", "struct"), ("s", "double")]:
        classed(file.create_group(name), kind)
    file["s"].attrs["MATLAB_sparse"] = np.uint64(3)
    file["s/data"] = np.arange(2.0)
    file["when"] = np.zeros((1, 6), "u4")
    classed(file["when"], "datetime")
with open("cells_7.3.mat", "r+b") as file:
    file.write(b"MATLAB 7.3 MAT-file".ljust(124) + bytes([0, 2]) + b"IM")
