"""Meshes in Wavefront OBJ files: lines of vertices and of faces."""

from __future__ import annotations

from array import array
from itertools import pairwise
from pathlib import Path

import numpy as np

from hgs_core.base.errors import InputError
from hgs_core.interchange.mesh.triangles import Mesh, mesh_of_polygons

__all__ = ["obj_mesh"]

_LONGEST_LINE = 1 << 16
_CURE = "export it again"


def obj_mesh(path: Path) -> Mesh:
    """Read the vertices and faces of an OBJ file; all else in it is ignored.

    Raises:
        InputError: it is missing, unreadable, or a line of it names no numbers.
    """
    places, corners = array("d"), array("q")  # three numbers each
    try:
        with path.open("rb") as file:
            for number, line in enumerate(iter(lambda: file.readline(_LONGEST_LINE), b""), 1):
                words = line.split()
                try:
                    if words[:1] == [b"v"]:
                        x, y, z = map(float, words[1:4])
                        places.extend((x, y, z))
                    elif words[:1] == [b"f"]:
                        face = [_row(word, len(places) // 3) for word in words[1:]]
                        for second, third in pairwise(face[1:]):
                            corners.extend((face[0], second, third))
                except (ValueError, OverflowError) as error:
                    shown = line[:40].decode("utf-8", "replace").strip()
                    raise InputError(path, f"line {number} is {shown!r}, which is no vertex or face", _CURE) from error
    except OSError as error:
        raise InputError(path, f"cannot be read ({error.strerror})", "give an .obj mesh") from error
    vertices, polygons = np.array(places).reshape(-1, 3), np.array(corners, np.int64).reshape(-1, 3)
    return mesh_of_polygons(path, vertices, polygons)


def _row(word: bytes, known: int) -> int:
    """Return the vertex of a corner such as 7, 7/2 or 7//3 from 0; numbers below 0 count back from the last one."""
    number = int(word.partition(b"/")[0])
    if number == 0 or number < -known:
        raise ValueError(word)
    return number - 1 if number > 0 else known + number
