"""What the Python package costs over the call into the library, and what importing it costs.

The call into the library is that of the native module, which takes the samples as they are and gives arrays;
both are timed side by side, the best of 20, on 100 000 samples.
"""

import subprocess
import sys
import time

import numpy as np

import hysteron_models as hy

SAMPLES = 100_000


def best(work):
    """Shortest time of 20 [ms]."""
    times = []
    for _ in range(20):
        begun = time.perf_counter()
        work()
        times.append(time.perf_counter() - begun)
    return 1e3 * min(times)


record = hy.read("examples/piezo-p885-200hz/identification_1hz.csv")
model = hy.Hammerstein(seed=1).fit(record).model_
drive = 1.8 * (1 - np.cos(2 * np.pi * np.arange(SAMPLES) / 200))
long = hy.Record(drive, 15 * drive - 120, fs=200)

print("| call on 100 000 samples | Python | library | Python over library |")
print("| --- | --- | --- | --- |")
for name, whole, native in [
    ("predict", lambda: model.predict(long), lambda: model._native.predict(long._native)),
    ("simulate", lambda: model.simulate(long), lambda: model._native.simulate(long._native)),
]:
    ours, theirs = best(whole), best(native)
    print(f"| {name} | {ours:.3g} ms | {theirs:.3g} ms | {ours / theirs:.3f} |")

script = "import time, numpy; b = time.perf_counter(); import hysteron_models; print(time.perf_counter() - b)"
seconds = min(
    float(subprocess.run([sys.executable, "-c", script], capture_output=True, text=True).stdout)
    for _ in range(5)
)
print(f"\nimport hysteron_models, NumPy loaded: {seconds:.3f} s")
