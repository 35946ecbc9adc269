"""First points on disk: a file for each segment, kept by a search that was stopped, and the same bits in any case."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.base.progress import Progress, StageStopped, silent
from hgs_core.capture.capture import Capture
from hgs_core.capture.open import open_capture
from hgs_core.decompose.masks import motion_masks
from hgs_core.points.initial_points import PointSearch
from hgs_core.points.kept_points import keep_points, segment_points
from hgs_core.points.near_plane import load_near_planes, with_near_planes
from hgs_core.points.point_cloud import PointCloud
from tests.synthetic import write_capture

VIEWS = (0, 1, 3, 4)
SEGMENTS = ((0, 2), (2, 3, 4), (4, 5))
FILES = ["0.npz", "1.npz", "2.npz", "near.json", "still.npz"]


@pytest.fixture(scope="module")
def capture(tmp_path_factory: pytest.TempPathFactory) -> Capture:
    folder = tmp_path_factory.mktemp("capture")
    write_capture(folder)
    return open_capture(folder)


@pytest.fixture(scope="module")
def search(capture: Capture) -> PointSearch:
    rows, columns = np.indices((48, 64))
    middle = (rows - 24) ** 2 + (columns - 32) ** 2 < 18**2  # the middle of the scene
    masks = motion_masks(capture, VIEWS, progress=silent).changed(lambda camera, frame, mask: middle)
    return PointSearch(capture, VIEWS, masks, static_target=200, dynamic_target=120)


@pytest.fixture(scope="module")
def reports() -> list[Progress]:
    return []


@pytest.fixture(scope="module")
def whole(search: PointSearch, reports: list[Progress], tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("whole")
    keep_points(folder, search, SEGMENTS, seed=0, progress=reports.append)
    return folder


def arrays(folder: Path) -> dict[str, dict[str, bytes]]:
    """The content of the files; zip archives have dates."""
    found = {}
    for file in sorted(folder.iterdir()):
        if file.suffix == ".npz":
            with np.load(file) as archive:
                found[file.name] = {name: archive[name].tobytes() for name in archive.files}
        else:
            found[file.name] = {"": file.read_bytes()}
    return found


def test_each_segment_has_a_file_of_its_own(whole: Path) -> None:
    assert sorted(file.name for file in whole.iterdir()) == FILES


def test_progress_rises_to_its_total(whole: Path, reports: list[Progress]) -> None:
    assert [report.done for report in reports] == list(range(8))
    assert {report.total for report in reports} == {7}


@pytest.mark.parametrize(("stopped_at", "kept"), [(1, 0), (3, 1), (4, 1), (5, 2), (7, 3)])
def test_a_search_stopped_anywhere_goes_on_to_the_same_bits(
    search: PointSearch, whole: Path, tmp_path: Path, stopped_at: int, kept: int
) -> None:
    def stop(step: Progress) -> None:
        if step.done == stopped_at:
            raise StageStopped

    with pytest.raises(StageStopped):
        keep_points(tmp_path, search, SEGMENTS, seed=0, progress=stop)
    there = {file: file.stat().st_mtime_ns for file in tmp_path.iterdir()}
    assert len(there) == kept
    keep_points(tmp_path, search, SEGMENTS, seed=0, progress=silent)
    assert {file: file.stat().st_mtime_ns for file in there} == there
    assert arrays(tmp_path) == arrays(whole)


@pytest.mark.parametrize("lost", ["1.npz", "still.npz"])
def test_a_file_that_is_gone_is_made_again(search: PointSearch, whole: Path, tmp_path: Path, lost: str) -> None:
    folder = shutil.copytree(whole, tmp_path / "points")
    (folder / lost).unlink()
    keep_points(folder, search, SEGMENTS, seed=0, progress=silent)
    assert arrays(folder) == arrays(whole)


def test_a_segment_is_read_without_the_others(whole: Path, tmp_path: Path) -> None:
    for name in ("still.npz", "1.npz"):
        shutil.copy(whole / name, tmp_path)
    points = segment_points(tmp_path, 1)
    assert len(points) > len(PointCloud.load(whole / "still.npz"))
    with pytest.raises(InputError, match=r"2\.npz.*delete it and near\.json"):
        segment_points(tmp_path, 2)


def test_a_segment_has_the_points_of_both_its_ends(whole: Path, capture: Capture) -> None:
    for number, (first, *_, last) in enumerate(SEGMENTS):
        times = PointCloud.load(whole / f"{number}.npz").times
        assert times.min() == np.float32(capture.times[first])
        assert times.max() == np.float32(capture.times[last])
    before, after = (PointCloud.load(whole / f"{number}.npz") for number in (0, 1))
    border = np.float32(capture.times[2])
    assert before.take(before.times == border).xyz.tobytes() == after.take(after.times == border).xyz.tobytes()


def test_near_planes_are_those_of_all_points(whole: Path, capture: Capture) -> None:
    parts = [PointCloud.load(whole / "still.npz").xyz, PointCloud.load(whole / "0.npz").xyz]
    for number in (1, 2):
        later = PointCloud.load(whole / f"{number}.npz")
        parts.append(later.xyz[later.times > np.float32(capture.times[SEGMENTS[number][0]])])
    expected = with_near_planes(capture.cameras, np.concatenate(parts))
    found = load_near_planes(whole / "near.json", capture.cameras)
    assert [camera.near for camera in found] == [camera.near for camera in expected]


def test_a_damaged_file_is_named_with_a_cure(search: PointSearch, whole: Path, tmp_path: Path) -> None:
    folder = shutil.copytree(whole, tmp_path / "points")
    (folder / "0.npz").write_bytes(b"nothing")
    (folder / "1.npz").unlink()
    with pytest.raises(InputError, match=r"0\.npz: unreadable.*delete it and near\.json beside it"):
        keep_points(folder, search, SEGMENTS, seed=0, progress=silent)
