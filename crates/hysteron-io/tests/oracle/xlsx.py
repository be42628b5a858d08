"""Workbooks that openpyxl and pandas write, and what pandas reads from them.

python xlsx.py FOLDER writes the files and FOLDER/expected.json.
"""

import datetime
import sys
from pathlib import Path

import expected

try:
    import numpy as np
    import openpyxl
    import pandas
except ImportError as missing:
    expected.skip(missing)

folder = Path(sys.argv[1])
random = np.random.default_rng(18)
cases = []


def add(name, sheets):
    """A file, the columns of its sheets (name: first row of the header, columns) as pandas reads them."""
    path = folder / f"{name}.xlsx"
    columns = []
    for sheet, (skip, names) in sheets.items():
        table = pandas.read_excel(path, sheet_name=sheet, skiprows=skip, header=0 if names is None else None)
        for i, title in enumerate(table.columns):
            values = table[title]
            if pandas.api.types.is_datetime64_any_dtype(values):
                continue
            if pandas.api.types.is_numeric_dtype(values) and not values.isna().any():
                columns.append(
                    expected.column(f"{sheet}!{title if names is None else names[i]}", values.astype(float))
                )
    assert columns, name
    cases.append({"file": path.name, "columns": columns})


def table(rows):
    return {
        "t_s": np.arange(rows) / 1000,
        "u_V": random.normal(size=rows) * 10.0 ** random.integers(-12, 12, rows),
        "y_um": random.normal(size=rows),
    }


for rows in (2, 30, 500):
    for sheet in ("Sheet1", "run 1 (µm)"):
        for dtype in ("float64", "int32", "bool"):
            data = pandas.DataFrame(table(rows))
            data["n"] = random.integers(0, 2, rows).astype(dtype)
            data.to_excel(folder / f"pandas_{len(cases)}.xlsx", sheet_name=sheet, index=False)
            add(f"pandas_{len(cases)}", {sheet: (0, None)})

# Several sheets, of different lengths.
for sheets in (2, 3):
    name = f"sheets_{sheets}"
    with pandas.ExcelWriter(folder / f"{name}.xlsx") as writer:
        for i in range(sheets):
            pandas.DataFrame(table(20 + 10 * i)).to_excel(writer, sheet_name=f"S{i}", index=False)
    add(name, {f"S{i}": (0, None) for i in range(sheets)})


def workbook(name, fill):
    book = openpyxl.Workbook()
    fill(book.active)
    book.save(folder / f"{name}.xlsx")


def offset(sheet, start_row, start_column, header=True, rows=25):
    for i, (title, values) in enumerate(table(rows).items()):
        if header:
            sheet.cell(start_row, start_column + i, title)
        for k, value in enumerate(values):
            sheet.cell(start_row + k + int(header), start_column + i, float(value))


for row in (1, 4):
    for column in (1, 3):
        workbook(f"offset_{row}_{column}", lambda sheet: offset(sheet, row, column))
        add(f"offset_{row}_{column}", {"Sheet": (row - 1, None)})
        workbook(f"letters_{row}_{column}", lambda sheet: offset(sheet, row, column, header=False))
        letters = [openpyxl.utils.get_column_letter(i + 1) for i in range(column + 2)]
        add(f"letters_{row}_{column}", {"Sheet": (row - 1, letters)})


def comments(sheet):
    sheet.append(["# made on the bench"])
    sheet.append(["u_V", "y_um", "note"])
    for k in range(10):
        sheet.append([float(random.normal()), float(random.normal()), "ok"])


workbook("comments", comments)
add("comments", {"Sheet": (1, None)})

# Dates: seconds since the first.
start = datetime.datetime(2024, 2, 29, 12)
stamps = [start + datetime.timedelta(seconds=int(s)) for s in np.arange(40) * 5]
data = pandas.DataFrame({"time": stamps, "u_V": random.normal(size=40), "y_um": random.normal(size=40)})
data.to_excel(folder / "dates.xlsx", index=False)
add("dates", {"Sheet1": (0, None)})

# Written cell by cell without the shared strings.
book = openpyxl.Workbook(write_only=True)
sheet = book.create_sheet("streamed")
sheet.append(["u_V", "y_um"])
for k in range(300):
    sheet.append([float(random.normal()), k])
book.save(folder / "streamed.xlsx")
add("streamed", {"streamed": (0, None)})
expected.write(folder, cases)
