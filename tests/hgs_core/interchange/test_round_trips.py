"""What is exported is imported again: exactly where the format holds floats, within its steps elsewhere."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from hgs_core.codec.encoder.rotations import matrices
from hgs_core.interchange import Action, Change, export_scene, import_scene, scene_at
from hgs_core.scene import HybridScene, Segment, StaticSplats, evaluate
from hgs_core.scene.camera import Camera

CAMERA = Camera("cam00", 640, 480, 500.0, 510.0, 320.0, 240.0, np.eye(4))


def export(scene: HybridScene[np.ndarray], path: Path, **more: object) -> tuple[Change, ...]:
    return export_scene(scene, path, cameras=[CAMERA], **more)  # type: ignore[arg-type]


def axes_of(quats: np.ndarray) -> np.ndarray:
    return matrices(quats / np.linalg.norm(quats, axis=1, keepdims=True))


def test_a_3dgs_ply_gives_the_same_floats_but_for_the_harmonic_of_colours(
    still: HybridScene[np.ndarray], tmp_path: Path
) -> None:
    export(still, tmp_path / "x.ply")
    found = import_scene(tmp_path / "x.ply", 1.0)
    for name in ("means", "log_scales", "quats", "opacity_logits"):
        np.testing.assert_array_equal(getattr(found.scene.static, name), getattr(still.static, name))
    np.testing.assert_allclose(found.scene.static.rgb, still.static.rgb, atol=1e-6)
    assert (len(found.scene.segments[0].dynamic), found.changes, found.scene.antialiased) == (0, (), False)


def test_an_stgs_ply_gives_the_same_splats_of_both_kinds(scene: HybridScene[np.ndarray], tmp_path: Path) -> None:
    export(scene, tmp_path / "x.ply")
    found = import_scene(tmp_path / "x.ply", 2.0).scene
    assert (found.start, found.end) == (0.0, 2.0)
    for name, array in scene.static.items():
        np.testing.assert_array_equal(getattr(found.static, name), array)
    for name, array in scene.segments[0].dynamic.items():
        np.testing.assert_allclose(getattr(found.segments[0].dynamic, name), array, rtol=1e-6, atol=1e-6)


def test_motion_of_the_fifth_order_becomes_the_nearest_cubic_and_it_is_said_how_near(
    scene: HybridScene[np.ndarray], tmp_path: Path
) -> None:
    """Reference: numpy's polyfit over the times at which a splat that hardly fades is seen."""
    own = scene.segments[0].dynamic
    motion = np.pad(own.motion, ((0, 0), (0, 2), (0, 0)))
    motion[0, :, 0] = 50, 3, -2, 1, 8, -40
    dynamic = dataclasses.replace(own, motion=motion)
    dynamic.time_centers[0], dynamic.time_log_precisions[0] = 0.5, -20
    dynamic.opacity_logits[0] = 5
    fifth = dataclasses.replace(scene, segments=(dataclasses.replace(scene.segments[0], dynamic=dynamic),))
    (change,) = [change for change in export(fifth, tmp_path / "x.ply") if "fifth" in change.reason]
    assert (change.action, change.what, change.count, change.of) == (Action.REPLACED, "motion", 1, 80)
    found = import_scene(tmp_path / "x.ply", 2.0).scene.segments[0].dynamic
    assert found.motion.shape[1:] == (4, 3)
    np.testing.assert_allclose(found.motion[1:], own.motion[1:], rtol=1e-6, atol=1e-6)
    d = np.linspace(-0.5, 0.5, 33)
    path = np.polynomial.polynomial.polyval(d, motion[0, :, 0].astype(np.float64))
    expected = np.polynomial.polynomial.polyfit(d, path, 3)
    np.testing.assert_allclose(found.motion[0, :, 0], expected, rtol=1e-5, atol=1e-5)
    error = float(change.reason.split()[-3])
    assert error == pytest.approx(np.abs(np.polynomial.polynomial.polyval(d, expected) - path).max(), rel=0.01)
    assert not any("fifth" in change.reason for change in export(scene, tmp_path / "y.splatv"))
    assert any("fifth" in change.reason for change in export(fifth, tmp_path / "z.splatv"))


def test_an_stgs_ply_has_the_fields_and_the_size_of_its_trainer(scene: HybridScene[np.ndarray], tmp_path: Path) -> None:
    export(scene, tmp_path / "x.ply")
    header, _, rows = (tmp_path / "x.ply").read_bytes().partition(b"end_header\n")
    names = [line.split()[2] for line in header.decode().splitlines() if line.startswith("property float")]
    expected = "x y z trbf_center trbf_scale nx ny nz " + " ".join(f"motion_{i}" for i in range(9))
    expected += " f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3"
    assert names == (expected + " omega_0 omega_1 omega_2 omega_3").split()
    assert len(rows) == 80 * 128


@pytest.mark.parametrize("seconds", [2.0, 3.1, 4.0])
def test_a_moment_is_what_the_equations_of_time_say(scene: HybridScene[np.ndarray], seconds: float) -> None:
    found = scene_at(scene, seconds)
    positions, quats, opacities = evaluate(scene.segments[0].dynamic, (seconds - 2) / 2)
    alive = opacities >= 1 / 255
    assert len(found) == 50 + alive.sum() < 80
    np.testing.assert_allclose(found.means[50:], positions[alive], atol=1e-6)
    np.testing.assert_allclose(found.quats[50:], quats[alive], atol=1e-6)
    np.testing.assert_allclose(1 / (1 + np.exp(-found.opacity_logits[50:])), opacities[alive], rtol=1e-4)


def test_a_splat_file_holds_places_exactly_and_the_rest_in_bytes(
    still: HybridScene[np.ndarray], tmp_path: Path
) -> None:
    export(still, tmp_path / "x.splat")
    assert (tmp_path / "x.splat").stat().st_size == 50 * 32
    found = import_scene(tmp_path / "x.splat", 1.0).scene.static
    order = [int(np.abs(still.static.means - mean).sum(axis=1).argmin()) for mean in found.means]
    before = still.static.take(order)
    np.testing.assert_array_equal(found.means, before.means)
    np.testing.assert_allclose(found.log_scales, before.log_scales, atol=1e-5)
    np.testing.assert_allclose(found.rgb, before.rgb, atol=0.5 / 255 + 1e-6)
    np.testing.assert_allclose(axes_of(found.quats), axes_of(before.quats), atol=0.03)


@pytest.mark.parametrize("antialiased", [False, True])
def test_an_spz_file_is_within_its_steps_and_says_how_to_draw(
    still: HybridScene[np.ndarray], tmp_path: Path, antialiased: bool
) -> None:
    export(dataclasses.replace(still, antialiased=antialiased), tmp_path / "x.spz")
    imported = import_scene(tmp_path / "x.spz", 1.0)
    found = imported.scene.static
    assert imported.scene.antialiased == antialiased
    np.testing.assert_allclose(found.means, still.static.means, atol=0.5 / 4096 + 1e-6)
    np.testing.assert_allclose(found.log_scales, still.static.log_scales, atol=0.5 / 16 + 1e-6)
    np.testing.assert_allclose(found.rgb, still.static.rgb, atol=0.5 / 255 / 0.15 * 0.2821 + 1e-6)
    np.testing.assert_allclose(axes_of(found.quats), axes_of(still.static.quats), atol=0.006)


@pytest.mark.parametrize("suffix", [".ply", ".splat", ".spz"])
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


def test_several_segments_need_one_to_be_named(scene: HybridScene[np.ndarray], tmp_path: Path) -> None:
    other = scene.segments[0]
    longer = HybridScene(scene.static, (other, Segment(4.0, 6.0, other.dynamic.take(slice(0, 10)))))
    export(longer, tmp_path / "x.ply", segment=1)
    assert len(import_scene(tmp_path / "x.ply", 1.0).scene.segments[0].dynamic) == 10
    with pytest.raises(ValueError, match="--segment: is missing: the scene has 2 segments"):
        export(longer, tmp_path / "y.splatv")
