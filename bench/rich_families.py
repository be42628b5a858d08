"""Plays with fractional dynamics, from a 3 s loop and a 10 s sweep at 10 kHz whose truth is outside the
class: `hysteron identify` from CSV files to a model file, beside two fits in numpy and scipy of a structure
that is given to them."""

import json

import numpy as np

import joint
from joint import RATE_HZ, clocks, command, since
from peers import plays

# All keys are optional: the default truth of the rig, asymmetric plays and two resonances.
DEFAULT_TRUTH = {}
OPTIONS = ["--hysteresis", "prandtl-ishlinskii"]
DEGREE = 3
# Near the resonance of usual stacks, little damped: both peers find the same optimum from here.
START_HZ, START_DAMPING = 500.0, 0.05
# Ratio of the training errors from which fits are not of one quality.
ALIKE = 2.0
# Largest relative differences of the training errors of peers with the same plays, which have the same
# optimum, and of a peer's own training error from that of its model file.
SAME_OPTIMUM, SAME_MODEL = 0.02, 0.02


def random_record(folder, quick):
    """A held-out record of the same bench: noise to 100 Hz over the whole range."""
    drive, made = folder / "random.csv", folder / "random"
    command(
        "excite", "random", "--to", 100, "--duration", 1 if quick else 4, "--sample-rate", RATE_HZ,
        "--high", 10, "--soft-start", 0.2, "--seed", 2, "--out", drive,
    )
    command(
        "rig", "--truth", folder / "truth.json", "--drive", drive, "--out-dir", made, "--seed", 2,
    )
    return next(made.glob("*.csv"))


def quantities(named):
    return {name: {"value": float(value), "unit": unit} for name, (value, unit) in named.items()}


def term(coefficient, order):
    return {
        "coefficient": {"value": float(coefficient), "unit": f"s^{order}"},
        "order": {"value": float(order), "unit": "1"},
    }


def dynamics(theta):
    """H as a ratio of sums of powers of s: numerator and denominator times s^mu, over the highest term."""
    ln_b2, q2, ln_b1, q1, _, ln_creep, mu = theta
    b2 = np.exp(ln_b2) * plays.REFERENCE**-q2
    b1 = np.exp(ln_b1) * plays.REFERENCE**-q1
    creep = np.exp(ln_creep) * plays.CREEP_REFERENCE**mu
    return {
        "kind": "fractional",
        "numerator": [term(creep / b2, 0.0), term(1.0 / b2, mu)],
        "denominator": [term(1.0 / b2, mu), term(b1 / b2, q1 + mu), term(1.0, q2 + mu)],
    }


POWERS = ("linear", "quadratic", "cubic")
KEPT = ("format", "version", "kind", "units", "scheme", "sample_rate_hz", "normalisation", "start")


def write_model(path, like, solution, thresholds):
    """A peer's fit as a model file, so that one program scores all."""
    named = {name: (c, "um/V" + (f"^{p}" if p > 1 else "")) for p, (name, c) in enumerate(
        zip(POWERS, solution.polynomial, strict=True), 1)}
    named |= {f"threshold_{k}": (r, "V") for k, r in enumerate(thresholds, 1)}
    named |= {f"weight_{k}": (w, "um/V") for k, w in enumerate(solution.weights, 1)}
    model = {key: like[key] for key in KEPT} | {
        "hysteresis": {"kind": "prandtl-ishlinskii", "parameters": quantities(named)},
        "dynamics": dynamics(solution.theta),
        "delay": {"value": float(solution.theta[4] * plays.DELAY_UNIT_S), "unit": "s"},
        "offset": {"value": 0.0, "unit": "um"},
    }
    path.write_text(json.dumps(model))


def scores(model, training, held_out):
    """Errors by `hysteron validate`: of the training records together, and of the held-out one [um]."""
    text, _ = command("validate", model, *training, held_out, "--json")
    rows = json.loads(text)["records"]
    squares = sum(row["samples"] * row["rmse_um"] ** 2 for row in rows[:-1])
    samples = sum(row["samples"] for row in rows[:-1])
    return {"training_um": (squares / samples) ** 0.5, "held_out_um": rows[-1]["rmse_um"]}


def given(found, arrays):
    """Half-widths of ours, of which the peers are told the largest, and the records with the memory that ours
    found."""
    parameters = found["parameters"]
    half_widths = [value for name, value in parameters.items() if name.startswith("threshold_")]
    memories = [parameters.get(f"memory_{i}", 0.0) for i in range(1, len(arrays) + 1)]
    return half_widths, [plays.Record(u, y, memory) for (u, y), memory in zip(arrays, memories, strict=True)]


def timed(fit, records, thresholds, runs):
    """The fastest of some runs, and its solution."""
    structure = plays.Structure(thresholds, DEGREE)
    start = plays.rough_start(START_HZ, START_DAMPING)
    best = None
    for _ in range(runs):
        begin = clocks()
        solution = fit(records, RATE_HZ, structure, start)
        took = since(begin)
        if best is None or took["wall_s"] < best["wall_s"]:
            best = took
    return solution, best | {"evaluations": solution.evaluations, "jacobians": solution.jacobians}


def check(result):
    """Times of fits of different quality are not compared."""
    ours = result["hysteron"]["training_um"]
    for row in result["peers"]:
        ratio = row["training_um"] / ours
        if not 1.0 / ALIKE < ratio < ALIKE:
            raise SystemExit(
                f"error: {row['name']}, {row['plays']} plays: training error {ratio:.2f} times ours: not "
                "fits of one quality"
            )
        if abs(row["own_rms_um"] / row["training_um"] - 1.0) > SAME_MODEL:
            raise SystemExit(
                f"error: {row['name']}, {row['plays']} plays: training error {row['own_rms_um']} um by the "
                f"peer, {row['training_um']} um by hysteron validate: not the same model"
            )
    for count in {row["plays"] for row in result["peers"]}:
        costs = [row["own_rms_um"] for row in result["peers"] if row["plays"] == count]
        if max(costs) > (1.0 + SAME_OPTIMUM) * min(costs):
            raise SystemExit(f"error: {count} plays: the peers end at different optima, {costs} um")


def bench(folder, quick):
    files, arrays = joint.make_records(folder, quick, DEFAULT_TRUTH)
    held_out = random_record(folder, quick)
    found = joint.ours(files, folder, OPTIONS, 1 if quick else 3)
    like = json.loads((folder / "model.json").read_text())
    half_widths, records = given(found, arrays)
    reach = max(half_widths)
    result = {"samples": [len(u) for u, _ in arrays], "reach_v": reach, "degree": DEGREE, "peers": []}
    del found["parameters"]
    result["hysteron"] = found | {"plays": len(half_widths)}
    result["hysteron"] |= scores(folder / "model.json", files, held_out)
    contestants = [
        ("scipy, all samples", plays.plain, [12] if quick else [12, 24, 40], 1),
        ("numpy, same algorithm", plays.gauss_newton, [12, 24, 40], 1 if quick else 3),
    ]
    for name, fit, counts, runs in contestants:
        for count in counts:
            thresholds = plays.uneven_thresholds(count, reach)
            solution, row = timed(fit, records, thresholds, runs)
            write_model(folder / "peer.json", like, solution, thresholds)
            row |= {"name": name, "plays": count, "own_rms_um": solution.rms}
            result["peers"].append(row | scores(folder / "peer.json", files, held_out))
    check(result)
    return result
