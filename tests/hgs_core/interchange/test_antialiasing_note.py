"""Every exported scene is imported as it was drawn, without an option."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
import torch

from hgs_core.base.progress import silent
from hgs_core.interchange import export_scene, export_sequence, import_scene
from hgs_core.interchange.antialiasing_note import UNTOLD, noted
from hgs_core.interchange.ply.ply_table import write_ply
from hgs_core.interchange.still_moment import scene_at
from hgs_core.render.rasterize import rasterize
from hgs_core.scene import DynamicSplats, HybridScene, Segment
from hgs_core.scene.camera import Camera, looking_at
from tests.hgs_core.interchange.scenes import CAMERA, Write, dynamics, statics

LEAST = {  # dB that come back
    "x.ply": 90,
    "x.splat": 45,
    "x.spz": 45,
    "x.glb": 90,
    "x.4dgs": 40,
    "moving.ply": 90,
    "moving.4dgs": 35,
    "frames": 90,
}


def thin_scene(name: str, antialiased: bool) -> HybridScene[np.ndarray]:
    """Splats thinner than pixels, of which antialiasing decides how strong they are."""
    static, moving = statics(200), dynamics(30)
    static.log_scales[:] -= 2.5
    dynamic = dataclasses.replace(moving, motion=moving.motion * np.float32(0.05), log_scales=moving.log_scales - 1)
    dynamic.motion[:, 0] = moving.motion[:, 0]
    if name.startswith("x."):
        return HybridScene(static, (Segment(0.0, 0.0, DynamicSplats.empty()),), antialiased=antialiased)
    return HybridScene(static, (Segment(0.0, 1.0, dynamic),), antialiased=antialiased)


def drawn(scene: HybridScene[np.ndarray], seconds: float) -> np.ndarray:
    camera = Camera("", 96, 96, 90, 90, 48, 48, looking_at(np.array([0.0, 0, -8]), np.zeros(3)))
    splats = scene_at(scene, seconds).map(torch.from_numpy)
    return rasterize(splats, None, camera, gradients="none", antialiased=scene.antialiased).rgb.numpy()


@pytest.mark.parametrize("antialiased", [True, False])
@pytest.mark.parametrize("name", list(LEAST))
def test_what_is_exported_comes_back_without_a_flag(tmp_path: Path, name: str, antialiased: bool) -> None:
    if name.endswith(".4dgs"):
        pytest.importorskip("fourdgs", reason="fourdgs is not installed (extra 4dgs)")
    scene, path = thin_scene(name, antialiased), tmp_path / name
    if name == "frames":
        export_sequence(scene, path, 4.0, silent)
    else:
        export_scene(scene, path, cameras=[CAMERA])
    back = import_scene(path, 1.0, 4.0)
    assert back.scene.antialiased is antialiased
    assert (UNTOLD in back.changes) == (name == "x.splat" and not antialiased)
    for seconds in (0.0, 0.5):
        error = float(((drawn(scene, seconds) - drawn(back.scene, seconds)) ** 2).mean())
        assert -10 * np.log10(error + 1e-12) > LEAST[name]
    other = dataclasses.replace(scene, antialiased=not antialiased)
    assert -10 * np.log10(float(((drawn(scene, 0.0) - drawn(other, 0.0)) ** 2).mean())) < 30  # it does matter


def test_a_file_that_says_nothing_is_told_and_an_answer_is_taken(written: Write) -> None:
    names = ["x", "y", "z", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3", "opacity"]
    table = {name: np.zeros(2) for name in (*names, "f_dc_0", "f_dc_1", "f_dc_2")}
    table |= dict.fromkeys(("x", "rot_0"), np.ones(2))
    path = written("x.ply", write_ply(table))
    found = import_scene(path)
    assert (found.scene.antialiased, found.antialiased, found.changes) == (False, None, (UNTOLD,))
    assert "--antialiased" in str(UNTOLD)
    for answer in (True, False):
        found = import_scene(path, antialiased=answer)
        assert (found.scene.antialiased, found.antialiased, found.changes) == (answer, answer, ())


def test_an_answer_against_the_files_own_word_is_taken_and_told(tmp_path: Path) -> None:
    export_scene(thin_scene("x.ply", True), tmp_path / "x.ply", cameras=[CAMERA])
    assert not [change for change in import_scene(tmp_path / "x.ply", antialiased=True).changes if change.count is None]
    found = import_scene(tmp_path / "x.ply", antialiased=False)
    assert found.scene.antialiased is False
    assert "antialiasing replaced: by --no-antialiased: the file says otherwise" in map(str, found.changes)


def test_a_note_is_a_line_of_two_words() -> None:
    assert noted(["made by hand", "hgs_antialiased 1"]) is True
    assert noted(["hgs_antialiased 0"]) is False
    assert noted(["hgs_antialiased 2", "hgs_antialiased", "not hgs_antialiased 1"]) is None
