"""Writes the workbooks of this folder and `truth.json`, what openpyxl and xlrd find in them.

    python3 -m venv venv && venv/bin/pip install openpyxl==3.1.5 xlsxwriter==3.3.1 xlwt==1.3.0 xlrd==2.0.2
    venv/bin/python make.py

Made up by formula, and free of rights.
"""

import datetime
import json
import math
import pathlib
import struct

import openpyxl
import xlrd
import xlsxwriter
import xlwt

HERE = pathlib.Path(__file__).parent
ROWS = 120
CHANNELS = ["door x", "door y", "door z"]
DAY_S = 86400.0


def sample(channel, row):
    """A number with all its digits, one with few, and a whole one in turn."""
    value = -30 * math.sin(math.pi * (row - 20) / 70) if 20 <= row < 90 else 0.01 * math.sin(row)
    value *= 1 + channel / 3
    # No negative zero, which openpyxl reads as a plain one.
    return [value, round(value, 2), float(round(value)), round(value, 3)][row % 4] + 0.0


def time_s(row):
    return round(row * 1e-4 - 1e-3, 4)


def by_openpyxl():
    book = openpyxl.Workbook()
    sheet = book.active
    sheet.title = "Data"
    sheet.append(["Test no", 7292])
    sheet.append(["Laboratory", "A laboratory"])
    sheet.append(["Test date", datetime.date(2026, 1, 15)])
    sheet.append([])
    sheet.append(["Time", *CHANNELS])
    sheet.append(["s", "g", "g", "g"])
    for row in range(ROWS):
        sheet.append([time_s(row), *(sample(channel, row) for channel in range(3))])
    book.create_sheet("Empty")
    book.save(HERE / "openpyxl.xlsx")


def by_xlsxwriter():
    """Times of day, texts that cells share, formulas with their results."""
    book = xlsxwriter.Workbook(HERE / "xlsxwriter.xlsx")
    clock = book.add_format({"num_format": "hh:mm:ss.000"})
    sheet = book.add_worksheet("Data")
    sheet.write_row(0, 0, ["Time", *(f"{name} [g]" for name in CHANNELS)])
    for row in range(ROWS):
        sheet.write(row + 1, 0, 0.5 + row * 1e-4 / DAY_S, clock)
        sheet.write_row(row + 1, 1, [sample(channel, row) for channel in range(3)])
    book.close()
    strip_the_wish_to_compute(HERE / "xlsxwriter.xlsx")


def strip_the_wish_to_compute(path):
    """XlsxWriter asks each program to compute its formulas; a program that did no longer does."""
    import zipfile

    with zipfile.ZipFile(path) as before:
        parts = {name: before.read(name) for name in before.namelist()}
    parts["xl/workbook.xml"] = parts["xl/workbook.xml"].replace(b' fullCalcOnLoad="1"', b"")
    sheet = parts["xl/worksheets/sheet1.xml"].decode()
    # The last channel becomes a formula whose result is stored.
    sheet = sheet.replace('<c r="D2">', '<c r="D2"><f>1*1</f>')
    parts["xl/worksheets/sheet1.xml"] = sheet.encode()
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as after:
        for name, data in parts.items():
            after.writestr(zipfile.ZipInfo(name, (2026, 1, 15, 10, 0, 0)), data, zipfile.ZIP_DEFLATED)


def by_xlwt(name, dated):
    book = xlwt.Workbook(encoding="utf-8")
    sheet = book.add_sheet("Daten")
    clock = xlwt.easyxf(num_format_str="yyyy-mm-dd hh:mm:ss.000")
    sheet.write(0, 0, "Time" if dated else "Time [s]")
    for channel, label in enumerate(CHANNELS):
        sheet.write(0, 1 + channel, f"{label} [g]")
    for row in range(ROWS):
        if dated:
            sheet.write(1 + row, 0, 46037.5 + row * 1e-4 / DAY_S, clock)
        else:
            sheet.write(1 + row, 0, time_s(row))
        for channel in range(3):
            sheet.write(1 + row, 1 + channel, sample(channel, row))
    # Words beside the table, in letters of one byte and of two.
    sheet.write(0, 5, "Prüfung 中文")
    book.save(HERE / name)


def bits(value):
    return struct.pack(">d", float(value)).hex()


def truth():
    found = []
    for name, first in [("openpyxl.xlsx", 7), ("xlsxwriter.xlsx", 2)]:
        sheet = openpyxl.load_workbook(HERE / name, data_only=True)["Data"]
        for channel, label in enumerate(CHANNELS):
            column = [sheet.cell(first + row, 2 + channel).value for row in range(ROWS)]
            found.append({"file": name, "channel": label, "bits": [bits(value) for value in column]})
    for name in ["xlwt.xls", "xlwt-dates.xls"]:
        sheet = xlrd.open_workbook(HERE / name).sheet_by_index(0)
        for channel, label in enumerate(CHANNELS):
            column = [sheet.cell_value(1 + row, 1 + channel) for row in range(ROWS)]
            found.append({"file": name, "channel": label, "bits": [bits(value) for value in column]})
    (HERE / "truth.json").write_text(json.dumps(found, indent=0) + "\n")


by_openpyxl()
by_xlsxwriter()
by_xlwt("xlwt.xls", False)
by_xlwt("xlwt-dates.xls", True)
truth()
