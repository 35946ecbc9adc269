"""Creation of runs by a separate process, which checks the submitted captures.

Results are cached: a capture with the same settings is not opened again until one of its files changes.
"""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hgs_core.base.atomic import write_bytes
from hgs_core.base.errors import InputError
from hgs_core.runs.given_files import GivenFiles
from hgs_core.runs.run_config import RunConfig
from hgs_core.runs.run_folder import RunFolder
from server.captures.capture_readers import CaptureReaders, ReaderEndedError, answered
from server.captures.reading_cache import KEPT_SECONDS, ReadingCache, files_mark

__all__ = ["LimitedCreation"]

_SECONDS = 600  # processor time: every packet of hours of video is read
_WALL_SECONDS = 1800.0
_MOST_KEPT = 200
_LARGEST_KEPT = 1 << 20  # bytes of a run.json


@dataclass(frozen=True)
class _Kept:
    """Result of a check: the run.json of a trainable capture, or the error."""

    config: RunConfig | None = None
    spec: bytes = b""
    refusal: InputError | None = None
    seconds: float = float("inf")  # time to remember it


class LimitedCreation:
    """Creates runs without opening their captures in this process; safe to use from several threads."""

    def __init__(self, readers: CaptureReaders) -> None:
        self._readers = readers
        self._kept = ReadingCache[_Kept](_MOST_KEPT)

    def create_run(self, run: Path, capture: Path, config: RunConfig, given: GivenFiles) -> RunConfig:
        """Check the capture and the config and write `run`/run.json, as the pipeline does.

        Raises:
            InputError: the capture or the config is unusable, or no process can read the capture.
            OSError: the disk is full.
        """
        files = {"capture": str(capture), **given.to_json()}
        asked = {**files, "config": config.to_json()}
        marks = [files_mark(Path(one)) for one in files.values()]
        key = hashlib.sha256(json.dumps([asked, marks], sort_keys=True).encode()).hexdigest()
        kept = self._kept.get(key)
        if kept is None or (kept.config is not None and not kept.spec):
            kept = self._look(run, capture, asked)
            self._kept.keep(key, kept, seconds=kept.seconds)
        elif kept.spec:
            write_bytes(RunFolder(run).spec, kept.spec)
        if kept.config is None:
            raise kept.refusal or InputError(capture, "cannot be read")
        return kept.config

    def _look(self, run: Path, capture: Path, asked: dict[str, Any]) -> _Kept:
        request = {"run": str(run), "seconds": _SECONDS, **asked}
        run.mkdir(parents=True, exist_ok=True)  # the reader may make nothing but files in it
        try:
            (answer,) = self._readers.read("create", request, _WALL_SECONDS)
            found, spec = answered(answer, capture), RunFolder(run).spec
        except ReaderEndedError as error:
            return _Kept(refusal=error.of(capture), seconds=KEPT_SECONDS)
        except InputError as error:
            return _Kept(refusal=error)
        alone = [one.name for one in run.iterdir()] == [spec.name]  # otherwise there are files that are not cached
        kept = alone and spec.stat().st_size <= _LARGEST_KEPT
        return _Kept(RunConfig.from_json(found["config"]), spec.read_bytes() if kept else b"")
