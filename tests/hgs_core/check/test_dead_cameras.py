from __future__ import annotations

from pathlib import Path

import pytest

from hgs_core.base.errors import InputError
from hgs_core.check.dead_cameras import judge_dead, require_alive
from hgs_core.check.picture_changes import watched_frames
from hgs_core.check.watched_cameras import WatchedCamera, watch_cameras
from tests.hgs_core.check.filmed import Fault, blank, every, films, frozen, pictures

NAMES = ["a", "b", "c", "d", "e"]
FRAMES = 40


def watch(fault: Fault, noise: float = 0.0) -> list[WatchedCamera]:
    filmed = films(FRAMES, noise)
    filmed[2] = fault(filmed[2])
    return watch_cameras(pictures(filmed), watched_frames(FRAMES))


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        (blank(0, 39, 0), "its pictures are black in all 40 frames"),
        (blank(20, 39, 255), "its pictures are white from frame 20 on (20 of 40 frames)"),
        (blank(0, 9, 128), "its pictures are of one grey level (128) until frame 9 (10 of 40 frames)"),
        (blank(8, 11, 0), "its pictures are black in frames 8 to 11"),
        (frozen(20, 39), "it shows the same picture from frame 20 on (20 of 40 frames)"),
    ],
)
def test_a_dead_camera_stops_and_its_span_is_named(fault: Fault, words: str) -> None:
    (finding,) = judge_dead(NAMES, watch(fault))
    assert (finding.stops, finding.of_pictures, finding.cameras) == (True, True, ("c",))
    assert words in finding.problem
    assert "--hold-out c" in finding.cure


def test_most_cameras_may_have_frozen() -> None:
    filmed = films(FRAMES)
    watched = watch_cameras(pictures([*map(frozen(15, 39), filmed[:4]), filmed[4]]), watched_frames(FRAMES))
    assert [finding.cameras[0] for finding in judge_dead(NAMES, watched)] == ["a", "b", "c", "d"]
    assert [camera.energy() is None for camera in watched] == [True] * 4 + [False]


@pytest.mark.parametrize("fault", [every(2), frozen(15, 21), blank(6, 6, 0)])
def test_a_camera_that_is_mostly_alive_is_reported_and_trained(fault: Fault) -> None:
    (finding,) = judge_dead(NAMES, watch(fault))
    assert not finding.stops


def test_repeats_are_counted() -> None:
    (finding,) = judge_dead(NAMES, watch(every(2)))
    assert "of its 40 frames repeat the one before" in finding.problem


def test_when_a_dead_camera_began_is_not_measured() -> None:
    with pytest.raises(InputError, match="c: it shows the same picture from frame 15 on") as refused:
        require_alive(Path("capture"), NAMES, watch(frozen(15, FRAMES - 1)))
    assert "take its files and its pose out" in str(refused.value)
    require_alive(Path("capture"), NAMES, watch(frozen(30, FRAMES - 1)))
