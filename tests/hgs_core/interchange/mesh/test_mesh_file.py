"""Mesh files: chosen by the ending, bounded, and never a cause of another error."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hgs_core.base.errors import InputError
from hgs_core.interchange.mesh.mesh_file import read_mesh
from hgs_core.interchange.mesh.triangles import MOST_BYTES
from tests.hgs_core.interchange.mesh.meshes import FILES, TRIANGLES, VERTICES


@pytest.mark.parametrize("name", FILES)
def test_a_surface_is_the_same_in_every_format(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_bytes(FILES[name])
    mesh = read_mesh(tmp_path / name)
    np.testing.assert_allclose(mesh.corners, VERTICES[TRIANGLES])


def test_another_ending_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"has the ending '\.stl'; give a mesh as \.ply, \.obj, \.glb"):
        read_mesh(tmp_path / "a.stl")


def test_too_large_a_file_is_refused_before_it_is_read(tmp_path: Path) -> None:
    path = tmp_path / "a.ply"
    path.touch()
    os.truncate(path, MOST_BYTES + 1)
    with pytest.raises(InputError, match=r"has 1073741825 bytes, and 1073741824 are the most"):
        read_mesh(path)


@pytest.mark.parametrize("name", FILES)
@given(
    changes=st.lists(st.tuples(st.integers(0, 1 << 16), st.integers(0, 255)), max_size=6), cut=st.integers(0, 1 << 16)
)
@settings(max_examples=150, deadline=None)
def test_no_damage_raises_another_error(
    tmp_path_factory: pytest.TempPathFactory, name: str, changes: list[tuple[int, int]], cut: int
) -> None:
    """Cut short, or with bytes changed, a file is read or refused."""
    data = bytearray(FILES[name])
    for place, value in changes:
        data[place % len(data)] = value
    path = tmp_path_factory.getbasetemp() / f"damaged{Path(name).suffix}"
    path.write_bytes(bytes(data[: cut % len(data)] if cut % 3 == 0 else data))
    with contextlib.suppress(InputError):
        assert np.isfinite(read_mesh(path).corners).all()
