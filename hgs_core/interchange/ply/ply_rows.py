"""Rows of PLY files: the numbers of one element after another, in text or in bytes of either order."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hgs_core.base.errors import InputError
from hgs_core.interchange.ply.ply_header import NumberFormat, PlyElement, PlyHeader, PlyProperty

__all__ = ["element_columns"]

Columns = dict[str, NDArray[Any]]
_MOST_LISTED = 1 << 27  # numbers of a padded table
_LINE = re.compile(rb"[^\r\n]*[^\s][^\r\n]*")  # a line that is not blank


def element_columns(
    path: Path, data: bytes, header: PlyHeader, wanted: frozenset[str], *, lists: bool = False
) -> dict[str, Columns]:
    """Return the columns [rows] of the `wanted` elements, in their own types.

    Lists have none. With `lists` those of whole numbers have columns [rows, longest], ended by -1.

    What a count promises is compared with the bytes that are there before anything is made of that size.

    Raises:
        InputError: the file ends too early, or holds words where numbers belong.
    """
    found: dict[str, Columns] = {}
    at = header.size
    for element in header.elements:
        if wanted <= found.keys():
            break
        needed = element.name in wanted
        if header.format is NumberFormat.ASCII:
            columns, at = _of_text(path, data, at, element, needed, lists)
        else:
            order = "<" if header.format is NumberFormat.LITTLE else ">"
            columns, at = _of_bytes(path, data, at, element, order, lists and needed)
        if needed:
            found[element.name] = columns
    return found


def _of_bytes(path: Path, data: bytes, at: int, element: PlyElement, order: str, lists: bool) -> tuple[Columns, int]:
    """Return the columns of an element that begins at a byte, and where it ends."""
    if not element.has_lists:
        row = np.dtype([(one.name, order + one.kind) for one in element.properties])
        rows, end = _rows(path, data, at, element, row), at + element.count * row.itemsize
        return _columns(rows, element, lists), end
    lengths = _first_lengths(data, at, element, order)
    if lengths is not None:  # lists are mostly of one length
        fields: list[tuple[str, str] | tuple[str, str, tuple[int]]] = []
        for one in element.properties:
            if one.length:
                fields.append((f"#{one.name}", order + one.length))
                fields.append((one.name, order + one.kind, (lengths[one.name],)))
            else:
                fields.append((one.name, order + one.kind))
        row = np.dtype(fields)
        if element.count * row.itemsize <= len(data) - at:
            rows = np.frombuffer(data, row, element.count, at)
            if all((rows[f"#{name}"] == length).all() for name, length in lengths.items()):
                return _columns(rows, element, lists), at + element.count * row.itemsize
    return _of_uneven_bytes(path, data, at, element, order, lists)


def _rows(path: Path, data: bytes, at: int, element: PlyElement, row: np.dtype[Any]) -> NDArray[Any]:
    there, needed = len(data) - at, element.count * row.itemsize
    if there < needed:
        what = "vertices" if element.name == "vertex" else f"the element {element.name}"
        raise InputError(path, f"has {max(there, 0)} bytes of {what}, {element.count} need {needed}", "copy it again")
    if not row.itemsize:
        return np.zeros(0, row)
    return np.frombuffer(data, row, element.count, at)


def _columns(rows: NDArray[Any], element: PlyElement, lists: bool) -> Columns:
    return {
        one.name: rows[one.name].astype(np.int64 if one.length else one.kind, copy=False)
        for one in _read(element, lists)
    }  # native byte order


def _read(element: PlyElement, lists: bool) -> list[PlyProperty]:
    """Return the properties that are read: single numbers, and with `lists` lists of whole ones."""
    return [one for one in element.properties if not one.length or (lists and one.kind[0] in "iu")]


def _first_lengths(data: bytes, at: int, element: PlyElement, order: str) -> dict[str, int] | None:
    """Return the lengths of the lists in the first row, None if there is none."""
    found: dict[str, int] = {}
    if not element.count:
        return None
    for one in element.properties:
        size = np.dtype(one.kind).itemsize
        if one.length:
            length = np.dtype(order + one.length)
            if at + length.itemsize > len(data):
                return None
            found[one.name] = int(np.frombuffer(data, length, 1, at)[0])
            at += length.itemsize
            size *= found[one.name]
        if found.get(one.name, 0) < 0 or at + size > len(data):
            return None
        at += size
    return found


def _of_uneven_bytes(
    path: Path, data: bytes, at: int, element: PlyElement, order: str, lists: bool
) -> tuple[Columns, int]:
    """Read rows one by one: their lists differ in length."""
    values: dict[str, list[Any]] = {one.name: [] for one in _read(element, lists)}
    for number in range(element.count):
        for one in element.properties:
            count = 1
            kind = np.dtype(order + one.kind)
            if one.length:
                length = np.dtype(order + one.length)
                count = int(np.frombuffer(data, length, 1, at)[0]) if at + length.itemsize <= len(data) else -1
                at += length.itemsize
            if count < 0 or at + count * kind.itemsize > len(data):
                problem = f"ends in row {number} of the {element.count} of its element {element.name}"
                raise InputError(path, problem, "copy it again")
            if one.name in values:
                row = np.frombuffer(data, kind, count, at)
                values[one.name].append(row if one.length else row[0])
            at += count * kind.itemsize
    return _as_columns(path, values, element), at


def _of_text(
    path: Path, data: bytes, at: int, element: PlyElement, needed: bool, with_lists: bool
) -> tuple[Columns, int]:
    """Return the columns of an element with its first line at a byte, and its end."""
    width = len(element.properties)
    if not needed or element.has_lists:
        lines = _lines(path, data, at, element)
        if not needed:
            return {}, max([at, *(line.end() for line in lines)])
        found = list(lines)
        return _of_lines(path, found, element, with_lists), max([at, *(line.end() for line in found)])
    numbers = element.count * width
    if 2 * numbers - 1 > len(data) - at:
        problem = f"has {len(data) - at} bytes of text for the {numbers} numbers of its element {element.name}"
        raise InputError(path, problem, "copy it again")
    end = at
    lines = _lines(path, data, at, element)
    for line in lines:
        end = line.end()
    table = _numbers(path, data[at:end], numbers).reshape(element.count, width)
    return {one.name: table[:, i].astype(one.kind) for i, one in enumerate(element.properties)}, end


def _lines(path: Path, data: bytes, at: int, element: PlyElement) -> Iterator[re.Match[bytes]]:
    """Yield the lines of an element."""
    found = _LINE.finditer(data, at)
    for number in range(element.count):
        line = next(found, None)
        if line is None:
            problem = f"has {number} lines of its element {element.name}, and says that there are {element.count}"
            raise InputError(path, problem, "copy it again")
        yield line


def _of_lines(path: Path, lines: list[re.Match[bytes]], element: PlyElement, with_lists: bool) -> Columns:
    """Read lines with lists in them."""
    values: dict[str, list[Any]] = {one.name: [] for one in _read(element, with_lists)}
    for line in lines:
        words = _numbers(path, line[0], None).tolist()
        at = 0
        for one in element.properties:
            if at >= len(words) or (one.length and not 0 <= words[at] <= len(words) - at - 1):
                raise InputError(path, f"has the line {line[0][:40]!r}, which is too short", "export it again")
            count = int(words[at]) if one.length else 0
            if one.name in values:
                values[one.name].append(np.array(words[at + 1 : at + 1 + count]) if one.length else words[at])
            at += 1 + count
    return _as_columns(path, values, element)


def _as_columns(path: Path, values: dict[str, list[Any]], element: PlyElement) -> Columns:
    """Return the values of rows that were read one by one."""
    found: Columns = {}
    for one in element.properties:
        if one.name not in values:
            continue
        if not one.length:
            found[one.name] = np.array(values[one.name], one.kind)
            continue
        longest = max((len(row) for row in values[one.name]), default=0)
        if longest * element.count > _MOST_LISTED:
            raise InputError(path, f"has lists {one.name} of up to {longest} numbers", "export triangles")
        table = np.full((element.count, longest), -1, np.int64)
        with np.errstate(invalid="ignore"):  # a text may hold numbers beyond whole ones
            for own, row in zip(table, values[one.name], strict=True):
                own[: len(row)] = row
        found[one.name] = table
    return found


def _numbers(path: Path, text: bytes, count: int | None) -> NDArray[np.float64]:
    """Return the numbers of a text, `count` of them where that is known."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", DeprecationWarning)  # how numpy says that words are no numbers
            found = np.fromstring(text.decode("ascii"), np.float64, sep=" ")
    except (DeprecationWarning, ValueError, UnicodeDecodeError) as error:
        raise InputError(path, "holds words where numbers belong", "export it again") from error
    if count is not None and len(found) != count:
        raise InputError(path, f"has {len(found)} numbers where {count} belong", "copy it again")
    return found
