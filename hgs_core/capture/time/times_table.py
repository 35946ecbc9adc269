"""timestamps.csv: a row with a camera and a time for each frame, as caliscope and others write it.

Columns are parted by commas, semicolons, tabs or bars, in quotes or without; decimals have a full stop or a comma.
Names of columns are read in capitals or small, with blanks or without, and may end with a unit: "Frame Time (ms)".
Without one the step from frame to frame tells the unit, compared with the rate of the footage.
"""

from __future__ import annotations

import csv
from array import array
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import numpy.typing as npt

from hgs_core.base.errors import InputError
from hgs_core.base.wording import shown
from hgs_core.capture.files.text_file import text_lines
from hgs_core.capture.files.unreadable import unreadable
from hgs_core.capture.time.clock import mean_rate
from hgs_core.capture.time.time_units import SECONDS, TimeUnit, unit_in_name, unit_of_step

__all__ = ["CURE", "TimesTable", "read_times_table", "unit_of_table"]

CURE = "restore it, or remove it to go by the videos' own time stamps"
"""Of a table that does not fit its footage."""

_CAMERA_COLUMNS = ("cam_id", "camera", "cam", "port", "camera_id", "camera_name", "cam_name", "camera_index")
_TIME_COLUMNS = ("frame_time", "time", "timestamp", "time_stamp", "frame_timestamp", "capture_time", "t", "")
_SEPARATORS = (",", ";", "\t", "|")
_MOST_ROWS = 10_000_000  # an hour of 90 cameras at 30 frames per second
_MOST_CAMERAS = 10_000
_LARGEST = 1e30
_DIFFERS = 0.05  # share of a rate that is worth a note: arrivals jitter


@dataclass(frozen=True)
class TimesTable:
    """The contents of a table."""

    times: Mapping[str, npt.NDArray[np.float64]]  # camera -> times in the order of rows, in the table's unit
    unit: TimeUnit | None  # unit at the end of the column's name
    column: str  # name of the column of times


def read_times_table(file: Path) -> TimesTable:
    """Return the contents of a table.

    Raises:
        InputError: the file is unreadable, lacks a column, has a time that is none or that does not follow the one
            before, or more rows than are read; names the row.
    """
    times: dict[str, array[float]] = {}
    try:
        rows = _rows(file)
        columns = next(rows, [])
        of_camera, of_time, unit = _columns(file, columns)
        for number, row in enumerate(rows, 1):
            if not any(cell.strip() for cell in row):
                continue
            where = f"{file}, row {number}"
            if len(row) <= max(of_camera, of_time):
                problem = f"has {len(row)} columns, and the first line has {len(columns)}"
                raise InputError(where, problem, "complete the row, or remove it")
            seconds, is_number = _number(row[of_time])
            unit = unit if is_number else SECONDS
            if seconds is None:
                raise InputError(where, f"{columns[of_time].strip()} is {shown(row[of_time])}", "it is a number")
            own = times.setdefault(row[of_camera].strip(), array("d"))
            if own and seconds <= own[-1]:
                late = f"{shown(row[of_time].strip())} of camera {shown(row[of_camera].strip())}"
                cure = "correct it, or remove the table to go by the videos' own time stamps"
                raise InputError(where, f"{late} is no later than the time before", cure)
            own.append(seconds)
            if number > _MOST_ROWS or len(times) > _MOST_CAMERAS:
                problem = f"has more than {_MOST_ROWS} rows or {_MOST_CAMERAS} cameras"
                raise InputError(file, problem, "remove it to go by the videos' own time stamps")
    except csv.Error as error:
        raise unreadable(file, error, CURE) from error
    return TimesTable({name: np.array(own) for name, own in times.items()}, unit, columns[of_time].strip())


def unit_of_table(file: Path, table: TimesTable, steps: Mapping[str, float], *, assumed: bool) -> tuple[TimeUnit, str]:
    """Return the unit of the times, and a note on it.

    `steps` are the seconds from frame to frame that the footage of the table's cameras states; where that is `assumed`,
    any usual rate will do.

    Raises:
        InputError: the steps fit the footage in no unit, or not in that of the column's name.
    """
    ratios = [1.0 / (mean_rate(table.times[n]) * step) for n, step in steps.items() if len(table.times[n]) > 1]
    if not ratios:
        return table.unit or SECONDS, ""
    step = float(np.median(list(steps.values())))
    own = float(np.median(ratios)) * step
    found = unit_of_step(own, None if assumed else 1.0 / step)
    rate = 1.0 / step
    if table.unit is not None and found not in (None, table.unit):
        there = f"{table.unit.per_second / own:.4g} frames per second in {table.unit.name}"
        problem = f"{table.column} steps by {own:.6g} from frame to frame: {there}, and the footage has {rate:.4g}"
        raise InputError(file, problem, f"it is that in {found.name}: correct the name of the column")
    unit = table.unit or found
    if unit is None:
        problem = f"{table.column} steps by {own:.6g} and the footage has {rate:.4g} frames per second: no unit fits"
        cure = f'call the column "{table.column}_s" where it is in seconds, "{table.column}_ms" in milliseconds'
        raise InputError(file, problem, cure)
    there = f"{unit.per_second / own:.4g} frames per second"
    if unit is not SECONDS and table.unit is None:
        return unit, f"{file.name} is in {unit.name}, by the rate of the footage: {there}"
    differs = not assumed and abs(rate * own / unit.per_second - 1) > _DIFFERS
    return unit, f"{file.name} has {there} and the footage {rate:.4g}: the table counts" if differs else ""


def _rows(file: Path) -> Iterator[list[str]]:
    """Yield the cells of each line."""
    lines = text_lines(file, CURE)
    first = next(lines, None)
    if first is None:
        return
    separator = max(_SEPARATORS, key=first.count)
    yield next(csv.reader([first], delimiter=separator), [])
    yield from csv.reader((f"{line}\n" for line in lines), delimiter=separator)


def _columns(file: Path, columns: list[str]) -> tuple[int, int, TimeUnit | None]:
    """Return the places of the cameras and of the times, and the unit of these."""
    named = [unit_in_name(column) for column in columns]
    whole = ["_".join(filter(None, (name, unit.name if unit else ""))) for name, unit in named]
    of_camera = next((whole.index(name) for name in _CAMERA_COLUMNS if name in whole), None)
    candidates = ((place, name, unit) for place, (name, unit) in enumerate(named) if name or unit)
    known = [(_TIME_COLUMNS.index(name), place, unit) for place, name, unit in candidates if name in _TIME_COLUMNS]
    if of_camera is None or not known:
        listed = ", ".join(shown(column.strip())[1:-1] for column in columns[:12]) or "none"
        cure = "it needs a column cam_id and a column frame_time, in seconds"
        raise InputError(file, f"the columns are {listed}", cure)
    _, of_time, unit = min(known, key=lambda one: one[:2])
    return of_camera, of_time, unit


def _number(cell: str) -> tuple[float | None, bool]:
    """Return a number, or the seconds of a date or of a time of day, None if it is none of them; and whether it is a
    number.
    """
    text = cell.strip()
    try:
        if ":" in text:
            has_date = "-" in text
            moment = datetime.fromisoformat(text if has_date else f"2000-01-01 {text}")
            value = moment.timestamp() if moment.tzinfo else moment.replace(tzinfo=UTC).timestamp()
        else:
            value = float(_with_full_stop(text))
    except (ValueError, OverflowError):
        return None, False
    return (value if abs(value) < _LARGEST else None), ":" not in text


def _with_full_stop(text: str) -> str:
    """Return a number with a full stop before its decimals and nothing between thousands."""
    text = text.replace("\u00a0", "").replace(" ", "")
    commas, stops = text.count(","), text.count(".")
    if commas == 1 and text.rfind(",") > text.rfind("."):
        return text.replace(".", "").replace(",", ".")
    if commas:
        return text.replace(",", "")
    return text.replace(".", "") if stops > 1 else text
