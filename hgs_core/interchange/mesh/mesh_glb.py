"""Meshes in GLB files: the triangles of all nodes of the scene that is shown, in their places."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from hgs_core.base.errors import InputError
from hgs_core.interchange.gltf.glb_container import read_glb
from hgs_core.interchange.gltf.gltf_asset import GltfAsset
from hgs_core.interchange.mesh.triangles import Mesh, mesh_of_polygons

__all__ = ["glb_mesh"]

_TRIANGLES = 4  # mode of a primitive; below it points and lines, above it strips and fans


def glb_mesh(path: Path) -> Mesh:
    """Read a GLB file.

    Raises:
        InputError: it is missing, damaged, or keeps triangles in a form that is not read.
    """
    asset = GltfAsset(path, *read_glb(path))
    places, faces, count = [np.zeros((0, 3))], [np.zeros((0, 3), np.int64)], 0
    for mesh, world in asset.placed_meshes():
        for primitive in mesh.get("primitives", []):
            mode = primitive.get("mode", _TRIANGLES)
            if mode in range(_TRIANGLES):
                continue
            if mode != _TRIANGLES:
                raise InputError(path, f"has a primitive of mode {mode}, a strip or fan", "export plain triangles")
            vertices = asset.numbers(primitive.get("attributes", {}).get("POSITION"))
            if vertices.shape[1] != 3:
                raise InputError(path, f"has positions of {vertices.shape[1]} numbers", "export it again")
            if "indices" in primitive:
                rows = asset.numbers(primitive["indices"]).astype(np.int64).ravel()
                if len(rows) and rows.max() >= len(vertices):
                    problem = f"has a triangle of vertex {rows.max()}; there are {len(vertices)}"
                    raise InputError(path, problem, "export it again")
            else:
                rows = np.arange(len(vertices))
            faces.append(rows[: len(rows) // 3 * 3].reshape(-1, 3) + count)
            places.append(vertices @ world[:3, :3].T + world[:3, 3])
            count += len(vertices)
    return mesh_of_polygons(path, np.concatenate(places), np.concatenate(faces))
