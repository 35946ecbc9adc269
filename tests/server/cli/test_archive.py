from __future__ import annotations

import io
import stat
import tarfile
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest
import zstandard

from hgs_core.base.errors import InputError
from server.cli.archive import ARCHIVES, unpack
from server.uploads.upload_limits import UploadLimits

FILES = {"studio/cam00.mp4": b"a video" * 1000, "studio/sparse/0/cameras.txt": b"poses", "./studio/.hidden": b"x"}
LIMITS = UploadLimits(files=5, file=50_000, upload=80_000)


def write(archive: Path, files: dict[str, bytes]) -> Path:
    if archive.name.endswith(".zip"):
        with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as opened:
            for name, content in files.items():
                opened.writestr(name, content)
        return archive
    packed = io.BytesIO()
    with tarfile.open(fileobj=packed, mode="w:gz" if archive.name.endswith("gz") else "w") as tar:
        for name, content in files.items():
            member = tarfile.TarInfo(name)
            member.size = len(content)
            tar.addfile(member, io.BytesIO(content))
    data = packed.getvalue()
    archive.write_bytes(zstandard.compress(data) if archive.name.endswith(".zst") else data)
    return archive


@pytest.fixture
def out(tmp_path: Path) -> Path:
    folder = tmp_path / "out"
    folder.mkdir()
    return folder


@pytest.mark.parametrize("ending", ARCHIVES)
def test_files_come_out_but_for_hidden_ones(tmp_path: Path, out: Path, ending: str) -> None:
    unpack(write(tmp_path / f"a{ending}", FILES), out, LIMITS)
    found = {str(path.relative_to(out)): path.read_bytes() for path in out.rglob("*") if path.is_file()}
    assert found == {name: content for name, content in FILES.items() if "hidden" not in name}


@pytest.mark.parametrize("ending", [".zip", ".tar.gz"])
@pytest.mark.parametrize(
    ("files", "words"),
    [
        ({"../x": b""}, "'..'"),
        ({"a/../../x": b""}, "'..'"),
        ({"/etc/x": b""}, "absolute"),
        ({"a": b"", "A": b""}, "one file or folder"),
        ({"con": b""}, "device"),
        ({"a\\b": b""}, "backslash"),
        ({"bomb": bytes(50_001)}, "one file may have 50.0 kB"),
        ({"a": bytes(41_000), "b": bytes(41_000)}, "one upload may have 80.0 kB"),
        ({str(number): b"" for number in range(6)}, "one upload may have 5"),
    ],
)
def test_what_no_upload_may_have_is_refused(
    tmp_path: Path, out: Path, files: dict[str, bytes], words: str, ending: str
) -> None:
    with pytest.raises(InputError, match=words):
        unpack(write(tmp_path / f"a{ending}", files), out, LIMITS)
    assert not (tmp_path / "x").exists()
    assert sum(path.stat().st_size for path in out.rglob("*") if path.is_file()) <= LIMITS.upload


def test_links_and_devices_are_refused(tmp_path: Path, out: Path) -> None:
    for kind, mode in (
        (tarfile.SYMTYPE, stat.S_IFLNK),
        (tarfile.LNKTYPE, stat.S_IFLNK),
        (tarfile.CHRTYPE, stat.S_IFCHR),
    ):
        with tarfile.open(tmp_path / "a.tar", "w") as tar:
            member = tarfile.TarInfo("cam00.mp4")
            member.type, member.linkname = kind, "/etc/passwd"
            tar.addfile(member)
        entry = zipfile.ZipInfo("cam00.mp4")
        entry.external_attr = (mode | 0o777) << 16
        with zipfile.ZipFile(tmp_path / "a.zip", "w") as opened:
            opened.writestr(entry, "/etc/passwd")
        for archive in ("a.tar", "a.zip"):
            with pytest.raises(InputError, match=r"'cam00\.mp4' is a link or a device"):
                unpack(tmp_path / archive, out, LIMITS)
    assert list(out.iterdir()) == []


def _cut(data: bytes) -> bytes:
    return data[: len(data) // 3]


def _garbage(data: bytes) -> bytes:
    return b"no archive at all" * 100


@pytest.mark.parametrize("ending", ARCHIVES)
@pytest.mark.parametrize("damage", [_cut, _garbage])
def test_damaged_archives_are_refused(tmp_path: Path, out: Path, ending: str, damage: Callable[[bytes], bytes]) -> None:
    archive = write(tmp_path / f"a{ending}", FILES)
    archive.write_bytes(damage(archive.read_bytes()))
    with pytest.raises(InputError, match=f"a{ending}: cannot be unpacked .*; make the archive again"):
        unpack(archive, out, LIMITS)
