"""The state of a run between a run folder of this machine and the object store, for machines that share no disk.

A worker first claims the run, which shuts out whoever had it before, then fetches what its own folder lacks, and from
then on saves what has changed. What the folder holds of the same epoch is as new as the store or newer, and stays.
"""

from __future__ import annotations

import contextlib
import os
import re
import stat
import threading
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

from hgs_core.base.atomic import write_bytes
from hgs_core.base.errors import InputError
from jobs.runs.capture_places import SPEC, Translation
from jobs.runs.progress_log import COURSE
from jobs.runs.stored_run import RunHead, RunTakenError, StoredFile, StoredRun

__all__ = ["QUIET", "RunState", "bring", "files_of_run", "run_prefix"]

QUIET = frozenset({"stage.log", COURSE, "preview.jpg"})
"""Files of a run folder that nothing goes on from: they are saved with the others, and else now and then."""

_LOCKS = re.compile(r"run\.lock|run\.lease\..*|segments/[^/]*\.lock")
_THREADS = 8  # files moved at once
_TRIES = 20  # tries of an operation that another process may spoil

Stamp = tuple[int, int]  # a file's modification time, nanoseconds, and its bytes


def run_prefix(job_id: str) -> str:
    """Return where the state of a job's run lies in the store."""
    return f"runs/{job_id}"


class RunState:
    """One run folder and its counterpart in the store. Safe to use from several threads; every method blocks."""

    def __init__(
        self,
        stored: StoredRun,
        folder: Path,
        epoch: int,
        *,
        wanted: Callable[[str], bool] = lambda name: True,
        translate: Translation | None = None,
        mark: str = ".epoch",
    ) -> None:
        """Have nothing to do with files that are not `wanted`, by their path below the folder.

        The file `mark` in the folder tells under which epoch this machine had the run last.
        """
        self._mark = mark
        self._stored = stored
        self._folder = folder
        self._epoch = epoch
        self._wanted = wanted
        self._translate = translate
        self._head: RunHead | None = None  # ours, the last one that was put
        self._saved: dict[str, Stamp] = {}  # stamps of the head's files on this machine
        self._turn = threading.Lock()

    @property
    def claimed(self) -> bool:
        """Whether `claim` has come to its end."""
        return self._head is not None

    def create(self) -> None:
        """Put the folder there as the state of a new run.

        Raises:
            RunTakenError: there is such a run.
        """
        with self._turn:
            files, stamps = self._put_changed({}, self._look())
            self._head = self._stored.create(RunHead(self._epoch, files))
            self._saved = stamps

    def claim(self) -> None:
        """Become the only saver, then bring the folder to the state in the store.

        Raises:
            RunTakenError: a later epoch has the run.
            InputError: there is no such run, or an object is damaged.
        """
        with self._turn:
            self._go_on(*self._take())

    def go_on(self, head: RunHead, before: RunHead) -> None:
        """Go on under `head`, which the caller has put in the place of `before`, as `claim` does."""
        with self._turn:
            self._go_on(head, before)

    def _go_on(self, head: RunHead, before: RunHead) -> None:
        self._folder.mkdir(parents=True, exist_ok=True)
        if self._own_epoch() == before.epoch:  # nobody else has saved since: what lies here follows from it
            self._saved = {}
        else:
            self._fetch(head)
        write_bytes(self._folder / self._mark, str(head.epoch).encode())
        self._head = head
        self._stored.remove_superseded(head)

    def save(self, *, complete: bool = False, free: bool = False, always: bool = False) -> None:
        """Put the changed files and a head that names them; with `always` a head even without changes.

        Raises:
            RunTakenError: another process has the run; nothing was saved.
            OSError: a file cannot be read.
        """
        with self._turn:
            before = self._head
            if before is None:
                raise ValueError("claim the run first")
            files, stamps = self._put_changed(before.files, self._look())
            after = replace(before, files=files, complete=complete, free=free)
            if always or after != before:
                self._head = self._stored.replace(before, after)
                kept = {file.name for file in files.values()}
                self._stored.remove_files([file for file in before.files.values() if file.name not in kept])
            self._saved = stamps

    def look(self) -> tuple[frozenset[str], frozenset[str]]:
        """Return the names of all files, and of those that are not saved as they are now, gone ones included."""
        looked = self._look()
        names = looked.keys() | self._saved.keys()
        return frozenset(looked), frozenset(name for name in names if looked.get(name) != self._saved.get(name))

    def _take(self) -> tuple[RunHead, RunHead]:
        """Return the head that was put, and the one before."""
        for _ in range(_TRIES):
            before = self._stored.head()
            if before is None:
                raise InputError(self._stored.prefix, "is not in the store", "delete the job and submit it again")
            if before.epoch > self._epoch:
                raise RunTakenError(f"{self._stored.prefix}: epoch {before.epoch} has this run, not {self._epoch}")
            with contextlib.suppress(RunTakenError):  # a saver of an earlier epoch came in between
                return self._stored.replace(before, RunHead(self._epoch, before.files)), before
        raise RunTakenError(f"{self._stored.prefix}: others change it without a pause")

    def _own_epoch(self) -> int | None:
        try:
            return int((self._folder / self._mark).read_text())
        except (FileNotFoundError, ValueError):
            return None

    def _fetch(self, head: RunHead) -> None:
        (self._folder / self._mark).unlink(missing_ok=True)  # no epoch while the folder is incomplete
        for name in self._look().keys() - head.files.keys():
            (self._folder / name).unlink(missing_ok=True)
        try:
            bring(self._stored, head.files, self._folder, self._translate)
        except FileNotFoundError as error:  # no fault of the store, which would be waited for
            where = f"the store's {self._stored.prefix}"
            raise InputError(where, f"lacks what its head names ({error})", "submit the job again") from None
        for left in self._folder.glob(".*.part"):  # interrupted downloads of superseded files
            left.unlink()
        self._saved = self._look()

    def _put_changed(
        self, known: Mapping[str, StoredFile], looked: Mapping[str, Stamp]
    ) -> tuple[dict[str, StoredFile], dict[str, Stamp]]:
        """Put the files that are not as they were, and return all with their stamps; one that vanishes is left out."""
        files = {name: known[name] for name in looked if name in known and self._saved.get(name) == looked[name]}

        def put(name: str) -> StoredFile | None:
            path = self._folder / name
            with contextlib.suppress(FileNotFoundError):
                if name == SPEC and self._translate is not None:
                    spec = self._translate.portable(path.read_bytes())
                    return self._stored.put_bytes(self._epoch, spec, known.get(name))
                with path.open("rb") as file:
                    return self._stored.put_file(self._epoch, file, known.get(name), growing=name in QUIET)
            return None

        new = [name for name in looked if name not in files]
        with ThreadPoolExecutor(_THREADS) as pool:
            for name, stored in zip(new, pool.map(put, new), strict=True):
                if stored is not None:
                    files[name] = stored
        return files, {name: looked[name] for name in files}

    def _look(self) -> dict[str, Stamp]:
        return {name: stamp for name, stamp in files_of_run(self._folder) if self._wanted(name)}


def bring(
    stored: StoredRun, files: Mapping[str, StoredFile], folder: Path, translate: Translation | None = None
) -> None:
    """Write files into a folder, made if need be, each whole or not at all; a download that was cut off goes on."""
    folder.mkdir(parents=True, exist_ok=True)

    def one(item: tuple[str, StoredFile]) -> None:
        name, file = item
        target, part = folder / name, folder / f".{file.sha256}.part"
        if name == SPEC and translate is not None:
            write_bytes(target, translate.local(stored.read(file)))
            return
        stored.fetch(file, part)
        with part.open("rb") as whole:
            os.fsync(whole.fileno())
        target.parent.mkdir(parents=True, exist_ok=True)
        part.replace(target)

    unique: dict[str, list[str]] = {}
    for name, file in files.items():
        unique.setdefault(file.sha256, []).append(name)
    first = {names[0]: files[names[0]] for names in unique.values()}
    with ThreadPoolExecutor(_THREADS) as pool:
        list(pool.map(one, first.items()))
    for names in unique.values():  # the same content under several names
        for name in names[1:]:
            one((name, files[name]))


def files_of_run(folder: Path) -> Iterator[tuple[str, Stamp]]:
    """Yield the state files of a run folder, by path below it: neither locks, decoded pictures nor files being written.

    A folder comes before what lies in it, so that whoever finds a manifest finds the chunks it names, too.
    """
    for root, folders, names in os.walk(folder):
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        for name in sorted(names):
            path = Path(root, name)
            relative = path.relative_to(folder).as_posix()
            if name.startswith(".") or name.endswith(".tmp") or _LOCKS.fullmatch(relative):
                continue
            with contextlib.suppress(FileNotFoundError):
                found = path.lstat()
                if stat.S_ISREG(found.st_mode):
                    yield relative, (found.st_mtime_ns, found.st_size)
