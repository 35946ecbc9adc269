"""Captures that were uploaded, for machines that share no folder: the store has them, and workers keep copies.

```
captures/<name>/head.json             the files of a capture; it never changes
captures/<name>/0/<sha256>            the content of a file
<home>/uploads/captures/<name>/       on the machine that took the upload
<home>/fetched/<name>/                the copy of another
```

A run names such a capture as `upload:<name>`, which each machine reads as the place where it has it.
"""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
import shutil
from collections.abc import Iterator
from pathlib import Path, PurePosixPath

from hgs_core.base.errors import InputError
from hgs_core.runs.asked_edit import source_of_edit
from jobs.home.home import Home
from jobs.home.object_store import open_object_store
from jobs.runs.capture_places import Translation
from jobs.runs.retention import folder_bytes
from jobs.runs.run_transfer import bring
from jobs.runs.stored_run import RunHead, RunTakenError, StoredFile, StoredRun

__all__ = ["StoredCaptures", "capture_of", "is_upload"]

_SCHEME = "upload:"


def is_upload(capture: str) -> bool:
    """Return whether a run names its capture as one that was uploaded."""
    return capture.startswith(_SCHEME)


def capture_of(run: Path) -> Path | None:
    """Return where this machine has the capture of a run folder; None where run.json does not tell, or is not there.

    A run that edits a scene has its copy in its own folder.
    """
    try:
        spec = json.loads((run / "run.json").read_text())
        capture = Path(spec["capture"])
        return source_of_edit(run, capture.name) if spec.get("edited") else capture
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None


class StoredCaptures:
    """The uploaded captures of an installation, as one machine sees them. Every method may block for long."""

    def __init__(self, home: Home) -> None:
        self._store = open_object_store(home.store_url)
        self._uploaded = home.folder / "uploads" / "captures"
        self._fetched = home.folder / "fetched"
        self._most = home.capture_cache

    def put(self, name: str, folder: Path) -> bool:
        """Bring the files of a capture to the store; False if another capture has this name. Doing it again is fine."""
        stored = self._capture(name)
        there = stored.head()
        known = {} if there is None else there.files
        files: dict[str, StoredFile] = {}
        for path in sorted(path for path in folder.rglob("*") if path.is_file()):
            relative = path.relative_to(folder).as_posix()
            with path.open("rb") as file:
                if there is None:
                    files[relative] = stored.put_file(0, file)
                elif relative not in known or not stored.is_content(known[relative], file):
                    return False
        if there is not None:
            return True
        try:
            stored.create(RunHead(0, files, complete=True))
        except RunTakenError:
            return self.put(name, folder)
        return True

    def remove(self, name: str) -> None:
        """Remove a capture from the store; copies on machines are removed when their room is needed."""
        self._capture(name).remove()

    def portable(self, path: str) -> str:
        """Return how runs name the capture at a path of this machine; a path of no upload stays as it is."""
        for place in (self._uploaded, self._fetched):
            if Path(path).is_relative_to(place) and Path(path) != place:
                return _SCHEME + Path(path).relative_to(place).as_posix()
        return path

    def local(self, path: str) -> str:
        """Return the path that a run's capture has on this machine."""
        if not is_upload(path):
            return path
        inside = PurePosixPath(path.removeprefix(_SCHEME))
        if inside.is_absolute() or ".." in inside.parts or not inside.parts:
            raise InputError("run.json", f"names the capture {path!r}", "delete the job and submit it again")
        here = (self._uploaded / inside.parts[0]).is_dir()
        return str((self._uploaded if here else self._fetched) / inside)

    def translation(self) -> Translation:
        """Return the translation of run.json from one machine to another."""
        return Translation(self.portable, self.local)

    @contextlib.contextmanager
    def held(self, path: Path) -> Iterator[None]:
        """Have the capture at a path that `local` returned on this machine, fetched if need be, while the block runs.

        Raises:
            InputError: the capture was deleted, or is damaged in the store.
            OSError: the disk is full.
        """
        if not path.is_relative_to(self._fetched):
            yield
            return
        name = path.relative_to(self._fetched).parts[0]
        self._fetched.mkdir(parents=True, exist_ok=True)
        with (self._fetched / f".{name}.lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            if not (self._fetched / name).is_dir():
                self._fetch(name)
            os.utime(self._fetched / name)
            fcntl.flock(lock, fcntl.LOCK_SH)  # keeps it from being removed
            yield

    def _fetch(self, name: str) -> None:
        stored = self._capture(name)
        head = stored.head()
        if head is None:
            raise InputError("capture", f"the upload {name!r} was deleted", "send it again, and submit another job")
        self._make_room(sum(file.size for file in head.files.values()))
        part = self._fetched / f".{name}.part"
        part.mkdir(exist_ok=True)
        missing = {path: file for path, file in head.files.items() if not (part / path).is_file()}  # whole or not there
        bring(stored, missing, part)
        part.rename(self._fetched / name)

    def _make_room(self, size: int) -> None:
        """Remove copies that no worker of this machine uses, those first that were not used for the longest time."""
        copies = [path for path in self._fetched.iterdir() if path.is_dir() and not path.name.startswith(".")]
        sizes = {path: folder_bytes(path) for path in copies}
        for path in sorted(copies, key=lambda path: path.stat().st_mtime):
            if size + sum(sizes.values()) <= self._most:
                return
            with (self._fetched / f".{path.name}.lock").open("w") as lock:
                try:
                    fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                except BlockingIOError:
                    continue
                shutil.rmtree(path)
                del sizes[path]

    def _capture(self, name: str) -> StoredRun:
        return StoredRun(self._store, f"captures/{name}")
