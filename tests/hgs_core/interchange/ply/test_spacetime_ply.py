"""Point clouds of Spacetime Gaussians: its equations are the reference for the meaning of fields."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.interchange.changes import nonzero
from hgs_core.interchange.ply.ply_table import read_ply
from hgs_core.interchange.ply.spacetime_ply import is_spacetime, spacetime_ply, spacetime_splats
from hgs_core.scene import DynamicSplats, HybridScene, evaluate
from tests.hgs_core.interchange.scenes import Write, counted, dynamics, statics

FIELDS = "x y z trbf_center trbf_scale nx ny nz " + " ".join(f"motion_{i}" for i in range(9))
FIELDS += " f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3"
NAMES = (FIELDS + " omega_0 omega_1 omega_2 omega_3").split()


def table_of(scene: HybridScene[np.ndarray], written: Write) -> dict[str, np.ndarray]:
    data = spacetime_ply(scene.static, scene.segments[0].dynamic).data
    return dict(read_ply(written("x.ply", data)).vertices)


def test_a_file_has_the_fields_and_the_size_of_its_trainer(scene: HybridScene[np.ndarray]) -> None:
    data = spacetime_ply(scene.static, scene.segments[0].dynamic).data
    header, _, rows = data.partition(b"end_header\n")
    assert [line.split()[2] for line in header.decode().splitlines() if line.startswith("property float")] == NAMES
    assert len(rows) == 80 * 128


@pytest.mark.parametrize("time", [0.0, 0.35, 1.0])
def test_the_trainers_equations_draw_the_scene(scene: HybridScene[np.ndarray], written: Write, time: float) -> None:
    """Statics come first, and stand at every time as they are."""
    table = {name: array.astype(np.float64) for name, array in table_of(scene, written).items()}
    d = time - table["trbf_center"]
    place = [
        table[axis] + sum(table[f"motion_{3 * k + i}"] * d ** (k + 1) for k in range(3)) for i, axis in enumerate("xyz")
    ]
    turn = np.stack([table[f"rot_{i}"] + table[f"omega_{i}"] * d for i in range(4)], axis=1)
    opacity = np.exp(-((d / np.exp(table["trbf_scale"])) ** 2)) / (1 + np.exp(-table["opacity"]))
    positions, quats, opacities = evaluate(scene.segments[0].dynamic, time)
    static = scene.static
    np.testing.assert_allclose(np.stack(place, axis=1), np.concatenate([static.means, positions]), rtol=1e-5, atol=1e-5)
    unit = turn / np.linalg.norm(turn, axis=1, keepdims=True)
    np.testing.assert_allclose(unit, np.concatenate([static.quats, quats]), atol=1e-5)
    still = 1 / (1 + np.exp(-static.opacity_logits.astype(np.float64)))
    np.testing.assert_allclose(opacity, np.concatenate([still, opacities]), rtol=1e-4, atol=1e-7)
    colours = np.stack([table[f"f_dc_{i}"] for i in range(3)], axis=1)  # colours themselves, no harmonics
    np.testing.assert_array_equal(colours, np.concatenate([static.rgb, scene.segments[0].dynamic.rgb]))


def test_splats_of_both_kinds_come_back(scene: HybridScene[np.ndarray], written: Write) -> None:
    found = spacetime_splats(Path("x.ply"), table_of(scene, written))
    static, (dynamic,) = found.static, found.dynamic
    for name, array in scene.static.items():
        np.testing.assert_array_equal(getattr(static, name), array)
    for name, array in scene.segments[0].dynamic.items():
        np.testing.assert_allclose(getattr(dynamic, name), array, rtol=1e-6, atol=1e-6)
    assert nonzero(found.changes) == ()


@pytest.mark.parametrize(("field", "value"), [("motion_8", 1e-9), ("omega_3", 1e-9), ("trbf_scale", 4.9)])
def test_what_moves_turns_or_fades_in_the_least_is_dynamic(
    scene: HybridScene[np.ndarray], written: Write, field: str, value: float
) -> None:
    table = table_of(scene, written)
    table[field] = table[field].copy()
    table[field][7] = value
    found = spacetime_splats(Path("x.ply"), table)
    static, (dynamic,) = found.static, found.dynamic
    assert (len(static), len(dynamic)) == (49, 31)
    np.testing.assert_array_equal(dynamic.motion[0, 0], scene.static.means[7])


def test_features_of_the_full_model_are_left_out_and_counted(scene: HybridScene[np.ndarray], written: Write) -> None:
    more = {"f_t_0": np.arange(80, dtype=np.float32) // 75, "age": np.zeros(80, np.float32)}
    changes = spacetime_splats(Path("x.ply"), table_of(scene, written) | more).changes
    assert counted(nonzero(changes)) == {("left out", "features f_t"): 5, ("left out", "properties age"): None}


def test_a_point_cloud_is_told_by_its_times_and_a_missing_field_is_named(
    scene: HybridScene[np.ndarray], written: Write
) -> None:
    table = table_of(scene, written)
    assert is_spacetime(table)
    assert not is_spacetime({name: array for name, array in table.items() if not name.startswith("trbf")})
    del table["omega_2"]
    with pytest.raises(InputError, match="has no vertex property omega_2"):
        spacetime_splats(Path("x.ply"), table)


def test_splats_that_are_never_seen_are_left_out_and_lives_are_limited() -> None:
    dynamic = dynamics()
    dynamic.opacity_logits[:3] = -9  # below 1/255
    dynamic.time_log_precisions[3:5] = 50.0
    assert sorted(str(change) for change in spacetime_ply(statics(), dynamic).changes if change.count) == [
        "3 of 80 splats left out: they are never seen",
        "life of 2 of 27 splats limited: to widths of 2.1e-09 to 2.2e+04 of the time shown",
    ]


def test_logits_that_viewers_cannot_take_are_limited_and_dark_colours_told(written: Write) -> None:
    static = statics(4)
    static.opacity_logits[0], static.rgb[1, 2] = 40.0, -0.1
    data, changes = spacetime_ply(static, DynamicSplats.empty()).data, spacetime_ply(static, dynamics(0)).changes
    found = counted(changes)
    assert (found["limited", "opacity"], found["limited", "colour"]) == (1, 1)
    assert read_ply(written("x.ply", data)).vertices["opacity"][0] == 30
