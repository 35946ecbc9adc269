"""The whole way on videos of samples/studio, with known cameras."""

from __future__ import annotations

from pathlib import Path

import av
import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.calibrate.calibration_views import View
from hgs_core.calibrate.find_cameras import cameras_of_views, find_cameras
from hgs_core.capture.open import open_capture
from hgs_core.points.features import Features
from tests.conftest import REPOSITORY
from tests.hgs_core.calibrate.boards import BOARD, FRAMES, HEIGHT, WIDTH, photograph, rig

STUDIO = REPOSITORY / "samples" / "studio"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("videos")
    for name in ("cam00", "cam03", "cam06", "cam09", "cam12"):
        (folder / f"{name}.mp4").symlink_to(STUDIO / f"{name}.mp4")
    find_cameras(folder)
    return folder


def test_five_cameras_are_found_within_a_quarter_of_a_degree(folder: Path) -> None:
    import pycolmap

    model = pycolmap.Reconstruction(str(folder / "sparse" / "0"))
    found = {str(image.name): image.cam_from_world().matrix()[:, :3] for image in model.images.values()}
    assert sorted(found) == ["cam00", "cam03", "cam06", "cam09", "cam12"]
    true = {camera.name: camera.world_to_camera[:3, :3] for camera in open_capture(STUDIO).cameras}
    for one in found:
        for other in found:
            off = found[one] @ found[other].T @ (true[one] @ true[other].T).T
            assert np.degrees(np.arccos(np.clip((np.trace(off) - 1) / 2, -1, 1))) < 0.4  # two that are 0.25 off


def test_down_is_where_it_is_in_the_studio(folder: Path) -> None:
    """The studio's z points up; relative to a camera, down is found without asking the poses."""
    import pycolmap

    model = pycolmap.Reconstruction(str(folder / "sparse" / "0"))
    pose = next(image for image in model.images.values() if image.name == "cam06").cam_from_world().matrix()
    true = next(camera for camera in open_capture(STUDIO).cameras if camera.name == "cam06").world_to_camera
    down, true_down = pose[:3, :3] @ (0, 1, 0), true[:3, :3] @ (0, 0, -1)
    assert np.degrees(np.arccos(np.clip(down @ true_down, -1, 1))) < 3


def test_cameras_that_are_there_are_kept(folder: Path) -> None:
    with pytest.raises(InputError, match="there are cameras already"):
        find_cameras(folder)


def views(*counts: int) -> list[View]:
    empty = Features(np.zeros((0, 2)), np.zeros((0, 128), np.float32))
    return [View(f"cam{i}", 640, 480, None, (empty,)) for i, _ in enumerate(counts)]


def test_two_cameras_are_too_few() -> None:
    with pytest.raises(InputError, match="2 cameras are too few"):
        cameras_of_views(Path("rig"), views(0, 0), lambda progress: None)


def test_a_rig_without_common_views_is_refused_with_the_cure() -> None:
    with pytest.raises(InputError, match=r"no two cameras share.*add cameras in between.*or show them a board"):
        cameras_of_views(Path("rig"), views(0, 0, 0, 0), lambda progress: None)


def test_a_board_in_the_videos_gives_the_cameras_in_metres(tmp_path: Path) -> None:
    pytest.importorskip("cv2")
    cameras = rig()
    for camera in cameras[:3]:
        with av.open(str(tmp_path / f"{camera.name}.mp4"), "w") as container:
            stream = container.add_stream("libx264", rate=10, options={"crf": "10", "preset": "ultrafast"})
            stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, "yuv420p"
            for frame in range(FRAMES):
                container.mux(stream.encode(av.VideoFrame.from_ndarray(photograph(camera, frame), format="rgb24")))
            container.mux(stream.encode())
    find_cameras(tmp_path, board=BOARD, floor=True)
    found = {camera.name: camera for camera in open_capture(tmp_path).cameras}
    for camera in cameras[:3]:
        np.testing.assert_allclose(found[camera.name].position, camera.position, atol=0.05)
