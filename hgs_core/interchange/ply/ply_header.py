"""Headers of PLY files: the format of the numbers, the elements with their properties, the comments."""

from __future__ import annotations

import re
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

from hgs_core.base.errors import InputError

__all__ = ["NumberFormat", "PlyElement", "PlyHeader", "PlyProperty", "read_header"]

_TYPES = {
    "char": "i1",
    "int8": "i1",
    "uchar": "u1",
    "uint8": "u1",
    "short": "i2",
    "int16": "i2",
    "ushort": "u2",
    "uint16": "u2",
    "int": "i4",
    "int32": "i4",
    "uint": "u4",
    "uint32": "u4",
    "float": "f4",
    "float32": "f4",
    "double": "f8",
    "float64": "f8",
    "int64": "i8",
    "uint64": "u8",
}
_LONGEST_HEADER = 1 << 20
_MOST_ROWS = 1 << 40
_CURE = "give a .ply file of splats"
_BYTE_ORDER_MARK = b"\xef\xbb\xbf"
_FIRST_LINE = re.compile(rb"ply[ \t]*(\r\n|\n|\r)")


class NumberFormat(StrEnum):
    """How the numbers of a file are written."""

    ASCII = "ascii"
    LITTLE = "binary_little_endian"
    BIG = "binary_big_endian"


@dataclass(frozen=True)
class PlyProperty:
    """One number of every row of an element, or a list of them."""

    name: str
    kind: str  # numpy's name of the type, without the byte order
    length: str = ""  # type of a list's length; "" for a number


@dataclass(frozen=True)
class PlyElement:
    """A table of the file."""

    name: str
    count: int  # rows
    properties: tuple[PlyProperty, ...]

    @property
    def has_lists(self) -> bool:
        """Whether its rows may differ in length."""
        return any(one.length for one in self.properties)


@dataclass(frozen=True)
class PlyHeader:
    """The header of a file."""

    format: NumberFormat
    elements: tuple[PlyElement, ...]
    comments: tuple[str, ...]
    size: int  # bytes, up to the first row


def read_header(path: Path, data: bytes) -> PlyHeader:
    """Read the header at the beginning of `data`; lines may end as on any system.

    Raises:
        InputError: there is none, or it holds what no PLY header does.
    """
    at = len(_BYTE_ORDER_MARK) if data.startswith(_BYTE_ORDER_MARK) else 0
    first = _FIRST_LINE.match(data, at)
    end = None
    if first is not None:
        end = re.compile(rb"[\r\n]end_header[ \t]*" + first[1]).search(data, at, _LONGEST_HEADER)
    if first is None or end is None:
        raise InputError(path, "is not a PLY file: it has no PLY header", _CURE)
    found: NumberFormat | None = None
    comments: list[str] = []
    elements: list[tuple[str, int, list[PlyProperty]]] = []
    for line in data[first.end() : end.start()].decode("utf-8", "replace").splitlines():
        words = line.split()
        match words:
            case ["format", kind, *_]:
                if kind not in tuple(NumberFormat):
                    raise InputError(path, f"is in the format {kind}", "save it as binary_little_endian")
                found = NumberFormat(kind)
            case ["comment" | "obj_info", *_]:
                comments.append(" ".join(words[1:]))
            case ["element", name, number]:
                if not (number.isascii() and number.isdecimal()) or int(number) > _MOST_ROWS:
                    raise InputError(path, f"has an element {name} of {number} rows", "export it again")
                if any(name == other for other, _, _ in elements):
                    raise InputError(path, f"has the element {name} twice", "export it again")
                elements.append((name, int(number), []))
            case ["property", "list", length, kind, name] if elements:
                _add(path, elements[-1], name, kind, length)
            case ["property", kind, name] if elements:
                _add(path, elements[-1], name, kind, "")
            case []:
                pass
            case _:
                raise InputError(path, f"has the header line {line[:60]!r}, which no PLY header has", "export it again")
    if found is None:
        raise InputError(path, "does not say in which format it is", "export it again")
    if not any(name == "vertex" for name, _, _ in elements):
        raise InputError(path, "has no vertices", _CURE)
    tables = tuple(PlyElement(name, count, tuple(properties)) for name, count, properties in elements)
    return PlyHeader(found, tables, tuple(comments), end.end())


def _add(path: Path, element: tuple[str, int, list[PlyProperty]], name: str, kind: str, length: str) -> None:
    of, _, properties = element
    unknown = kind not in _TYPES or (length and _TYPES.get(length, "f")[0] == "f")
    if unknown or any(name == other.name for other in properties):
        what = f"list {length} {kind} {name}" if length else f"{kind} {name}"
        raise InputError(path, f"has the {of} property {what}, unknown or twice", "export it again")
    properties.append(PlyProperty(name, _TYPES[kind], _TYPES[length] if length else ""))
