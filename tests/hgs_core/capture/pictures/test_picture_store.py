"""The store of decoded pictures: reading as written, its limit, other captures and boots, full disks."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.capture.pictures import picture_store
from hgs_core.capture.pictures.picture_store import PictureStore

HEIGHT, WIDTH = 4, 5
SIZE = HEIGHT * WIDTH * 3


def picture(level: int) -> np.ndarray:
    return np.full((HEIGHT, WIDTH, 3), level, np.uint8)


def filled(folder: Path, count: int, limit: int = 100 * SIZE, fingerprint: str = "a") -> PictureStore:
    store = PictureStore(folder, limit, fingerprint)
    store.make_room(count * SIZE, [(0, frame) for frame in range(count)])
    for frame in range(count):
        store.write(0, frame, picture(frame))
    return store


def test_pictures_are_read_as_written_and_read_only(tmp_path: Path) -> None:
    store = filled(tmp_path / "p", 2)
    found = store.read(0, 1, HEIGHT, WIDTH)
    assert found is not None
    np.testing.assert_array_equal(found, picture(1))
    assert not found.flags.writeable
    assert store.read(0, 2, HEIGHT, WIDTH) is None


def test_another_process_finds_what_was_written(tmp_path: Path) -> None:
    filled(tmp_path / "p", 2)
    again = PictureStore(tmp_path / "p", 100 * SIZE, "a")
    assert (0, 1) in again
    assert again.bytes_held == 2 * SIZE
    assert again.read(0, 1, HEIGHT, WIDTH) is not None


def test_pictures_of_another_capture_are_removed(tmp_path: Path) -> None:
    filled(tmp_path / "p", 2)
    other = PictureStore(tmp_path / "p", 100 * SIZE, "b")
    assert other.read(0, 1, HEIGHT, WIDTH) is None
    other.make_room(SIZE, [])
    assert not list((tmp_path / "p").glob("*/*.rgb"))


def test_pictures_of_another_boot_are_not_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    boot = tmp_path / "boot"
    boot.write_text("one")
    monkeypatch.setattr(picture_store, "_BOOT", boot)
    filled(tmp_path / "p", 1)
    assert (0, 0) in PictureStore(tmp_path / "p", 100 * SIZE, "a")
    boot.write_text("two")
    assert (0, 0) not in PictureStore(tmp_path / "p", 100 * SIZE, "a")


def test_others_than_those_kept_make_room(tmp_path: Path) -> None:
    store = filled(tmp_path / "p", 4, limit=4 * SIZE)
    store.make_room(2 * SIZE, [(0, 0), (0, 1)])
    assert [frame for frame in range(4) if (0, frame) in store] == [0, 1]
    assert sorted(path.name for path in (tmp_path / "p" / "0").iterdir()) == ["0.rgb", "1.rgb"]


def test_a_picture_that_is_gone_or_cut_short_is_not_there(tmp_path: Path) -> None:
    store = filled(tmp_path / "p", 3)
    (tmp_path / "p" / "0" / "0.rgb").unlink()
    (tmp_path / "p" / "0" / "1.rgb").write_bytes(b"short")
    assert [store.read(0, frame, HEIGHT, WIDTH) is None for frame in range(3)] == [True, True, False]
    assert (0, 0) not in store


def test_a_full_disk_is_reported_before_anything_is_written(tmp_path: Path) -> None:
    store = PictureStore(tmp_path / "p", 1 << 60, "a")
    with pytest.raises(InputError, match=r"take [\d.]+ GB, and [\d.]+ GB are free.*picture_disk_gib=\d+"):
        store.make_room(1 << 59, [])


def test_a_picture_that_cannot_be_written_leaves_nothing(tmp_path: Path) -> None:
    store = filled(tmp_path / "p", 1)
    (tmp_path / "p" / "1").write_text("in the way")
    with pytest.raises(InputError, match=r"1\.rgb|p/1"):
        store.write(1, 0, picture(0))
    assert (1, 0) not in store
    assert not list((tmp_path / "p").rglob("*.tmp"))


def test_expected_pictures_may_be_gone(tmp_path: Path) -> None:
    store = filled(tmp_path / "p", 2)
    (tmp_path / "p" / "0" / "0.rgb").unlink()
    store.expect([(0, 0), (0, 1), (5, 5)])
    assert store.read(0, 1, HEIGHT, WIDTH) is not None
