"""Reference: splaTV's vertex shader, one splat at a time in Python."""

from __future__ import annotations

import dataclasses
import json
import struct
from pathlib import Path

import numpy as np

from hgs_core.interchange import export_scene
from hgs_core.scene import HybridScene, evaluate
from hgs_core.scene.camera import Camera
from tests.hgs_core.interchange.scenes import counted

POSE = np.array([[0, 0, -1, 0.5], [0, 1, 0, 0], [1, 0, 0, 2], [0, 0, 0, 1]], float)
CAMERA = Camera("cam07", 640, 480, 500.0, 510.0, 320.0, 240.0, POSE)


def halves(*words: int) -> list[float]:
    return [x for word in words for x in struct.unpack("<2e", struct.pack("<I", word))]


def shader(words: list[int], time: float) -> tuple[list[float], list[float], float]:
    """Place, unnormalised rotation (w, x, y, z) and opacity of a splat of sixteen words."""
    center, width = halves(words[15])
    dt = time - center
    m = halves(*words[8:13])
    turning = halves(*words[13:15])
    place = list(struct.unpack("<3f", struct.pack("<3I", *words[:3])))
    place = [place[i] + m[i] * dt + m[3 + i] * dt**2 + m[6 + i] * dt**3 for i in range(3)]
    rotation = [a + b * dt for a, b in zip(halves(words[3], words[4]), turning, strict=True)]
    return place, rotation, (words[7] >> 24) / 255 * float(np.exp(-((dt / width) ** 2)))


def test_the_viewers_shader_draws_the_scene(scene: HybridScene[np.ndarray], tmp_path: Path) -> None:
    changes = export_scene(dataclasses.replace(scene, antialiased=True), tmp_path / "x.splatv", cameras=[CAMERA])
    data = (tmp_path / "x.splatv").read_bytes()
    magic, length = struct.unpack_from("<2I", data)
    (chunk,) = json.loads(data[8 : 8 + length])
    assert (magic, chunk["type"], chunk["texwidth"], chunk["texheight"]) == (0x674B, "splat", 4096, 1)
    assert len(data) == 8 + length + chunk["size"]
    assert chunk["hgs_antialiased"] is True
    assert "antialiasing" in [change.what for change in changes]
    texture = np.frombuffer(data, "<u4", offset=8 + length).reshape(-1, 16)
    assert len(texture) == 1024
    dynamic = scene.segments[0].dynamic
    for time in (0.0, 0.4, 1.0):
        positions, quats, opacities = evaluate(dynamic, time)
        for n in range(80):
            place, rotation, opacity = shader([int(word) for word in texture[n]], time)
            if n < 50:
                np.testing.assert_allclose(place, scene.static.means[n], rtol=1e-6)
                continue
            np.testing.assert_allclose(place, positions[n - 50], atol=4e-3)
            unit = np.array(rotation) / np.linalg.norm(rotation)
            np.testing.assert_allclose(unit, quats[n - 50], atol=2e-2)
            np.testing.assert_allclose(opacity, opacities[n - 50], atol=6e-3)
    assert shader([int(word) for word in texture[80]], 0.5)[2] == 0


def test_the_camera_is_the_captures(scene: HybridScene[np.ndarray], tmp_path: Path) -> None:
    export_scene(scene, tmp_path / "x.splatv", cameras=[CAMERA])
    data = (tmp_path / "x.splatv").read_bytes()
    (camera,) = json.loads(data[8 : 8 + struct.unpack_from("<I", data, 4)[0]])[0]["cameras"]
    to_camera = np.array(camera["rotation"]).T
    np.testing.assert_allclose(to_camera, POSE[:3, :3])
    np.testing.assert_allclose(-to_camera @ camera["position"], POSE[:3, 3])


def test_what_halves_and_bytes_change_is_counted(scene: HybridScene[np.ndarray], tmp_path: Path) -> None:
    dynamic = scene.segments[0].dynamic
    dynamic.motion[0, 1] = 1e6
    dynamic.time_log_precisions[:2] = 30.0
    scene.static.log_scales[:4] = 12.0
    found = counted(export_scene(scene, tmp_path / "x.splatv", cameras=[CAMERA]))
    assert found[("limited", "motion")] == 1
    assert found[("limited", "life")] == 2
    assert found[("limited", "scale")] == 4
    assert found[("rounded", "colour")] == found[("rounded", "rotation")] == 80
    assert found[("rounded", "motion")] == found[("rounded", "turning")] == 30
