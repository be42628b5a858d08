"""A drive computed from a model, played through a zero-order hold on a stage that is not of its class.

The stage is simulated in continuous time by code that shares nothing with hysteron's simulators or its bench
(numpy and scipy, at fifty times the sample rate): an amplifier's lag, sixty plays of unequal width and weight,
a polynomial, creep of many relaxations, two modes, a delay. A 3 s loop and a 10 s sweep of one amplitude with
4 nm of noise, 10 kHz, are identified; the drives for references that were never measured are computed with
`hysteron invert`, the whole reference known, and played. Everything is simulated.

With --stages N further stages follow, whose resonances, lag, delay and creep are drawn at random, and the medians
over all of them.

    python bench/independent_stage.py [--hysteron PROGRAM] [--stages N] [OPTIONS OF identify ...]
"""

import argparse
import json
import pathlib
import subprocess
import tempfile

import numpy as np
from scipy.signal import cont2discrete, lfilter

RATE_HZ = 10_000
FINER = 50
NOISE_UM = 0.004
# Share of a motion from rest that is not scored.
EASED = 0.25


def monotone_parts(u):
    """Bounds of the parts of a signal between its turning points."""
    steps = np.sign(np.diff(u))
    moving = np.flatnonzero(steps)
    turns = moving[1:][steps[moving[1:]] != steps[moving[:-1]]]
    return np.concatenate(([0], turns, [len(u) - 1]))


def plays(u, half_widths, offsets, weights):
    """Sum of plays from rest at u[0], each between u − r + a and u + r + a."""
    bounds = monotone_parts(u)
    out = np.zeros_like(u)
    for r, a, w in zip(half_widths, offsets, weights):
        state = np.clip(0.0, u[0] - r + a, u[0] + r + a)
        for first, last in zip(bounds[:-1], bounds[1:]):
            part = u[first + 1:last + 1]
            if len(part) == 0:
                continue
            values = np.maximum(state, part - r + a) if part[-1] >= u[first] else np.minimum(state, part + r + a)
            out[first + 1:last + 1] += w * values
            state = values[-1]
    return out - out[0] if u[0] == 0 else out


def filtered(numerator, denominator, x, dt):
    """Response of a transfer function to x, joined by straight lines, from rest at x[0]."""
    b, a, _ = cont2discrete((numerator, denominator), dt, method="foh")
    gain = numerator[-1] / denominator[-1]
    return lfilter(b.ravel(), a, x - x[0]) + gain * x[0]


class Stage:
    """Stroke 30 µm at 0 to 10 V."""

    lag_hz, delay_s, creep = 1500.0, 2.7e-4, 0.0016
    modes = ((420.0, 0.035, 0.96), (1310.0, 0.02, 0.04))

    def __init__(self, seed=7):
        draw = np.random.default_rng(seed)
        x = (np.arange(60) + 0.5) / 60
        self.half_widths = 4.6 * x**1.4 * draw.uniform(0.97, 1.03, 60)
        self.offsets = 0.03 * self.half_widths * draw.uniform(-1.0, 1.0, 60)
        weights = np.exp(-2.2 * x) + 0.4 * np.exp(-((x - 0.55) / 0.15) ** 2)
        self.weights = 1.35 * weights / weights.sum() * draw.uniform(0.9, 1.1, 60)

    @classmethod
    def drawn(cls, seed):
        """One of other numbers: resonance 420 to 1200 Hz, lag 1 to 4 kHz, delay 50 to 400 µs."""
        stage, draw = cls(seed), np.random.default_rng(1000 + seed)

        def between(low, high):
            return np.exp(draw.uniform(np.log(low), np.log(high)))

        first_hz, damping = between(420.0, 1200.0), between(0.02, 0.15)
        stage.lag_hz, stage.delay_s = between(1000.0, 4000.0), draw.uniform(5e-5, 4e-4)
        second_hz, share = first_hz * draw.uniform(2.2, 4.0), draw.uniform(0.01, 0.06)
        stage.creep = draw.uniform(0.0008, 0.0024)
        stage.modes = ((first_hz, damping, 1.0 - share), (second_hz, 0.02, share))
        return stage

    def displacement(self, drive_v):
        """At RATE_HZ, of a drive that is held between its samples."""
        dt = 1.0 / (RATE_HZ * FINER)
        held = np.repeat(drive_v, FINER)
        # Exact for a held drive: the lag of an amplifier.
        pole = np.exp(-2 * np.pi * self.lag_hz * dt)
        u = lfilter([0.0, 1 - pole], [1.0, -pole], held - held[0]) + held[0]
        v = 1.7 * u + plays(u, self.half_widths, self.offsets, self.weights)
        v += 0.0012 * v**2 - 2.5e-5 * v**3
        # Creep: the logarithm of time by relaxations of 1 ms to 1000 s, three a decade.
        crept = np.zeros_like(v)
        for time_s in np.logspace(-3, 3, 19):
            crept += filtered([self.creep], [time_s, 1.0], v, dt)
        v = v + crept
        y = np.zeros_like(v)
        for f, damping, share in self.modes:
            w = 2 * np.pi * f
            y += filtered([share * w * w], [1.0, 2 * damping * w, w * w], v, dt)
        delay = int(round(self.delay_s / dt))
        return np.concatenate((np.full(delay, y[0]), y[:-delay]))[::FINER]


def write(path, columns):
    np.savetxt(path, np.column_stack(list(columns.values())), delimiter=",", header=",".join(columns), comments="",
               fmt="%.9g")
    return str(path)


def errors(stage, hysteron, options):
    """RMS errors of the drives of both references in per cent of their strokes."""
    noise = np.random.default_rng(1)
    t = np.arange(3 * RATE_HZ) / RATE_HZ
    sweep_t = np.arange(10 * RATE_HZ) / RATE_HZ
    growth = np.log(100.0) / 10.0
    drives = {
        "loop": 5 * (1 - np.cos(2 * np.pi * t)),
        "sweep": 5 * (1 - np.cos(2 * np.pi * (np.exp(growth * sweep_t) - 1) / growth)),
    }
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        records = []
        for name, u in drives.items():
            y = stage.displacement(u) + noise.normal(0.0, NOISE_UM, len(u))
            records.append(write(folder / f"{name}.csv", {"t_s": np.arange(len(u)) / RATE_HZ, "u_V": u, "y_um": y}))
        model = str(folder / "model.json")
        fit = [hysteron, "identify", *records, "-o", model, "--inter-sample", "hold", *options]
        subprocess.run(fit, check=True, capture_output=True)
        results = {}
        for name, centre, amplitude, f in (("10 µm at 100 Hz", 8.0, 5.0, 100), ("2 µm at 500 Hz", 8.0, 1.0, 500)):
            time_s = np.arange(2 * RATE_HZ) / RATE_HZ
            climb = centre * 0.5 * (1 - np.cos(np.pi * np.minimum(time_s / 0.5, 1.0)))
            motion = amplitude * np.sin(2 * np.pi * f * time_s) * np.clip((time_s - 0.6) / 0.3, 0.0, 1.0)
            wanted = climb + motion
            reference = write(folder / "reference.csv", {"t_s": time_s, "reference_um": wanted})
            drive = str(folder / "drive.csv")
            band = ["--bandwidth", str(min(2 * f + 500, 2000))]
            subprocess.run([hysteron, "invert", model, reference, "-o", drive, "--range", "0:10", *band],
                           check=True, capture_output=True)
            played = np.genfromtxt(drive, delimiter=",", names=True)
            y = stage.displacement(played["u_V"])
            scored = slice(int(EASED * len(y)) + int(0.7 * RATE_HZ), -200)
            error = (y - wanted)[scored]
            error -= error.mean()
            results[name] = 100 * np.sqrt(np.mean(error**2)) / (2 * amplitude)
    return results


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--hysteron", default="target/release/hysteron", help="program to measure")
    parser.add_argument("--stages", type=int, default=0, metavar="N", help="further stages, drawn at random")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    asked, options = parser.parse_known_args()
    stages = [Stage(), *(Stage.drawn(seed) for seed in range(1, asked.stages + 1))]
    results = []
    for stage in stages:
        results.append(errors(stage, asked.hysteron, options))
        if not asked.json:
            told = ", ".join(f"{name}: {percent:.3f} %" for name, percent in results[-1].items())
            print(f"resonance {stage.modes[0][0]:.0f} Hz: {told} of the stroke, rms", flush=True)
    median = {name: float(np.median([result[name] for result in results])) for name in results[0]}
    if asked.json:
        print(json.dumps({"stages": results, "median": median} if asked.stages else results[0]))
    elif asked.stages:
        print("median: " + ", ".join(f"{name}: {percent:.3f} %" for name, percent in median.items()))


if __name__ == "__main__":
    main()
