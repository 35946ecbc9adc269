"""Compressed .ply files: one of another program, and words packed by hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.interchange import import_scene
from hgs_core.interchange.ply.compressed_ply import is_compressed, unpacked
from hgs_core.scene.opacities import opacities_of
from tests.hgs_core.interchange.gltf.test_gaussian_glb import VECTORS
from tests.hgs_core.interchange.scenes import axes_of, statics

ENDS = {"x": (1, 3), "y": (-1, 1), "z": (0, 8), "scale_x": (-4, 0), "scale_y": (-4, 0), "scale_z": (-4, 0)}


def one(**more: np.ndarray) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """A splat at the lower end of x, the upper one of y, in the middle of z; its largest component is y's."""
    word = lambda value: np.array([value], np.uint32)  # noqa: E731
    vertices = {
        "packed_position": word(0 << 21 | 1023 << 11 | 1024),
        "packed_scale": word(2047 << 21 | 0 << 11 | 2047),
        "packed_rotation": word(2 << 30 | 512 << 20 | 1023 << 10 | 512),
        "packed_color": word(255 << 24 | 51),
    }
    chunks = {
        f"{end}_{name}": np.float32([ends[i]]) for name, ends in ENDS.items() for i, end in ((0, "min"), (1, "max"))
    }
    return vertices | more, chunks


def test_words_are_shares_between_the_bounds() -> None:
    table = unpacked(Path("x.ply"), *one())
    found = {name: float(array[0]) for name, array in table.items()}
    assert [found[axis] for axis in "xyz"] == pytest.approx([1, 1, 8 * 1024 / 2047])
    assert [found[f"scale_{i}"] for i in range(3)] == [0, -4, 0]
    half = (512 / 1023 - 0.5) * 2**0.5
    assert [found[f"rot_{i}"] for i in (0, 1, 3)] == pytest.approx([half, 0.5**0.5, half], abs=1e-6)
    assert found["rot_2"] == pytest.approx(0.5**0.5, abs=1e-3)
    assert opacities_of(table["opacity"])[0] == pytest.approx(0.2, rel=1e-5)
    assert [found[f"f_dc_{i}"] * 0.28209479 + 0.5 for i in range(3)] == pytest.approx([1, 0, 0], abs=1e-6)


def test_colours_have_bounds_where_the_file_does() -> None:
    vertices, chunks = one()
    chunks |= {f"min_{c}": np.float32([0.5]) for c in "rgb"} | {f"max_{c}": np.float32([1.5]) for c in "rgb"}
    table = unpacked(Path("x.ply"), vertices, chunks)
    assert [float(table[f"f_dc_{i}"][0]) * 0.28209479 + 0.5 for i in range(3)] == pytest.approx([1.5, 0.5, 0.5])


def test_bounds_that_do_not_fit_and_missing_words_are_refused() -> None:
    vertices, chunks = one()
    with pytest.raises(InputError, match="has bounds of 0 chunks, 1 splats need 1"):
        unpacked(Path("x.ply"), vertices, None)
    with pytest.raises(InputError, match="has no vertex property uint packed_color"):
        unpacked(Path("x.ply"), {name: array for name, array in vertices.items() if name != "packed_color"}, chunks)
    with pytest.raises(InputError, match="has no vertex property max_z"):
        unpacked(Path("x.ply"), vertices, {name: array for name, array in chunks.items() if name != "max_z"})
    assert not is_compressed({"x": np.zeros(1)})


@pytest.mark.parametrize(("name", "place", "scale"), [("compressed.ply", 0.01, 0.01), ("sog", 1e-3, 0.2)])
def test_files_of_another_program_are_our_splats(name: str, place: float, scale: float) -> None:
    """splat-transform 2.7.1 made them of a 3DGS file of these splats."""
    given = statics(12, 7)
    found = import_scene(VECTORS / f"splat_transform.{name}").scene.static
    order = [int(np.abs(found.means - mean).sum(axis=1).argmin()) for mean in given.means]
    assert sorted(order) == list(range(12))
    found = found.take(order)
    np.testing.assert_allclose(found.means, given.means, atol=place)
    np.testing.assert_allclose(found.log_scales, given.log_scales, atol=scale)
    np.testing.assert_allclose(found.rgb, given.rgb, atol=0.03)
    np.testing.assert_allclose(opacities_of(found.opacity_logits), opacities_of(given.opacity_logits), atol=1 / 255)
    np.testing.assert_allclose(axes_of(found.quats), axes_of(given.quats), atol=0.03)
