"""GLB meshes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.interchange.mesh.mesh_glb import glb_mesh
from tests.hgs_core.interchange.mesh.meshes import TRIANGLES, VERTICES, glb


def test_triangles_stand_where_their_nodes_place_them(tmp_path: Path) -> None:
    (tmp_path / "a.glb").write_bytes(glb())
    np.testing.assert_allclose(glb_mesh(tmp_path / "a.glb").corners, VERTICES[TRIANGLES])


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (glb().replace(b'"mode":0', b'"mode":5'), r"has a primitive of mode 5, a strip or fan; export plain"),
        (glb().replace(b'"VEC3"', b'"VEC2"'), r"has positions of 2 numbers"),
        (b"glTF", r"is not a GLB file"),
    ],
)
def test_a_wrong_file_is_refused_with_a_cure(tmp_path: Path, content: bytes, problem: str) -> None:
    (tmp_path / "a.glb").write_bytes(content)
    with pytest.raises(InputError, match=problem):
        glb_mesh(tmp_path / "a.glb")
