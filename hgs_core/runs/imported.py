"""A file of splats as a run: `hgs import` makes it, for encode, eval and publish."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hgs_core.base.atomic import write_bytes
from hgs_core.base.errors import InputError
from hgs_core.base.progress import ProgressCallback
from hgs_core.capture.open import open_capture
from hgs_core.codec import load_manifest
from hgs_core.interchange.antialiasing_note import UNTOLD
from hgs_core.interchange.changes import Action, Change, nonzero
from hgs_core.interchange.import_scene import USUAL_DURATION, USUAL_FRAME_RATE, Imported, import_scene
from hgs_core.interchange.ply.ply_sequence import frame_files
from hgs_core.interchange.sog_writer import META
from hgs_core.points.near_plane import save_near_planes, with_near_planes
from hgs_core.runs.creation import create_run
from hgs_core.runs.encoding import encode
from hgs_core.runs.photographed_errors import photographed_errors
from hgs_core.runs.run_config import RunConfig
from hgs_core.runs.run_folder import RunFolder, RunSpec
from hgs_core.scene.files import save_scene

__all__ = ["ImportedRun", "import_run"]

CLEARLY = 0.3  # dB by which pictures must be nearer, as files that say nothing are mostly not drawn antialiased


@dataclass(frozen=True)
class ImportedRun:
    """The result of an import."""

    splats: int  # splats of the file
    kept: int  # splats of the encoded scene
    changes: tuple[Change, ...]  # losses of reading and encoding

    def to_json(self) -> dict[str, Any]:
        """Return the plain form."""
        return {"splats": self.splats, "kept": self.kept, "changes": [change.to_json() for change in self.changes]}


def import_run(
    file: Path,
    run: Path,
    progress: ProgressCallback,
    *,
    duration: float | None = None,
    frame_rate: float | None = None,
    capture: Path | None,
    config: RunConfig,
    antialiased: bool | None = None,
    activated: bool | None = None,
) -> ImportedRun:
    """Make a run folder of a file of splats and encode it; return the omissions and changes.

    `duration` is how long a 4D file lasts, seconds; `frame_rate` how many files of a folder a second has. With a
    `capture`, the pictures the splats were made of, the loss of encoding is measured on its cameras that `config` does
    not hold out, and the run can be evaluated; without, views are made up around the splats. `antialiased` says whether
    the splats are to be drawn so, `activated` whether scales and opacities stand in the file as they are drawn; None:
    the file tells, and of the first the capture's pictures, if there are any.

    Raises:
        InputError: the file, the capture or the config are unusable, `run` holds something else, or no splat is left.
            A folder that was not there before is gone then.
    """
    if duration is None:
        duration = USUAL_DURATION
    elif not duration > 0 or file.is_dir():
        problem = "is not for a folder of frames" if file.is_dir() else f"{duration} is not positive"
        raise InputError(
            "--duration", problem, "give --fps" if file.is_dir() else "give the seconds that the scene lasts"
        )
    if frame_rate is None:
        frame_rate = USUAL_FRAME_RATE
    elif not frame_rate > 0 or not file.is_dir():
        problem = f"{frame_rate} is not positive" if file.is_dir() else "is for a folder of frames"
        raise InputError("--fps", problem, "give frames for each second" if file.is_dir() else "give --duration")
    imported = import_scene(
        file, duration, frame_rate, antialiased=antialiased, activated=activated, centred=capture is None
    )
    fresh = not run.exists()
    if capture is None:
        if config.capture.hold_out:
            raise InputError("--hold-out", "needs the capture's cameras", "name the capture with --capture")
        config = config.changed({"train.antialiased": imported.scene.antialiased})
        fingerprint = _fingerprint(file)
        RunFolder(run).write_spec(RunSpec(file.resolve(), fingerprint, config, without_capture=True))
    else:
        if imported.antialiased is None:
            imported = _as_photographed(imported, capture, config)
        config = config.changed({"train.antialiased": imported.scene.antialiased})
        create_run(run, capture, config)
    folder = RunFolder(run)
    with folder.exclusive():
        try:
            if not folder.train_summary.exists():
                _write(folder, file, imported)
            encode(run, progress)
            totals = load_manifest(folder.scene).totals
            kept = totals.splats_static + totals.splats_dynamic
            if kept == 0:
                raise InputError(file, f"holds {imported.splats:,} splats, none of which shows in any picture")
        except BaseException:  # a folder without a scene is of no use: reading the file again costs little
            if fresh:
                shutil.rmtree(run, ignore_errors=True)
            raise
    encoded = len(imported.scene.static) + imported.scene.dynamic_splats
    missed = Change(Action.LEFT_OUT, "splats", encoded - kept, encoded, "no picture misses them")
    return ImportedRun(imported.splats, kept, nonzero((*imported.changes, missed)))


def _as_photographed(imported: Imported, capture: Path, config: RunConfig) -> Imported:
    """Return the scene drawn antialiased, if the pictures of a capture are clearly nearer so, or else not."""
    scene = imported.scene
    errors = photographed_errors(scene, open_capture(capture), config)
    with_it, without = (float(-10 * np.log10(errors[drawn] + 1e-12)) for drawn in (True, False))
    nearer = with_it > without + CLEARLY
    names = ("with antialiasing", "without antialiasing")[:: 1 if nearer else -1]
    decibels = [f"{value:.1f} dB" for value in ((with_it, without) if nearer else (without, with_it))]
    reason = f"the capture's pictures are {decibels[0]} from it so, and {decibels[1]} {names[1]}"
    changes = [change for change in imported.changes if change != UNTOLD]
    changes.append(Change.whole(Action.ASSUMED, f"drawing {names[0]}", reason))
    return dataclasses.replace(
        imported, scene=dataclasses.replace(scene, antialiased=nearer), changes=tuple(changes), antialiased=nearer
    )


def _fingerprint(file: Path) -> str:
    """Return the SHA-256 of a file, or of all files of a scene in a folder."""
    found = hashlib.sha256()
    for part in _parts(file):
        found.update(part.read_bytes())
    return found.hexdigest()


def _parts(file: Path) -> list[Path]:
    folder = file.parent if file.name == META else file
    if (folder / META).is_file():
        return sorted([folder / META, *folder.glob("*.webp")])
    return frame_files(file) if file.is_dir() else [file]


def _write(folder: RunFolder, file: Path, imported: Imported) -> None:
    spec, scene = folder.read_spec(), imported.scene
    if not spec.without_capture:
        centres = np.concatenate([scene.static.means, *(part.dynamic.motion[:, 0] for part in scene.segments)])
        save_near_planes(folder.near_planes, with_near_planes(folder.open_capture(spec).cameras, centres))
    save_scene(folder.trained, scene)
    write_bytes(folder.train_summary, json.dumps({"seconds": 0.0, "imported": file.name}, indent=1).encode())
