from __future__ import annotations

from pathlib import Path

import obstore

from jobs.object_store import is_folder, open_object_store


def test_a_folder_is_made(tmp_path: Path) -> None:
    url = (tmp_path / "deep" / "store").as_uri()
    assert is_folder(url)
    obstore.put(open_object_store(url), "a", b"1")
    assert (tmp_path / "deep" / "store" / "a").read_bytes() == b"1"


def test_a_bucket_is_no_folder() -> None:
    assert not is_folder("s3://bucket/prefix")
