"""The splats of any file after import: omissions, limits, and the length of the scene."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.interchange.gltf.gaussian_glb import glb_file
from hgs_core.interchange.gltf.glb_container import glb_bytes, read_glb
from hgs_core.interchange.import_scene import import_scene
from hgs_core.interchange.ply.spacetime_ply import spacetime_ply
from hgs_core.interchange.splat_file import splat_file
from hgs_core.interchange.spz.spz_file import spz_file
from hgs_core.interchange.still_moment import scene_at
from hgs_core.scene import DynamicSplats, HybridScene, Segment
from tests.hgs_core.interchange.scenes import Write, counted, export, gaussian_ply_of, plain, plain_but, statics

NOT_SAID = ("assumed", "drawing without antialiasing")


def test_a_still_file_lasts_no_time_and_a_moving_one_as_long_as_asked(
    scene: HybridScene[np.ndarray], written: Write
) -> None:
    still = import_scene(written("x.ply", gaussian_ply_of(scene.static)), 3.0)
    assert (still.scene.start, still.scene.end, still.splats, still.changes) == (0.0, 0.0, 50, ())
    data = spacetime_ply(scene.static, scene.segments[0].dynamic).data
    moving = import_scene(written("x.ply", data), 3.0)
    assert (moving.scene.start, moving.scene.end, moving.splats) == (0.0, 3.0, 80)
    assert (len(moving.scene.static), moving.scene.dynamic_splats) == (50, 30)


@pytest.mark.parametrize("antialiased", [False, True])
def test_the_scene_is_drawn_as_the_file_says(written: Write, antialiased: bool) -> None:
    found = import_scene(written("x.spz", spz_file(plain(), antialiased=antialiased).data), 1.0)
    assert found.scene.antialiased == antialiased


def test_splats_that_are_no_numbers_are_left_out_and_others_limited_attribute_by_attribute(written: Write) -> None:
    given = plain_but(
        means={0: np.nan, 1: np.inf},
        quats={2: np.nan},
        opacity_logits={3: np.inf, 4: -np.inf},
        log_scales={5: -np.inf, 6: 99.0},
        rgb={7: -0.5, 8: np.nan},
    ).static
    found = import_scene(written("x.ply", gaussian_ply_of(given)), 1.0)
    assert (found.splats, len(found.scene.static)) == (20, 16)
    assert [str(change) for change in found.changes] == [
        "2 of 20 splats left out: position is no finite number",
        "1 of 20 splats left out: rotation is no finite number",
        "1 of 20 splats left out: colour is no finite number",
        "opacity of 2 of 16 splats limited: to 0.000001 to 0.999999",
        "scale of 2 of 16 splats limited: to e^-30 to e^30",
        "colour of 1 of 16 splats limited: to 0 to 8",
    ]
    static = found.scene.static
    opacities = 1 / (1 + np.exp(-static.opacity_logits.astype(np.float64)))
    np.testing.assert_allclose(opacities[:2], [1 - 1e-6, 1e-6], rtol=0.01)
    assert (static.log_scales[2:4, 0].tolist(), static.rgb[4, 0]) == ([-30, 30], 0)


def test_motions_that_are_no_numbers_are_left_out(scene: HybridScene[np.ndarray], written: Write) -> None:
    dynamic = scene.segments[0].dynamic
    dynamic.motion[:2, 2] = np.nan
    changes = import_scene(written("x.ply", spacetime_ply(scene.static, dynamic).data), 1.0).changes
    assert counted(changes) == {("left out", "splats"): 2}
    assert changes[-1].reason == "position or motion is no finite number"


def test_a_deviation_below_0_is_no_scale_and_one_of_0_a_thin_one(written: Write) -> None:
    rows = np.frombuffer(splat_file(plain()).data, "<f4").reshape(20, 8).copy()
    rows[0, 3] = -1.0
    rows[1:4, 4] = 0.0
    found = counted(import_scene(written("x.splat", rows.tobytes()), 1.0).changes)
    assert found == {("left out", "splats"): 1, ("limited", "scale"): 3, NOT_SAID: None}


@pytest.mark.parametrize(
    ("name", "value", "problem"),
    [
        ("means", np.nan, "holds no splat that can be seen: all 20 splats left out: position is no finite number"),
        ("opacity_logits", -8.0, "holds no splat that can be seen; export it again"),
    ],
)
def test_a_file_of_which_nothing_would_be_left_is_refused(
    written: Write, name: str, value: float, problem: str
) -> None:
    splats = plain()
    nothing = dataclasses.replace(splats, **{name: np.full_like(getattr(splats, name), value)})
    with pytest.raises(InputError, match=problem):
        import_scene(written("x.ply", gaussian_ply_of(nothing)), 1.0)


def test_a_file_without_splats_is_refused(written: Write) -> None:
    header = gaussian_ply_of(plain(1)).partition(b"end_header\n")[0].replace(b"vertex 1", b"vertex 0")
    with pytest.raises(InputError, match="holds no splats; give a file with at least one"):
        import_scene(written("x.ply", header + b"end_header\n"), 1.0)


@pytest.mark.parametrize("name", ["x.ply", "x.splat", "x.spz"])
def test_a_missing_file_is_named(tmp_path: Path, name: str) -> None:
    with pytest.raises(InputError, match=name):
        import_scene(tmp_path / name, 1.0)


def test_a_format_that_cannot_be_read_is_refused(written: Write) -> None:
    with pytest.raises(InputError, match=r"has the suffix '\.splatv'; give one of \.ply, \.splat, \.spz"):
        import_scene(written("x.splatv", b""), 1.0)


def test_frames_are_shown_one_after_another_each_for_its_time(tmp_path: Path) -> None:
    parts = [statics(3, seed) for seed in range(4)]
    for number, part in enumerate(parts):
        export(HybridScene(part, (Segment(0.0, 0.0, DynamicSplats.empty()),)), tmp_path / f"f{number}.ply")
    found = import_scene(tmp_path, frame_rate=8.0)
    assert [part.start for part in found.scene.segments] == [0, 0.125, 0.25, 0.375]
    assert found.scene.end == 0.5
    assert (len(found.scene.static), found.splats) == (0, 12)
    for seconds, part in ((0.0, 0), (0.12, 0), (0.13, 1), (0.5, 3)):
        np.testing.assert_allclose(scene_at(found.scene, seconds).means, parts[part].means, atol=1e-6)


def test_what_overflows_on_its_way_is_told_like_what_is_not_finite_in_the_file(written: Write) -> None:
    """A node of a GLB that stretches everything by 2e39, of which the first splats stay within floats."""
    document, binary = read_glb(written("x.glb", glb_file(plain()).data))
    document["nodes"][0]["scale"] = [2e39] * 3
    found = import_scene(written("x.glb", glb_bytes(document, binary)))
    told = {change.reason: change.count for change in found.changes}
    beyond = np.abs(plain().means[:, 0].astype(np.float64) * 2e39) > np.finfo(np.float32).max
    assert told["position is no finite number"] == beyond.sum() == 9
    assert told["position is beyond 1e+30"] == 10
    assert len(found.scene.static) == 1
