"""Faults put into a capture of real pictures, each named; the capture as it is has none."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from hgs_core.capture.capture import Capture
from hgs_core.capture.open import open_capture
from hgs_core.check import capture_check
from hgs_core.check.capture_check import check_capture
from hgs_core.check.evidence import Evidence
from tests.hgs_core.check.conftest import STUDIO, Spoil, write_studio


def invert(poses: np.ndarray) -> None:
    for row in poses:
        matrix = row[:15].reshape(3, 5)
        turn, place = matrix[:, :3].copy(), matrix[:, 3].copy()
        matrix[:, :3], matrix[:, 3] = turn.T, -turn.T @ place


def opencv_columns(poses: np.ndarray) -> None:
    for row in poses:
        matrix = row[:15].reshape(3, 5)
        down, right, back = matrix[:, :3].T.copy()
        matrix[:, 0], matrix[:, 1], matrix[:, 2] = right, down, -back


def swap(poses: np.ndarray) -> None:
    poses[[1, 2]] = poses[[2, 1]]


def double_focal(poses: np.ndarray) -> None:
    poses[2, 14] *= 2


def centimetres(poses: np.ndarray) -> None:
    poses[2, :15].reshape(3, 5)[:, 3] *= 100


FAULTS: dict[str, tuple[Spoil, tuple[str, ...], str]] = {
    "inverted": (invert, (), "the poses are inverted"),
    "OpenCV's axes": (opencv_columns, (), "OpenCV's columns in poses_bounds.npy"),
    "swapped": (swap, ("cam04", "cam06"), "the two are swapped"),
    "focal": (double_focal, ("cam06",), "0.50 times it fits"),
    "unit": (centimetres, ("cam06",), "centimetres"),
}


def test_a_right_capture_has_nothing_that_stands_out(studio: Capture) -> None:
    check = check_capture(studio)
    assert check.findings == ()
    assert all(camera.error is not None and camera.error < 0.3 for camera in check.cameras)
    assert check.table().endswith("nothing stands out")


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_stops_and_is_named(
    fault: str,
    studio_with: Callable[[Spoil | None], Capture],
    studio_evidence: Evidence,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Matches do not ask the poses: they are taken from the pictures once for all faults."""
    spoil, cameras, words = FAULTS[fault]
    capture = studio_with(spoil)
    seen = dataclasses.replace(studio_evidence, cameras=capture.cameras)
    monkeypatch.setattr("hgs_core.check.capture_check.gather", lambda capture, progress, followed: seen)
    check = check_capture(capture)
    (finding,) = check.stops
    assert finding.cameras == cameras
    assert words in finding.problem


def rewritten(folder: Path, frames: Callable[[int], np.ndarray]) -> Capture:
    """The five cameras with another video of cam06, made of `frames` of the one it has, 20 in all of each camera."""
    import av

    write_studio(folder)
    source = open_capture(folder)
    for index, camera in enumerate(source.cameras):
        file = folder / f"{camera.name}.mp4"
        pictures = [frames(i) if camera.name == "cam06" else source.frame(index, i) for i in range(20)]
        file.unlink()
        with av.open(str(file), "w") as container:
            stream = container.add_stream("libx264", rate=30, options={"crf": "12", "preset": "ultrafast"})
            stream.width, stream.height, stream.pix_fmt = 512, 384, "yuv444p"
            for picture in pictures:
                container.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="rgb24")))
            container.mux(stream.encode(None))
    return open_capture(folder)


@pytest.fixture
def cam06() -> Callable[[int], np.ndarray]:
    capture = open_capture(STUDIO)
    index = capture.camera_index("cam06")
    return lambda frame: capture.frame(index, frame)


def test_a_camera_that_moves_is_named(tmp_path: Path, cam06: Callable[[int], np.ndarray]) -> None:
    capture = rewritten(tmp_path / "moving", lambda i: np.roll(cam06(i), 2 * i, axis=1))
    (finding,) = check_capture(capture).stops
    assert finding.cameras == ("cam06",)
    assert "the camera moves" in finding.problem


def test_a_camera_that_began_late_is_named_with_its_frames(tmp_path: Path, cam06: Callable[[int], np.ndarray]) -> None:
    check = check_capture(rewritten(tmp_path / "late", lambda i: cam06(i + 3)))
    assert not check.stops
    (finding,) = check.findings
    assert finding.cameras == ("cam06",)
    assert "ahead of the others" in finding.problem
    assert next(camera.ahead for camera in check.cameras if camera.name == "cam06") == pytest.approx(3, abs=0.6)


def test_a_picture_upside_down_is_named(tmp_path: Path, cam06: Callable[[int], np.ndarray]) -> None:
    (finding,) = check_capture(rewritten(tmp_path / "turned", lambda i: cam06(i)[::-1, ::-1])).stops
    assert finding.cameras == ("cam06",)
    assert "upside down" in finding.problem


def test_masks_that_mark_everything_are_told(tmp_path: Path) -> None:
    folder = write_studio(tmp_path / "masked")
    (folder / "masks" / "cam06").mkdir(parents=True)
    for frame in range(60):
        Image.new("L", (512, 384), 255).save(folder / "masks" / "cam06" / f"{frame:04d}.png")
    (finding,) = check_capture(open_capture(folder)).findings
    assert finding.cameras == ("cam06",)
    assert "mark 100 %" in finding.problem


def test_offsets_are_told_beyond_a_limit_and_the_cure_counts_frames() -> None:
    """Twenty frames of a good capture gave 1.4 by chance."""
    assert capture_check._unsynchronous(["a", "b"], [0.0, 1.4], 1.5, set()) == []
    (finding,) = capture_check._unsynchronous(["a", "b"], [0.0, 1.4], 1.0, set())
    assert finding.cameras == ("b",)
    assert "cut the first 1 frame of the others" in finding.cure
