"""USD files, read back by usd-core."""

from __future__ import annotations

import builtins
import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.interchange.still_moment import scene_at
from hgs_core.metrics.psnr import psnr
from hgs_core.scene import DynamicSplats, HybridScene, Segment, StaticSplats
from hgs_core.scene.opacities import opacities_of
from hgs_core.scene.temporal import evaluate
from tests.hgs_core.interchange.scenes import counted, dynamics, export, figure, figure_picture, plain, statics

HARMONIC = 0.28209479177387814


@pytest.fixture
def core() -> Any:
    return pytest.importorskip("pxr.Usd", reason="usd-core is not installed (extra usd)")


def opened(path: Path) -> Any:
    from pxr import Usd

    return Usd.Stage.Open(str(path))


def shown(stage: Any, code: float | None = None) -> StaticSplats[np.ndarray]:
    """The visible splats of all prims at a time code, in our axes."""
    from pxr import Usd, UsdGeom, UsdVol

    moment = Usd.TimeCode.Default() if code is None else Usd.TimeCode(code)
    parts = []
    for prim in stage.Traverse():
        if not prim.IsA(UsdVol.ParticleField3DGaussianSplat):
            continue
        if UsdGeom.Imageable(prim).ComputeVisibility(moment) == UsdGeom.Tokens.invisible:
            continue
        value = {name: np.array(prim.GetAttribute(name).Get(moment)) for name in ("positions", "scales", "opacities")}
        turns = np.array(prim.GetAttribute("orientations").Get(moment))  # x, y, z, w
        assert prim.GetAttribute("radiance:sphericalHarmonicsDegree").Get() == 0
        colours = 0.5 + HARMONIC * np.array(prim.GetAttribute("radiance:sphericalHarmonicsCoefficients").Get())
        seen = value["opacities"] > 0
        opacity = np.clip(value["opacities"][seen].astype(np.float64), 1e-9, 1 - 1e-7)
        found = StaticSplats(
            value["positions"][seen] * np.float32([1, -1, -1]),
            np.log(value["scales"][seen]),
            turns[seen][:, [3, 0, 1, 2]] * np.float32([1, 1, -1, -1]),
            np.log(opacity / (1 - opacity)).astype(np.float32),
            colours[seen].astype(np.float32),
        )
        parts.append(found)
    return StaticSplats(*(np.concatenate([getattr(p, name) for p in parts]) for name, _ in parts[0].items()))


def as_scene(splats: StaticSplats[np.ndarray]) -> HybridScene[np.ndarray]:
    return HybridScene(splats, (Segment(0.0, 0.0, DynamicSplats.empty()),))


def test_a_moment_is_the_scene_that_stands_still(core: Any, tmp_path: Path) -> None:
    scene = figure()
    export(scene, tmp_path / "x.usd", time=0.5)
    found = shown(opened(tmp_path / "x.usd"))
    expected = scene_at(scene, 0.5)
    np.testing.assert_allclose(found.means, expected.means)
    np.testing.assert_allclose(found.log_scales, expected.log_scales, atol=1e-6)
    np.testing.assert_allclose(opacities_of(found.opacity_logits), opacities_of(expected.opacity_logits), atol=1e-6)
    np.testing.assert_allclose(found.rgb, expected.rgb, atol=1e-6)
    assert psnr(figure_picture(as_scene(found), 0.0), figure_picture(scene, 0.5)) > 80


def test_samples_are_the_scene_at_their_times(core: Any, tmp_path: Path) -> None:
    """Time codes are seconds times the rate; the pictures are the renderer's."""
    scene = figure()
    export(scene, tmp_path / "x.usdc", frame_rate=10.0)
    stage = opened(tmp_path / "x.usdc")
    assert (stage.GetTimeCodesPerSecond(), stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (10, 0, 20)
    for seconds in (0.0, 0.7, 2.0):
        found = shown(stage, seconds * 10)
        assert len(found) == len(scene_at(scene, seconds))
        assert psnr(figure_picture(as_scene(found), 0.0), figure_picture(scene, seconds)) > 80
    between = shown(stage, 7.5)
    assert psnr(figure_picture(as_scene(between), 0.0), figure_picture(scene, 0.75)) > 40


def brief(count: int, middle: float) -> DynamicSplats[np.ndarray]:
    """Splats with a life of a hundredth of the time."""
    life = np.full(count, middle, np.float32), np.full(count, 14.0, np.float32)
    return dataclasses.replace(dynamics(count), time_centers=life[0], time_log_precisions=life[1])


def test_a_segment_is_shown_for_its_time_alone(core: Any, tmp_path: Path) -> None:
    scene = HybridScene(statics(), (Segment(2.0, 3.0, dynamics(9)), Segment(3.0, 4.0, dynamics(12, 5))))
    export(scene, tmp_path / "x.usd", frame_rate=30.000000000000107)
    stage = opened(tmp_path / "x.usd")
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (60, 120)
    for seconds in (2.0, 2.9, 3.0, 3.1, 4.0):
        expected = scene_at(scene, seconds)
        np.testing.assert_allclose(shown(stage, round(seconds * 30)).means, expected.means, atol=1e-5)
    early = evaluate(scene.segments[0].dynamic, 29 / 30)[2] >= 1 / 255
    assert len(shown(stage, 89.9)) == 50 + early.sum()


def test_what_no_sample_shows_is_left_out_and_what_moves_is_told(core: Any, tmp_path: Path) -> None:
    scene = HybridScene(
        plain(), (Segment(0.0, 1.0, brief(7, 0.25)), Segment(1.0, 2.0, brief(5, 0.5))), antialiased=True
    )
    changes = export(scene, tmp_path / "x.usd", frame_rate=2.0)
    assert counted(changes) == {
        ("left out", "splats"): 7,
        ("replaced", "motion, turning and life"): 5,
        ("left out", "antialiasing"): None,
        ("assumed", "unit"): None,
    }
    assert "by 5 samples, 2 a second, and straight between them" in str(changes[1])
    assert opened(tmp_path / "x.usd").GetRootLayer().customLayerData == {"hgs_antialiased": True}


def test_the_box_holds_the_splats_of_all_times(core: Any, tmp_path: Path) -> None:
    from pxr import Usd, UsdGeom

    scene = figure()
    export(scene, tmp_path / "x.usd", frame_rate=5.0)
    stage = opened(tmp_path / "x.usd")
    assert UsdGeom.GetStageUpAxis(stage) == "Y"
    box = (
        UsdGeom.BBoxCache(Usd.TimeCode(0), ["default"]).ComputeWorldBound(stage.GetDefaultPrim()).ComputeAlignedRange()
    )
    for code in range(11):
        places = shown(stage, float(code)).means * [1, -1, -1]
        assert (places > np.array(box.GetMin())).all()
        assert (places < np.array(box.GetMax())).all()


def test_without_the_library_the_cure_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plainly = builtins.__import__

    def without(name: str, *more: Any) -> Any:
        if name.startswith("pxr"):
            raise ImportError(name)
        return plainly(name, *more)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(InputError, match=r"\.usd: needs the package usd-core; pip install 'hgs\[usd\]'"):
        export(figure(), tmp_path / "x.usd")
    assert not any(tmp_path.iterdir())


def test_a_file_without_splats_is_refused(core: Any, tmp_path: Path) -> None:
    scene = HybridScene(plain(0), (Segment(0.0, 1.0, brief(7, 0.25)),))
    for more in ({"time": 0.9}, {"frame_rate": 1.0}):
        with pytest.raises(InputError, match="splats: are none; choose another time"):
            export(scene, tmp_path / "x.usd", **more)


def test_a_rate_that_is_none_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="--fps: 0 is not positive"):
        export(figure(), tmp_path / "x.usd", frame_rate=0.0)
