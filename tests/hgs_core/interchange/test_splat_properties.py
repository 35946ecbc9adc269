"""Splats of other programs: other names, other meanings of numbers, places far away."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.interchange import import_scene
from hgs_core.interchange.ply.ply_table import write_ply
from hgs_core.scene import StaticSplats
from tests.hgs_core.interchange.scenes import Write, statics

COUNT = 300
UNTOLD = "drawing without antialiasing"


def columns(count: int = COUNT) -> dict[str, np.ndarray]:
    s = statics(count)
    names = ["x", "y", "z", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3", "opacity"]
    table = np.concatenate([s.means, s.log_scales, s.quats, s.opacity_logits[:, None]], axis=1)
    dc = {f"f_dc_{i}": (s.rgb[:, i] - 0.5) / 0.28209479 for i in range(3)}
    return dict(zip(names, table.T.astype(np.float64), strict=True)) | dc


def but(table: dict[str, np.ndarray], rename: dict[str, str], **more: np.ndarray) -> dict[str, np.ndarray]:
    return {rename.get(name, name): array for name, array in table.items() if rename.get(name, name)} | more


def told(path: Path, **options: object) -> tuple[StaticSplats[np.ndarray], list[str]]:
    found = import_scene(path, **options)  # type: ignore[arg-type]
    return found.scene.static, [change.what for change in found.changes if change.what != UNTOLD]


def test_other_names_are_known(written: Write) -> None:
    plain, _ = told(written("x.ply", write_ply(columns())))
    names = {"opacity": "alpha", "rot_0": "qw", "rot_1": "qx", "rot_2": "qy", "rot_3": "qz"}
    names |= {f"scale_{i}": f"scale_{axis}" for i, axis in enumerate("xyz")}
    found, changes = told(written("y.ply", write_ply(but(columns(), names))))
    for name, array in plain.items():
        np.testing.assert_array_equal(getattr(found, name), array)
    assert changes == []


@pytest.mark.parametrize(("names", "most"), [(("red", "green", "blue"), 255), (("r", "g", "b"), 1)])
def test_plain_colours_take_the_place_of_harmonics(written: Write, names: tuple[str, ...], most: float) -> None:
    rgb = statics(COUNT).rgb
    table = but(columns(), {f"f_dc_{i}": "" for i in range(3)}, **dict(zip(names, most * rgb.T, strict=True)))
    found, _ = told(written("x.ply", write_ply(table)))
    np.testing.assert_allclose(found.rgb, rgb, atol=1e-6)


def test_a_surfel_is_a_flat_splat(written: Write) -> None:
    found, changes = told(written("x.ply", write_ply(but(columns(), {"scale_2": ""}))))
    assert changes == ["thickness"]
    np.testing.assert_allclose(found.log_scales[:, 2], np.log(1e-6), rtol=1e-6)
    np.testing.assert_allclose(found.log_scales[:, :2], statics(COUNT).log_scales[:, :2])


def test_the_points_that_a_training_begins_with_are_no_splats(written: Write) -> None:
    points = {name: columns()[name] for name in ("x", "y", "z")} | dict.fromkeys(
        ("red", "green", "blue"), np.ones(COUNT)
    )
    with pytest.raises(InputError, match=r"holds points, not splats: .*point_cloud/iteration_30000/point_cloud\.ply$"):
        import_scene(written("x.ply", write_ply(points)))
