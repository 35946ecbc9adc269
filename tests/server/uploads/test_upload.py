from __future__ import annotations

import hashlib
from pathlib import Path

import pytest

from server.http.problems import ProblemError
from server.uploads.upload import Announcement, Upload
from server.uploads.upload_limits import UploadLimits

FILES = {"cam00.mp4": b"first" * 100, "sparse/0/cameras.txt": b"poses", "empty.txt": b""}
ANNOUNCED = Announcement("studio", len(FILES), sum(map(len, FILES.values())), "key")
LIMITS = UploadLimits(file=1000)


def announce(upload: Upload, path: str, content: bytes) -> int:
    return upload.add(path, len(content), hashlib.sha256(content).hexdigest(), LIMITS).number


def send(upload: Upload, path: str, content: bytes, until: int | None = None) -> None:
    file = upload.file(announce(upload, path, content))
    if rest := content[file.offset : until]:
        file.append(file.begin(file.offset), rest)


@pytest.fixture
def upload(tmp_path: Path) -> Upload:
    return Upload.create(tmp_path / "studio-1", ANNOUNCED)


def test_files_get_their_names_when_all_are_there(upload: Upload) -> None:
    for path, content in FILES.items():
        send(upload, path, content)
    tree = upload.assemble()
    assert {str(p.relative_to(tree)): p.read_bytes() for p in tree.rglob("*") if p.is_file()} == FILES
    assert upload.received == ANNOUNCED.bytes


def test_what_is_missing_is_told(upload: Upload) -> None:
    send(upload, "cam00.mp4", FILES["cam00.mp4"], until=7)
    with pytest.raises(ProblemError, match="2 of 3 files are not announced yet"):
        upload.assemble()
    for path in ("sparse/0/cameras.txt", "empty.txt"):
        send(upload, path, FILES[path])
    with pytest.raises(ProblemError, match=r"bytes of 1 files are missing, 'cam00\.mp4'"):
        upload.assemble()


@pytest.mark.parametrize("torn", [b"", b'{"path":"ca', b'{"path":"x","size":3,"sha256":"aa"}'])
def test_a_killed_server_finds_everything_again(upload: Upload, torn: bytes) -> None:
    send(upload, "sparse/0/cameras.txt", FILES["sparse/0/cameras.txt"])
    send(upload, "cam00.mp4", FILES["cam00.mp4"], until=123)
    with (upload.folder / "files.jsonl").open("ab") as journal:
        journal.write(torn)
    again = Upload.load(upload.folder)
    assert again.announced == ANNOUNCED
    assert [(f["path"], f["offset"], f["verified"]) for f in again.describe_files()] == [
        ("sparse/0/cameras.txt", 5, True),
        ("cam00.mp4", 123, False),
    ]
    for path, content in FILES.items():
        send(again, path, content)
    assert Upload.load(again.folder).assemble().is_dir()  # the line that was torn harms no later one


def test_a_server_killed_while_files_get_their_names_does_the_rest(upload: Upload) -> None:
    for path, content in FILES.items():
        send(upload, path, content)
    (upload.folder / "capture").mkdir()
    upload.file(0).whole.rename(upload.folder / "capture" / "cam00.mp4")
    tree = Upload.load(upload.folder).assemble()
    assert sorted(str(p.relative_to(tree)) for p in tree.rglob("*") if p.is_file()) == sorted(FILES)


def test_announcing_again_is_the_same_file_and_new_content_another(upload: Upload) -> None:
    send(upload, "cam00.mp4", b"old" * 100, until=9)
    assert announce(upload, "cam00.mp4", b"old" * 100) == 0
    assert upload.received == 9
    assert announce(upload, "cam00.mp4", b"new" * 100) == 1
    assert upload.received == 0
    with pytest.raises(ProblemError, match="no file 0"):
        upload.file(0)
    send(Upload.load(upload.folder), "cam00.mp4", b"new" * 100)


@pytest.mark.parametrize(
    ("path", "content", "words"),
    [
        ("../x", b"", "'..'"),
        ("CAM00.mp4", b"", "one file or folder"),
        ("big", b"x" * 1001, "one file may have 1.0 kB"),
        ("more", b"x" * 600, "makes 1.1 kB, more than the 505 bytes announced"),
    ],
)
def test_what_was_not_announced_so_is_refused(upload: Upload, path: str, content: bytes, words: str) -> None:
    announce(upload, "cam00.mp4", FILES["cam00.mp4"])
    with pytest.raises(ProblemError, match=words):
        announce(upload, path, content)
    assert len(upload.describe_files()) == 1


def test_no_file_more_than_announced_is_taken(upload: Upload) -> None:
    for path in "abc":
        announce(upload, path, b"")
    with pytest.raises(ProblemError, match="one file more than the 3"):
        announce(upload, "d", b"")
