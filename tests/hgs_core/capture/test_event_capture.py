"""The test capture with an event that scripts/make_event_capture.py makes of another one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from hgs_core.base.errors import InputError
from hgs_core.capture.capture import Capture
from hgs_core.capture.open import open_capture
from scripts.make_event_capture import Ball, brightened, write_event_capture
from tests.synthetic import write_capture

PLACE = np.array([0.1, -0.2, -1.0])


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> Capture:
    path = tmp_path_factory.mktemp("source")
    write_capture(path, cameras=3, frames=4)
    return open_capture(path)


def test_the_ball_is_there_in_its_frames_alone(source: Capture, tmp_path: Path) -> None:
    write_event_capture(source, tmp_path / "out", 1, 2, Ball(PLACE, 0.3))
    made = open_capture(tmp_path / "out")
    for index, camera in enumerate(made.cameras):
        np.testing.assert_allclose(camera.world_to_camera, source.cameras[index].world_to_camera)
        for frame in range(4):
            where = np.array(Image.open(tmp_path / "out" / "event" / camera.name / f"{frame:04d}.png")) > 0
            changed = (made.frame(index, frame) != source.frame(index, frame)).any(2)
            assert not changed[~where].any()
            assert changed[where].mean() > 0.9 if frame in (1, 2) else not changed.any()


def test_the_ball_stands_where_cameras_project_it(source: Capture) -> None:
    """Reference: the camera's own projection of the centre, which a small ball is seen around."""
    for camera in source.cameras:
        _, coverage = Ball(PLACE, 0.1).seen_by(camera)
        rows, columns = np.mgrid[: camera.height, : camera.width] + 0.5
        centre = [float((x * coverage).sum() / coverage.sum()) for x in (columns, rows)]
        (pixel,), (depth,) = camera.project(PLACE[None])
        np.testing.assert_allclose(centre, pixel, atol=0.1)
        radius = camera.fx * 0.1 / np.sqrt(depth**2 - 0.1**2)
        assert coverage.sum() == pytest.approx(np.pi * radius**2, rel=0.1)


def test_under_the_lamp_everything_is_brighter(source: Capture, tmp_path: Path) -> None:
    write_event_capture(source, tmp_path / "out", 3, 3, None)
    made = open_capture(tmp_path / "out")
    np.testing.assert_array_equal(made.frame(0, 2), source.frame(0, 2))
    np.testing.assert_array_equal(made.frame(0, 3), brightened(source.frame(0, 3)))
    assert made.frame(0, 3).mean() > 1.2 * source.frame(0, 3).mean()


@pytest.mark.parametrize(
    ("first", "last", "ball", "problem"),
    [(2, 4, None, "within"), (2, 1, None, "within"), (0, 1, Ball([0, 0, -9], 0.1), "no camera")],
)
def test_what_cannot_be_is_refused(
    source: Capture, tmp_path: Path, first: int, last: int, ball: Ball | None, problem: str
) -> None:
    with pytest.raises(InputError, match=problem):
        write_event_capture(source, tmp_path / "out", first, last, ball)
    assert not (tmp_path / "out").exists()


def test_a_folder_that_exists_is_left_alone(source: Capture, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="exists"):
        write_event_capture(source, tmp_path, 0, 1, None)
