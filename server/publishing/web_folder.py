"""A scene as a folder that any web server can serve, with the player's page (docs/static.md)."""

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

_TEMPORARY = re.compile(r"\..+\.[0-9a-f]{12}\.tmp")  # what hgs_core/base/atomic.py leaves when it is killed


def publish_to_folder(
    run: Path, to: Path, *, player: Path | None, replace: bool = False, progress: ProgressCallback = silent
) -> Transfer:
    """Write the scene of a finished run to the folder `to`, which a web server can then serve as it is.

    Every chunk is decoded before it is written, and the manifest comes last, so whoever finds one finds all that it
    names. Called again, after a kill too, it reuses the files that are there and whole. `player` is the folder with
    the built player, None: only the scene's data is written. `replace` allows another scene to take the place of the
    one that is there; that one can be seen until the new manifest is written, and its chunks are removed afterwards.

    Raises:
        InputError: the run has no encoded scene or a damaged one, the player is not built, or `to` holds another
            scene, something else than a scene, or cannot be written. A folder that has no manifest gets none then, and
            a scene that is there stays whole.
    """
    try:
        if to.exists() and not to.is_dir():
            raise InputError(to, "is not a folder", "give a new folder")
        return publish_static(run, _WebFolder(to), player, replace, progress)
    except OSError as error:
        raise InputError(to, f"cannot be written ({error})", "give a folder on a disk with room for it") from error


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
