"""LVM files of all layouts, put together here as LabVIEW writes them, and what lvm_read reads from them.

python lvm.py FOLDER writes the files and FOLDER/expected.json.
"""

import sys
from pathlib import Path

import expected

try:
    import lvm_read
    import numpy as np
except ImportError as missing:
    expected.skip(missing)

folder = Path(sys.argv[1])
random = np.random.default_rng(18)


def segment(sep, decimal, x_columns, data, step, start, comment):
    """A segment: its header, and a line a sample."""
    channels, rows = data.shape
    names = ["drive", "sensor", "force"][:channels]
    units = ["Volts", "um", "mN"][:channels]
    show = lambda value: f"{value:.16E}".replace(".", decimal)
    # Where each channel has its x, LabVIEW's entries stand above the channels' columns.
    multiple = x_columns == "Multi"
    between = sep + sep if multiple else sep
    lines = ["Channels" + sep + str(channels) + (sep * (2 * channels - 1) if multiple else "")]
    lines += ["Samples" + sep + between.join([str(rows)] * channels)]
    lines += [
        "Date" + sep + between.join(["2024/02/29"] * channels),
        "Time" + sep + between.join(["12:00:00"] * channels),
    ]
    lines += [
        "Y_Unit_Label" + sep + between.join(units),
        "X_Dimension" + sep + between.join(["Time"] * channels),
    ]
    lines += [
        "X0" + sep + between.join([show(start)] * channels),
        "Delta_X" + sep + between.join([show(step)] * channels),
    ]
    lines += ["***End_of_Header***" + sep]
    head = ["X_Value"] + sum(
        ([name] if i == 0 or x_columns != "Multi" else ["X_Value", name] for i, name in enumerate(names)), []
    )
    lines += [sep.join(head + ["Comment"])]
    for row in range(rows):
        x = "" if x_columns == "No" else f"{start + row * step:.6f}".replace(".", decimal)
        numbers = [show(value) for value in data[:, row]]
        fields = [x] + sum(
            ([n] if i == 0 or x_columns != "Multi" else [x, n] for i, n in enumerate(numbers)), []
        )
        lines.append(sep.join(fields) + (sep + "begun" if comment and row == 0 else ""))
    return lines


number = 0
for separator, sep in (("Tab", "\t"), ("Comma", ","), ("Semicolon", ";")):
    for decimal in ".,":
        for x_columns in ("One", "No", "Multi"):
            for channels in (2, 3):
                for parts in (1, 3):
                    if decimal == sep:
                        continue
                    lines = [
                        "LabVIEW Measurement" + sep,
                        "Writer_Version" + sep + "2",
                        "Reader_Version" + sep + "2",
                        "Separator" + sep + separator,
                        "Decimal_Separator" + sep + decimal,
                        "Multi_Headings" + sep + "Yes",
                        "X_Columns" + sep + x_columns,
                        "Time_Pref" + sep + "Relative",
                        "Operator" + sep + "bench",
                        "***End_of_Header***" + sep,
                    ]
                    # The parts of one measurement follow on one another.
                    values = [random.normal(size=(channels, 20)) for _ in range(parts)]
                    for part, data in enumerate(values):
                        lines += [sep] + segment(
                            sep, decimal, x_columns, data, 2e-4, 20 * part * 2e-4, part == 1
                        )
                    mark = "comma" if decimal == "," else "point"
                    name = f"{number}_{separator}_{mark}_{x_columns}_{channels}_{parts}.lvm"
                    number += 1
                    text = ("\r\n" if number % 2 else "\n").join(lines) + "\n"
                    (folder / name).write_text(text, newline="")

cases = []
for path in sorted(folder.glob("*.lvm")):
    # lvm_read tells the separator by one letter of its name; only tabs are its own.
    text = path.read_text()
    sep = {"Tab": "\t", "Comma": ",", "Semicolon": ";"}[path.name.split("_")[1]]
    lines = text.splitlines(keepends=True)
    if path.name.split("_")[2] == "comma":
        lines = [
            line.replace("Decimal_Separator" + sep + ",", "Decimal_Separator" + sep + ",") for line in lines
        ]
    read = lvm_read.read_lines([line.replace(sep, "\t") for line in lines], separator="\t")
    columns = []
    parts = [read[i] for i in range(read["Segments"])]
    multiple = "_Multi_" in path.name
    for i, name in enumerate(["drive", "sensor", "force"][: parts[0]["Channels"]]):
        at = (2 * i + 1) if multiple else i + ("_No_" not in path.name)
        data = np.concatenate([part["data"][:, at] for part in parts])
        columns.append(
            expected.column(
                f"{name}/{name}" if multiple else name,
                data,
                unit=["V", "um", "mN"][i],
                sample_rate_hz=1 / 2e-4,
            )
        )
    cases.append({"file": path.name, "columns": columns})
expected.write(folder, cases)
