"""A scene as a folder for any web server, with the player's page (docs/static.md)."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable
from pathlib import Path

from hgs_core.base.atomic import write_bytes
from hgs_core.base.errors import InputError
from hgs_core.base.progress import ProgressCallback, silent
from hgs_core.codec.format.scene_folder import CHUNKS
from server.publishing.static_folder import StaticFile, Transfer, publish_static

__all__ = ["publish_to_folder"]

_TEMPORARY = re.compile(r"\..+\.[0-9a-f]{12}\.tmp")  # remains of hgs_core/base/atomic.py after a kill


def publish_to_folder(
    run: Path, to: Path, *, player: Path | None, replace: bool = False, progress: ProgressCallback = silent
) -> Transfer:
    """Write the scene of a finished run to the folder `to`, ready for any web server.

    Every chunk is decoded before it is written, and the manifest comes last, so a manifest never names a
    missing file. A repeated call, even after a kill, reuses complete files. `player` is the folder with
    the built player, None: only the scene's data is written. `replace` allows another scene to replace the
    present one, which stays visible until the new manifest is written; then its chunks are removed.

    Raises:
        InputError: the run has no encoded scene or a damaged one, the player is not built, or `to` contains another
            scene, foreign files, or cannot be written. A folder without a manifest gets none then, and
            a present scene stays complete.
    """
    try:
        if to.exists() and not to.is_dir():
            raise InputError(to, "is not a folder", "give a new folder")
        return publish_static(run, _WebFolder(to), player, replace, progress)
    except OSError as error:
        raise InputError(to, f"cannot be written ({error})", "give a folder on a disk with enough space") from error


class _WebFolder:
    """A `StaticTarget` on this machine."""

    kind = "folder"
    takes_codings = False

    def __init__(self, path: Path) -> None:
        self._path = path

    def __str__(self) -> str:
        return str(self._path)

    def names(self) -> list[str]:
        if not self._path.exists():
            return []
        return sorted(path.name for path in self._path.iterdir() if not _TEMPORARY.fullmatch(path.name))

    def read(self, name: str) -> bytes:
        return (self._path / name).read_bytes()

    def write(self, files: Iterable[StaticFile]) -> Transfer:
        done = Transfer()
        for file in files:
            path = self._path / file.name
            if path.is_file() and path.stat().st_size == len(file.data) and path.read_bytes() == file.data:
                done += Transfer(kept=1)
            else:
                write_bytes(path, file.data)
                done += Transfer(1, len(file.data))
        return done

    def remove(self, name: str) -> None:
        (self._path / name).unlink(missing_ok=True)

    def remove_other_chunks(self, wanted: Collection[str]) -> None:
        left = [path for path in (self._path / CHUNKS).iterdir() if path.name not in wanted]
        left += [path for path in self._path.iterdir() if _TEMPORARY.fullmatch(path.name)]
        for path in left:
            path.unlink()
