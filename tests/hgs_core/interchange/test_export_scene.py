"""The files of exports, the losses of formats, and refused exports."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.base.progress import silent
from hgs_core.interchange import export_sequence, import_scene
from hgs_core.scene import HybridScene, Segment, StaticSplats
from tests.hgs_core.interchange.scenes import CAMERA, axes_of, counted, export, plain_but

HARD = {
    "means": {0: 1e-5},
    "rgb": {1: -0.25, 2: 1.75, 3: 0.3333},
    "opacity_logits": {4: -9.0, 5: 0.77, 6: 40.0},
    "log_scales": {7: -100.0, 8: 90.0, 9: -2.01},
    "quats": {10: 0.7},
}
LOST = {
    ".ply": {("limited", "opacity"): 1, ("limited", "colour"): 1},
    ".splat": {
        ("limited", "scale"): 2,
        ("limited", "colour"): 2,
        ("rounded", "colour"): 20,
        ("rounded", "opacity"): 1,
        ("replaced", "opacity"): 1,
        ("rounded", "rotation"): 20,
    },
    ".spz": {
        ("rounded", "position"): 1,
        ("limited", "scale"): 2,
        ("rounded", "scale"): 1,
        ("limited", "colour"): 1,
        ("rounded", "colour"): 20,
        ("rounded", "opacity"): 1,
        ("replaced", "opacity"): 1,
    },
    ".sog": {
        ("rounded", "position"): 17,
        ("rounded", "opacity"): 1,
        ("replaced", "opacity"): 1,
        ("rounded", "rotation"): 20,
    },
    ".glb": {("limited", "scale"): 2, ("limited", "colour"): 1},
}


@pytest.mark.parametrize("suffix", list(LOST))
def test_what_a_still_format_cannot_hold_is_counted_by_kind(tmp_path: Path, suffix: str) -> None:
    assert counted(export(plain_but(**HARD), tmp_path / f"x{suffix}")) == LOST[suffix]


def test_what_a_format_holds_is_not_told(tmp_path: Path) -> None:
    assert export(plain_but(), tmp_path / "x.ply") == ()


@pytest.mark.parametrize(
    ("suffix", "expected"),
    [
        (".ply", ["background", "antialiasing"]),
        (".splat", ["background", "antialiasing"]),
        (".splatv", ["background", "time", "antialiasing"]),
        (".spz", ["background"]),
        (".sog", ["background"]),
        (".glb", ["background", "antialiasing"]),
        (".4dgs", ["background", "antialiasing", "time"]),
    ],
)
def test_what_a_scene_has_as_a_whole_is_told(tmp_path: Path, suffix: str, expected: list[str]) -> None:
    if suffix == ".4dgs":
        pytest.importorskip("fourdgs", reason="fourdgs is not installed (extra 4dgs)")
    scene = dataclasses.replace(plain_but(), antialiased=True, background=(1.0, 1.0, 1.0))
    found = counted(export(scene, tmp_path / f"x{suffix}"))
    assert [what for (_, what), count in found.items() if count is None] == expected


def test_a_moment_of_a_moving_scene_tells_what_it_lacks(scene: HybridScene[np.ndarray], tmp_path: Path) -> None:
    dynamic = scene.segments[0].dynamic
    dynamic.time_centers[:10], dynamic.time_log_precisions[:10] = 0.0, 9.0  # long gone at 3 s
    dynamic.time_centers[10:], dynamic.time_log_precisions[10:] = 0.5, 0.0
    found = counted(export(scene, tmp_path / "x.ply", time=3.0))
    assert found[("left out", "splats")] == 10
    assert found[("left out", "motion and life")] == 20
    assert import_scene(tmp_path / "x.ply", 1.0).splats == 70


def test_of_several_segments_the_one_named_is_written_and_the_others_are_told(
    scene: HybridScene[np.ndarray], tmp_path: Path
) -> None:
    own = scene.segments[0]
    own.dynamic.opacity_logits[:3] = -9  # below 1/255
    own.dynamic.time_log_precisions[3:5] = 50.0
    longer = HybridScene(scene.static, (own, Segment(4.0, 6.0, own.dynamic.take(slice(20, 27)))))
    changes = export(longer, tmp_path / "x.ply", segment=0)
    assert sorted(str(change) for change in changes) == [
        "3 of 80 splats left out: they are never seen",
        "7 of 87 splats left out: they are of other segments",
        "life of 2 of 27 splats limited: to widths of 2.1e-09 to 2.2e+04 of the time shown",
        "time replaced: 0 to 1 stands for 2 to 4 s",
    ]
    export(longer, tmp_path / "y.ply", segment=1)
    found = import_scene(tmp_path / "y.ply", 1.0).scene.segments[0].dynamic
    np.testing.assert_array_equal(found.time_centers, longer.segments[1].dynamic.time_centers)


@pytest.mark.parametrize("suffix", [".ply", ".splatv"])
def test_how_near_a_cubic_comes_to_a_motion_of_the_fifth_order_is_told(
    scene: HybridScene[np.ndarray], tmp_path: Path, suffix: str
) -> None:
    own = scene.segments[0]
    motion = np.pad(own.dynamic.motion, ((0, 0), (0, 2), (0, 0)))
    cubic = dataclasses.replace(own, dynamic=dataclasses.replace(own.dynamic, motion=motion.copy()))
    motion[0, 5] = 1.0
    fifth = dataclasses.replace(own, dynamic=dataclasses.replace(own.dynamic, motion=motion))
    (change,) = [
        change
        for change in export(HybridScene(scene.static, (fifth,)), tmp_path / f"x{suffix}")
        if "motion of the fifth order, by the nearest cubic, off by at most" in change.reason
    ]
    assert (str(change.action), change.what, change.count, change.of) == ("replaced", "motion", 1, 80)
    told = export(HybridScene(scene.static, (cubic,)), tmp_path / f"x{suffix}")
    assert not any("fifth" in change.reason for change in told)


@pytest.mark.parametrize("suffix", [".ply", ".splat", ".spz", ".sog"])
def test_a_mirrored_axis_would_be_seen(still: HybridScene[np.ndarray], tmp_path: Path, suffix: str) -> None:
    """A splat to the right (+x), one below (+y), one ahead (+z), each turned by 90 degrees about another axis."""
    half = np.sqrt(0.5)
    given = StaticSplats(
        np.diag([1.0, 2.0, 3.0]).astype(np.float32),
        np.log([[0.4, 0.2, 0.1]] * 3).astype(np.float32),
        np.array([[half, half, 0, 0], [half, 0, half, 0], [half, 0, 0, half]], np.float32),
        np.array([5, 2, 1], np.float32),
        np.eye(3, dtype=np.float32) * 0.5 + 0.2,
    )
    export(dataclasses.replace(still, static=given), tmp_path / f"x{suffix}")
    found = import_scene(tmp_path / f"x{suffix}", 1.0).scene.static
    found = found.take(np.argsort(found.means.argmax(axis=1)))
    np.testing.assert_allclose(found.means, given.means, atol=1e-3)
    np.testing.assert_allclose(axes_of(found.quats), axes_of(given.quats), atol=0.02)
    # Seen by a camera at the origin that looks along +z, the one on +y lies below the one on +z.
    pixels, _ = CAMERA.project(found.means + np.array([0, 0, 5]))
    assert pixels[0, 0] > pixels[2, 0] + 50
    assert pixels[1, 1] > pixels[2, 1] + 50


@pytest.mark.parametrize(
    ("name", "more", "problem"),
    [
        ("x.obj", {}, "has the suffix '.obj'; give one of .ply, .splat, .splatv, .spz"),
        ("x.splat", {}, "holds one moment, and this scene moves; add --time 2 to 4"),
        ("x.splat", {"time": 5.0}, "--time: 5.0 s is outside the scene; give 2 to 4"),
        ("x.splat", {"time": 1.9}, "--time: 1.9 s is outside the scene; give 2 to 4"),
        ("x.splatv", {"time": 3.0}, "--time: is not for .splatv"),
        ("x.ply", {"segment": 2}, "--segment: 2 is not one of the scene's; give one of 0 to 1"),
        ("x.ply", {"segment": -1}, "--segment: -1 is not one of the scene's"),
        ("x.ply", {}, "--segment: is missing: the scene has 2 segments; give one of 0 to 1"),
    ],
)
def test_an_export_that_cannot_be_is_refused_and_nothing_is_written(
    scene: HybridScene[np.ndarray], tmp_path: Path, name: str, more: dict[str, float], problem: str
) -> None:
    first, second = Segment(2.0, 3.0, scene.segments[0].dynamic), Segment(3.0, 4.0, scene.segments[0].dynamic)
    with pytest.raises(InputError) as caught:
        export(HybridScene(scene.static, (first, second)), tmp_path / name, **more)
    assert problem in str(caught.value)
    assert not any(tmp_path.iterdir())


def test_a_version_is_chosen_of_spz_and_of_nothing_else(tmp_path: Path) -> None:
    for version in (2, 3, 4):
        export(plain_but(), tmp_path / "x.spz", version=version)
        assert (tmp_path / "x.spz").read_bytes().startswith(b"NGSP") == (version == 4)
    for name, version in (("x.spz", 5), ("x.glb", 3)):
        with pytest.raises(InputError, match=rf"--spz-version: {version} is none of {name[1:]}; leave it out"):
            export(plain_but(), tmp_path / name, version=version)


def test_frames_lack_what_their_format_cannot_say(scene: HybridScene[np.ndarray], tmp_path: Path) -> None:
    drawn = dataclasses.replace(scene, antialiased=True, background=(1.0, 0.0, 0.0))
    changes = export_sequence(drawn, tmp_path / "frames", 1.0, silent)
    assert {"background", "antialiasing"} <= {change.what for change in changes}
    assert all(change.count != 0 for change in changes)
