"""PLY files as tables: the vertices' numbers by property name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from hgs_core.base.arrays import Floats
from hgs_core.base.errors import InputError
from hgs_core.interchange.changes import Action, Change
from hgs_core.interchange.file_bytes import file_bytes

__all__ = ["columns", "left_over", "read_ply", "write_ply"]

_TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "<i2", "int16": "<i2", "ushort": "<u2",
    "uint16": "<u2", "int": "<i4", "int32": "<i4", "uint": "<u4", "uint32": "<u4", "float": "<f4", "float32": "<f4",
    "double": "<f8", "float64": "<f8",
}  # fmt: skip
_LONGEST_HEADER = 1 << 16

Table = Mapping[str, Floats]


def read_ply(path: Path) -> tuple[dict[str, Floats], list[Change]]:
    """Read the vertices of a binary little-endian PLY file: one float32 array [N] per property, and what that changes.

    Raises:
        InputError: the file is missing, is no such file, or is shorter than its header says.
    """
    data = file_bytes(path, "a .ply file of splats")
    end = data.find(b"end_header\n", 0, _LONGEST_HEADER)
    if not data.startswith(b"ply\n") or end < 0:
        raise InputError(path, "is not a PLY file: it has no PLY header", "give a .ply file of splats")
    dtype, count, others = _layout(path, data[:end].decode("ascii", "replace").split("\n"))
    begin = end + len(b"end_header\n")
    if len(data) - begin < count * dtype.itemsize:
        raise InputError(
            path, f"has {len(data) - begin} bytes of vertices, {count} need {count * dtype.itemsize}", "copy it again"
        )
    rows = np.frombuffer(data, dtype, count, begin)
    with np.errstate(over="ignore"):
        table = {name: rows[name].astype(np.float32) for name in dtype.names or ()}
    changed = np.zeros(count, np.bool_)
    for name, values in table.items():
        changed |= (values != rows[name]) & np.isfinite(values)
    changes = [Change.where(Action.ROUNDED, "numbers", changed, "they have more bits than the 32 of a float")]
    changes += [Change.whole(Action.LEFT_OUT, f"element {name}", "only vertices are splats") for name in others]
    return table, changes


def left_over(table: Table, known: Sequence[str], prefixes: tuple[str, ...] = ()) -> list[Change]:
    """Return the properties that are not among the `known` ones, nor begin with one of `prefixes`, as left out."""
    names = [name for name in table if name not in known and not name.startswith(("nx", "ny", "nz", *prefixes))]
    reason = "they are no part of a splat"
    return [Change.whole(Action.LEFT_OUT, f"properties {', '.join(names)}", reason)] if names else []


def _layout(path: Path, header: Sequence[str]) -> tuple[np.dtype[Any], int, list[str]]:
    """Return type and number of the vertices, which must be the file's first element, and the others that are there."""
    count, element = -1, ""
    others: list[str] = []
    fields: list[tuple[str, str]] = []
    for line in header:
        match line.split():
            case ["format", kind, *_] if kind != "binary_little_endian":
                raise InputError(path, f"is in the format {kind}", "save it as binary_little_endian")
            case ["element", name, number]:
                element = name
                if count < 0 and (name != "vertex" or not number.isdecimal()):
                    raise InputError(path, f"begins with the element {name} {number}", "its vertices must come first")
                if name == "vertex":
                    count = int(number)
                elif number != "0":
                    others.append(name)
            case ["property", kind, name] if element == "vertex":
                if kind not in _TYPES or name in dict(fields):
                    raise InputError(path, f"has the vertex property {kind} {name}, unknown or twice")
                fields.append((name, _TYPES[kind]))
            case ["property", "list", *_] if element == "vertex":
                raise InputError(path, "has vertices with lists: it holds no splats", "give a .ply file of splats")
    if count < 0:
        raise InputError(path, "has no vertices", "give a .ply file of splats")
    return np.dtype(fields), count, others


def columns(path: Path, table: Table, names: Sequence[str]) -> Floats:
    """Return some properties as one array [N, C].

    Raises:
        InputError: one is missing.
    """
    missing = [name for name in names if name not in table]
    if missing:
        raise InputError(path, f"has no vertex property {missing[0]}", "give a .ply file of splats")
    return np.stack([table[name] for name in names], axis=1)


def write_ply(table: Table) -> bytes:
    """Return a binary little-endian PLY file with these properties, as float."""
    rows = np.stack(list(table.values()), axis=1).astype("<f4")
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(rows)}"]
    header += [f"property float {name}" for name in table]
    return "\n".join([*header, "end_header\n"]).encode() + rows.tobytes()
