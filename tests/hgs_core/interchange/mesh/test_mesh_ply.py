"""PLY meshes of text and of bytes."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.interchange.mesh.mesh_ply import ply_mesh
from tests.hgs_core.interchange.mesh.meshes import TRIANGLES, VERTICES, ply


@pytest.mark.parametrize("order", ["<", ">", ""])
def test_faces_before_vertices_and_other_properties_are_read(tmp_path: Path, order: str) -> None:
    (tmp_path / "a.ply").write_bytes(ply(order))
    np.testing.assert_allclose(ply_mesh(tmp_path / "a.ply").corners, VERTICES[TRIANGLES])


@pytest.mark.parametrize("order", ["<", ""])
def test_polygons_of_several_lengths_are_read(tmp_path: Path, order: str) -> None:
    kind = "binary_little_endian" if order else "ascii"
    head = f"ply\nformat {kind} 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z\n"
    head += "element face 2\nproperty list uchar uint vertex_index\nend_header\n"
    if order:
        body = VERTICES.astype("<f8").tobytes() + struct.pack("<B4I", 4, 0, 1, 2, 3) + struct.pack("<B3I", 3, 0, 1, 2)
    else:
        body = ("".join(f"{x} {y} {z}\n" for x, y, z in VERTICES) + "4 0 1 2 3\n3 0 1 2\n").encode()
    (tmp_path / "a.ply").write_bytes(head.encode() + body)
    triangles = sorted(map(tuple, ply_mesh(tmp_path / "a.ply").triangles.tolist()))
    assert triangles == [(0, 1, 2), (0, 1, 2), (0, 2, 3)]


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (
            ply("").replace(b"element face 2", b"element face 0").replace(b"7 3 0 1 2\n7 3 0 2 3\n", b""),
            r"has no faces",
        ),
        (ply("<")[:-40], r"has 12 bytes of vertices, 4 need 52; copy it again"),
        (ply("<").replace(b"face 2", b"face 2000000000"), r"ends in row 7"),
    ],
)
def test_a_wrong_file_is_refused_with_a_cure(tmp_path: Path, content: bytes, problem: str) -> None:
    (tmp_path / "a.ply").write_bytes(content)
    with pytest.raises(InputError, match=problem):
        ply_mesh(tmp_path / "a.ply")
