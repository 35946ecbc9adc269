"""Tables of times as spreadsheets and recorders write them."""

from __future__ import annotations

import csv
import io
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.capture.open import open_capture
from hgs_core.capture.time.times_table import read_times_table
from tests.hgs_core.capture.layouts import CAMERAS, FRAMES, NAMES, PICTURES

_UNITS = {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9}


@pytest.fixture
def capture(tmp_path: Path) -> Path:
    CAMERAS["caliscope"](tmp_path)
    PICTURES["videos"](tmp_path)
    return tmp_path


def write(root: Path, unit: str, origin: float, column: str = "frame_time", late: float = 1 / 30) -> None:
    """Cameras at 30 frames per second, the second later by a frame."""
    per_second = _UNITS[unit]
    rows = [f"cam_id,{column}"]
    for frame in range(FRAMES):
        for camera, name in enumerate(NAMES):
            moment = origin * per_second + (frame / 30 + (late if camera == 1 else 0)) * per_second
            rows.append(f"{name},{moment:.6f}" if unit == "s" else f"{name},{round(moment)}")
    (root / "timestamps.csv").write_text("\n".join(rows) + "\n")


@pytest.mark.parametrize("unit", _UNITS)
@pytest.mark.parametrize("origin", [0.0, 12.5, 1_764_000_000.0])
def test_the_unit_is_told_by_the_rate_of_the_footage(capture: Path, unit: str, origin: float) -> None:
    write(capture, unit, origin)
    opened = open_capture(capture)
    assert opened.seconds == pytest.approx((FRAMES - 2) / 30, rel=0.01)
    assert [opened.number(camera, 0) for camera in range(4)] == [1, 0, 1, 1]
    said = [note for note in opened.notes if "by the rate of the footage" in note]
    assert len(said) == (unit != "s")


@pytest.mark.parametrize("column", ["timestamp_ms", "Time (ms)", "frameTime_ms", "time [milliseconds]", "MS"])
def test_the_unit_in_the_name_of_the_column_counts(capture: Path, column: str) -> None:
    write(capture, "ms", 0.0, column)
    opened = open_capture(capture)
    assert opened.seconds == pytest.approx((FRAMES - 2) / 30, rel=0.01)
    assert not any("by the rate" in note for note in opened.notes)


def test_a_unit_that_the_footage_contradicts_is_refused_and_the_cure_cures(capture: Path) -> None:
    write(capture, "ms", 0.0, "time_s")
    with pytest.raises(
        InputError, match=r"time_s steps by 33.* in seconds, and the footage has 30; it is that in milli"
    ):
        open_capture(capture)
    write(capture, "ms", 0.0, "time_ms")
    assert len(open_capture(capture).times) == FRAMES - 1


@pytest.mark.parametrize("step", [1.0, 1 / 300, 3.3, 1e4 / 3, 333_333.3, 0.5])
def test_steps_of_no_unit_are_refused_and_the_cure_cures(capture: Path, step: float) -> None:
    """Numbers of frames, tenths of milliseconds, ticks of 100 ns and the like."""
    rows = [f"{name},{step * frame:.9g}" for frame in range(FRAMES) for name in NAMES]
    (capture / "timestamps.csv").write_text("\n".join(["cam_id,frame_time", *rows]))
    with pytest.raises(InputError, match=r'the footage has 30 frames per second: no unit fits; call .* "frame_time_s"'):
        open_capture(capture)
    (capture / "timestamps.csv").write_text("\n".join(["cam_id,frame_time_s", *rows]))
    opened = open_capture(capture)
    assert opened.seconds == pytest.approx(step * (FRAMES - 1), rel=1e-6)
    assert any(note.endswith("frames per second and the footage 30: the table counts") for note in opened.notes)


def test_a_table_that_differs_from_the_footage_counts_and_says_so(capture: Path) -> None:
    rows = [f"{name},{frame / 20:.6f}" for frame in range(FRAMES) for name in NAMES]
    (capture / "timestamps.csv").write_text("\n".join(["cam_id,frame_time", *rows]))
    opened = open_capture(capture)
    assert opened.seconds == pytest.approx((FRAMES - 1) / 20)
    assert "timestamps.csv has 20 frames per second and the footage 30: the table counts" in opened.notes


@pytest.mark.parametrize("separator", [",", ";", "\t", "|"])
@pytest.mark.parametrize("comma", [False, True])
@pytest.mark.parametrize("quoted", [False, True])
@pytest.mark.parametrize(
    "columns", [("cam_id", "frame_time"), ("Cam ID", " Frame Time "), ("CAMERA", "TIMESTAMP"), ("camId", "time")]
)
def test_every_way_to_write_a_table(
    tmp_path: Path, separator: str, comma: bool, quoted: bool, columns: tuple[str, str]
) -> None:
    if comma and separator == "," and not quoted:
        return
    held = io.StringIO()
    writer = csv.writer(held, delimiter=separator, quoting=csv.QUOTE_ALL if quoted else csv.QUOTE_MINIMAL)
    writer.writerow([*columns, "note"])
    for frame in range(3):
        writer.writerow(["left", f"{100 + frame / 30:.4f}".replace(".", "," if comma else "."), "x"])
    (tmp_path / "timestamps.csv").write_text(held.getvalue(), "utf-8-sig")
    table = read_times_table(tmp_path / "timestamps.csv")
    assert list(table.times) == ["left"]
    np.testing.assert_allclose(table.times["left"], [100, 100.0333, 100.0667], atol=1e-3)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1.764.000,5", 1_764_000.5),
        ("1,764,000.5", 1_764_000.5),
        ("1,764,000", 1_764_000),
        ("1 764,25", 1764.25),
        ("1e3", 1000),
    ],
)
def test_thousands_may_be_parted(tmp_path: Path, text: str, value: float) -> None:
    (tmp_path / "t.csv").write_text(f"cam;time\na;{text}\n")
    assert read_times_table(tmp_path / "t.csv").times["a"].tolist() == [value]


@pytest.mark.parametrize("pattern", ["%Y-%m-%d %H:%M:%S.%f", "%Y-%m-%dT%H:%M:%S.%f+00:00", "%H:%M:%S.%f"])
def test_dates_and_times_of_day_are_seconds(capture: Path, pattern: str) -> None:
    start = datetime(2025, 3, 1, 12, 0, tzinfo=UTC)
    moments = [(start + timedelta(seconds=frame / 30)).strftime(pattern) for frame in range(FRAMES)]
    rows = [f"{name};{moment}" for moment in moments for name in NAMES]
    (capture / "timestamps.csv").write_text("\n".join(["camera;time", *rows]))
    assert open_capture(capture).seconds == pytest.approx((FRAMES - 1) / 30, abs=1e-4)


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        (
            "cam_id,frame_time\na,1\na,1\n",
            "t.csv, row 2: '1' of camera 'a' is no later than the time before; correct it",
        ),
        ("cam_id,frame_time\na,nan\n", "t.csv, row 1: frame_time is 'nan'; it is a number"),
        ("cam_id,frame_time\na,1e999\n", "t.csv, row 1: frame_time is '1e999'"),
        ("cam_id,frame_time\na\n", "t.csv, row 1: has 1 columns, and the first line has 2; complete the row"),
        ("cam_id,when\na,1\n", "the columns are cam_id, when; it needs a column cam_id and a column frame_time"),
    ],
)
def test_a_row_that_tells_no_time_is_named(tmp_path: Path, text: str, problem: str) -> None:
    (tmp_path / "t.csv").write_text(text)
    with pytest.raises(InputError, match=problem):
        read_times_table(tmp_path / "t.csv")
