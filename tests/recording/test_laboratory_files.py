"""Files as instruments and programs of laboratories write them, of one and the same motion.

Each is read at the first try with its numbers, names and units, or refused in one right line.
"""

import gzip
import io
import json
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import openpyxl
import pandas
import pytest
from scipy.io import savemat

from opensuction.recording import table
from opensuction.recording.column_unit import seconds_of_column, unit_of_column
from tests.recording.test_mat_table import structures, written_73
from tests.recording.test_table import refusal

TIME_S = [0.0, 0.02, 0.04, 0.06, 0.08]
HEAD = [0.0, 1.5, 1012.25, 1.5, -2.0]
FORCE = [0.25, -0.5, 0.0, 12.125, 0.75]
SAMPLES = list(zip(TIME_S, HEAD, FORCE, strict=True))
FRAME = pandas.DataFrame({"t_s": TIME_S, "head_mm": HEAD, "force_N": FORCE})


class Expected(NamedTuple):
    """Columns in which a file has the motion, as a person names them, and their units."""

    time: str
    head: str
    force: str
    head_unit: str = "mm"
    force_unit: str = "N"
    elapsed: bool = False
    """The time counts from another origin than 0."""


def rows(separator: str, write: Callable[[float], str] = repr, end: str = "\r\n") -> str:
    """The samples as lines of text."""
    return "".join(separator.join(map(write, sample)) + end for sample in SAMPLES)


def comma(number: float) -> str:
    return f"{number:.3f}".replace(".", ",")


def german(number: float) -> str:
    """With points between the thousands."""
    return f"{number:,.3f}".translate(str.maketrans(",.", ".,"))


def stamped(stamps: list[str], separator: str, write: Callable[[float], str] = repr) -> str:
    """The samples with their time written in another way."""
    cells = zip(stamps, HEAD, FORCE, strict=True)
    return "".join(
        separator.join((at, write(head), write(force))) + "\r\n" for at, head, force in cells
    )


CLOCK = [f"12:00:00.{int(1000 * at):03d}" for at in TIME_S]
PLAIN = Expected("t_s", "head_mm", "force_N")
GERMAN = Expected("Zeit", "Weg", "Kraft")
LVM = (
    "LabVIEW Measurement\t\r\nWriter_Version\t2\r\nSeparator\tTab\r\nDecimal_Separator\t,\r\n"
    "Date\t2026/01/31\r\nTime\t12:00:00,5\r\n***End_of_Header***\t\r\n\t\r\n"
    "Channels\t2\t\t\t\r\nSamples\t5\t5\t\t\r\nY_Unit_Label\tmm\tN\t\t\r\n"
    "Delta_X\t0,02\t0,02\t\t\r\n***End_of_Header***\t\t\t\t\r\n"
)

TEXTS: dict[str, tuple[str, str, Expected]] = {
    "LabVIEW, tabs and decimal commas": (
        f"{LVM}X_Value\tHead\tForce\tComment\r\n" + rows("\t", comma),
        "cp1252",
        Expected("X_Value", "Head", "Force", "", ""),
    ),
    "LabVIEW, Unicode text": (
        "Time [s]\tHead [mm]\tForce [N]\r\n" + rows("\t", comma),
        "utf-16",
        Expected("Time [s]", "Head [mm]", "Force [N]"),
    ),
    "tensile machine, all in quotes, thousands": (
        '"Specimen","A1"\r\n"Rate","2.0","mm/min"\r\n\r\n"Time","Extension","Load"\r\n'
        '"(s)","(mm)","(N)"\r\n' + rows('","', "{:,.3f}".format, '"\r\n"')[:-1].join('""')[:-1],
        "utf-8",
        Expected("Time", "Extension", "Load"),
    ),
    "servo-hydraulic frame": (
        "MTS793|MPT|ENU|1|2|.|/|:|1|0|0|A\n\nData Acquisition: Timed\tTime:\t0.0\tSec\n"
        "Station Name: x.cfg\nTime\tAxial Displacement\tAxial Force\nSec\tmm\tkN\n"
        + rows("\t", end="\n"),
        "ascii",
        Expected("Time", "Axial Displacement", "Axial Force", force_unit="kN"),
    ),
    "testing machine, German": (
        "Prüfer;Müller\r\nProbe;7\r\n\r\nPrüfzeit;Standardweg;Standardkraft\r\ns;mm;N\r\n"
        + rows(";", comma),
        "cp1252",
        Expected("Prüfzeit", "Standardweg", "Standardkraft"),
    ),
    "German, points between thousands, µ and °": (
        "Zeit [ms];Weg (µm);Kraft [µN];Temp °C\r\n"
        + "".join(
            f"{german(1000 * at)};{german(head)};{german(force)};20,1\r\n"
            for at, head, force in SAMPLES
        ),
        "cp1252",
        Expected("Zeit [ms]", "Weg (µm)", "Kraft [µN]", "um", "uN"),
    ),
    "testing machine, units behind 'in'": (
        "Zeit in s;Weg in mm;Kraft in N\r\n" + rows(";", comma),
        "cp1252",
        Expected("Zeit in s", "Weg in mm", "Kraft in N"),
    ),
    "friction tester": (
        "[File Info]\nVersion: 3\n[Data]\nT(s)\tX(mm)\tFx(N)\n" + rows("\t", "{:.6E}".format, "\n"),
        "ascii",
        Expected("T(s)", "X(mm)", "Fx(N)"),
    ),
    "oscilloscope, preamble above": (
        "Model,DPO2024\nFirmware Version,1.52\n\nWaveform Type,ANALOG,,\nHorizontal Units,s,,\n"
        "Vertical Units,V,V,\nLabel,,,\nTIME,CH1,CH2\n" + rows(",", end="\n"),
        "ascii",
        Expected("TIME", "CH1", "CH2", "", ""),
    ),
    "oscilloscope, numbered channels": (
        "x-axis,1,2\nsecond,Volt,Volt\n" + rows(",", "{:+.6E}".format, "\n"),
        "ascii",
        Expected("x-axis", "1", "2", "V", "V"),
    ),
    "oscilloscope, units in names": (
        "Time(s),CH1(V),CH2(V)\n" + rows(",", end="\n"),
        "ascii",
        Expected("Time(s)", "CH1(V)", "CH2(V)", "V", "V"),
    ),
    "data acquisition, preamble with colons": (
        "DASYLab - V 11.00\r\nAufnahmedatum: 31.01.2026, 12:00:00\r\nBlockgröße : 64\r\n"
        "Delta: 0,02 sec.\r\nZeit [s];Weg [mm];Kraft [N]\r\n" + rows(";", comma),
        "cp1252",
        Expected("Zeit [s]", "Weg [mm]", "Kraft [N]"),
    ),
    "pandas, with its index": (FRAME.to_csv(), "utf-8", PLAIN),
    "pandas, without": (FRAME.to_csv(index=False), "utf-8", PLAIN),
    "NumPy's savetxt": (
        "# t_s head_mm force_N\n" + rows(" ", "{:.18e}".format, "\n"),
        "ascii",
        PLAIN,
    ),
    "NumPy's savetxt, bare": (
        rows(" ", "{:.18e}".format, "\n"),
        "ascii",
        Expected("1", "2", "3", "", ""),
    ),
    "MATLAB's writematrix": (rows(",", end="\n"), "ascii", Expected("1", "2", "3", "", "")),
    "MATLAB's writetable": (
        "Var1,Var2,Var3\n" + rows(",", end="\n"),
        "ascii",
        Expected("Var1", "Var2", "Var3", "", ""),
    ),
    "gnuplot, blocks": (
        "# t[s] head[mm] force[N]\n" + rows(" ", end="\n").replace("\n0.06", "\n\n\n0.06"),
        "ascii",
        Expected("t[s]", "head[mm]", "force[N]"),
    ),
    "names and units in comments": (
        "# bench 3\n# t head force\n# s mm N\n" + rows("\t", end="\n"),
        "ascii",
        Expected("t", "head", "force"),
    ),
    "Fortran": (
        "  t_s  head_mm  force_N\n" + rows("  ", "{:23.15E}".format, "\n").replace("E", "D"),
        "ascii",
        PLAIN,
    ),
    "tabs, one behind each line": (
        "t_s\thead_mm\tforce_N\t\r\n" + rows("\t", end="\t\r\n"),
        "ascii",
        PLAIN,
    ),
    "old Macintosh": ("t_s,head_mm,force_N\r" + rows(",", end="\r"), "mac-roman", PLAIN),
    "empty lines behind": (
        "t_s,head_mm,force_N\n" + rows(",", end="\n") + "\n\n\n",
        "ascii",
        PLAIN,
    ),
    "database": ("t_s|head_mm|force_N\n" + rows("|", end="\n"), "ascii", PLAIN),
    "dates, ISO": (
        "timestamp,head_mm,force_N\n" + stamped([f"2026-01-31T{at}Z" for at in CLOCK], ","),
        "ascii",
        Expected("timestamp", "head_mm", "force_N", elapsed=True),
    ),
    "dates, German": (
        "Zeit;Weg [mm];Kraft [N]\r\n"
        + stamped([f"31.01.2026 {at}".replace(".0", ",0") for at in CLOCK], ";", comma).replace(
            "31,01", "31.01"
        ),
        "cp1252",
        Expected("Zeit", "Weg [mm]", "Kraft [N]", elapsed=True),
    ),
    "time of day": (
        "Time (hh:mm:ss.fff)\tHead (mm)\tForce (N)\r\n" + stamped(CLOCK, "\t"),
        "ascii",
        Expected("Time (hh:mm:ss.fff)", "Head (mm)", "Force (N)", elapsed=True),
    ),
    "a spreadsheet's separator": (
        "sep=;\r\nZeit [s];Weg [mm];Kraft [N]\r\n" + rows(";", comma),
        "utf-8-sig",
        Expected("Zeit [s]", "Weg [mm]", "Kraft [N]"),
    ),
    "records of JSON": (
        json.dumps([dict(zip(FRAME.columns, sample, strict=True)) for sample in SAMPLES]),
        "utf-8",
        PLAIN,
    ),
    "lines of JSON": (FRAME.to_json(orient="records", lines=True), "utf-8", PLAIN),
}


def write_workbook(path: Path) -> None:
    book = openpyxl.Workbook()
    book.active.append(["Bench 3", "Smith"])
    sheet = book.create_sheet("Run 1")
    for row in (["Zeit", "Weg", "Kraft"], ["s", "mm", "N"], *SAMPLES):
        sheet.append(row)
    book.save(path)


def archive_of(t_s: list[float], head_mm: list[float], force_N: list[float]) -> bytes:  # noqa: N803
    """A NumPy archive; not written to a path, for `savez` adds a suffix to it."""
    content = io.BytesIO()
    np.savez_compressed(content, t_s=t_s, head_mm=head_mm, force_N=force_N)
    return content.getvalue()


VECTORS = {"t_s": TIME_S, "head_mm": HEAD, "force_N": FORCE}
SIGNALS = {"values": np.column_stack([HEAD, FORCE]), "label": "head", "dimensions": 2}
CAPTURE = {
    "X": {"Name": "t", "Data": TIME_S},
    "Y": structures([{"Name": "head", "Data": HEAD}, {"Name": "force", "Data": FORCE}]),
}
BINARIES: dict[str, tuple[Callable[[Path], object], Expected]] = {
    "Excel, a cover before": (write_workbook, GERMAN),
    "Excel of pandas": (lambda path: FRAME.to_excel(path, engine="openpyxl"), PLAIN),
    "Parquet of pandas": (FRAME.to_parquet, PLAIN),
    "NumPy archive": (lambda path: path.write_bytes(archive_of(**VECTORS)), PLAIN),
    "MATLAB, columns": (lambda path: savemat(path, VECTORS, oned_as="column"), PLAIN),
    "MATLAB, one matrix": (
        lambda path: savemat(path, {"data": np.array(SAMPLES)}),
        Expected("data(:,1)", "data(:,2)", "data(:,3)", "", ""),
    ),
    "Simulink, structure with time": (
        lambda path: savemat(path, {"out": {"time": TIME_S, "signals": SIGNALS}}),
        Expected("time", "signals.values(:,1)", "signals.values(:,2)", "", ""),
    ),
    "dSPACE, capture": (
        lambda path: savemat(path, {"rec1": CAPTURE}),
        Expected("X.Data", "Y(1).Data", "Y(2).Data", "", ""),
    ),
    "MATLAB 7.3": (
        lambda path: written_73(
            path, **{name: ("double", np.array([row])) for name, row in VECTORS.items()}
        ),
        PLAIN,
    ),
}


def check(path: Path, expected: Expected) -> None:
    opened = table.open_table(path)
    names = [table.find_name(opened, name) for name in expected[:3]]
    columns, left_out = table.read_columns(opened, names)
    time, head, force = (columns[name] for name in names)
    time = time * seconds_of_column(names[0], None) - (time[0] if expected.elapsed else 0.0)
    assert time == pytest.approx(TIME_S, abs=1e-6)  # a date of 2026 in doubles: 0.24 us
    assert head.tolist() == HEAD
    assert force.tolist() == FORCE
    assert [unit_of_column(name) for name in names[1:]] == [*expected[3:5]]
    assert left_out == 0


@pytest.mark.parametrize("case", TEXTS)
def test_text_is_read_at_the_first_try(case: str, tmp_path: Path) -> None:
    content, encoding, expected = TEXTS[case]
    path = tmp_path / "recording.txt"
    path.write_bytes(content.encode(encoding))
    check(path, expected)


@pytest.mark.parametrize("case", BINARIES)
def test_other_files_are_read_at_the_first_try(case: str, tmp_path: Path) -> None:
    write, expected = BINARIES[case]
    write(tmp_path / "recording.bin")
    check(tmp_path / "recording.bin", expected)


def zip_of(name: str, content: str) -> bytes:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        archive.writestr(name, content)
    return packed.getvalue()


TABLE = TEXTS["pandas, without"][0]

REFUSED: dict[str, tuple[bytes, str]] = {
    "LabVIEW, TDMS": (b"TDSm\x0e\0\0\0", "is a TDMS file of LabVIEW; export it as CSV"),
    "packed with gzip": (gzip.compress(TABLE.encode()), "is compressed (gzip); unpack it first"),
    "packed with zip": (zip_of("a.csv", TABLE), "is a zip archive; unpack it first, and give the"),
    "OpenDocument": (
        zip_of("mimetype", "application/vnd.oasis.opendocument.spreadsheet"),
        "is a spreadsheet; save it as .xlsx, or export the sheet as CSV",
    ),
    "Excel of old": (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", "is a spreadsheet of an old kind (.xls)"),
    "oscilloscope, preamble beside the samples": (
        b"Record Length,2.5e+03,,-0.02,0.1,\nSample Interval,4e-06,,-0.01,0.2,\n,,,0.0,0.3,\n",
        "line 1 has text and numbers side by side, such as '2.5e+03', so it may be the header or",
    ),
    "oscilloscope, increment behind the units": (
        b"X,CH1,CH2,Start,Increment,\nSequence,VOLT,VOLT,-6.0e-02,1.0e-04\n0,1.0,2.0,,\n",
        "line 2: 5 cells, the header has 6; complete or remove the line",
    ),
    "amplifier, rows of devices and rates": (
        b"t [s]\thead [mm]\nMX840\tMX840\n50 Hz\t50 Hz\n0,0\t1,5\n0,02\t1,6\n",
        "lines 1 and 2 may both be the header of the numbers from line 3 on; remove one of them",
    ),
    "one name twice": (
        TABLE.replace("force_N", "head_mm").encode(),
        "2 columns are called 'head_mm'; rename all but one",
    ),
    "dates, American": (
        b"when,head\n1/31/2026 12:00:00 PM,1\n1/31/2026 12:00:01 PM,2\n",
        "line 2, column 'when': '1/31/2026 12:00:00 PM' is not a number; write times in seconds",
    ),
    "minutes or hours": (b"t,head\n12:00,1\n12:01,2\n", "column 't': '12:00' is not a number"),
    "marks of missing numbers": (
        b"t,head\n0,1\n1,#N/A\n2,-\n3,1.#QNAN\n4,2\n",
        "line 3, column 'head': '#N/A' is no number (in 3 of 5 rows); fill it in, or leave such",
    ),
    "overflow": (b"t,head\n0,1\n1,1.#INF\n", "line 3, column 'head': '1.#INF' is not finite"),
    "units in cells": (b"t,head\n0,1.5 mm\n1,2 mm\n", "line 2, column 'head': '1.5 mm' is not a"),
    "two runs in one file": (
        b"t,head\n0,1\n1,2\n\nt,head\n0,3\n",
        "line 5, column 't': 't' is not a number",
    ),
    "an end mark": (b"t,head\n0,1\n1,2\nEND\n", "line 4: 1 cell, the header has 2; complete"),
    "decimal commas between commas": (
        b"t,head\n0,0,1,5\n0,5,2,5\n",
        "line 2: 4 cells, the header has 2; numbers with decimal commas need another separator",
    ),
    "thousands or decimals": (
        b't,head\n0,"1,500"\n1,"2,500"\n',
        "line 2, column 'head': '1,500' may be 1.500 or 1500",
    ),
    "values by name": (b'{"rate": 50, "name": "A1"}', "is JSON without a table of numbers"),
    "a page of a repository": (b"<!DOCTYPE html>\n<html>", "is a web page; download the file"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_read_is_refused_in_one_right_line(case: str, tmp_path: Path) -> None:
    content, words = REFUSED[case]
    path = tmp_path / "recording.dat"
    path.write_bytes(content)
    assert words in refusal(path)
