"""A run on disk: where its files are, and the specification it was started with."""

from __future__ import annotations

import dataclasses
import fcntl
import json
import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from hgs_core.base.atomic import write_bytes
from hgs_core.base.errors import InputError
from hgs_core.runs.given_files import GivenFiles
from hgs_core.runs.lease import LeaseHeldError, lease
from hgs_core.runs.run_config import RunConfig

if TYPE_CHECKING:
    from hgs_core.capture.capture import Capture

__all__ = ["RunFolder", "RunSpec"]

LOST = 70  # exit status of a process that has lost its run to another


@dataclass(frozen=True)
class RunSpec:
    """The specification of a run."""

    capture: Path
    fingerprint: str  # fingerprint of the capture at the run's creation
    config: RunConfig
    given: GivenFiles = field(default_factory=GivenFiles)
    without_capture: bool = False  # imported or edited: `capture` is the scene's source, without pictures
    found: Path | None = None  # a folder with cameras and a sync.json, where the capture's own could not be written
    prepared: bool = True  # False: cameras, or when the videos began, are still to be found
    edited: bool = False  # then without a capture

    def open_capture(self, *, cache_bytes: int = 1 << 30, index: Path | None = None) -> Capture:
        """Open the capture as the run sees it: with its masks and at its resolution; `index` as `open_capture` has it.

        Raises:
            InputError: as `hgs_core.capture.open.open_capture`, or the files are not those the run began with, or the
                run was imported without a capture, or edited.
        """
        if self.edited:
            raise InputError(
                self.capture, "was edited, so that no pictures show the scene as it is now", "score that run itself"
            )
        if self.without_capture:
            raise InputError(self.capture, "was imported without a capture", "import it again with --capture")
        if not self.fingerprint:
            raise InputError(self.capture, "the run has not found its cameras yet", "run hgs train to its end first")
        capture = self.open_unchecked(cache_bytes=cache_bytes, index=index)
        self.check_unchanged(capture)
        return capture

    def open_unchecked(self, *, cache_bytes: int = 1 << 30, index: Path | None = None) -> Capture:
        """Open the capture as `open_capture` does, with files that may have changed.

        Raises:
            InputError: as `hgs_core.capture.open.open_capture`.
        """
        from hgs_core.capture.open import open_capture  # the API process knows runs, and opens no capture

        return open_capture(
            self.capture,
            masks=self.given.masks,
            depth=self.given.depth,
            mesh=self.given.mesh,
            downscale=self.config.capture.downscale,
            reductions=self.config.capture.reductions,
            cache_bytes=cache_bytes,
            found=self.found,
            index=index,
        )

    def trusting(self, poses: bool) -> RunSpec:
        """Return the specification with `trust_poses` as given; it lets a run go on and changes no result."""
        return dataclasses.replace(self, config=self.config.changed({"capture.trust_poses": poses}))

    def with_audio(self, audio: str) -> RunSpec:
        """Return the specification with another sound."""
        return dataclasses.replace(self, given=dataclasses.replace(self.given, audio=audio))

    def check_unchanged(self, capture: Capture) -> None:
        """Refuse a capture with other files than those at the run's beginning.

        Raises:
            InputError: the fingerprints differ.
        """
        if capture.fingerprint() != self.fingerprint:
            raise InputError(self.capture, "the capture has changed since the run was created", "start a new run")


class RunFolder:
    """The files of a run (docs/architecture.md, "Folders")."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.spec = path / "run.json"
        self.check = path / "check.json"
        self.need = path / "need.json"  # memory, disk and time that the training needs
        self.found = path / "found"  # cameras and sync.json, where the capture's folder cannot be written
        self.pictures = path / ".pictures"  # decoded ones of a large capture, made anew where they are missing
        self.videos = path / ".videos"  # time stamps of the videos, made anew where they are missing
        self.points = path / "points"  # first points (hgs_core/points/kept_points.py)
        self.near_planes = self.points / "near.json"  # last file of the stage `initialise`
        self.masks = path / "masks"  # automatic ones, a file for each segment
        self.views = path / "views.json"  # cameras and clock of an edited scene
        self.trained = path / "scene.npz"
        self.train_summary = path / "train.json"
        self.scene = path / "scene"
        self.manifest = self.scene / "manifest.json"
        self.thumbnail = self.scene / "thumbnail.jpg"
        self.evaluation = path / "eval.json"
        self.preview = path / "preview.jpg"  # picture of a running training

    def checkpoint(self, segment: int) -> Path:
        """Return where the training state of a segment is kept."""
        return self.path / ("checkpoint.pt" if segment == 0 else f"checkpoint-{segment}.pt")

    def segment(self, number: int) -> Path:
        """Return the folder of a segment that is encoded by itself."""
        return self.path / "segments" / str(number)

    def open_capture(self, spec: RunSpec) -> Capture:
        """Open the capture of a run, with the memory and disk of its config for decoded pictures.

        Raises:
            InputError: as `RunSpec.open_capture`, or the run's folder cannot be read.
        """
        capture = spec.open_capture(cache_bytes=spec.config.capture.cache_bytes, index=self.videos)
        capture.keep_on_disk(self.pictures, spec.config.capture.disk_bytes)
        return capture

    def write_spec(self, spec: RunSpec) -> None:
        """Create the folder and its run.json.

        Raises:
            InputError: the folder holds another run or other files.
        """
        if self.spec.exists():
            there = self.read_spec()
            fingerprint = spec.fingerprint if there.prepared else there.fingerprint
            spec = dataclasses.replace(spec, fingerprint=fingerprint, found=there.found, prepared=there.prepared)
            if there == spec:
                return
            if there.trusting(spec.config.capture.trust_poses) != spec:
                raise InputError(self.path, "holds a run of another capture or config", "choose another --out")
        elif self.path.exists() and (not self.path.is_dir() or any(self.path.iterdir())):
            raise InputError(self.path, "exists and is not a run", "choose a new or empty folder for --out")
        self.replace_spec(spec)

    def replace_spec(self, spec: RunSpec) -> None:
        """Write run.json anew."""
        value: dict[str, Any] = {
            "capture": str(spec.capture),
            "fingerprint": spec.fingerprint,
            "config": spec.config.to_json(),
            **spec.given.to_json(),
        }
        if spec.without_capture:
            value["without_capture"] = True
        if spec.found is not None:
            value["found"] = True
        if not spec.prepared:
            value["prepared"] = False
        if spec.edited:
            value["edited"] = True
        write_bytes(self.spec, json.dumps(value, indent=1).encode())

    @contextmanager
    def exclusive(self, patience: float = 0.0, on_lost: Callable[[], object] | None = None) -> Iterator[None]:
        """Hold the run's file lock and its lease, so that no two processes work on one run.

        The kernel frees the lock when a process dies; the lease (`hgs_core.runs.lease`) also keeps those away whom the
        lock does not reach, on another machine or mount. Waits `patience` seconds for another process to end. Should
        another process take the lease away, after this one was silent for long, `on_lost` is called from a thread; by
        default it ends this process.

        Raises:
            InputError: another process still works on the run.
        """
        deadline = time.monotonic() + patience
        with (self.path / "run.lock").open("w") as lock, ExitStack() as held:
            while True:
                try:
                    fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                    held.enter_context(lease(self.path, lock.fileno(), on_lost or self._end))
                    break
                except (BlockingIOError, LeaseHeldError) as error:
                    if time.monotonic() >= deadline:
                        who = str(error) if isinstance(error, LeaseHeldError) else "another process works on this run"
                        raise InputError(self.path, who, "wait until it ends") from None
                    time.sleep(0.1)
            yield

    def _end(self) -> NoReturn:
        print(f"{self.path}: another process has taken this run over: ending", file=sys.stderr, flush=True)
        os._exit(LOST)

    def read_spec(self) -> RunSpec:
        """Read run.json.

        Raises:
            InputError: there is none, or it is damaged.
        """
        try:
            value: dict[str, Any] = json.loads(self.spec.read_text())
            config = RunConfig.from_json(value["config"])
            given = GivenFiles.from_json(value)
            without = bool(value.get("without_capture", False))
            found = self.found if value.get("found", False) else None
            prepared = bool(value.get("prepared", True))
            edited = bool(value.get("edited", False))
            capture, fingerprint = Path(value["capture"]), str(value["fingerprint"])
            return RunSpec(capture, fingerprint, config, given, without, found, prepared, edited)
        except FileNotFoundError as error:
            raise InputError(self.path, "is not a run: it has no run.json", "make one with hgs train") from error
        except InputError as error:
            raise InputError(f"{self.spec}, {error.where}", error.problem, error.cure) from error
        except (KeyError, TypeError, AttributeError, ValueError, RecursionError) as error:  # no JSON, or another shape
            raise InputError(self.spec, f"unreadable ({error!r})", "start a new run") from error
