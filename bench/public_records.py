"""Held-out errors on measured public records, by hysteresis family.

Each row names the data that a model is identified from, then the data that it is scored on (`hysteron validate`,
offset and initial memory estimated): RMSE in per cent of the stroke. No option but columns and the family, and no
demand on the fit, so that a model that describes nothing is scored, too. In band: share of the scored samples
within the 95 % band of a new measurement of the default, in per cent; "outside" where the model file holds a
model of the misfit; none for a run in parts and for kinds of models without a band. Before: the default of a
force over a displacement until that kind of model was there. The records are read from the folder that
HYSTERON_DATA names (../shared/data by default); their licences are in its README.

    python bench/public_records.py [--hysteron PROGRAM] [--only TEXT]
"""

import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile

FAMILIES = ("prandtl-ishlinskii", "dead-zone-plays", "auto")
DATA = pathlib.Path(os.environ.get("HYSTERON_DATA", "../shared/data"))


class Cut:
    """Rows of a record, without its header."""

    def __init__(self, path, first, last=None):
        self.path, self.first, self.last = path, first, last

    def write(self, folder):
        lines = (DATA / self.path).read_text().splitlines()
        target = folder / f"{pathlib.Path(self.path).stem}_{self.first}.csv"
        target.write_text("\n".join([lines[0], *lines[1:][self.first:self.last]]) + "\n")
        return str(target)


class Sequence:
    """One sequence of the ferrite set, sampled at 16 MHz."""

    def __init__(self, number):
        self.number = number

    def write(self, folder):
        lines = (DATA / "magnetx-3c90/sequences.csv").read_text().splitlines()
        rows = [line.split(",") for line in lines[1:] if line.startswith(f"{self.number},")]
        target = folder / f"sequence_{self.number}.csv"
        text = "".join(f"{62.5e-9 * int(row[3]):.10g},{row[4]},{row[5]}\n" for row in rows)
        target.write_text("t_s,B_T,H_A_per_m\n" + text)
        return str(target)


def columns(drive, output):
    return ["--input", drive, "--output", output]


STACK, SINE = "piezo-p885-200hz/identification_1hz.csv", "piezo-sine-1hz/sine_1hz_150v.csv"
LOOPS, RAMPS = "piezo-michelson-quasistatic/loop_", "piezo-afm-cellhesion-100um/jpk00758_2013-05-27_4x_5umps.csv"
STAGE = "piezo-afm-cellhesion-100um/jpk00758_"
THREE, EIGHT = STAGE + "2015-05-21_3x50um_10_25umps.csv", STAGE + "2016-11-07_8x25um_7umps.csv"
FIFTY, THIRTY, LATER = (
    STAGE + name for name in
    ("2015-10-07_50um_10_25umps.csv", "2016-06-15_30um_10_25umps.csv", "2017-01-16_25um_10umps.csv")
)
OTHER_STAGE, SCANNER = "piezo-afm-cellhesion-100um/jpk01466_2021-06-30_", "piezo-afm-z15um/"
SOFT, FRICTION, FLUID = "hasel-multifreq/sine_", "friction-damper-brfd/", "mr-damper-utfsm/25mm0x"
VOLTS = columns("u_V", "y_um")
FERRITE = columns("B_T", "H_A_per_m")
SWITCH, DAMPER = columns("x_mm", "F_kN"), columns("x_mm", "F_N")
FORCES = (SWITCH, DAMPER)


def scanner(name, numbers):
    return [f"{SCANNER}{name}_0{number}.csv" for number in numbers]


# Name, records identified from, records scored, flags.
CASES = [
    ("P-885 stack, 20 s → next 20 s", [Cut(STACK, 0, 4000)], [Cut(STACK, 4000)], []),
    ("piezo at 1 Hz, ±150 V, 3.7 s → next 3 s", [Cut(SINE, 0, 35000)], [Cut(SINE, 35000)], []),
    ("stack by fringes, 0–100 V → 30–70 V", [LOOPS + "0_100.csv"], [LOOPS + "30_70.csv"], VOLTS),
    ("stack by fringes, 30–70 V → 0–100 V", [LOOPS + "30_70.csv"], [LOOPS + "0_100.csv"], VOLTS),
    ("AFM stage, 2 × 50 µm → third", [Cut(THREE, 0, 28000)], [Cut(THREE, 28000)], VOLTS),
    ("AFM stage, 4 loops → next 4", [Cut(EIGHT, 0, 42185)], [Cut(EIGHT, 42185)], VOLTS),
    ("AFM stage, ramps of 30 µm → 4, 10 µm", [Cut(RAMPS, 0, 48000)], [Cut(RAMPS, 48000)], VOLTS),
    ("AFM stage, 50 µm → 30 µm later", [FIFTY], [THIRTY], VOLTS),
    ("AFM stage, 12–70 V → 66–100 V later", [FIFTY], [LATER], VOLTS),
    ("AFM stage, 12–70, 18–56 V → 66–100 V later", [FIFTY, THIRTY], [LATER], VOLTS),
    ("AFM stage, brain → gel", [OTHER_STAGE + "brain_30um_creep3s.csv"], [OTHER_STAGE + "gel_30um_creep3s.csv"], VOLTS),
    ("AFM scanner, cycles 00–03 → 04–07", scanner("cycle_1_300hz", range(4)), scanner("cycle_1_300hz", range(4, 8)),
     [*VOLTS, "--continued"]),
    ("AFM scanner, ramps 00–05 → 06, 07", scanner("ramps_0p2s", range(6)), scanner("ramps_0p2s", range(6, 8)),
     [*VOLTS, "--continued"]),
    ("HASEL, 0.5, 3.5 → 1.5 Hz", [SOFT + "0p5Hz.csv", SOFT + "3p5Hz.csv"], [SOFT + "1p5Hz.csv"],
     columns("u_cmd_V", "y_mm")),
    ("HASEL, 0.5 → 1.5 Hz", [SOFT + "0p5Hz.csv"], [SOFT + "1p5Hz.csv"], columns("u_cmd_V", "y_mm")),
    ("friction damper, 1.5, 0.5 in → 1 in", [FRICTION + "0.25Hz_1.5in.csv", FRICTION + "0.25Hz_0.5in.csv"],
     [FRICTION + "0.25Hz_1in.csv"], SWITCH),
    ("friction damper, 1 in → 1.5 in", [FRICTION + "0.25Hz_1in.csv", FRICTION + "0.5Hz_1in.csv"],
     [FRICTION + "0.25Hz_1.5in.csv"], SWITCH),
    ("MR damper at 1 A, 0.1, 0.5 → 0.25 Hz", [FLUID + "1Hz1A.csv", FLUID + "5Hz1A.csv"], [FLUID + "25Hz1A.csv"],
     DAMPER),
    ("ferrite 3C90, 50 kHz, 4 sequences → fifth", [Sequence(n) for n in (0, 21, 42, 63)], [Sequence(84)], FERRITE),
    ("ferrite 3C90, 200 kHz, 4 sequences → fifth", [Sequence(n) for n in (9, 30, 51, 72)], [Sequence(93)], FERRITE),
]


def held_out(hysteron, folder, case, choice=()):
    """RMSE of the scored records [% of the stroke], and their share in the band [%]; None where no model was
    identified."""
    _, fitted, scored, flags = case
    paths = [
        [record.write(folder) if not isinstance(record, str) else str(DATA / record) for record in records]
        for records in (fitted, scored)
    ]
    model = str(folder / "model.json")
    fit = [hysteron, "identify", *paths[0], *flags, "-o", model, "--least-fit", "0", *choice]
    if subprocess.run(fit, capture_output=True).returncode != 0:
        return None
    validate = [hysteron, "validate", model, *paths[1], *flags, "--json"]
    told = subprocess.run(validate, capture_output=True, text=True)
    if not told.stdout:
        sys.exit(f"error: {case[0]}: {told.stderr}")
    found = json.loads(told.stdout)
    scores = [found["whole"]] if found.get("whole") else found["records"]
    error = sum(score["rmse_percent_of_stroke"] for score in scores) / len(scores)
    if choice or "--continued" in flags:
        return error, None
    told = subprocess.run([*validate, "--band"], capture_output=True, text=True)
    if not told.stdout:
        return error, None
    scores = json.loads(told.stdout)["records"]
    inside = sum(score["within_band_percent"] * score["samples"] for score in scores)
    outside = " (outside)" if "misfit" in json.loads(pathlib.Path(model).read_text()) else ""
    return error, f"{inside / sum(score['samples'] for score in scores):.1f}{outside}"


def row(hysteron, folder, case):
    """Cells of a row: the default before, the default with its share in the band, the other families."""
    default = held_out(hysteron, folder, case)
    forced = case[3] in FORCES
    before = held_out(hysteron, folder, case, ["--structure", "hammerstein"]) if forced else default
    others = [held_out(hysteron, folder, case, ["--hysteresis", family]) for family in FAMILIES]
    cells = ["none" if one is None else f"{one[0]:.3g}" for one in (before, default, *others)]
    cells.insert(2, (default and default[1]) or "–")
    return cells


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--hysteron", default="target/release/hysteron", help="program to measure")
    parser.add_argument("--only", default="", help="rows that contain this text")
    asked = parser.parse_args()
    if not DATA.is_dir():
        sys.exit(f"error: no records in {DATA}\n  try: HYSTERON_DATA=FOLDER, the folder of the public records")
    print("| identified from → scored on | before | default | in band | plays | plays with dead zones | `auto` |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    for case in CASES:
        if asked.only not in case[0]:
            continue
        with tempfile.TemporaryDirectory() as folder:
            cells = row(asked.hysteron, pathlib.Path(folder), case)
        print(f"| {case[0]} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
