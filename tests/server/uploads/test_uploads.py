from __future__ import annotations

import contextlib
import dataclasses
import hashlib
import os
import shutil
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from server.http.problems import ProblemError
from server.uploads.upload import Announcement, Upload
from server.uploads.upload_limits import UploadLimits
from server.uploads.uploads import Uploads

CONTENT = b"a video" * 50
STUDIO = Announcement("studio", 1, len(CONTENT), "key")
LIMITS = UploadLimits(quota=1000, upload=900, free=0, open=3)


@pytest.fixture
def open_uploads(tmp_path: Path) -> Iterator[Callable[..., Uploads]]:
    """Return a function that opens the uploads as a server does when it starts; the one before is gone then."""
    opened: list[Uploads] = []

    def start(**limits: Any) -> Uploads:
        for one in opened:
            one.close()
        opened.append(Uploads(tmp_path / "uploads", dataclasses.replace(LIMITS, **limits)))
        return opened[-1]

    yield start
    for one in opened:
        one.close()


def send(upload: Upload, content: bytes = CONTENT) -> None:
    file = upload.add("cam00.mp4", len(content), hashlib.sha256(content).hexdigest(), LIMITS)
    file.append(file.begin(0), content)


def finished(uploads: Uploads, announced: Announcement = STUDIO) -> Upload:
    upload, _ = uploads.begin(announced)
    send(upload)
    uploads.finish(upload)
    return upload


def test_a_finished_upload_is_a_capture_and_nothing_else_is(open_uploads: Callable[..., Uploads]) -> None:
    uploads = open_uploads()
    upload, new = uploads.begin(STUDIO)
    assert new
    send(upload)
    assert not uploads.captures.exists()
    for _ in range(2):
        uploads.finish(upload)
    assert (uploads.captures / "studio" / "cam00.mp4").read_bytes() == CONTENT
    assert sorted(path.name for path in upload.folder.iterdir()) == ["files.jsonl", "upload.json"]
    (file,) = upload.describe_files()
    assert (file["path"], file["sha256"], file["verified"]) == ("cam00.mp4", hashlib.sha256(CONTENT).hexdigest(), True)
    told = uploads.describe(upload)
    assert (told["state"], told["capture"], told["expires"]) == ("finished", str(uploads.captures / "studio"), None)


def test_the_same_announcement_goes_on_and_another_key_begins_anew(open_uploads: Callable[..., Uploads]) -> None:
    first, _ = open_uploads().begin(STUDIO)
    uploads = open_uploads()
    assert (uploads.begin(STUDIO)[0].id, uploads.begin(STUDIO)[1]) == (first.id, False)
    other, new = uploads.begin(dataclasses.replace(STUDIO, key="other"))
    assert new
    assert other.id != first.id


def test_captures_of_one_name_are_told_apart(open_uploads: Callable[..., Uploads]) -> None:
    uploads = open_uploads()
    names = [finished(uploads, dataclasses.replace(STUDIO, name=name)).capture for name in ("studio", "STUDIO")]
    assert names == ["studio", "STUDIO 2"]


@pytest.mark.parametrize("moved", [False, True])
def test_a_server_killed_at_the_last_step_has_a_capture_afterwards(
    open_uploads: Callable[..., Uploads], moved: bool
) -> None:
    uploads = open_uploads()
    upload, _ = uploads.begin(STUDIO)
    send(upload)
    tree = upload.assemble()
    upload.finish("studio")
    if moved:
        uploads.captures.mkdir()
        tree.rename(uploads.captures / "studio")
    again = open_uploads()
    assert again.describe(again.get(upload.id))["state"] == "finished"
    assert (again.captures / "studio" / "cam00.mp4").read_bytes() == CONTENT


@pytest.mark.parametrize(
    ("announced", "limits", "status", "words"),
    [
        (Announcement("x", 1, 901, ""), {}, 413, "one upload may have 900 bytes"),
        (
            Announcement("x", 1, 700, ""),
            {},
            507,
            "may take 1.0 kB in total (--uploads quota), of which 650 bytes",
        ),
        (Announcement("x", 1, 1, ""), {"open": 1}, 503, "1 uploads are unfinished (--uploads open)"),
        (Announcement("x", 1, 1, ""), {"free": 2**60}, 507, "room for 0 bytes more"),
    ],
)
def test_what_would_be_too_much_together_is_refused(
    open_uploads: Callable[..., Uploads], announced: Announcement, limits: dict[str, Any], status: int, words: str
) -> None:
    open_uploads().begin(STUDIO)
    uploads = open_uploads(**limits)
    with pytest.raises(ProblemError) as caught:
        uploads.begin(announced)
    assert caught.value.status == status
    assert words in caught.value.detail
    assert len(uploads.all()) == 1


def test_one_client_may_have_less_than_all_together(open_uploads: Callable[..., Uploads]) -> None:
    uploads = open_uploads(share=400)
    uploads.begin(STUDIO, "key 1")
    with pytest.raises(
        ProblemError, match=r"400 bytes in total \(--uploads share\), of which 50 bytes are left"
    ) as caught:
        uploads.begin(Announcement("x", 1, 100, ""), "key 1")
    assert caught.value.status == 507
    uploads.begin(Announcement("x", 1, 100, ""), "key 2")


def test_bytes_are_refused_while_the_disk_is_full(open_uploads: Callable[..., Uploads]) -> None:
    open_uploads().begin(STUDIO)
    with pytest.raises(ProblemError, match="received data is kept"):
        open_uploads(free=2**60).require_room()


def test_finished_captures_count_until_they_are_deleted(open_uploads: Callable[..., Uploads]) -> None:
    uploads = open_uploads(quota=400)
    upload = finished(uploads)
    with pytest.raises(ProblemError, match="50 bytes are left"):
        uploads.begin(STUDIO)
    uploads.delete(upload)
    assert list(uploads.captures.iterdir()) == []
    assert not upload.folder.exists()
    assert uploads.begin(STUDIO)[1]


def test_nobody_waits_for_an_upload_that_was_abandoned(open_uploads: Callable[..., Uploads]) -> None:
    uploads = open_uploads(hours=1.0)
    lost, _ = uploads.begin(STUDIO)
    live, _ = uploads.begin(dataclasses.replace(STUDIO, key="live"))
    for upload, hours in ((lost, 1.1), (live, 0.9)):
        before = time.time() - 3600 * hours
        os.utime(upload.folder / "upload.json", (before, before))
    uploads = open_uploads(hours=1.0)
    assert [one.id for one in uploads.all()] == [live.id]
    assert not lost.folder.exists()


def test_finished_captures_do_not_expire_and_vanish_with_their_folder(open_uploads: Callable[..., Uploads]) -> None:
    upload = finished(open_uploads())
    os.utime(upload.folder / "upload.json", (0, 0))
    uploads = open_uploads()
    assert [one.id for one in uploads.all()] == [upload.id]
    shutil.rmtree(uploads.captures / "studio")
    assert uploads.all() == []


def test_what_is_damaged_or_half_deleted_is_cleared_away(
    open_uploads: Callable[..., Uploads], caplog: pytest.LogCaptureFixture
) -> None:
    uploads = open_uploads()
    upload, _ = uploads.begin(STUDIO)
    (upload.folder / "upload.json").write_text("{")
    (uploads.folder / ".deleted-1" / "data").mkdir(parents=True)
    assert open_uploads().all() == []
    assert upload.id in caplog.text
    assert [path.name for path in uploads.folder.iterdir()] == ["lock"]


def test_one_process_at_a_time_looks_after_the_uploads(open_uploads: Callable[..., Uploads], tmp_path: Path) -> None:
    open_uploads().begin(STUDIO)
    other = Uploads(tmp_path / "uploads", LIMITS)
    with pytest.raises(ProblemError, match="another server process") as caught:
        other.begin(STUDIO)
    assert caught.value.status == 503


def test_finishing_sweeping_and_deleting_at_once_do_not_wait_for_each_other_for_ever(
    open_uploads: Callable[..., Uploads],
) -> None:
    uploads = open_uploads(quota=10**6, open=100, hours=1e-9)
    made = [uploads.begin(dataclasses.replace(STUDIO, key="0"))[0]]
    send(made[0])

    def finish() -> None:
        with contextlib.suppress(ProblemError, OSError):  # it was swept away before
            uploads.finish(made[0])

    threads = [threading.Thread(target=target, daemon=True) for target in (finish, uploads.sweep, uploads.all) * 5]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60)
    assert not any(thread.is_alive() for thread in threads)


class Everywhere:
    """Where other machines find captures; one of them has already put one there that is called studio."""

    def __init__(self) -> None:
        self.names: list[str] = []

    def put(self, name: str, folder: Path) -> bool:
        assert (folder / "cam00.mp4").read_bytes() == CONTENT
        if name != "studio":
            self.names.append(name)
        return name != "studio"

    def remove(self, name: str) -> None:
        self.names.remove(name)


def test_where_machines_share_no_folder_a_capture_is_in_the_store_first(tmp_path: Path) -> None:
    everywhere = Everywhere()
    uploads = Uploads(tmp_path / "uploads", LIMITS, everywhere)  # type: ignore[arg-type]
    upload = finished(uploads)
    assert upload.capture == "studio 2"
    assert everywhere.names == ["studio 2"]
    uploads.delete(upload)
    assert everywhere.names == []
    uploads.close()


def test_one_client_cannot_hold_them_all(open_uploads: Callable[..., Uploads]) -> None:
    uploads = open_uploads(open=4, client=2, quota=10**6)
    first, _ = uploads.begin(dataclasses.replace(STUDIO, key="0"), "anna")
    uploads.begin(dataclasses.replace(STUDIO, key="1"), "anna")
    uploads = open_uploads(open=4, client=2, quota=10**6)  # the server was started again
    with pytest.raises(ProblemError, match=r"the limit is 2 .* finish or delete one") as refused:
        uploads.begin(dataclasses.replace(STUDIO, key="2"), "anna")
    assert (refused.value.status, refused.value.headers) == (429, {"Retry-After": "60"})
    assert uploads.begin(dataclasses.replace(STUDIO, key="1"), "anna")[1] is False  # going on is no new one
    assert uploads.begin(dataclasses.replace(STUDIO, key="2"), "bert")[1]
    uploads.delete(uploads.get(first.id))
    assert uploads.begin(dataclasses.replace(STUDIO, key="3"), "anna")[1]
