"""Workbooks that pandas, openpyxl, XlsxWriter and PyExcelerate write, and what pandas and openpyxl read from
them.

python xlsx.py FOLDER writes the files and FOLDER/expected.json.
"""

import datetime
import math
import sys
from pathlib import Path

import expected

try:
    import numpy as np
    import openpyxl
    import pandas
    import workbooks
    from workbooks import Error, Formula, Sheet
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


# The same sheets by several programs; openpyxl reads what they wrote.


def number(value, first, epoch):
    """A cell as its double; a date in seconds since the first one."""
    if isinstance(value, datetime.datetime):
        days = openpyxl.utils.datetime.to_excel(value, epoch)
        return (days - openpyxl.utils.datetime.to_excel(first, epoch)) * 86400.0
    if isinstance(value, datetime.timedelta):
        return value / datetime.timedelta(seconds=1)
    return float(value)


def below(sheet, header, letter):
    """Values below a header, or of a column; cells without any are left out."""
    cells = [cell for row in sheet.iter_rows() for cell in row if cell.value is not None]
    if letter is not None:
        return [cell.value for cell in cells if cell.column_letter == letter]
    [top] = [cell for cell in cells if cell.value == header]
    return [cell.value for cell in cells if cell.column == top.column and cell.row > top.row]


def compared(name, write, sheets, columns, refused=(), **how):
    """A file, and the columns to compare: the path of each, header or letter, and the values written."""
    path = folder / f"{name}.xlsx"
    write(path, sheets, **how)
    book = openpyxl.load_workbook(path, data_only=True)
    told = []
    for sheet, header, values in columns:
        own = header.removeprefix("letter ")
        read = below(book[sheet], own, own if own != header else None)
        numbers = [number(value, read[0], book.epoch) for value in read]
        written = [number(value, values[0], book.epoch) for value in values]
        # Some programs write 15 or 16 digits: what is compared bit by bit is what stands in the file.
        assert len(numbers) == len(written), (name, header)
        assert all(math.isclose(a, b, rel_tol=1e-14) for a, b in zip(numbers, written)), (name, header)
        is_time = isinstance(read[0], (datetime.datetime, datetime.timedelta))
        told.append(expected.column(f"{sheet}!{own}", np.array(numbers), "s" if is_time else None))
    cases.append({"file": path.name, "columns": told, "refused": list(refused)})


def doubles(rows=12, low=-300, high=98):
    return [float(x) for x in random.normal(size=rows) * 10.0 ** random.integers(low, high, rows)]


def whole(rows=12, limit=2**31):
    return [int(n) for n in random.integers(-limit, limit, rows)]


def dates(rows=12):
    first = datetime.datetime(2024, 2, 29, 12) + workbooks.STEP * int(random.integers(0, 1 << 20))
    return [first + workbooks.STEP * k for k in range(rows)]


def durations(rows=12):
    return [workbooks.STEP * k for k in range(3, rows + 3)]


def texts(rows=12):
    return [["ok", "broken", 'm² <&> "x"'][k % 3] for k in range(rows)]


def plain(kinds, name="run", row=1, column=1):
    """A sheet of columns under headers, all of which are compared."""
    columns = dict(kinds)
    sheet = Sheet(name).table(columns, row, column)
    return [sheet], [(name, header, values) for header, values in columns.items()]


HEADERS = [
    ("t_s", "u_V", "y_um"),
    ("t [s]", "u [V]", "y [µm]"),
    ("time", "drive voltage", "путь_um"),
    ("t_s", "u_cmd_V", 'a<b>&"c"_um'),
]
SHEETS = ["run", "Messung 1 (µm)", "it's & <that>", "0815", "シート"]
FORMATS = [
    "0.00E+00",
    '0.000 "mm"',
    '#,##0.00" s"',
    "0.0%",
    '[Red]0.00;[Blue]-0.00 "d"',
    '"Day" 0',
    "# ?/?",
    "@",
]


def variants():
    """Sheets, what is compared of them, and what must be refused; names of programs that cannot write
    them."""
    for headers in HEADERS:
        yield "headers", *plain(zip(headers, ([k / 8 for k in range(12)], doubles(), doubles()))), (), ()
    for name in SHEETS:
        # PyExcelerate does not escape them.
        without = ("pyexcelerate",) if "&" in name else ()
        yield "sheet", *plain({"u_V": doubles(), "y_um": whole()}, name), (), without
    for rows in (2, 3, 700):
        yield "rows", *plain({"u_V": doubles(rows), "y_um": doubles(rows, -3, 3)}), (), ()
    yield (
        "small",
        *plain({"u_V": doubles(12, -307, -290), "y_um": [5e-324 * 3**k for k in range(12)]}),
        (),
        (),
    )
    yield "large", *plain({"u_V": doubles(12, 80, 98), "y_um": whole(12, 2**62)}), (), ()
    mixed = [value for pair in zip(whole(6), doubles(6)) for value in pair]
    yield "mixed", *plain({"u_V": mixed, "y_um": [1, 2.5, 3, -4, 0, 7e-9] * 2}), (), ()
    flags = [bool(k % 3) for k in range(12)]
    yield "flags", *plain({"u_V": doubles(), "y_um": doubles(), "valid": flags}), (), ()
    flags = [bool(k % 2) if k % 3 else 3.5 * k for k in range(12)]
    yield "flags_and_numbers", *plain({"u_V": doubles(), "y_um": flags}), (), ()
    for row, column in [(3, 1), (7, 4), (1, 27)]:
        yield "offset", *plain({"u_V": doubles(), "y_um": doubles()}, "run", row, column), (), ()
    for row, column in [(1, 1), (5, 3), (2, 26)]:
        letters = [openpyxl.utils.get_column_letter(column + i) for i in range(2)]
        values = [doubles(), whole()]
        sheet = Sheet("run").put(row, column, values[0]).put(row, column + 1, values[1])
        yield "letters", [sheet], [("run", f"letter {a}", v) for a, v in zip(letters, values)], (), ()
    for shown in FORMATS:
        [sheet], columns = plain({"u_V": doubles(12, -3, 3), "y_um": whole()})
        sheet.formats = {1: shown, 2: shown}
        yield "format", [sheet], columns, (), ("pyexcelerate",)
    for stamps in (dates(), durations()):
        yield "time", *plain({"time": stamps, "u_V": doubles(), "y_um": doubles()}), (), ("pyexcelerate",)
    yield "dates_and_numbers", *plain({"u_V": doubles()}), (), ()
    [sheet], columns = plain({"u_V": doubles(), "y_um": doubles()})
    sheet.put(1, 3, ["when", *dates(6), *doubles(6)])
    yield "dates_and_numbers", [sheet], columns, ["run!when"], ("pyexcelerate",)
    # Lines of text above and below, empty lines between, remarks beside.
    sheet = Sheet("run").put(1, 1, ["# made on the bench", "% again"])
    sheet.table({"u_V": doubles(), "y_um": doubles()}, 4)
    columns = [
        ("run", own, [sheet.cells[5 + k, i] for k in range(12)]) for i, own in ((1, "u_V"), (2, "y_um"))
    ]
    yield "comments", [sheet], columns, (), ()
    sheet = Sheet("run")
    columns = {"u_V": doubles(), "y_um": doubles()}
    for i, (header, values) in enumerate(columns.items()):
        sheet.put(2, 1 + i, [header, None, *values[:5], None, None, *values[5:]])
    yield "empty_rows", [sheet], [("run", *own) for own in columns.items()], (), ()
    [sheet], columns = plain({"u_V": doubles(), "y_um": doubles()})
    sheet.put(3, 5, ["a remark beside", 17.0])
    yield "remarks", [sheet], columns, (), ()
    [sheet], columns = plain({"u_V": doubles(), "y_um": doubles()})
    sheet.put(1, 3, ["note", *texts()])
    yield "texts", [sheet], columns, ["run!note"], ()
    sheet = Sheet("run").table(
        {"u_V": doubles(), "y_um": doubles(), "gaps": [1.0, 2.0, None, None, 5.0, 6.0]}
    )
    columns = [("run", "u_V", [sheet.cells[2 + k, 1] for k in range(12)])]
    yield "gaps", [sheet], columns, ["run!gaps"], ()
    [sheet], columns = plain({"u_V": doubles(), "y_um": doubles()})
    sheet.put(1, 3, ["ratio", *doubles(4), Error("#DIV/0!"), *doubles(7)])
    yield "errors", [sheet], columns, ["run!ratio"], ("pyexcelerate",)
    values = [float(k) for k in range(1, 13)]
    sheet = Sheet("run").table(
        {"u_V": values, "y_um": [Formula(f"=SQRT(A{k + 2})", math.sqrt(k + 1)) for k in range(12)]}
    )
    columns = [("run", "u_V", values), ("run", "y_um", [math.sqrt(value) for value in values])]
    yield "formulas", [sheet], columns, (), ("openpyxl", "pyexcelerate")
    sheet.put(1, 3, ["verdict", *[Formula('=IF(A2>0,"up","down")', "up")] * 12])
    yield "formulas_of_texts", [sheet], columns, ["run!verdict"], ("openpyxl", "pyexcelerate")
    [sheet], columns = plain({"u_V": doubles(), "y_um": doubles()})
    sheet.put(1, 3, ["never", *[Formula("=A2*2", None)] * 12])
    yield "formulas_without_values", [sheet], columns, ["run!never"], ("xlsxwriter", "pyexcelerate")
    # A header over two columns, of which it names the first.
    sheet = Sheet("run", merged=["B1:C1"])
    columns = [("run", "u_V", doubles()), ("run", "y_um", doubles())]
    sheet.put(1, 1, ["u_V", *columns[0][2]]).put(1, 2, ["y_um", *columns[1][2]]).put(2, 3, doubles())
    yield "merged", [sheet], columns, (), ("pyexcelerate",)
    for count in (2, 5):
        sheets, columns = [], []
        for i in range(count):
            own, of_own = plain({"u_V": doubles(10 + i), "y_um": doubles(10 + i)}, f"S{i + 1}")
            sheets += own
            columns += of_own
        yield "sheets", sheets, columns, (), ()
        sheets[1].hidden, sheets[0].hidden_rows = True, (3, 4)
        yield "hidden", sheets, columns, (), ("pyexcelerate",)
    wide = {f"c{i}_V": doubles(4) for i in range(702)}
    [sheet], columns = plain(wide)
    yield "wide", [sheet], [columns[i] for i in (0, 25, 26, 51, 52, 700, 701)], (), ()


count = 0
for kind, sheets, columns, refused, without in variants():
    for program, write in (
        ("openpyxl", workbooks.by_openpyxl),
        ("xlsxwriter", workbooks.by_xlsxwriter),
        ("pyexcelerate", workbooks.by_pyexcelerate),
    ):
        if program not in without:
            count += 1
            compared(f"{program}_{count}_{kind}", write, sheets, columns, refused)

# The other epoch, workbooks written row by row, and what spreadsheets hold beside numbers.
stamped = plain({"time": dates(), "u_V": doubles(), "y_um": doubles()})
numbered = plain({"t_s": [k / 8 for k in range(40)], "u_V": doubles(40), "y_um": doubles(40)})
for program, write in (("openpyxl", workbooks.by_openpyxl), ("xlsxwriter", workbooks.by_xlsxwriter)):
    compared(f"{program}_1904", write, *stamped, date1904=True)
    compared(f"{program}_streamed", write, *numbered, streamed=True)
compared("xlsxwriter_decorated", workbooks.by_xlsxwriter, *numbered, decorated=True)

expected.write(folder, cases)
