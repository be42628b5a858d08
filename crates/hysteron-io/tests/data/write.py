"""Writes the arrays of this folder; they were written with numpy 2. The TDMS files are some of ../oracle/tdms.py."""
import numpy as np

t = np.arange(5) / 1000
u = np.array([0, 1.5, -2.5, 3.25, 4], dtype=">f4")
y = np.asfortranarray(np.arange(-1, 4, dtype=np.int16).reshape(5, 1))
valid = np.array([1, 1, 0, 1, 1], dtype=bool)
np.savez("numpy_savez.npz", u_V=u, y_um=y, valid=valid, fs=1000, note="bench 3")
np.savez_compressed("numpy_savez_compressed.npz", t_s=t, u_V=u, y_um=y, valid=valid)
fields = np.zeros(5, dtype=np.dtype([("t_s", "f8"), ("valid", "?"), ("u_V", ">f4"), ("y_um", "i2")], align=True))
fields["t_s"], fields["u_V"], fields["y_um"], fields["valid"] = t, u, y[:, 0], valid
np.save("numpy_structured.npy", fields)

# Five periods of 2 Hz at 200 Hz, the output late by 0.1 rad.
angle = 2 * np.pi * 2 * np.arange(500) / 200
u, y = 50 - 50 * np.cos(angle), 10 - 10 * np.cos(angle - 0.1)
np.savez_compressed("loop.npz", u_V=u.astype("f4"), y_um=y.astype("f4"), fs=200)
