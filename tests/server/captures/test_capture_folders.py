from __future__ import annotations

import dataclasses
import os
from pathlib import Path

import pytest

from hgs_core.base.errors import InputError
from server.captures.capture_folders import CaptureFolders
from server.http.problems import ProblemError
from tests.conftest import REPOSITORY


@pytest.fixture
def folders(tmp_path: Path) -> CaptureFolders:
    """Two folders, `first` and `second`, each with captures, beside one that is not among them."""
    for name in ("first/studio", "first/both", "second/garden", "second/both", "other"):
        (tmp_path / name).mkdir(parents=True)
    return CaptureFolders((tmp_path.resolve() / "first", tmp_path.resolve() / "second"))


@pytest.mark.parametrize(
    ("capture", "found"),
    [("studio", "first/studio"), ("garden", "second/garden"), ("both", "first/both"), ("garden/../both", "first/both")],
)
def test_names_are_looked_up_in_the_folders_in_order(
    folders: CaptureFolders, tmp_path: Path, capture: str, found: str
) -> None:
    assert folders.locate(capture) == tmp_path.resolve() / found


def test_absolute_paths_inside_a_folder_are_taken(folders: CaptureFolders) -> None:
    garden = folders.folders[1] / "garden"
    assert folders.locate(str(garden)) == garden


@pytest.mark.parametrize("capture", ["/etc", "../other", "studio/../../other"])
def test_what_lies_outside_is_403_with_the_setting(folders: CaptureFolders, capture: str) -> None:
    with pytest.raises(ProblemError, match="HGS_CAPTURES") as caught:
        folders.locate(capture)
    assert (caught.value.status, caught.value.code) == (403, "capture-outside")


def test_a_symbolic_link_leads_out_no_more_than_dots_do(folders: CaptureFolders) -> None:
    for folder in folders.folders:
        (folder / "link").symlink_to(os.sep)
    with pytest.raises(ProblemError, match="outside"):
        folders.locate("link")


@pytest.mark.parametrize("capture", ["missing", "~", "file"])
def test_what_is_no_folder_is_bad_input(folders: CaptureFolders, capture: str) -> None:
    (folders.folders[0] / "file").write_text("")
    with pytest.raises(InputError, match="is not a folder; give the folder of a capture"):
        folders.locate(capture)


@pytest.mark.parametrize("capture", ["x" * 4000, "a\0b", "\ud800"])
def test_what_no_path_can_be_is_bad_input(folders: CaptureFolders, capture: str) -> None:
    with pytest.raises(InputError, match="capture"):
        folders.locate(capture)


def test_files_are_looked_up_in_the_capture_first(folders: CaptureFolders) -> None:
    first, second = folders.folders
    for file in (first / "studio" / "a.wav", first / "a.wav", second / "b.wav"):
        file.write_text("")
    (first / "studio" / "c.wav").symlink_to(os.devnull)
    for name, found in (("a.wav", first / "studio" / "a.wav"), ("b.wav", second / "b.wav")):
        assert folders.locate_file("audio", name, first / "studio") == found
    assert folders.locate_file("audio", str(second / "b.wav"), first / "studio") == second / "b.wav"
    with pytest.raises(InputError, match="audio: there is no file"):
        folders.locate_file("audio", "d.wav", first / "studio")
    with pytest.raises(InputError, match="is not a path"):
        folders.locate_file("audio", "a\0b", first / "studio")
    for outside in ("/etc/hostname", "../../other/x.wav"):
        with pytest.raises(ProblemError, match="HGS_CAPTURES") as caught:
            folders.locate_file("audio", outside, first / "studio")
        assert (caught.value.status, caught.value.code, caught.value.field) == (403, "capture-outside", "audio")
    with pytest.raises(InputError, match="there is no file"):  # a link that leads out is passed over
        folders.locate_file("audio", "c.wav", first / "studio")


def test_a_list_that_is_given_counts_before_the_variable(tmp_path: Path) -> None:
    given, variable = f"{tmp_path}/a{os.pathsep}{tmp_path}/b", {"HGS_CAPTURES": f"{tmp_path}/c"}
    assert CaptureFolders.configured(tmp_path, given, variable).folders == (tmp_path / "a", tmp_path / "b")
    assert CaptureFolders.configured(tmp_path, environment=variable).folders == (tmp_path / "c",)


def test_the_default_is_the_home_and_the_samples_of_a_checkout(tmp_path: Path) -> None:
    assert CaptureFolders.configured(tmp_path, environment={}).folders == (
        tmp_path / "captures",
        REPOSITORY / "samples",
    )


def test_links_in_the_setting_are_resolved(tmp_path: Path) -> None:
    (tmp_path / "real" / "studio").mkdir(parents=True)
    (tmp_path / "link").symlink_to(tmp_path / "real")
    configured = CaptureFolders.configured(tmp_path, str(tmp_path / "link"))
    assert configured.locate("studio") == tmp_path.resolve() / "real" / "studio"


@pytest.mark.parametrize("link", ["cam00.mp4", "images/cam00", "sparse/0/cameras.bin"])
def test_a_link_inside_a_capture_leads_out_no_more_than_the_capture_does(
    folders: CaptureFolders, tmp_path: Path, link: str
) -> None:
    place = folders.folders[0] / "studio" / link
    place.parent.mkdir(parents=True, exist_ok=True)
    place.symlink_to(tmp_path / "second" / "garden")
    folders.require_inner_links(folders.locate("studio"))  # into a folder that may be read, too
    place.unlink()
    place.symlink_to(tmp_path / "other")
    with pytest.raises(ProblemError, match=f"'{link}' is a link that leads outside .*HGS_CAPTURES") as caught:
        folders.require_inner_links(folders.locate("studio"))
    assert (caught.value.status, caught.value.code) == (403, "capture-outside")


def test_a_loop_of_links_inside_a_capture_ends(folders: CaptureFolders) -> None:
    (folders.folders[0] / "studio" / "again").symlink_to(folders.folders[0] / "studio")
    folders.require_inner_links(folders.locate("studio"))


def test_uploaded_captures_are_looked_up_last(folders: CaptureFolders, tmp_path: Path) -> None:
    for name in ("both", "sent"):
        (tmp_path / "uploaded" / name).mkdir(parents=True)
    both = dataclasses.replace(folders, uploaded=tmp_path.resolve() / "uploaded")
    assert both.locate("both") == tmp_path.resolve() / "first" / "both"
    assert both.locate("sent") == tmp_path.resolve() / "uploaded" / "sent"


@pytest.mark.parametrize(
    ("told", "shown"),
    [
        ("/srv/all/studio/cam0.mp4: is damaged", "studio/cam0.mp4: is damaged"),
        ("'/srv/all/a b/c' and /srv/all/d", "'a b/c' and d"),
        ("/srv/all: is empty", "all: is empty"),
        ("/srv/all/inner/x: is short", "x: is short"),  # the innermost folder counts
        ("/srv/allowed/x and /mnt/srv/all/x stay", "/srv/allowed/x and /mnt/srv/all/x stay"),
        ("/uploads/one/t.json: is short", "one/t.json: is short"),
    ],
)
def test_clients_are_told_names_below_the_folders(told: str, shown: str) -> None:
    folders = CaptureFolders((Path("/srv/all"), Path("/srv/all/inner"), Path("/")), Path("/uploads"))
    assert folders.shown(told) == shown
