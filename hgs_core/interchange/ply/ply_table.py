"""PLY files as tables: the vertices' numbers by property name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hgs_core.base.arrays import Doubles, Floats
from hgs_core.base.errors import InputError
from hgs_core.interchange.changes import Action, Change
from hgs_core.interchange.file_bytes import file_bytes
from hgs_core.interchange.ply.ply_header import read_header
from hgs_core.interchange.ply.ply_rows import element_columns

__all__ = ["PlyFile", "Table", "columns", "exact_columns", "left_over", "read_ply", "rounded", "write_ply"]

Table = Mapping[str, NDArray[Any]]
VERTEX, CHUNK = "vertex", "chunk"


@dataclass(frozen=True)
class PlyFile:
    """The table of a file: columns [N] by property name, in the types of the file."""

    vertices: Table
    chunks: Table | None  # the bounds of packed numbers, where there are any
    comments: tuple[str, ...]
    changes: tuple[Change, ...]  # omissions in reading


def read_ply(path: Path) -> PlyFile:
    """Read the vertices of a PLY file: text or binary of either byte order, the elements in any order.

    Raises:
        InputError: the file is missing, is no such file, or is shorter than its header says.
    """
    data = file_bytes(path, "a .ply file of splats")
    header = read_header(path, data)
    there = {element.name: element for element in header.elements if element.count or element.name == VERTEX}
    found = element_columns(path, data, header, frozenset({VERTEX, CHUNK} & there.keys()))
    others = [name for name in there if name not in (VERTEX, CHUNK)]
    changes = [Change.whole(Action.LEFT_OUT, f"element {name}", "only vertices are splats") for name in others]
    lists = [one.name for one in there[VERTEX].properties if one.length]
    if lists:
        changes.append(Change.whole(Action.LEFT_OUT, f"properties {', '.join(lists)}", "they are lists"))
    return PlyFile(found[VERTEX], found.get(CHUNK), header.comments, tuple(changes))


def left_over(table: Table, known: Sequence[str], prefixes: tuple[str, ...] = ()) -> list[Change]:
    """Return the properties that are not among the `known` ones, nor begin with one of `prefixes`, as left out."""
    names = [name for name in table if name not in known and not name.startswith(("nx", "ny", "nz", *prefixes))]
    reason = "they are no part of a splat"
    return [Change.whole(Action.LEFT_OUT, f"properties {', '.join(names)}", reason)] if names else []


def exact_columns(path: Path, table: Table, names: Sequence[str]) -> Doubles:
    """Return some properties as one array [N, C] of 64 bits.

    Raises:
        InputError: one is missing.
    """
    missing = [name for name in names if name not in table]
    if missing:
        raise InputError(path, f"has no vertex property {missing[0]}", "give a .ply file of splats")
    return np.stack([table[name].astype(np.float64) for name in names], axis=1)


def columns(path: Path, table: Table, names: Sequence[str]) -> Floats:
    """Return some properties as one array [N, C] of 32 bits.

    Raises:
        InputError: one is missing.
    """
    with np.errstate(over="ignore"):
        return exact_columns(path, table, names).astype(np.float32)


def rounded(table: Table, places: Doubles, names: Sequence[str]) -> Change:
    """Return the splats of which a number has more bits than a float: of `places` [N, 3], or of the columns named."""
    changed = np.zeros(len(places), np.bool_)
    with np.errstate(over="ignore", invalid="ignore"):
        for values in (*places.T, *(table[name] for name in names)):
            changed |= (values.astype(np.float32) != values) & np.isfinite(values)
    return Change.where(Action.ROUNDED, "numbers", changed, "they have more bits than the 32 of a float")


def write_ply(table: Table, comments: Sequence[str] = ()) -> bytes:
    """Return a binary little-endian PLY file with these properties, as float."""
    rows = np.stack(list(table.values()), axis=1).astype("<f4")
    header = ["ply", "format binary_little_endian 1.0", *(f"comment {text}" for text in comments)]
    header += [f"element vertex {len(rows)}", *(f"property float {name}" for name in table)]
    return "\n".join([*header, "end_header\n"]).encode() + rows.tobytes()
