"""Where the cameras' times come from: sync.json, timestamps.csv, time codes, and the videos' own stamps."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.capture.open import open_capture
from hgs_core.capture.time.timecodes import timecode_seconds
from tests.hgs_core.capture import layouts
from tests.hgs_core.capture.layouts import FRAMES, NAMES, level, picture, write_video


@pytest.fixture
def capture(tmp_path: Path) -> Path:
    layouts.llff(tmp_path)
    layouts.PICTURES["videos"](tmp_path)
    return tmp_path


def grey(path: Path, camera: int, frame: int) -> int:
    return 10 * round(float(open_capture(path).frame(camera, frame).mean()) / 10)


@pytest.mark.parametrize(("unit", "value"), [("seconds", 0.5 / 30), ("frames", 0.5)])
def test_a_camera_half_a_frame_late_is_seen_at_its_own_time(capture: Path, unit: str, value: float) -> None:
    (capture / "sync.json").write_text(json.dumps({unit: {"cam02": value}}))
    opened = open_capture(capture)
    assert len(opened.times) == FRAMES
    assert opened.moment(1, 2) == pytest.approx(2.5 / 30)
    assert opened.moment(0, 2) == pytest.approx(2 / 30)
    assert "sync.json says when each camera began" in opened.notes


@pytest.mark.parametrize("name", ["cam02", "CAM02", " Cam02"])
def test_a_whole_number_of_frames_shifts_a_camera(capture: Path, name: str) -> None:
    (capture / "sync.json").write_text(f'{{"frames": {{"{name}": 2}}}}')
    opened = open_capture(capture)
    assert len(opened.times) == FRAMES - 2
    assert [grey(capture, camera, 0) for camera in (0, 1)] == [level(0, 2), level(1, 0)]
    assert opened.moment(1, 0) == 0.0


def test_a_video_says_what_its_own_times_lack_of_the_clock(capture: Path) -> None:
    (capture / "sync.json").write_text('{"frames": {"cam02": 2}}')
    opened = open_capture(capture)
    for camera, lack in ((0, -2 / 30), (1, 0.0)):
        video = opened.video(camera)
        assert video is not None
        assert video[0].name.startswith(NAMES[camera])
        assert video[1] == pytest.approx(lack)


def test_sync_json_counts_for_the_fingerprint(capture: Path) -> None:
    found = [open_capture(capture).fingerprint()]
    for offset in (0, 1):
        (capture / "sync.json").write_text(json.dumps({"frames": {"cam02": offset}}))
        found.append(open_capture(capture).fingerprint())
    assert len(set(found)) == 3


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        ("{", "unreadable"),
        ("[]", r"has \[\]"),
        ('{"offsets": {}}', r"has \['offsets'\]; it is like"),
        ('{"frames": {}, "seconds": {}}', "has both"),
        ('{"rate": 0}', "rate is 0; it is frames per second"),
        ('{"frames": 3}', "frames is 3"),
        ('{"frames": {"cam02": "late"}}', "frames of cam02 is 'late'"),
        ('{"frames": {"cam99": 1}}', "there is no camera 'cam99'; the cameras are cam01, cam02, cam03, cam10"),
        ('{"frames": {"cam02": 99}}', "by it cam02 begins at 3.3 s, .*: no moment in common; correct the number"),
        ('{"seconds": {"cam02": 33}}', "no moment in common; where they are milliseconds, .*, as in 0.033; or"),
    ],
)
def test_bad_values_of_sync_json_are_named(capture: Path, content: str, problem: str) -> None:
    (capture / "sync.json").write_text(content)
    with pytest.raises(InputError, match=problem):
        open_capture(capture)


def test_a_start_offset_of_the_file_counts(capture: Path) -> None:
    stamps = [round(1000 * (frame + 2) / 30) for frame in range(FRAMES)]
    (capture / "cam02.mp4").unlink()
    write_video(capture / "cam02.mkv", [picture(1, frame) for frame in range(FRAMES)], stamps=stamps)
    opened = open_capture(capture)
    assert len(opened.times) == FRAMES - 2
    assert [grey(capture, camera, 0) for camera in (0, 1)] == [level(0, 2), level(1, 0)]
    assert "by their time stamps these begin later: cam02 by 0.067 s (sync.json can say otherwise)" in opened.notes


def test_variable_rates_are_matched_by_time(capture: Path) -> None:
    (capture / "cam02.mp4").unlink()
    stamps = [0, 40, 60, 130, 140]  # ms: nearest to the ticks 0, 1, 2, 4 and, too many, 4
    write_video(capture / "cam02.mkv", [picture(1, frame) for frame in range(5)], stamps=stamps)
    opened = open_capture(capture)
    np.testing.assert_allclose(opened.times, np.array([0, 1, 2, 4]) / 30)
    assert opened.moment(1, 1) == pytest.approx(0.04)
    assert any("1 moment of 5 left out, at which cam02 has no frame" in note for note in opened.notes)


def test_a_shorter_video_ends_the_capture(capture: Path) -> None:
    write_video(capture / "cam03.mp4", [picture(2, frame) for frame in range(3)])
    opened = open_capture(capture)
    assert len(opened.times) == 3
    assert f"the capture ends with cam03: {FRAMES - 3} moments of other cameras left out" in opened.notes


def test_time_codes_say_when_cameras_began(capture: Path) -> None:
    for camera, name in enumerate(NAMES):
        late = 2 if name == "cam02" else 0
        pictures = [picture(camera, frame) for frame in range(FRAMES)]
        write_video(capture / f"{name}.mp4", pictures, timecode=f"01:00:00:{late:02d}")
    opened = open_capture(capture)
    assert [grey(capture, camera, 0) for camera in (0, 1)] == [level(0, 2), level(1, 0)]
    assert any("time codes say when each camera began" in note for note in opened.notes)


@pytest.mark.parametrize(
    ("code", "rate", "seconds"),
    [
        ("00:00:01:15", 30.0, 1.5),
        ("01:00:00;00", 30000 / 1001, 107892 * 1001 / 30000),  # SMPTE 12M: an hour of drop-frame code is 107,892 frames
        ("00:01:00;02", 30000 / 1001, 1800 * 1001 / 30000),
        ("00:10:00;00", 60000 / 1001, 35964 * 1001 / 60000),
        ("01:00:00:00", 25.0, 3600.0),
        ("01:00:00:00", 24000 / 1001, 3603.6),
        ("noon", 30.0, None),
    ],
)
def test_seconds_of_a_time_code(code: str, rate: float, seconds: float | None) -> None:
    assert timecode_seconds(code, rate) == (None if seconds is None else pytest.approx(seconds))


def write_table(path: Path, columns: str, late: float = 0.0, jitter: float = 0.0) -> None:
    rows = [columns]
    for frame in range(FRAMES):
        for camera, name in enumerate(NAMES):
            offset = (late if camera == 1 else 0.0) + jitter * (-1) ** (frame + camera)
            rows.append(f"{int(name[3:])},{1000 + frame / 30 + offset:.6f}")
    path.write_text("\n".join(rows) + "\n")


@pytest.mark.parametrize("columns", ["cam_id,frame_time", "port, time"])
def test_a_table_says_when_frames_were_taken(capture: Path, columns: str) -> None:
    """Arrivals that jitter by a tenth of a period are not late; half a period is."""
    write_table(capture / "timestamps.csv", columns, late=0.4 / 30, jitter=0.001)
    opened = open_capture(capture)
    assert len(opened.times) == FRAMES
    assert opened.moment(1, 2) - opened.moment(0, 2) == pytest.approx(0.4 / 30, abs=0.0025)
    assert opened.moment(3, 2) == opened.times[2]
    assert "timestamps.csv says when each frame was taken" in opened.notes


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("a,b\n1,2\n", "the columns are a, b; it needs a column cam_id"),
        ("cam_id,frame_time\n1,soon\n", "row 1: frame_time is 'soon'; it is a number"),
        ("cam_id,frame_time\n1,0.5\n", "has 1 row of camera cam01, whose footage has 5 frames"),
        ("", "the columns are none"),
    ],
)
def test_a_table_that_does_not_fit_is_named(capture: Path, text: str, problem: str) -> None:
    (capture / "timestamps.csv").write_text(text)
    with pytest.raises(InputError, match=rf"timestamps\.csv(, |: ){problem}"):
        open_capture(capture)
