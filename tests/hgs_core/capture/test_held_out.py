from __future__ import annotations

from hgs_core.capture.capture_config import CaptureConfig
from hgs_core.capture.held_out import AUTO, with_held_out
from tests.synthetic import ring_of_cameras


def test_of_an_arc_the_camera_in_the_middle_is_held_out() -> None:
    assert with_held_out(CaptureConfig(hold_out=AUTO), ring_of_cameras(7, 64, 48)).hold_out == ("3",)


def test_of_five_cameras_none_is_held_out() -> None:
    assert with_held_out(CaptureConfig(hold_out=AUTO), ring_of_cameras(5, 64, 48)).hold_out == ()


def test_what_is_said_is_done() -> None:
    cameras = ring_of_cameras(7, 64, 48)
    assert with_held_out(CaptureConfig(), cameras).hold_out == ()
    assert with_held_out(CaptureConfig(hold_out=("1", "2"), downscale=2), cameras).hold_out == ("1", "2")
