"""A run segment by segment: each is trained and encoded by itself, and shown before the others are there.

The first segment decides the statics, the colour maps and the coarseness; every other depends on nothing but its end,
so that they can be made in any order, by any process, to the same bits.
"""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hgs_core.base.atomic import write_bytes
from hgs_core.base.progress import ProgressCallback, interruptible
from hgs_core.codec.format.manifest import Manifest
from hgs_core.codec.format.scene_folder import CHUNKS, MANIFEST, THUMBNAIL, load_manifest, stored_sizes
from hgs_core.runs.run_folder import RunFolder, RunSpec

if TYPE_CHECKING:
    from hgs_core.scene.splats import HybridScene
    from hgs_core.train.segment_cuts import CaptureSegment

__all__ = ["assemble", "finish", "made", "make_segment", "part_of_all", "segment_count", "train_by_segment"]

_SETTINGS = "settings.json"  # encoding settings of the first segment, for all


def segment_count(run: Path) -> int:
    """Return the number of segments of a run with a prepared capture."""
    return len(_segments(RunFolder(run).read_spec())[0])


def made(run: Path, number: int) -> bool:
    """Return whether a segment is trained and encoded."""
    return (RunFolder(run).segment(number) / MANIFEST).exists()


def make_segment(run: Path, number: int, progress: ProgressCallback) -> None:
    """Train and encode one segment, into `run`/segments; it goes on from its checkpoint. The first one comes first.

    Two processes must not make the same segment at once.

    Raises:
        StageStopped: the callback asked to stop; what it needs to go on was saved.
    """
    if made(run, number):
        return
    from hgs_core.decompose.masks import MotionMasks
    from hgs_core.points.near_plane import with_near_planes
    from hgs_core.points.point_cloud import PointCloud
    from hgs_core.train.capture_training import TrainingInputs, segment_trainer
    from hgs_core.train.checkpoint import load_state

    folder = RunFolder(run)
    spec = folder.read_spec()
    segments, capture = _segments(spec)
    config, points = spec.config, PointCloud.load(folder.points)
    cameras = with_near_planes(capture.cameras, points.xyz)
    inputs = TrainingInputs(
        capture,
        {i: cameras[i] for i in config.capture.training_cameras(capture)},
        config.train,
        config.seed,
        points,
        capture.frames_in(config.points.interval),
        MotionMasks.load(folder.masks, capture),
    )
    first = load_state(folder.checkpoint(0)) if number else None
    trainer = segment_trainer(inputs, segments[number], folder.checkpoint(number), first)
    scene = trainer.run(progress)
    _encode(folder, spec, scene, segments, number)


def assemble(run: Path, training: Mapping[str, Any] | None = None) -> int:
    """Write `run`/scene with the segments that are made, up to the first that is not; returns how many it has.

    It grows (`live`) until it is called with what `training` is to tell, which is when all are made. One process at a
    time.
    """
    folder = RunFolder(run)
    parts: list[Manifest] = []
    while made(run, len(parts)):
        parts.append(load_manifest(folder.segment(len(parts))))
    if not parts:
        return 0
    first, manifest = parts[0], _joined(parts)
    live = None if training is not None else len(parts)
    told = dict(first.training) | dict(training or {})
    manifest = dataclasses.replace(manifest, live=live, training=told)
    text = json.dumps(manifest.to_json(), allow_nan=False, separators=(",", ":")).encode()
    if folder.manifest.exists() and folder.manifest.read_bytes() == text:
        return len(parts)
    for number, part in enumerate(parts):
        for name in stored_sizes(part):
            if not (folder.scene / CHUNKS / name).exists():
                write_bytes(folder.scene / CHUNKS / name, (folder.segment(number) / CHUNKS / name).read_bytes())
    if first.thumbnail and not folder.thumbnail.exists():
        write_bytes(folder.thumbnail, (folder.segment(0) / THUMBNAIL).read_bytes())
    write_bytes(folder.manifest, text)
    return len(parts)


def finish(run: Path, progress: ProgressCallback) -> None:
    """Write scene.npz, the whole manifest and train.json, once all segments are made."""
    from hgs_core.runs.training import told_of_training, train_run
    from hgs_core.scene.files import save_scene

    folder = RunFolder(run)
    scene, summary = train_run(folder, progress)
    save_scene(folder.trained, scene)
    assemble(run, told_of_training(summary))
    write_bytes(folder.train_summary, json.dumps(summary, indent=1).encode())


def train_by_segment(run: Path, progress: ProgressCallback, grown: Callable[[], None] = lambda: None) -> None:
    """Make all segments in this process, one after the other; `grown` is called whenever the scene has another one."""
    count = segment_count(run)
    for number in range(count):
        make_segment(run, number, part_of_all(progress, number, count))
        assemble(run)
        grown()
    finish(run, progress)


def part_of_all(progress: ProgressCallback, before: int, count: int) -> ProgressCallback:
    """Return a callback that reports a segment's training as a part of that of `count`, `before` of which are made."""
    return lambda step: progress(
        dataclasses.replace(step, done=before * step.total + step.done, total=count * step.total)
    )


def _segments(spec: RunSpec) -> tuple[list[CaptureSegment], Any]:
    from hgs_core.train.segment_cuts import cut_into_segments

    capture = spec.open_capture(cache_bytes=spec.config.capture.cache_bytes)
    return list(cut_into_segments(capture.times, spec.config.train.segment_frames)), capture


@interruptible()
def _encode(
    folder: RunFolder, spec: RunSpec, scene: HybridScene[Any], segments: list[CaptureSegment], number: int
) -> None:
    """Encode a segment by itself; the first one has the statics and the sound, and finds the settings."""
    from hgs_core.codec import EncodeSettings, SetUtility, Utility, encode_scene
    from hgs_core.fit.coarseness import fit
    from hgs_core.fit.find_seen_limits import with_seen_limits
    from hgs_core.fit.measured_utility import measure_utility
    from hgs_core.render.thumbnail import thumbnail
    from hgs_core.runs.encode_inputs import views_of_run
    from hgs_core.runs.sound import scene_sound
    from hgs_core.scene.splats import StaticSplats

    whole = views_of_run(folder, spec, scene)
    segment = segments[number]
    views = whole.of_frames(segment.first, segment.frames)
    utility = measure_utility(scene, list(views.trained.values()), views.times, any_background=views.any_background)
    # Of a splat that moves it is the mean over all of the scene, of which this is a part.
    part = segment.frames / len(whole.times)
    utility = Utility(utility.static, tuple(SetUtility(one.shown * part, one.missed * part) for one in utility.dynamic))
    training: dict[str, Any] = {}
    picture = audio = starts = None
    settings_file = folder.segment(0) / _SETTINGS
    if number == 0:
        found = fit(scene, views, utility, spec.config.encode.budget, spec.config.train, seed=spec.config.seed)
        settings = found.settings
        write_bytes(settings_file, json.dumps(dataclasses.asdict(settings)).encode())
        moving = found.loss.moving
        training = {
            "encoding_loss": round(found.loss.whole, 4),
            "encoding_loss_moving": None if moving is None else round(moving, 4),
        }
        starts = views.start_views(scene)
        picture = thumbnail(scene, views.first_camera(starts))
        end = segments[-1].clock.end
        audio = scene_sound(folder, spec, views.capture, scene.start, end)
    else:
        settings = EncodeSettings(**json.loads(settings_file.read_bytes()))
        scene = dataclasses.replace(scene, static=StaticSplats.empty())
        utility = Utility(SetUtility(utility.static.shown[:0], utility.static.missed[:0]), utility.dynamic)
    encode_scene(
        scene,
        folder.segment(number),
        cameras=whole.cameras,
        closer=whole.closer,
        times=whole.times,
        title=whole.title,
        settings=settings,
        thumbnail=picture,
        training=training,
        utility=utility,
        trained=whole.rig,
        narrowed=partial(with_seen_limits, scene=scene, cameras=whole.rig) if number == 0 else None,
        start_views=starts,
        up=whole.up,
        audio=audio,
    )


def _joined(parts: list[Manifest]) -> Manifest:
    """Return the first manifest with the segments of the others behind its own."""
    slices = [dataclasses.replace(piece, segment=number) for number, part in enumerate(parts) for piece in part.slices]
    return dataclasses.replace(
        parts[0],
        end=parts[-1].end,
        segments=tuple(part.segments[0] for part in parts),
        slices=tuple(slices),
        version=max(part.version for part in parts),
    )
