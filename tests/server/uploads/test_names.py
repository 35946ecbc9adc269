from __future__ import annotations

import re
import string
import unicodedata
from pathlib import PurePosixPath

import pytest
from hypothesis import given
from hypothesis import strategies as st

from server.http.problems import ProblemError
from server.uploads.names import FolderNames, capture_name, normal_path

PART = st.text(
    st.sampled_from(string.ascii_letters + string.digits + "_-äößﬁ\uff21 e\u0301\u202e./\\:\0\n"), max_size=12
)
PATH = st.one_of(st.text(max_size=40), st.lists(PART, max_size=10).map("/".join))


@given(PATH)
def test_a_path_that_is_taken_stays_in_its_folder_and_can_be_seen(path: str) -> None:
    refused = None
    try:
        normal = normal_path(path)
    except ProblemError as problem:
        refused = problem
    if refused is not None:
        assert (refused.status, refused.code, refused.field) == (422, "name-invalid", "path")
        assert refused.detail.isprintable()
        return
    parts = normal.split("/")
    assert PurePosixPath(normal).parts == tuple(parts)  # neither absolute nor with empty parts
    assert all(part not in ("", ".", "..") and part == part.strip() and "\\" not in part for part in parts)
    assert all(unicodedata.category(one)[0] != "C" for one in normal)
    assert unicodedata.is_normalized("NFC", normal)
    assert len(normal.encode()) <= 1024
    assert max(len(part.encode()) for part in parts) <= 255
    assert normal_path(normal) == normal


@pytest.mark.parametrize(
    ("path", "problem"),
    [
        ("", "empty"),
        ("/etc/passwd", "absolute"),
        ("../x", "'..'"),
        ("a/../b", "'..'"),
        ("a//b", "part ''"),
        ("a/", "part ''"),
        ("com1.mp4", "device"),
        ("con", "device"),
        ("x/NUL.txt", "device"),
        ("./a", "'.'"),
        ("a\\..\\b", "backslash"),
        (".ssh/x", "hidden"),
        ("a\0b", "U+0000"),
        ("a\nb", "U+000A"),
        ("gpj\u202eb.exe", "U+202E"),
        ("a\u200bb", "U+200B"),
        ("\ud800", "U+D800"),
        ("a. ", "space"),
        ("a.", "dot"),
        (" a", "space"),
        ("x" * 201, "201 bytes"),
        ("a/" * 8 + "b", "9 parts"),
        ("ä/" * 600, "longer than 1024"),
    ],
)
def test_what_is_no_plain_name_is_refused(path: str, problem: str) -> None:
    with pytest.raises(ProblemError, match=re.escape(problem)):
        normal_path(path)


@pytest.mark.parametrize(
    "path",
    [
        "cam00.mp4",
        "images/cam 00/0000.png",
        "Kamera Ä.mov",
        "sparse/0/cameras.bin",
        "カメラ/1.png",
        "a:b?.png",
        "console",
    ],
)
def test_names_of_captures_are_taken_as_they_are(path: str) -> None:
    assert normal_path(path) == path


def test_names_are_kept_composed() -> None:
    assert normal_path("a\u0308.png") == "ä.png"


@pytest.mark.parametrize(
    ("first", "second"),
    [
        ("a/x.png", "A/y.png"),
        ("cam.png", "CAM.PNG"),
        ("straße", "STRASSE"),
        ("ﬁlm", "film"),
        ("\uff21", "a"),
        ("a", "a/b"),
        ("a/b", "a"),
        ("a/b/c", "A/B"),
    ],
)
def test_names_that_could_be_one_are_refused(first: str, second: str) -> None:
    names = FolderNames()
    names.add(first)
    with pytest.raises(ProblemError, match="one file or folder") as caught:
        names.add(second)
    assert (caught.value.status, caught.value.code) == (409, "name-taken")
    names.add(first)


@given(st.lists(st.text("aAbBß/", min_size=1, max_size=6), max_size=12))
def test_files_that_are_taken_together_are_apart_where_case_does_not_count(paths: list[str]) -> None:
    names, taken = FolderNames(), set[str]()
    for path in paths:
        try:
            names.add(normal_path(path))
        except ProblemError:
            continue
        taken.add(path)
    folded = {path.casefold() for path in taken}
    assert len(folded) == len(taken)
    above = {str(parent) for path in folded for parent in PurePosixPath(path).parents}
    assert not folded & above
    spelled = {str(parent) for path in taken for parent in PurePosixPath(path).parents}
    assert len({one.casefold() for one in spelled}) == len(spelled)


@pytest.mark.parametrize(
    ("given_name", "name"),
    [
        ("studio", "studio"),
        ("My Take", "My Take"),
        ("../../etc", "etc"),
        (".hidden", "hidden"),
        ("", "capture"),
        ("NUL", "NUL capture"),
        ("a/b", "a b"),
        ("a\0\u202eb", "a b"),
        ("…" * 200, "…" * 33),
        (". .", "capture"),
    ],
)
def test_a_capture_is_called_nearly_as_the_folder_was(given_name: str, name: str) -> None:
    assert capture_name(given_name) == name


@given(st.text(max_size=300))
def test_the_name_of_a_capture_is_one_plain_part(name: str) -> None:
    plain = capture_name(name)
    assert normal_path(plain) == plain
    assert "/" not in plain
