"""Mesh files of every kind that is read."""

from __future__ import annotations

from pathlib import Path

from hgs_core.base.errors import InputError
from hgs_core.interchange.mesh.mesh_glb import glb_mesh
from hgs_core.interchange.mesh.mesh_obj import obj_mesh
from hgs_core.interchange.mesh.mesh_ply import ply_mesh
from hgs_core.interchange.mesh.triangles import MOST_BYTES, Mesh

__all__ = ["read_mesh"]

_READERS = {".ply": ply_mesh, ".obj": obj_mesh, ".glb": glb_mesh}


def read_mesh(path: Path) -> Mesh:
    """Read the triangles of a file; its ending tells the format.

    Raises:
        InputError: it is missing, too large, of another format, damaged, or without triangles.
    """
    read = _READERS.get(path.suffix.lower())
    if read is None:
        raise InputError(path, f"has the ending {path.suffix!r}", f"give a mesh as {', '.join(_READERS)}")
    try:
        size = path.stat().st_size
    except OSError as error:
        raise InputError(path, f"cannot be read ({error.strerror})", "give a mesh as PLY, OBJ or GLB") from error
    if size > MOST_BYTES:
        problem = f"has {size} bytes, and {MOST_BYTES} are the most that are read"
        raise InputError(path, problem, "give a simpler mesh: a million triangles show a room")
    return read(path)
