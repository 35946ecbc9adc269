"""Films of a scene: their pictures are those of the renderer."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest
import torch
from PIL import Image

from hgs_core.base.errors import InputError
from hgs_core.base.progress import Progress
from hgs_core.codec import decode_scene, load_manifest
from hgs_core.film.camera_path import CameraPath, KeyFrame
from hgs_core.film.make_film import FilmFormat, make_film
from hgs_core.film.ready_paths import orbit_path
from hgs_core.render.scene_picture import scene_picture

REST = CameraPath((KeyFrame(0.0, (0.0, 0.0, -3.0), (0.0, 0.0, 0.0), 45.0),))


def test_pictures_are_those_of_the_renderer(sounding_scene: Path, tmp_path: Path) -> None:
    manifest, scene = load_manifest(sounding_scene), decode_scene(sounding_scene).map(torch.from_numpy)
    path = orbit_path(manifest)
    assert make_film(sounding_scene, path, tmp_path / "film", size=(65, 48), rate=Fraction(4)) == 5
    for number in (0, 3):
        near = manifest.cameras[0].near
        camera = path.camera(number / 4, (65, 48), manifest.up, near)
        drawn = scene_picture(scene, camera, number / 4, rig=manifest.rig).rgb.clamp(0, 1)
        saved = np.asarray(Image.open(tmp_path / "film" / f"{number:06d}.png"))
        np.testing.assert_array_equal(saved, (drawn * 255).round().permute(1, 2, 0).numpy().astype(np.uint8))


def test_a_camera_at_rest_shows_the_whole_scene_with_its_sound(sounding_scene: Path, tmp_path: Path) -> None:
    seen: list[Progress] = []
    count = make_film(sounding_scene, REST, tmp_path / "x.mp4", size=(64, 48), progress=seen.append)
    assert count == 21
    assert [(one.stage, one.done, one.total) for one in (seen[0], seen[-1])] == [("render", 1, 21), ("render", 21, 21)]
    with av.open(str(tmp_path / "x.mp4")) as file:
        assert [stream.type for stream in file.streams] == ["video", "audio"]
    make_film(sounding_scene, REST, tmp_path / "silent.mp4", size=(64, 48), sound=False)
    with av.open(str(tmp_path / "silent.mp4")) as file:
        assert [stream.type for stream in file.streams] == ["video"]


def test_alpha_is_where_splats_are(sounding_scene: Path, tmp_path: Path) -> None:
    """Laid over black, the picture is the one without alpha: the scene's background is black."""
    for folder, alpha in (("with", True), ("without", False)):
        make_film(sounding_scene, REST, tmp_path / folder, size=(64, 48), rate=Fraction(1), alpha=alpha)
    rgba = np.asarray(Image.open(tmp_path / "with" / "000000.png")).astype(np.float64)
    plain = np.asarray(Image.open(tmp_path / "without" / "000000.png"))
    assert rgba[..., 3].min() < 20
    assert rgba[..., 3].max() > 240
    assert np.abs(rgba[..., :3] * rgba[..., 3:] / 255 - plain).max() <= 2


def test_a_path_may_outlast_the_scene(sounding_scene: Path, tmp_path: Path) -> None:
    path = CameraPath((REST.keys[0], KeyFrame(2.0, (0.0, 0.0, -3.0), (0.0, 0.0, 0.0), 45.0)))
    assert make_film(sounding_scene, path, tmp_path / "film", size=(32, 24), rate=Fraction(2)) == 5
    last, before = (np.asarray(Image.open(tmp_path / "film" / f"00000{k}.png")) for k in (4, 3))
    np.testing.assert_array_equal(last, before)


@pytest.mark.parametrize(
    ("name", "size", "alpha", "told"),
    [
        ("x.mov", (64, 48), False, r"\.mov is no format of films"),
        ("x.mp4", (65, 48), False, "--size: 65x48 has an odd side"),
        ("x", (0, 48), False, "--size: 0x48"),
        ("x", (64, 20_000), False, "--size: 64x20000"),
        ("x.mp4", (64, 48), True, "--alpha"),
    ],
)
def test_what_a_format_cannot_be_is_refused(
    name: str, size: tuple[int, int], alpha: bool, told: str, sounding_scene: Path, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=told):
        make_film(sounding_scene, REST, tmp_path / name, size=size, alpha=alpha)
    assert list(tmp_path.iterdir()) == []


def test_the_format_is_that_of_the_name() -> None:
    formats = [FilmFormat.of(Path(name)) for name in ("a.MP4", "a.webm", "frames")]
    assert formats == [FilmFormat.MP4, FilmFormat.WEBM, FilmFormat.PNG_FOLDER]
