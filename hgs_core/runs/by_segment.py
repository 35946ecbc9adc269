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
    folder = RunFolder(run)
    return len(_segments(folder, folder.read_spec())[0])


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
    from hgs_core.runs.training_inputs import training_inputs
    from hgs_core.train.capture_training import in_iterations, segment_trainer
    from hgs_core.train.checkpoint import load_state

    folder = RunFolder(run)
    spec = folder.read_spec()
    segments, capture = _segments(folder, spec)
    inputs = training_inputs(folder, capture, spec.config)
    first = load_state(folder.checkpoint(0)) if number else None
    trainer = segment_trainer(inputs, segments[number], folder.checkpoint(number), first)
    scene = trainer.run(lambda step: progress(in_iterations(step, spec.config.train)))
    _encode(folder, spec, scene, segments, number)


def assemble(run: Path, training: Mapping[str, Any] | None = None) -> int:
    """Write `run`/scene with the segments that are made, up to the first that is not; returns how many it has.

    It grows (`live`) until it is called with what `training` is to tell, which is when all are made. One process at a
    time.
    """
    folder = RunFolder(run)
    shown = json.loads(folder.manifest.read_bytes()) if folder.manifest.exists() else None
    before = count = 0 if shown is None else len(shown["segments"])
    while made(run, count):
        part = load_manifest(folder.segment(count))
        shown = part.to_json() if shown is None else _grown(shown, part, count)
        for name in stored_sizes(part):
            if not (folder.scene / CHUNKS / name).exists():
                write_bytes(folder.scene / CHUNKS / name, (folder.segment(count) / CHUNKS / name).read_bytes())
        if part.thumbnail and not folder.thumbnail.exists():
            write_bytes(folder.thumbnail, (folder.segment(count) / THUMBNAIL).read_bytes())
        count += 1
    if shown is None or (training is None and count == before):
        return count
    if training is None:
        shown["live"] = count
    else:
        shown.pop("live", None)
        shown["training"] |= training
    write_bytes(folder.manifest, json.dumps(shown, allow_nan=False, separators=(",", ":")).encode())
    return count


def finish(run: Path, progress: ProgressCallback) -> None:
    """Write scene.npz, the whole manifest and train.json, once all segments are made."""
    from hgs_core.runs.training import told_of_training, train_run

    folder = RunFolder(run)
    summary = train_run(folder, progress)
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


def _segments(folder: RunFolder, spec: RunSpec) -> tuple[list[CaptureSegment], Any]:
    from hgs_core.train.segment_cuts import cut_into_segments

    capture = folder.open_capture(spec)
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
        picture = partial(thumbnail, scene, views.first_camera(starts))
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


def _grown(shown: dict[str, Any], part: Manifest, number: int) -> dict[str, Any]:
    """Put segment `number` behind the others, in place, and return the document of the manifest."""
    new = part.to_json()
    shown["version"], shown["end"] = max(shown["version"], part.version), part.end
    shown["segments"] += new["segments"][:1]
    shown["slices"] += [piece | {"segment": number} for piece in new["slices"]]
    for name in ("splats_dynamic", "bytes_dynamic"):
        shown["totals"][name] += new["totals"][name]
    return shown
