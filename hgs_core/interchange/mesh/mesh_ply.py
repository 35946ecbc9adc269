"""Meshes in PLY files: vertices, and faces as lists of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from hgs_core.base.errors import InputError
from hgs_core.interchange.file_bytes import file_bytes
from hgs_core.interchange.mesh.triangles import Mesh, mesh_of_polygons
from hgs_core.interchange.ply.ply_header import read_header
from hgs_core.interchange.ply.ply_rows import element_columns
from hgs_core.interchange.ply.ply_table import exact_columns

__all__ = ["ply_mesh"]

_LISTS = ("vertex_indices", "vertex_index")


def ply_mesh(path: Path) -> Mesh:
    """Read a PLY file of text or of bytes of either order.

    Raises:
        InputError: it is missing, damaged, or has no faces.
    """
    data = file_bytes(path, "a .ply mesh")
    header = read_header(path, data)
    found = element_columns(path, data, header, frozenset({"vertex", "face"}), lists=True)
    faces = next((found["face"][name] for name in _LISTS if name in found.get("face", {})), np.zeros((0, 3), np.int64))
    if not len(faces):
        raise InputError(path, "has no faces: it is no mesh", "give a surface of triangles")
    return mesh_of_polygons(path, exact_columns(path, found["vertex"], ("x", "y", "z")), faces)
