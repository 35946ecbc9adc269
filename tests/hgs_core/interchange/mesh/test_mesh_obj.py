"""OBJ meshes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.interchange.mesh.mesh_obj import obj_mesh
from tests.hgs_core.interchange.mesh.meshes import TRIANGLES, VERTICES, obj


def test_faces_count_vertices_from_the_first_or_back_from_the_last(tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_bytes(obj())
    np.testing.assert_allclose(obj_mesh(tmp_path / "a.obj").corners, VERTICES[TRIANGLES])


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (b"v 1 2\n", r"line 1 is 'v 1 2', which is no vertex or face; export it again"),
        (b"v 1 2 3\nf 1 0 1\n", r"line 2 is 'f 1 0 1'"),
        (b"v 1 2 3\nf 1 1 9\n", r"has a triangle of vertex 8; there are 1"),
        (b"", r"has no triangles"),
    ],
)
def test_a_wrong_file_is_refused_with_a_cure(tmp_path: Path, content: bytes, problem: str) -> None:
    (tmp_path / "a.obj").write_bytes(content)
    with pytest.raises(InputError, match=problem):
        obj_mesh(tmp_path / "a.obj")
