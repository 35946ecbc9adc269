"""Names that another machine wrote, and the files that they mean."""

from __future__ import annotations

from pathlib import Path

import pytest

from hgs_core.capture.files.named_files import find_named, otherwise_named, path_as_written, plain_name


def touch(root: Path, *files: str) -> None:
    for file in files:
        (root / file).parent.mkdir(parents=True, exist_ok=True)
        (root / file).touch()


@pytest.mark.parametrize(
    ("name", "there"),
    [
        ("images/a.png", "images/a.png"),
        ("./images//a.png", "images/a.png"),
        ("images\\a.png", "images/a.png"),
        ("C:\\Users\\Eva\\scan\\images\\a.png", "images/a.png"),
        ("/home/eva/scan/images/a.png", "images/a.png"),
        ("../scan/images/a.png", "images/a.png"),
        ("Images/A.PNG", "images/a.png"),
        ("images/a.png", "IMAGES/A.PNG"),
        ("images/a", "images/a.jpg"),
        ("images/a.png", "images/a.jpg"),
        ("images/frame.0001", "images/frame.0001.tiff"),
        ("images/take%201/a%23.png", "images/take 1/a#.png"),
        (" images/a.png ", "images/a.png"),
        ("images/a 1.png", "images/a 1.png"),
        ("images\\a.png", "images\\a.png"),
        ("images/cam00", "images/cam00"),
        ("videos/a", "videos/a.MP4"),
    ],
)
def test_one_file_is_meant(tmp_path: Path, name: str, there: str) -> None:
    touch(tmp_path, there, "other/b.png")
    assert find_named(tmp_path, [name]).files == (tmp_path / there,)


def test_the_longest_end_of_a_path_counts(tmp_path: Path) -> None:
    touch(tmp_path, "cam00/0.png", "images/cam00/0.png")
    assert find_named(tmp_path, ["/x/images/cam00/0.png"]).files == (tmp_path / "images/cam00/0.png",)


def test_what_most_names_need_taken_away_is_taken_of_all(tmp_path: Path) -> None:
    """A lone 0.png at the top does not replace a missing picture of cam02."""
    touch(tmp_path, "images/cam00/0.png", "images/cam01/0.png", "0.png")
    found = find_named(tmp_path, [f"/x/images/cam{camera:02d}/0.png" for camera in range(3)])
    assert found.files == (tmp_path / "images/cam00/0.png", tmp_path / "images/cam01/0.png", None)


@pytest.mark.parametrize("files", [["a.jpg", "a.webp"], ["A.png", "a.PNG"], ["b.png"]])
def test_nothing_is_found_where_two_could_be_meant_or_none(tmp_path: Path, files: list[str]) -> None:
    touch(tmp_path, *files)
    assert find_named(tmp_path, ["a.png"]).files == (None,)


@pytest.mark.parametrize("name", ["../outside.png", "/etc/outside.png", "a/../../outside.png", "..\\outside.png"])
def test_no_name_leads_out_of_the_capture(tmp_path: Path, name: str) -> None:
    touch(tmp_path, "outside.png", "capture/a.png")
    assert find_named(tmp_path / "capture", [name]).files == (None,)
    assert path_as_written(tmp_path / "capture", name) is None


def test_what_is_written_otherwise_is_said_with_an_example(tmp_path: Path) -> None:
    touch(tmp_path, "images/a.png", "images/b.png", "images/c.png")
    found = find_named(tmp_path, ["images/a.png", "images/b", "images\\c.png"])
    (said,) = otherwise_named("t.json", found)
    assert said.startswith(
        "1 of the 3 names in t.json are written otherwise than the files there: 'images\\\\c.png' is"
    )
    assert otherwise_named("t.json", find_named(tmp_path, ["images/a.png"])) == []


def test_names_are_compared_plainly() -> None:
    assert plain_name(" Cam%2001\\Take ") == "cam 01/take"
