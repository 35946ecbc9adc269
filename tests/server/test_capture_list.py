"""The captures that a server offers."""

from __future__ import annotations

import dataclasses
import json
import shutil
from pathlib import Path
from typing import Any

import pytest

from hgs_core.base.errors import InputError
from hgs_core.capture.layout import Outline
from server import capture_list as module
from server.capture_folders import CaptureFolders
from server.capture_list import CaptureList
from tests.conftest import REPOSITORY


@pytest.fixture
def root(tmp_path: Path) -> Path:
    root = tmp_path / "captures"
    root.mkdir()
    return root


@pytest.fixture
def captures(root: Path) -> CaptureList:
    return CaptureList(CaptureFolders((root.resolve(),)))


def write_still(folder: Path, *pictures: str) -> None:
    """A capture of photographs, as far as a list looks into it."""
    folder.mkdir(parents=True)
    pose = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    frames = [{"file_path": name, "transform_matrix": pose} for name in pictures]
    (folder / "transforms.json").write_text(json.dumps({"fl_x": 50, "w": 64, "h": 48, "frames": frames}))
    for name in pictures:
        (folder / name).touch()


def names(captures: CaptureList) -> list[str]:
    return [capture["name"] for capture in captures.describe()["captures"]]


def test_a_capture_is_described_with_its_cameras_and_its_length(captures: CaptureList, root: Path) -> None:
    (root / "studio").symlink_to(root.parent / "elsewhere")
    shutil.copytree(REPOSITORY / "samples" / "studio", root / "shows" / "studio")
    (found,) = captures.describe()["captures"]
    assert found == {
        "capture": str(root / "shows" / "studio"), "name": "shows/studio", "layout": "N3DV",
        "cameras": [f"cam{number:02}" for number in range(16)], "frames": 60, "seconds": 2.0, "problem": None,
    }  # fmt: skip


def test_three_videos_without_poses_are_a_capture_too(captures: CaptureList, root: Path) -> None:
    studio = REPOSITORY / "samples" / "studio"
    for folder, numbers in (("three", (10, 2, 1)), ("two", (1, 2))):
        (root / folder).mkdir()
        for number in numbers:
            shutil.copy(studio / f"cam{number:02}.mp4", root / folder / f"cam{number}.mp4")
    (found,) = captures.describe()["captures"]
    assert found == {
        "capture": str(root / "three"), "name": "three", "layout": "videos without poses",
        "cameras": ["cam1", "cam2", "cam10"], "frames": 60, "seconds": 2.0, "problem": None,
    }  # fmt: skip


def test_captures_come_by_name_from_as_deep_as_the_bound(captures: CaptureList, root: Path) -> None:
    for name in ("b", "a/two", "a/one", "a/b/c", "a/b/d/too_deep", ".hidden"):
        write_still(root / name, "1.png")
    (root / "b" / "inside").mkdir()
    write_still(root / "b" / "inside" / "a_capture", "1.png")
    assert names(captures) == ["a/b/c", "a/one", "a/two", "b"]


def test_a_folder_that_is_a_capture_itself_has_its_own_name(root: Path) -> None:
    write_still(root / "studio", "1.png")
    assert names(CaptureList(CaptureFolders(((root / "studio").resolve(),)))) == ["studio"]


def test_links_that_lead_out_of_the_folders_are_not_followed(captures: CaptureList, root: Path) -> None:
    write_still(root.parent / "secret", "1.png")
    (root / "link").symlink_to(root.parent / "secret")
    (root / "loop").symlink_to(root)
    write_still(root / "mine", "1.png")
    assert "link" not in names(captures)
    assert "mine" in names(captures)


def test_a_damaged_capture_says_what_is_wrong_with_it(captures: CaptureList, root: Path) -> None:
    (root / "damaged").mkdir()
    (root / "damaged" / "train_meta.json").write_text("{")
    write_still(root / "well", "1.png")
    damaged, well = captures.describe()["captures"]
    assert "train_meta.json: unreadable" in damaged["problem"]
    assert (damaged["cameras"], damaged["frames"]) == ([], None)
    assert well["problem"] is None


def test_folders_are_named_whether_they_are_there_or_not(root: Path) -> None:
    listed = CaptureList(CaptureFolders((root, root / "missing"))).describe()
    assert listed == {
        "captures": [], "complete": True,
        "folders": [{"path": str(root), "exists": True}, {"path": str(root / "missing"), "exists": False}],
    }  # fmt: skip


@pytest.mark.parametrize(("bound", "most"), [("_MOST_CAPTURES", 3), ("_MOST_FOLDERS", 4)])
def test_a_list_that_meets_a_bound_is_cut_and_says_so(
    captures: CaptureList, root: Path, monkeypatch: pytest.MonkeyPatch, bound: str, most: int
) -> None:
    for number in range(9):
        write_still(root / str(number), "1.png")
    monkeypatch.setattr(module, bound, most)
    listed = captures.describe()
    assert (len(listed["captures"]), listed["complete"]) == (3, False)


def test_a_table_that_is_too_large_is_not_read(
    captures: CaptureList, root: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_still(root / "a", "1.png")
    monkeypatch.setattr(module, "_LARGEST_TABLE", 3)
    (found,) = captures.describe()["captures"]
    assert "too large" in found["problem"]


def test_only_what_has_changed_is_read_again(
    captures: CaptureList, root: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    read: list[str] = []

    def counting(path: Path, camera_format: Any, file: Path) -> Outline:
        read.append(path.name)
        if path.name == "b":
            raise InputError(path, "is damaged")
        return Outline(("1",))

    monkeypatch.setattr(module, "outline", counting)
    for name in ("a", "b"):
        write_still(root / name, "1.png")
    for _ in range(3):
        captures.describe()
    assert read == ["a", "b"]
    (root / "b" / "2.png").touch()
    captures.describe()
    assert read == ["a", "b", "b"]


@pytest.fixture
def uploaded(captures: CaptureList, root: Path) -> Path:
    """The folder of uploaded captures."""
    folder = root.parent / "uploaded"
    folder.mkdir()
    captures.folders = dataclasses.replace(captures.folders, uploaded=folder.resolve())
    return folder


@pytest.mark.parametrize(
    ("files", "name", "layout", "problem"),
    [
        (["a.mp4", "b.mp4"], "studio", None, "2 videos but no file of the cameras' poses"),
        (["a.jpg", "b.jpg", "c.jpg"], "studio", None, "3 pictures but no file"),
        (["notes.txt"], "studio", None, "of no known layout"),
        ([f"videos/{name}.mp4" for name in "abc"], "studio/videos", "videos without poses", "a.mp4"),
    ],
)
def test_an_upload_that_is_no_capture_is_listed_with_what_is_missing(
    captures: CaptureList, uploaded: Path, files: list[str], name: str, layout: str | None, problem: str
) -> None:
    for file in files:
        (uploaded / "studio" / file).parent.mkdir(parents=True, exist_ok=True)
        (uploaded / "studio" / file).touch()
    (found,) = captures.describe()["captures"]
    assert (found["name"], found["layout"]) == (name, layout)
    assert problem in found["problem"]


def test_the_capture_inside_an_upload_is_found(captures: CaptureList, uploaded: Path) -> None:
    write_still(uploaded / "all" / "of" / "it", "1.png")
    (found,) = captures.describe()["captures"]
    assert (found["name"], found["problem"]) == ("all/of/it", None)
    assert captures.describe()["folders"] == [{"path": str(captures.folders.folders[0]), "exists": True}]


def test_a_capture_with_a_link_that_leads_out_is_not_opened(captures: CaptureList, root: Path, tmp_path: Path) -> None:
    write_still(root / "a", "1.png")
    secret = tmp_path / "secret.json"
    shutil.copy(root / "a" / "transforms.json", secret)
    (root / "a" / "transforms.json").unlink()
    (root / "a" / "transforms.json").symlink_to(secret)
    (found,) = captures.describe()["captures"]
    assert "'transforms.json' is a link that leads outside" in found["problem"]
    assert found["cameras"] == []
