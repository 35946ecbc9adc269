from __future__ import annotations

from pathlib import Path

import av
import pytest

from hgs_core.base.errors import InputError
from hgs_core.capture.files.unreadable import unreadable
from hgs_core.capture.pictures.video import VideoReader


def test_damage_and_missing_rights_have_cures_of_their_own() -> None:
    damaged = unreadable(Path("a.json"), ValueError("no JSON"), "restore it")
    assert (damaged.problem, damaged.cure) == ("unreadable (no JSON)", "restore it")
    closed = unreadable(Path("a.json"), PermissionError(13, "Permission denied"), "restore it")
    assert (closed.problem, closed.cure) == ("may not be read", "make it readable")


def test_a_video_that_may_not_be_read_is_told_from_a_damaged_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(file: str, **_: object) -> None:
        raise av.PermissionError(13, "Permission denied", file)

    (tmp_path / "a.mp4").touch()
    monkeypatch.setattr(av, "open", refuse)
    with pytest.raises(InputError, match=r"a\.mp4: may not be read; make it readable"):
        VideoReader(tmp_path / "a.mp4")
