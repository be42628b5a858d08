"""Sheets that several programs write: what stands in which cell, and how each of them puts it into a file."""

import datetime
from dataclasses import dataclass, field

import openpyxl
import xlsxwriter
from pyexcelerate import Workbook as Excelerate

#: 1/1024 of a day is a whole number of milliseconds and a short binary fraction.
STEP = datetime.timedelta(days=1) / 1024


@dataclass
class Error:
    """A cell that shows an error."""

    code: str


@dataclass
class Formula:
    """A formula and the value that the program computed."""

    text: str
    value: object


@dataclass
class Sheet:
    """Cells by row and column from 1, and how the sheet looks."""

    name: str
    cells: dict = field(default_factory=dict)
    #: Number formats by column.
    formats: dict = field(default_factory=dict)
    #: Ranges `A1:B1` that are merged.
    merged: list = field(default_factory=list)
    hidden: bool = False
    hidden_rows: tuple = ()

    def put(self, row, column, values):
        """Values below one another; `None` leaves a cell empty."""
        for k, value in enumerate(values):
            if value is not None:
                self.cells[row + k, column] = value
        return self

    def table(self, columns, row=1, column=1):
        """Columns side by side, each under its header."""
        for i, (header, values) in enumerate(columns.items()):
            self.put(row, column + i, [header, *values])
        return self


def default_format(value):
    if isinstance(value, datetime.timedelta):
        return "[h]:mm:ss.000"
    if isinstance(value, datetime.datetime):
        return "yyyy-mm-dd hh:mm:ss.000"
    return None


def by_openpyxl(path, sheets, date1904=False, streamed=False):
    book = openpyxl.Workbook(write_only=streamed)
    if not streamed:
        book.remove(book.active)
    if date1904:
        book.epoch = openpyxl.utils.datetime.CALENDAR_MAC_1904
    for own in sheets:
        sheet = book.create_sheet(own.name)
        if own.hidden:
            sheet.sheet_state = "veryHidden"
        if streamed:
            rows = max(row for row, _ in own.cells)
            columns = max(column for _, column in own.cells)
            for row in range(1, rows + 1):
                sheet.append([own.cells.get((row, column)) for column in range(1, columns + 1)])
            continue
        for (row, column), value in own.cells.items():
            if isinstance(value, Error):
                value = value.code
            elif isinstance(value, Formula):
                # Which openpyxl does not compute.
                value = value.text
            cell = sheet.cell(row, column, value)
            shown = own.formats.get(column, default_format(value))
            if shown:
                cell.number_format = shown
        for cells in own.merged:
            sheet.merge_cells(cells)
        for row in own.hidden_rows:
            sheet.row_dimensions[row].hidden = True
    book.save(path)


def by_xlsxwriter(path, sheets, date1904=False, streamed=False, decorated=False):
    book = xlsxwriter.Workbook(path, {"date_1904": date1904, "constant_memory": streamed})
    for own in sheets:
        sheet = book.add_worksheet(own.name)
        if own.hidden:
            sheet.very_hidden()
        merged = {}
        for cells in own.merged:
            min_column, min_row, _, _ = openpyxl.utils.range_boundaries(cells)
            merged[min_row, min_column] = cells
        for (row, column), value in sorted(own.cells.items()):
            shown = own.formats.get(column, default_format(value))
            how = book.add_format({"num_format": shown}) if shown else None
            if (row, column) in merged:
                sheet.merge_range(merged[row, column], value, how)
            elif isinstance(value, Error):
                sheet.write_formula(row - 1, column - 1, "=1/0", how, value.code)
            elif isinstance(value, Formula):
                sheet.write_formula(row - 1, column - 1, value.text, how, value.value)
            else:
                sheet.write(row - 1, column - 1, value, how)
        for row in own.hidden_rows:
            sheet.set_row(row - 1, None, None, {"hidden": True})
        if decorated:
            decorate(book, sheet, own)
    book.close()


def decorate(book, sheet, own):
    """What stands beside the numbers of a sheet: a table, a remark, a picture of the numbers, rules of
    colour."""
    rows = max(row for row, _ in own.cells)
    columns = max(column for _, column in own.cells)
    headers = [{"header": own.cells[1, column]} for column in range(1, columns + 1)]
    sheet.add_table(0, 0, rows - 1, columns - 1, {"columns": headers})
    sheet.write_comment(1, 1, "the first sample")
    sheet.freeze_panes(1, 0)
    sheet.conditional_format(1, 1, rows - 1, 1, {"type": "data_bar"})
    sheet.data_validation(1, 2, rows - 1, 2, {"validate": "decimal", "criteria": ">", "value": -1e9})
    chart = book.add_chart({"type": "scatter"})
    chart.add_series({"categories": [own.name, 1, 1, rows - 1, 1], "values": [own.name, 1, 2, rows - 1, 2]})
    sheet.insert_chart(2, 6, chart)
    alone = book.add_chart({"type": "line"})
    alone.add_series({"values": [own.name, 1, 1, rows - 1, 1]})
    book.add_chartsheet("chart").set_chart(alone)


def by_pyexcelerate(path, sheets):
    book = Excelerate()
    for own in sheets:
        sheet = book.new_sheet(own.name)
        for (row, column), value in own.cells.items():
            sheet.set_cell_value(row, column, value)
    book.save(str(path))
