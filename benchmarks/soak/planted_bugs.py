"""Deliberate bugs, planted into the processes of a soak to see that it finds them. The product knows nothing of them.

Python imports `planted/sitecustomize.py` in each process, which loads this file by itself: it imports nothing of ours.
"""

from __future__ import annotations

import dataclasses
import itertools
import os
import secrets
import threading
import time
import zlib
from collections.abc import Callable, Iterator
from enum import StrEnum
from pathlib import Path
from types import ModuleType
from typing import Any

__all__ = ["BUGS", "PLANTED", "Bug"]

PLANTED = Path(__file__).parent / "planted"
"""The folder on the module path that plants them."""

LEAK = 1 << 20  # bytes per minute

_kept: list[bytes] = []


class Bug(StrEnum):
    """The deliberate bugs."""

    LOST_JOB = "lost-job"
    TWO_JOBS = "two-jobs"
    LOST_CANCEL = "lost-cancel"
    STUCK_JOB = "stuck-job"
    TWO_SCENES = "two-scenes"
    EARLY_COLLECTION = "early-collection"
    IMMORTAL_SCENE = "immortal-scene"
    LOST_TITLE = "lost-title"
    SHORT_CAPTURE = "short-capture"
    IMMORTAL_KEY = "immortal-key"
    LEAK = "leak"
    OPEN_FILES = "open-files"


def _lost_job(module: ModuleType) -> None:
    """Answer with every third job, and forget it."""
    submit, count = module.JobClient.submit, itertools.count(1)

    def forgetful(self: Any, request: Any) -> Any:
        job_id = submit(self, request)
        if next(count) % 3 == 0:
            job = self.get(job_id)
            self.cancel(job_id)
            self.delete(job_id)
            self.get = lambda asked, known=self.get: job if asked == job_id else known(asked)
        return job_id

    module.JobClient.submit = forgetful


def _two_jobs(module: ModuleType) -> None:
    """Take every request for a new one."""
    submit = module.JobClient.submit

    def doubling(self: Any, request: Any) -> Any:
        return submit(self, dataclasses.replace(request, key=f"{request.key}-{secrets.token_hex(4)}"))

    module.JobClient.submit = doubling


def _lost_cancel(module: ModuleType) -> None:
    """Say that a job is cancelled, and do nothing."""
    module.JobClient.cancel = lambda self, job_id: dataclasses.replace(
        self.get(job_id), state=module.JobState.CANCELLED
    )


def _stuck_job(module: ModuleType) -> None:
    """Never note the success of about every second job."""
    succeed = module.JobTable.succeed

    def sometimes(self: Any, job_id: str, *rest: Any) -> Any:
        return zlib.crc32(job_id.encode()) % 2 == 0 and succeed(self, job_id, *rest)

    module.JobTable.succeed = sometimes


def _two_scenes(module: ModuleType) -> None:
    """Publish every scene under a second id, too."""
    put = module.ArtifactStore.put_scene

    def twice(self: Any, folder: Path, scene_id: str, *rest: Any) -> None:
        put(self, folder, scene_id, *rest)
        put(self, folder, f"{scene_id}-2", *rest)

    module.ArtifactStore.put_scene = twice


def _early_collection(module: ModuleType) -> None:
    """Overlook the first chunk that a manifest names."""
    named = module._named

    def careless(*arguments: Any) -> Iterator[str]:
        yield from list(named(*arguments))[1:]

    module._named = careless  # type: ignore[attr-defined]


def _immortal_scene(module: ModuleType) -> None:
    """Keep scenes that are to be removed."""
    module.ArtifactStore.remove_scene = lambda self, scene_id: None


def _lost_title(module: ModuleType) -> None:
    """Forget new titles."""
    module.ArtifactStore.rename_scene = lambda self, scene_id, title: None


def _short_capture(module: ModuleType) -> None:
    """Cut the last byte off a file once its digest has been verified."""
    assemble = module.Upload.assemble

    def cut(self: Any) -> Path:
        tree: Path = assemble(self)
        file = max(path for path in tree.rglob("*") if path.is_file())
        os.truncate(file, file.stat().st_size - 1)
        return tree

    module.Upload.assemble = cut


def _immortal_key(module: ModuleType) -> None:
    """Never forget a key that was seen once."""
    refresh = module.Access._refresh

    async def keeping(self: Any, *rest: Any) -> None:
        before = self._keys
        await refresh(self, *rest)
        self._keys = before | self._keys

    module.Access._refresh = keeping


def _leak(module: ModuleType) -> None:
    """Keep a mebibyte more every minute."""

    def leak() -> None:
        while True:
            _kept.append(os.urandom(LEAK // 60))
            time.sleep(1)

    threading.Thread(target=leak, daemon=True).start()


def _open_files(module: ModuleType) -> None:
    """Leave a file open after every tenth request."""
    call, count = module.RequestLog.__call__, itertools.count(1)

    async def leaving(self: Any, *arguments: Any) -> None:
        if next(count) % 10 == 0:
            os.open(__file__, os.O_RDONLY)
        await call(self, *arguments)

    module.RequestLog.__call__ = leaving


BUGS: dict[str, tuple[str, Callable[[ModuleType], None]]] = {
    Bug.LOST_JOB: ("jobs.queue.client", _lost_job),
    Bug.TWO_JOBS: ("jobs.queue.client", _two_jobs),
    Bug.LOST_CANCEL: ("jobs.queue.client", _lost_cancel),
    Bug.STUCK_JOB: ("jobs.records.job_table", _stuck_job),
    Bug.TWO_SCENES: ("jobs.artifacts.artifact_store", _two_scenes),
    Bug.EARLY_COLLECTION: ("jobs.artifacts.chunk_collection", _early_collection),
    Bug.IMMORTAL_SCENE: ("jobs.artifacts.artifact_store", _immortal_scene),
    Bug.LOST_TITLE: ("jobs.artifacts.artifact_store", _lost_title),
    Bug.SHORT_CAPTURE: ("server.uploads.upload", _short_capture),
    Bug.IMMORTAL_KEY: ("server.access.visitors", _immortal_key),
    Bug.LEAK: ("server.app", _leak),
    Bug.OPEN_FILES: ("server.http.request_log", _open_files),
}
"""The module that each is planted in, and the change."""
