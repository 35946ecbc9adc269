"""Outlines of captures, from their lists and headers."""

from __future__ import annotations

import dataclasses
import json
import shutil
from pathlib import Path
from typing import Any

import pytest

from hgs_core.base.errors import InputError
from server.captures import capture_outlines as module
from server.captures.capture_folders import CaptureFolders
from server.captures.capture_outlines import (
    camera_pictures,
    describe_capture,
    find_captures,
    require_bounded_tables,
)
from server.http.problem_error import ProblemError
from tests.conftest import REPOSITORY


@pytest.fixture
def root(tmp_path: Path) -> Path:
    root = tmp_path / "captures"
    root.mkdir()
    return root.resolve()


@pytest.fixture
def folders(root: Path) -> CaptureFolders:
    return CaptureFolders((root,))


def write_still(folder: Path, *pictures: str) -> None:
    """A capture of photographs, as far as a list looks into it."""
    folder.mkdir(parents=True)
    pose = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    frames = [{"file_path": name, "transform_matrix": pose} for name in pictures]
    (folder / "transforms.json").write_text(json.dumps({"fl_x": 50, "w": 64, "h": 48, "frames": frames}))
    for name in pictures:
        (folder / name).touch()


def names(folders: CaptureFolders) -> list[str]:
    return [capture.name for capture in find_captures(folders)[0]]


def described(path: Path, folders: CaptureFolders) -> dict[str, Any]:
    """The description of a sound capture in a list, without its problem and its preview."""
    told = describe_capture(path, folders)
    assert told.pop("problem") is None
    assert set(told) >= {"picture", "presets"}
    return {name: value for name, value in told.items() if name not in ("picture", "presets")}


def test_a_capture_is_described_with_its_cameras_and_its_length(folders: CaptureFolders, root: Path) -> None:
    (root / "studio").symlink_to(root.parent / "elsewhere")
    shutil.copytree(REPOSITORY / "samples" / "studio", root / "shows" / "studio")
    (found,) = find_captures(folders)[0]
    assert (found.name, found.path, found.layout, found.cameras) == (
        "shows/studio",
        root / "shows" / "studio",
        "N3DV",
        (),
    )
    assert described(found.path, folders) == {
        "layout": "N3DV",
        "cameras": [f"cam{number:02}" for number in range(16)],
        "frames": 60,
        "seconds": 2.0,
    }


def test_three_videos_without_poses_are_a_capture_too(folders: CaptureFolders, root: Path) -> None:
    studio = REPOSITORY / "samples" / "studio"
    for folder, numbers in (("three", (10, 2, 1)), ("two", (1, 2))):
        (root / folder).mkdir()
        for number in numbers:
            shutil.copy(studio / f"cam{number:02}.mp4", root / folder / f"cam{number}.mp4")
    (found,) = find_captures(folders)[0]
    assert (found.name, found.layout, found.cameras) == ("three", "videos without poses", ("cam1", "cam2", "cam10"))
    assert described(found.path, folders) == {
        "layout": "videos without poses",
        "cameras": ["cam1", "cam2", "cam10"],
        "frames": 60,
        "seconds": 2.0,
    }


def test_captures_come_by_name_from_as_deep_as_the_bound(folders: CaptureFolders, root: Path) -> None:
    for name in ("b", "a/two", "a/one", "a/b/c", "a/b/d/too_deep", ".hidden"):
        write_still(root / name, "1.png")
    (root / "b" / "inside").mkdir()
    write_still(root / "b" / "inside" / "a_capture", "1.png")
    assert names(folders) == ["a/b/c", "a/one", "a/two", "b"]


def test_a_folder_that_is_a_capture_itself_has_its_own_name(root: Path) -> None:
    write_still(root / "studio", "1.png")
    assert names(CaptureFolders(((root / "studio"),))) == ["studio"]


def test_a_capture_has_a_preview(folders: CaptureFolders) -> None:
    told = describe_capture(REPOSITORY / "samples" / "studio", CaptureFolders((REPOSITORY / "samples",)))
    assert told["picture"].startswith("data:image/jpeg;base64,")
    assert set(told["presets"]) == {"preview", "standard", "best"}


def test_links_that_lead_out_of_the_folders_are_not_followed(folders: CaptureFolders, root: Path) -> None:
    write_still(root.parent / "secret", "1.png")
    (root / "link").symlink_to(root.parent / "secret")
    (root / "loop").symlink_to(root)
    write_still(root / "mine", "1.png")
    assert "link" not in names(folders)
    assert "mine" in names(folders)


def test_a_damaged_capture_is_found_and_refused(folders: CaptureFolders, root: Path) -> None:
    (root / "damaged").mkdir()
    (root / "damaged" / "train_meta.json").write_text("{")
    (found,) = find_captures(folders)[0]
    assert found.layout == "PanopticSports"
    with pytest.raises(InputError, match=r"train_meta.json: unreadable"):
        describe_capture(found.path, folders)


@pytest.mark.parametrize(("bound", "most"), [("_MOST_CAPTURES", 3), ("_MOST_FOLDERS", 4)])
def test_a_look_that_meets_a_bound_is_cut_and_says_so(
    folders: CaptureFolders, root: Path, monkeypatch: pytest.MonkeyPatch, bound: str, most: int
) -> None:
    for number in range(9):
        write_still(root / str(number), "1.png")
    monkeypatch.setattr(module, bound, most)
    found, complete = find_captures(folders)
    assert (len(found), complete) == (3, False)


@pytest.mark.parametrize("name", ["transforms.json", "sparse/0/CALIBRATION.TOML", "intri.yml"])
def test_a_table_that_is_too_large_is_not_read(
    folders: CaptureFolders, root: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    write_still(root / "a", "1.png")
    monkeypatch.setattr(module, "_LARGEST_TABLE", 999)
    require_bounded_tables(root / "a")
    (root / "a" / name).parent.mkdir(parents=True, exist_ok=True)
    (root / "a" / name).write_bytes(bytes(1000))
    with pytest.raises(InputError, match=f"{name}: is larger than"):
        describe_capture(root / "a", folders)


@pytest.mark.parametrize("change", ["transforms.json", "2.png", "images/2.png"])
def test_the_mark_of_a_capture_changes_with_its_files(folders: CaptureFolders, root: Path, change: str) -> None:
    write_still(root / "a", "1.png")
    (root / "a" / "images").mkdir()

    def mark() -> str:
        return find_captures(folders)[0][0].mark

    before = mark()
    assert mark() == before
    (root / "a" / change).write_text("{}")
    assert mark() != before


@pytest.fixture
def uploaded(folders: CaptureFolders, root: Path) -> CaptureFolders:
    """The same folders, with one of uploaded captures."""
    folder = root.parent / "uploaded"
    folder.mkdir()
    return dataclasses.replace(folders, uploaded=folder)


@pytest.mark.parametrize(
    ("files", "name", "layout", "problem"),
    [
        (["a.mp4", "b.mp4"], "studio", None, "2 videos but no file of the cameras' poses"),
        (["a.jpg", "b.jpg", "c.jpg"], "studio", None, "3 pictures but no file"),
        (["notes.txt"], "studio", None, "of no known layout"),
        ([f"videos/{name}.mp4" for name in "abc"], "studio/videos", "videos without poses", "a.mp4"),
    ],
)
def test_an_upload_that_is_no_capture_is_found_and_lacks_something(
    uploaded: CaptureFolders, files: list[str], name: str, layout: str | None, problem: str
) -> None:
    assert uploaded.uploaded is not None
    for file in files:
        (uploaded.uploaded / "studio" / file).parent.mkdir(parents=True, exist_ok=True)
        (uploaded.uploaded / "studio" / file).touch()
    (found,) = find_captures(uploaded)[0]
    assert (found.name, found.layout) == (name, layout)
    with pytest.raises(InputError, match=problem):
        describe_capture(found.path, uploaded)


def test_the_capture_inside_an_upload_is_found(uploaded: CaptureFolders) -> None:
    assert uploaded.uploaded is not None
    write_still(uploaded.uploaded / "all" / "of" / "it", "1.png")
    (found,) = find_captures(uploaded)[0]
    assert found.name == "all/of/it"
    assert described(found.path, uploaded)["frames"] == 1


def test_a_capture_with_a_link_that_leads_out_is_not_opened(
    folders: CaptureFolders, root: Path, tmp_path: Path
) -> None:
    write_still(root / "a", "1.png")
    secret = tmp_path / "secret.json"
    shutil.copy(root / "a" / "transforms.json", secret)
    (root / "a" / "transforms.json").unlink()
    (root / "a" / "transforms.json").symlink_to(secret)
    with pytest.raises(ProblemError, match=r"'transforms.json' is a link that leads outside"):
        describe_capture(root / "a", folders)


def test_each_camera_has_a_picture_of_its_own(
    folders: CaptureFolders, root: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.copytree(REPOSITORY / "samples" / "studio", root / "studio")
    monkeypatch.setattr(module, "_MOST_PICTURES", 3)
    pictures = list(camera_pictures(root / "studio", folders))
    assert [one["camera"] for one in pictures] == ["cam00", "cam01", "cam02"]
    assert len({one["picture"] for one in pictures}) == 3
    assert pictures[0]["picture"] == describe_capture(root / "studio", folders)["picture"]
