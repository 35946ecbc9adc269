"""The stages from a capture to an encoded scene; each is idempotent, resumable and reports its progress.

This module is light: every stage imports what it needs when it runs, so that the API process can create runs without
loading torch.
"""

from __future__ import annotations

import json
import logging
from collections.abc import Callable, Mapping
from pathlib import Path
from types import ModuleType

from hgs_core.base.atomic import write_bytes
from hgs_core.base.errors import InputError
from hgs_core.base.heap import trim_heap
from hgs_core.base.progress import ProgressCallback, interruptible, silent
from hgs_core.capture.capture import Capture
from hgs_core.capture.held_pictures import shared_pictures
from hgs_core.check.findings import CaptureCheck
from hgs_core.runs.asked_edit import make_edit
from hgs_core.runs.creation import create_run, prepare
from hgs_core.runs.encoding import encode
from hgs_core.runs.given_files import GivenFiles
from hgs_core.runs.require_room import require_room
from hgs_core.runs.run_config import RunConfig
from hgs_core.runs.run_folder import RunFolder
from hgs_core.runs.training_need import TrainingNeed

__all__ = [
    "STAGES",
    "check",
    "create_run",
    "encode",
    "initialise",
    "prepare",
    "require_room",
    "segments_of",
    "train",
    "train_scene",
]

log = logging.getLogger(__name__)


@interruptible()
def check(run: Path, progress: ProgressCallback) -> None:
    """Look for faults that training would be in vain with: check.json, which is kept if it is there.

    The capture is prepared first.

    Raises:
        InputError: there is one, and the config does not trust the poses.
    """
    from hgs_core.check.capture_check import check_capture
    from hgs_core.check.require_sound_capture import require_sound

    folder = RunFolder(run)
    if folder.near_planes.exists():
        return
    prepare(run, progress)
    spec = folder.read_spec()
    if folder.check.exists():
        result = CaptureCheck.load(folder.check)
    else:
        result = check_capture(folder.open_capture(spec), progress)
        result.save(folder.check)
        for finding in result.findings:
            log.info("%s: %s", spec.capture, finding.sentence())
    if not spec.config.capture.trust_poses:
        require_sound(result, spec.capture, spec.config.capture.hold_out)


@interruptible()
def initialise(run: Path, progress: ProgressCallback) -> None:
    """Find motion masks and first points, of which a segment's are kept if they are there.

    The capture is checked first; the last file is points/near.json. Of a scene to be edited, make the edit instead.
    """
    from hgs_core.decompose.masks import kept_masks
    from hgs_core.points.far_apart import angle_to_next, need_hulls
    from hgs_core.points.hull_search import HullSearch
    from hgs_core.points.initial_points import PointSearch
    from hgs_core.points.kept_points import keep_points
    from hgs_core.runs.training_inputs import segment_starts
    from hgs_core.train.segment_cuts import cut_into_segments

    folder = RunFolder(run)
    if folder.near_planes.exists():
        return
    if folder.read_spec().edited:
        make_edit(run, progress)
        return
    check(run, progress)
    capture, config = _open(folder)
    cameras = config.capture.training_cameras(capture)
    capture.hold(cameras, range(len(capture.times)), progress)
    masks = kept_masks(folder.masks, capture, cameras, segment_starts(capture, config), progress=progress)
    every = capture.frames_in(config.points.interval)
    views = [capture.cameras[index] for index in cameras]
    far_apart = config.points.hull and need_hulls(views, config.train.iterations)
    if far_apart:
        log.info(
            "%s: the cameras stand %.0f degrees apart: what moves is trained by its silhouettes, the rest on one"
            " surface around it (docs/training.md)",
            run,
            angle_to_next(views),
        )
    search = (HullSearch if far_apart else PointSearch)(
        capture,
        cameras,
        masks,
        static_target=config.points.static,
        dynamic_target=config.points.dynamic_in(capture.seconds),
        stereo=config.points.stereo,
        continued=config.points.continued,
        normals=config.points.discs,
    )
    moments = [segment.sampled(every) for segment in cut_into_segments(capture.times, config.train.segment_frames)]
    keep_points(folder.points, search, moments, seed=config.seed, progress=progress)


def train(run: Path, progress: ProgressCallback) -> None:
    """Train from the last checkpoint, or from the points, to scene.npz and train.json.

    Where the config says `encode.by_segment`, every segment is encoded as soon as it is trained.
    """
    from hgs_core.runs.by_segment import train_by_segment
    from hgs_core.runs.training import train_run

    folder = RunFolder(run)
    if folder.train_summary.exists():
        return
    if folder.read_spec().config.encode.by_segment:
        train_by_segment(run, progress)
        return
    summary = train_run(folder, progress)
    write_bytes(folder.train_summary, json.dumps(summary, indent=1).encode())


def segments_of(run: Path) -> ModuleType | None:
    """Return the maker of a run's segments one by one, if its config wants that and it is not trained yet."""
    from hgs_core.runs import by_segment

    folder = RunFolder(run)
    wanted = folder.read_spec().config.encode.by_segment and not folder.train_summary.exists()
    return by_segment if wanted else None


STAGES: Mapping[str, Callable[[Path, ProgressCallback], None]] = {
    "prepare": prepare,
    "check": check,
    "initialise": initialise,
    "train": train,
    "encode": encode,
}
"""The stages in order, by name."""


def train_scene(
    capture: Path,
    out: Path,
    config: RunConfig | None = None,
    *,
    masks: Path | None = None,
    depth: Path | None = None,
    mesh: Path | None = None,
    audio: str = "auto",
    progress: ProgressCallback = silent,
    checked: Callable[[CaptureCheck], None] = lambda result: None,
    needed: Callable[[TrainingNeed], None] = lambda need: None,
) -> Path:
    """Train a capture and encode the scene; calling it again resumes from the last checkpoint, to the same bits.

    Args:
        capture: folder of a multi-view capture, or of three or more videos whose poses are to be found
            (docs/captures.md).
        out: folder of the run: new, empty, or of an equal run to resume or to keep.
        config: how to go about it; by default the preset "standard".
        masks: a folder of masks, `<camera>/<FFFF>.png`, to use instead of the capture's own.
        depth: a folder of depth maps with their depth.json, to use instead of the capture's own.
        mesh: a PLY, OBJ or GLB file of triangles, to use instead of the capture's own.
        audio: what is heard: "auto" for the sound of the first camera that has any, "camera:" and the name of one,
            "none", or a file with sound.
        progress: called after every step of a stage; it may raise `StageStopped` to stop.
        checked: called with what the check of the capture found, also if that stops the run.
        needed: called with the need of the run, before any work if the capture has its cameras.

    Returns:
        `out`. The trained splats are in `out`/scene.npz, the encoded scene is the folder `out`/scene.

    Raises:
        InputError: the capture is unusable, its poses do not fit its pictures, a held-out camera is unknown, the folder
            is taken, another process works on the run, or there is less memory or disk than the run needs.
        StageStopped: `progress` raised it; what was done so far is kept.

    Example:
        >>> import hgs_core as hgs
        >>> from pathlib import Path
        >>> config = hgs.RunConfig.for_preset("preview", train={"iterations": 20}, capture={"hold_out": ["2"]})
        >>> run = hgs.train_scene(Path("capture"), Path("new_run"), config)
        >>> sorted(path.name for path in (run / "scene").iterdir())
        ['chunks', 'manifest.json', 'thumbnail.jpg']
    """
    new = not RunFolder(out).spec.exists()
    create_run(out, capture, config or RunConfig(), GivenFiles(masks, depth, mesh, audio))
    try:
        need = require_room(out)
    except InputError:
        if new:  # so that the cure can be tried in the same place
            RunFolder(out).spec.unlink()
        raise
    with RunFolder(out).exclusive(), shared_pictures():
        if need is not None:
            needed(need)
        for name, stage in STAGES.items():
            try:
                stage(out, progress)
                trim_heap()
            finally:
                if name == "check" and RunFolder(out).check.exists():
                    checked(CaptureCheck.load(RunFolder(out).check))
            if name == "prepare" and need is None and (need := TrainingNeed.load(RunFolder(out).need)) is not None:
                needed(need)
    return out


def _open(folder: RunFolder) -> tuple[Capture, RunConfig]:
    spec = folder.read_spec()
    return folder.open_capture(spec), spec.config
