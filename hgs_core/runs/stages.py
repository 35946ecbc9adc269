"""The stages from a capture to an encoded scene; each is idempotent, resumable and reports its progress.

This module is light: every stage imports what it needs when it runs, so that the API process can create runs without
loading torch.
"""

from __future__ import annotations

import dataclasses
import json
import logging
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

from hgs_core.base.atomic import write_bytes
from hgs_core.base.errors import InputError
from hgs_core.base.heap import trim_heap
from hgs_core.base.old_names import with_new_names
from hgs_core.base.progress import Progress, ProgressCallback, silent
from hgs_core.base.wording import counted
from hgs_core.calibrate.uncalibrated import are_enough_videos, has_poses
from hgs_core.capture.capture import Capture
from hgs_core.capture.held_out import AUTO, with_held_out
from hgs_core.capture.open import open_capture
from hgs_core.check.findings import CaptureCheck
from hgs_core.runs.config import RunConfig
from hgs_core.runs.folder import RunFolder, RunSpec

if TYPE_CHECKING:
    from hgs_core.codec.format.manifest import Manifest
    from hgs_core.fit.loss import Decibels

__all__ = [
    "STAGES",
    "Encoded",
    "check",
    "create_run",
    "encode",
    "encode_again",
    "initialise",
    "prepare",
    "segments_of",
    "train",
    "train_scene",
]

_MIN_CAMERAS = 2

log = logging.getLogger(__name__)


def create_run(
    run: Path, capture: Path, config: RunConfig, *, masks: Path | None = None, audio: str = "auto"
) -> RunConfig:
    """Check the capture and the config and write `run`/run.json; an equal run that is there already is kept.

    `masks` is a folder of masks to use instead of the capture's own; `audio` is the sound: "auto" for that of the first
    camera with any, "none", or a file. What was left out or found is logged. Returns the config of the run, which names
    the camera that is held out where `config` leaves the choice; that of videos without poses is chosen when `prepare`
    has found them.

    Raises:
        InputError: the capture is unusable, a held-out camera is unknown, the file has no sound, or the folder is
            taken. Nothing is written.
    """
    from hgs_core.runs.sound import require_sound_file

    audio = require_sound_file(audio)
    folder = RunFolder(run)
    found = folder.found if folder.found.is_dir() else None
    if not has_poses(capture) and (found is None or not has_poses(found)) and are_enough_videos(capture):
        folder.write_spec(
            RunSpec(capture.resolve(), "", config, masks and masks.resolve(), prepared=False, audio=audio)
        )
        return config
    opened = open_capture(
        capture, masks=masks, downscale=config.capture.downscale, reductions=config.capture.reductions, found=found
    )
    config = _with_held_out(config, folder, opened)
    _require_enough(config, opened)
    prepared = not opened.unaligned or config.capture.sync == "none"
    spec = RunSpec(
        capture.resolve(), opened.fingerprint(), config, masks and masks.resolve(), found=found, prepared=prepared,
        audio=audio,
    )  # fmt: skip
    folder.write_spec(spec)
    for note in opened.notes:
        log.warning("%s: %s", capture, note)
    return config


def _require_enough(config: RunConfig, capture: Capture) -> None:
    left = len(config.capture.training_cameras(capture))
    if left < _MIN_CAMERAS:
        raise InputError(
            "config.capture.hold_out",
            f"leaves {left} of {counted(len(capture.cameras), 'camera')} to train on",
            f"keep at least {_MIN_CAMERAS}",
        )


def _with_held_out(config: RunConfig, folder: RunFolder, capture: Capture) -> RunConfig:
    """Choose the camera to hold out, where that is asked for; a run that is there keeps its own."""
    if config.capture.hold_out != AUTO:
        return config
    if folder.spec.exists() and (there := folder.read_spec().config.capture.hold_out) != AUTO:
        return config.changed({"capture.hold_out": there})
    chosen = with_held_out(config.capture, capture.cameras)
    for name in chosen.hold_out:
        log.warning(
            "camera %s is held out, so that hgs eval can score the scene with it; --hold-out names others", name
        )
    return dataclasses.replace(config, capture=chosen)


def prepare(run: Path, progress: ProgressCallback) -> None:
    """Find out when the videos began and where the cameras stand, where the capture does not say.

    Both are written beside the videos, sync.json and sparse/0, or below the run's folder where that cannot be done.

    Raises:
        InputError: the videos tell too little.
    """
    folder = RunFolder(run)
    spec = folder.read_spec()
    if spec.prepared:
        return
    from hgs_core.runs.preparation import prepared_capture

    found = prepared_capture(spec, folder.found, progress)
    spec = dataclasses.replace(spec, found=found, prepared=True)
    reduced = spec.config.capture
    opened = open_capture(
        spec.capture, masks=spec.masks, downscale=reduced.downscale, reductions=reduced.reductions, found=found
    )
    config = _with_held_out(spec.config, folder, opened)
    _require_enough(config, opened)
    if not spec.fingerprint:
        for note in opened.notes:
            log.warning("%s: %s", spec.capture, note)
    folder.replace_spec(dataclasses.replace(spec, fingerprint=opened.fingerprint(), config=config))


def check(run: Path, progress: ProgressCallback) -> None:
    """Look for faults that training would be in vain with: check.json, which is kept if it is there.

    The capture is prepared first.

    Raises:
        InputError: there is one, and the config does not trust the poses.
    """
    from hgs_core.check.capture_check import check_capture
    from hgs_core.check.stopping import require_sound

    folder = RunFolder(run)
    if folder.points.exists():
        return
    prepare(run, progress)
    spec = folder.read_spec()
    if folder.check.exists():
        result = CaptureCheck.load(folder.check)
    else:
        result = check_capture(spec.open_capture(), progress)
        result.save(folder.check)
        for finding in result.findings:
            log.info("%s: %s", spec.capture, finding.sentence())
    if not spec.config.capture.trust_poses:
        require_sound(result, spec.capture)


def initialise(run: Path, progress: ProgressCallback) -> None:
    """Find what moves and where the first points are: masks.npz, which is kept if it is there, and points.npz.

    The capture is checked first.
    """
    from hgs_core.decompose.masks import MotionMasks, motion_masks
    from hgs_core.points.initial_points import initial_points
    from hgs_core.train.segments import cut_into_segments

    folder = RunFolder(run)
    if folder.points.exists():
        return
    check(run, progress)
    capture, config = _open(folder)
    cameras = config.capture.training_cameras(capture)
    if folder.masks.exists():  # of a stage that was stopped, or put there to be used
        masks = MotionMasks.load(folder.masks, capture)
    else:
        masks = motion_masks(capture, cameras, progress=progress)
        masks.save(folder.masks)
    every = capture.frames_in(config.points.interval)
    segments = cut_into_segments(capture.times, config.train.segment_frames)
    moments = sorted({frame for segment in segments for frame in segment.sampled(every)})
    points = initial_points(
        capture, cameras, masks, moments=moments, static_target=config.points.static,
        dynamic_target=config.points.dynamic_in(capture.seconds), seed=config.seed, progress=progress,
    )  # fmt: skip
    points.save(folder.points)


def train(run: Path, progress: ProgressCallback) -> None:
    """Train from the last checkpoint, or from the points, to scene.npz and train.json.

    Where the config says `encode.by_segment`, every segment is encoded as soon as it is trained.
    """
    from hgs_core.runs.by_segment import train_by_segment
    from hgs_core.runs.training import train_run
    from hgs_core.scene.files import save_scene

    folder = RunFolder(run)
    if folder.train_summary.exists():
        return
    if folder.read_spec().config.encode.by_segment:
        train_by_segment(run, progress)
        return
    scene, summary = train_run(folder, progress)
    save_scene(folder.trained, scene)
    write_bytes(folder.train_summary, json.dumps(summary, indent=1).encode())


def segments_of(run: Path) -> ModuleType | None:
    """Return what makes the segments of a run one by one, if its config wants that and it is not trained yet."""
    from hgs_core.runs import by_segment

    folder = RunFolder(run)
    wanted = folder.read_spec().config.encode.by_segment and not folder.train_summary.exists()
    return by_segment if wanted else None


@dataclass(frozen=True)
class Encoded:
    """What encoding made of a scene."""

    manifest: Manifest
    coarseness: float  # of static splats
    dynamic_share: float  # coarseness of dynamic splats over that
    loss: Decibels  # of the training views
    static: int  # splats before; those that show next to nothing are dropped
    dynamic: int


def encode(run: Path, progress: ProgressCallback) -> None:
    """Encode scene.npz into the scene folder: chunks, thumbnail, and the manifest last."""
    folder = RunFolder(run)
    if not folder.manifest.exists():
        encode_again(run, None, progress)


def encode_again(run: Path, budget: str | None, progress: ProgressCallback, *, fine_tune: int | None = None) -> Encoded:
    """Encode scene.npz in place of what is in the scene folder; `budget` is one of `BUDGETS`, None: the config's.

    `fine_tune` is for how many iterations the scene is trained further as it decodes; None: a share of the training's.

    Raises:
        InputError: the run is not trained yet, or its capture is gone or has changed, or its masks cannot be read.
    """
    from hgs_core.codec import encode_scene
    from hgs_core.fit.coarseness import fine_tune_iterations, fit
    from hgs_core.fit.utility import measure_utility
    from hgs_core.render.thumbnail import thumbnail
    from hgs_core.runs.encode_inputs import trained_scene, training_states, views_of_run
    from hgs_core.runs.sound import scene_sound
    from hgs_core.runs.training import told_of_training

    folder = RunFolder(run)
    spec = folder.read_spec()
    config, scene = spec.config, trained_scene(folder)
    views = views_of_run(folder, spec, scene)
    iterations = fine_tune_iterations(config.train) if fine_tune is None else fine_tune
    if views.capture is None:  # there is nothing to train with
        iterations = 0
    steps = 4 + iterations
    progress(Progress("encode", 0, steps))
    utility = measure_utility(
        scene, list(views.trained.values()), views.times,
        any_background=views.any_background,
    )  # fmt: skip
    progress(Progress("encode", 1, steps))
    found = fit(
        scene, views, utility, budget or config.encode.budget, config.train, seed=config.seed, iterations=iterations,
        states=training_states(folder, scene), trained=lambda done: progress(Progress("encode", 1 + done, steps)),
    )  # fmt: skip
    progress(Progress("encode", steps - 2, steps))
    picture = thumbnail(found.scene, views.cameras[0])
    progress(Progress("encode", steps - 1, steps))
    summary = with_new_names(json.loads(folder.train_summary.read_text()))
    training = told_of_training(summary) | {
        "encoding_loss": round(found.loss.whole, 4),
        "encoding_loss_moving": None if found.loss.moving is None else round(found.loss.moving, 4),
    }
    manifest = encode_scene(
        found.scene, folder.scene, cameras=views.cameras, closer=views.closer, times=views.times, title=views.title,
        settings=found.settings, thumbnail=picture, training=training, utility=found.utility,
        trained=list(views.trained.values()) if views.photographed else (), up=views.up,
        audio=scene_sound(folder, spec, views.capture, found.scene.start, found.scene.end),
    )  # fmt: skip
    progress(Progress("encode", steps, steps))
    settings = found.settings
    return Encoded(
        manifest, settings.coarseness, settings.dynamic_share, found.loss, len(scene.static), scene.dynamic_splats
    )


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
    audio: str = "auto",
    progress: ProgressCallback = silent,
    checked: Callable[[CaptureCheck], None] = lambda result: None,
) -> Path:
    """Train a capture and encode the scene; calling it again resumes from the last checkpoint, to the same bits.

    Args:
        capture: folder of a multi-view capture, or of three or more videos whose poses are to be found
            (docs/captures.md).
        out: folder of the run: new, empty, or of an equal run to resume or to keep.
        config: how to go about it; by default the preset "standard".
        masks: a folder of masks, `<camera>/<FFFF>.png`, to use instead of the capture's own.
        audio: what is heard: "auto" for the sound of the first camera that has any, "none", or a file with sound.
        progress: called after every step of a stage; it may raise `StageStopped` to stop.
        checked: called with what the check of the capture found, also if that stops the run.

    Returns:
        `out`. The trained splats are in `out`/scene.npz, the encoded scene is the folder `out`/scene.

    Raises:
        InputError: the capture is unusable, its poses do not fit its pictures, a held-out camera is unknown, the folder
            is taken, or another process works on the run.
        StageStopped: `progress` raised it; what was done so far is kept.

    Example:
        >>> import hgs_core as hgs
        >>> from pathlib import Path
        >>> config = hgs.RunConfig.for_preset("preview", train={"iterations": 20}, capture={"hold_out": ["2"]})
        >>> run = hgs.train_scene(Path("capture"), Path("new_run"), config)
        >>> sorted(path.name for path in (run / "scene").iterdir())
        ['chunks', 'manifest.json', 'thumbnail.jpg']
    """
    create_run(out, capture, config or RunConfig(), masks=masks, audio=audio)
    with RunFolder(out).exclusive():
        for name, stage in STAGES.items():
            try:
                stage(out, progress)
                trim_heap()
            finally:
                if name == "check" and RunFolder(out).check.exists():
                    checked(CaptureCheck.load(RunFolder(out).check))
    return out


def _open(folder: RunFolder) -> tuple[Capture, RunConfig]:
    spec = folder.read_spec()
    return spec.open_capture(cache_bytes=spec.config.capture.cache_bytes), spec.config
