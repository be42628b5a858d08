"""The results as Markdown."""


def ms(seconds):
    return f"{1e3 * seconds:.3g} ms" if seconds < 1.0 else f"{seconds:.3g} s"


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + " --- |" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(str(cell) for cell in row) + " |" for row in rows])


def fractional(result):
    times = result["times"]

    def row(text, ours, peer, difference):
        o, p = times[ours], times[peer]
        return [
            text, f"{ms(o['min_s'])} ({ms(o['median_s'])})", f"{ms(p['min_s'])} ({ms(p['median_s'])})",
            f"**{p['min_s'] / o['min_s']:.3g} ×** ({p['median_s'] / o['median_s']:.3g} ×)",
            f"{result['agreement'][difference]:.0e}",
        ]

    head = ["peer", "hysteron: best (median)", "peer: best (median)", "ratio",
            "largest difference / largest output"]
    rows = [
        row("numpy + scipy.fft, one FFT pair", "hysteron pair", "numpy pair", "numpy pair"),
        row("numpy + scipy.fft, input transform kept", "hysteron kept", "numpy kept", "numpy kept"),
        row("numba G(s) + scipy.fft, one FFT pair", "hysteron pair", "numba pair", "numba pair"),
        row("numba G(s) + scipy.fft, input transform kept", "hysteron kept", "numba kept", "numba kept"),
        row("numba O(N²) recursion, fast-math, merged kernel (Grünwald–Letnikov)",
            "hysteron pair, Grünwald-Letnikov", "numba recursion", "numba recursion"),
    ]
    text = table(head, rows)
    runs = times["hysteron pair"]["runs"]
    return f"{text}\n\nAllocations of hysteron in {2 * runs} evaluations: {result['allocations']}."


def scaling(rows):
    from math import log2

    def row(r):
        n, t = r["samples"], r["times"]
        pair, kept, peer = (t[name]["min_s"] for name in ("hysteron pair", "hysteron kept", "numpy pair"))
        length = r["transform_length"]
        return [
            f"{n:,}".replace(",", " "), ms(pair), f"{1e9 * pair / n:.1f}",
            f"{1e9 * pair / (n * log2(length)):.2f}",
            ms(kept), ms(peer), f"{peer / pair:.3g} ×", r["allocations"],
        ]

    head = ["N", "one FFT pair", "ns per sample", "ns per sample and log₂ L", "input transform kept",
            "numpy + scipy.fft, pair", "ratio", "allocations"]
    return table(head, [row(r) for r in rows])


def columns(rows):
    def row(r):
        pair = r["fft_pair_s"]
        return [
            r["scheme"], ms(pair), ms(r["response_s"]),
            f"{ms(r['column_s'])}: **{r['column_s'] / pair:.2f} ×**",
            ms(r["objective_s"]), ms(r["response_with_tangents_s"]),
            f"{ms(r['jacobian_s'])}: **{r['jacobian_s'] / r['objective_s']:.2f} ×**", r["allocations"],
        ]

    head = ["scheme", "FFT pair alone", "G and delay", "one column (G, FFT pair): over the FFT pair",
            "objective (G, 1 forward, 3 inverse FFTs)", "G, delay and 5 derivatives",
            "Jacobian (all of it, 8 inverse FFTs): over the objective", "allocations"]
    return table(head, [row(r) for r in rows])


def bouc_wen(rows):
    def cost(entry):
        if entry["substeps"] is None:
            return "not reached"
        return f"{entry['ns_per_sample']:.3g} ns ({entry['substeps']})"

    def row(r):
        ours = r["hysteron"]["ns_per_sample"]
        closed = r.get("numba closed form")
        euler = r["numba Euler to 1e-6"]["ns_per_sample"]
        return [
            f"{r['n']:g}", r["samples_per_period"], f"**{ours:.3g} ns**", f"{r['hysteron']['error']:.0e}",
            f"{r['numba Euler']['ns_per_sample']:.3g} ns", f"{r['numba Euler']['error']:.1e}",
            cost(r["numba Euler to 1e-3"]), cost(r["numba Euler to 1e-6"]),
            "" if euler is None else f"{euler / ours:.3g} ×",
            cost(r["numba Runge-Kutta 4 to 1e-6"]), f"{closed['ns_per_sample']:.3g} ns" if closed else "",
        ]

    head = ["n", "samples a period", "hysteron, exact", "its error", "Euler, 1 step a sample", "its error",
            "Euler to 1e-3 (sub-steps)", "Euler to 1e-6 (sub-steps)", "Euler to 1e-6 / hysteron",
            "Runge–Kutta 4 to 1e-6 (sub-steps)", "numba closed form"]
    text = table(head, [row(r) for r in rows])
    return (f"{text}\n\nTimes are per sample; errors are the largest over 14 periods, as a share of the "
            "stroke, against scipy's DOP853 at 1e-12.")


def identification(result):
    ours = [name for name in result if name.startswith("hysteron")]
    scipy = result["scipy"]
    rows = []
    for name in ours:
        r = result[name]
        evaluations = " + ".join(str(s["evaluations"]) for s in r["searches"])
        cost = " / ".join(f"{s['cost']:.4f}" for s in r["searches"])
        rows.append([name, evaluations, f"{r['cpu_s']:.3g} s", f"{r['seconds']:.3g} s", cost])
    rows.append([
        "scipy differential evolution over numba and scipy.fft, 1 process",
        " + ".join(str(n) for n in scipy["evaluations"]), f"{scipy['cpu_s']:.3g} s", "",
        " / ".join(f"{c:.4f}" for c in scipy["cost"]),
    ])
    head = ["", "evaluations, static + dynamic", "processor time", "wall clock",
            "RMSE, static / dynamic [µm]"]
    text = table(head, rows)
    ratio = scipy["cpu_s"] / result["hysteron de-abc, 1 thread"]["cpu_s"]
    least_squares = scipy["cpu_s"] / result["hysteron auto, 2 threads"]["cpu_s"]
    return (f"{text}\n\nProcessor time, scipy over hysteron: **{ratio:.2g} ×** with DE-ABC on one thread, "
            f"{least_squares:.2g} × with the default engine (least squares). hysteron's times include the "
            "choice of each record's start, the standard errors and the scores; scipy's are the two searches "
            "alone, numba's compilation not counted.")


def joint(result):
    """Joint fit: ours from files to file, the peers from arrays to parameters."""
    ours = result["hysteron, fractional"]
    rows = []

    def row(name, r, evaluations, starts, cost, note=""):
        ratio = "" if r is ours else (
            f"**{r['wall_s'] / ours['wall_s']:.3g} ×** ({r['cpu_s'] / ours['cpu_s']:.3g} ×)"
        )
        return [
            name + note, evaluations, starts, f"{r['wall_s']:.3g} s", f"{r['cpu_s']:.3g} s", ratio,
            f"{cost:.9f}" if cost is not None else "",
        ]

    for name in ("hysteron, fractional", "hysteron, default"):
        r = result[name]
        text = "`hysteron identify" + (" --dynamics fractional`" if name.endswith("fractional") else "`")
        rows.append(row(text, r, " + ".join(str(n) for n in r["evaluations"].values()), "", r.get("cost")))
    for name in ("numpy, all samples", "numpy, thinned records first"):
        r = result[name]
        rows.append(row(name, r, f"{r['evaluations']} + {r['jacobians']} Jacobians", r["starts"], r["cost"]))
    head = ["", "evaluations", "starts", "wall clock", "processor time",
            "over hysteron, wall clock (processor time)", "cost on all samples [µm]"]
    text = table(head, rows)
    evolution = []
    for name in ("differential evolution, all parameters searched",
                 "differential evolution, linear ones eliminated"):
        r = result[name]
        evolution.append([
            name, r["dimension"], r["evaluations"], ms(r["seconds"] / r["evaluations"]),
            ms(r["cpu_s"] / r["evaluations"]),
            f"{r['cost']:.4g}", f"{r['whole_run']:,}".replace(",", " "),
            f"{r['extrapolated_s']:.4g} s ({r['extrapolated_cpu_s']:.4g} s)",
            f"**{r['extrapolated_s'] / ours['wall_s']:.3g} ×** "
            f"({r['extrapolated_cpu_s'] / ours['cpu_s']:.3g} ×)",
        ])
    head = ["scipy", "parameters", "evaluations run", "wall clock of one", "processor time of one",
            "cost then reached [µm]", "evaluations of 150 generations of 15 a parameter",
            "whole run, **extrapolated**: wall clock (processor time)", "over hysteron, extrapolated"]
    samples = " + ".join(f"{n:,}".replace(",", " ") for n in result["samples"])
    factors = " and ".join(str(f) for f in result["numpy, thinned records first"]["factors"])
    compilation = result["compilation"]["wall_s"]
    return (
        f"{text}\n\n{samples} samples. hysteron: a process of its own, from CSV files to model file, choice "
        "of the degree, standard errors, intervals and scores included. The peer: from arrays in memory to "
        f"parameters, told the degree, imports and numba's compilation ({compilation:.2g} s) not counted; "
        f"'thinned first' searches on every {factors}th sample behind a low-pass and ends on all. The cost "
        "is that of all samples, worked out by one program for all; the peer's own differs from it by "
        f"{result['agreement']:.0e} (relative).\n\n"
        f"{table(head, evolution)}\n\n"
        "The first is what a user without variable projection would write, one simulation an evaluation; the "
        "second eliminates the linear parameters as the fits above do. Neither run is finished: its time is "
        "that of its evaluations."
    )


def rich_families(result):
    """Plays: ours from files to file, structure included; the peers from arrays to a structure given."""
    ours = result["hysteron"]

    def row(name, r, degree, evaluations):
        ratio = "" if r is ours else (
            f"**{r['wall_s'] / ours['wall_s']:.2g} ×** ({r['cpu_s'] / ours['cpu_s']:.2g} ×)"
        )
        return [
            name, r["plays"], degree, evaluations, f"{r['wall_s']:.3g} s", f"{r['cpu_s']:.3g} s", ratio,
            f"{1e3 * r['training_um']:.1f}", f"{1e3 * r['held_out_um']:.1f}",
        ]

    evaluations = " + ".join(str(n) for n in ours["evaluations"].values())
    rows = [row("`hysteron identify --hysteresis prandtl-ishlinskii`", ours, ours["degree"], evaluations)]
    for r in result["peers"]:
        counts = f"{r['evaluations']}, {r['jacobians']} Jacobians"
        rows.append(row(r["name"], r, result["degree"], counts))
    head = ["", "plays", "degree", "evaluations", "wall clock", "processor time",
            "over hysteron, wall clock (processor time)", "training error [nm]",
            "error on a random drive [nm]"]
    samples = " + ".join(f"{n:,}".replace(",", " ") for n in result["samples"])
    return (
        f"{table(head, rows)}\n\n{samples} samples. hysteron: a process of its own, from CSV files to model "
        "file, search from several starts, choice of half-widths and degree, standard errors, intervals and "
        "scores included; the weights of its plays are tied to a broken line over the half-width. The peers: "
        "one fit from arrays in memory to parameters, from one start near the resonance, told the half-widths"
        f" (uneven, up to the {result['reach_v']:g} V that ours chose), the degree, and the memory that ours "
        "found for each record; imports not counted. In evaluations of scipy's fit those of its finite "
        "differences are counted. Errors are root mean squares by `hysteron validate`, for all models; "
        "nothing was fitted to the random drive."
    )


def joint_scaling(rows):
    def row(r):
        n, records = r["samples"], r["records"]
        cells = [f"{n:,}".replace(",", " "), records]
        for t in r["times"]:
            jacobian = t["jacobian_s"]
            cells += [
                ms(t["objective_s"]), ms(jacobian) if jacobian else "",
                f"{jacobian / t['objective_s']:.2f}" if jacobian else "",
            ]
        total = n * records
        one = r["times"][0]["objective_s"]
        return cells + [f"{1e9 * one / total:.0f}", f"{1e9 * r['hysteresis_s'] / n:.1f}"]

    head = ["samples a record", "records", "objective, 1 thread", "Jacobian", "ratio",
            "objective, 2 threads", "Jacobian", "ratio", "ns per sample, objective, 1 thread",
            "ns per sample, hysteresis pass with derivatives"]
    return table(head, [row(r) for r in rows])


def joint_heading(result):
    lengths = "{:g} s loop and {:g} s sweep".format(*(n / 10_000 for n in result["samples"]))
    return f"### Joint fit: {lengths} at 10 kHz, truth of the model's class, 5 nm of noise"


def rich_families_heading(result):
    lengths = "{:g} s loop and {:g} s sweep".format(*(n / 10_000 for n in result["samples"]))
    return f"### Rich families: {lengths} at 10 kHz, truth outside the class, 5 nm of noise"


def markdown(result):
    m = result["machine"]
    return "\n\n".join([
        f"Machine: {m['processor']}, {m['cores']} cores; Python {m['python']}, numpy {m['numpy']}, "
        f"scipy {m['scipy']}, numba {m['numba']}. Load average {result['load_before']:.1f} before and "
        f"{result['load_after']:.1f} after the run"
        + (" (other programs were running: trust the ratios, and the best more than the median)."
           if max(result["load_before"], result["load_after"]) > m["cores"] else "."),
        f"### Fractional simulation: Eq. 13, 1–100 Hz chirp at 10 kHz, "
        f"N = {result['fractional']['samples']}, one thread",
        fractional(result["fractional"]),
        "### Growth with the length of the record",
        scaling(result["scaling"]),
        f"### Columns of a fit and their derivatives, fractional form with delay, "
        f"N = {result['columns'][0]['samples']}",
        columns(result["columns"]),
        "### Bouc–Wen simulation",
        bouc_wen(result["bouc_wen"]),
        joint_heading(result["joint"]),
        joint(result["joint"]),
        joint_heading(result["joint_short"]),
        joint(result["joint_short"]),
        rich_families_heading(result["rich_families"]),
        rich_families(result["rich_families"]),
        "### Growth of the joint fit",
        joint_scaling(result["joint_scaling"]),
        f"### Identification: {result['identification']['generations']} generations of 50 for each step, "
        "1 Hz loop and 10 s sweep at 10 kHz, full rate",
        identification(result["identification"]),
    ]) + "\n"


BEGIN = "<!-- results of the last `make bench`: written by bench/tables.py -->"
END = "<!-- end of results -->"


def write_into(page, text):
    """Puts the tables between the marks of a page."""
    whole = page.read_text()
    if BEGIN not in whole or END not in whole:
        raise SystemExit(f"error: {page} has no place for the tables\n"
                         f"  try: put the lines '{BEGIN}' and '{END}' into it")
    head, tail = whole.split(BEGIN, 1)[0], whole.split(END, 1)[1]
    page.write_text(f"{head}{BEGIN}\n{text}{END}{tail}")
