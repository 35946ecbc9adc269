"""A trained scene becomes the scene folder: as closely as the budget asks, with a thumbnail and its sound.

This module is light, as `hgs_core.runs.stages` is: torch is loaded when a scene is encoded.
"""

from __future__ import annotations

import json
import shutil
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hgs_core.base.progress import Progress, ProgressCallback, interruptible
from hgs_core.runs.run_folder import RunFolder

if TYPE_CHECKING:
    from hgs_core.base.arrays import Floats
    from hgs_core.codec import SceneChunks
    from hgs_core.codec.format.manifest import Manifest
    from hgs_core.fit.encoding_loss import Decibels
    from hgs_core.fit.encoding_views import EncodeViews
    from hgs_core.scene.splats import HybridScene

__all__ = ["Encoded", "encode", "encode_again", "encode_kept"]


@dataclass(frozen=True)
class Encoded:
    """The result of an encoding."""

    manifest: Manifest
    coarseness: float  # coarseness of static splats
    dynamic_share: float  # coarseness of dynamic splats over that
    loss: Decibels  # loss of the training views
    static: int  # splats before; those that show next to nothing are dropped
    dynamic: int


@interruptible()
def encode(run: Path, progress: ProgressCallback) -> None:
    """Encode scene.npz into the scene folder: chunks, thumbnail, and the manifest last.

    The decoded pictures on disk are removed then, unless the config keeps them.
    """
    folder = RunFolder(run)
    if not folder.manifest.exists():
        encode_again(run, None, progress)
    if not folder.read_spec().config.capture.keep_pictures:
        shutil.rmtree(folder.pictures, ignore_errors=True)


def encode_again(run: Path, budget: str | None, progress: ProgressCallback, *, fine_tune: int | None = None) -> Encoded:
    """Encode scene.npz anew into the scene folder; `budget` is one of `BUDGETS`, None: the config's.

    `fine_tune` is for how many iterations the scene is trained further as it decodes; None: the config's.

    Raises:
        InputError: the run is not trained yet, or its capture is gone or has changed, or its masks cannot be read.
    """
    from hgs_core.fit.coarseness import fit
    from hgs_core.fit.measured_utility import measure_utility
    from hgs_core.runs.encode_inputs import trained_scene, training_states, views_of_run

    folder = RunFolder(run)
    spec = folder.read_spec()
    config, scene = spec.config, trained_scene(folder)
    views = views_of_run(folder, spec, scene)
    iterations = config.encode.fine_tune_iterations(config.train.iterations) if fine_tune is None else fine_tune
    if views.capture is None:  # there is nothing to train with
        iterations = 0
    steps = 4 + iterations
    progress(Progress("encode", 0, steps))
    utility = measure_utility(
        scene,
        list(views.trained.values()),
        views.times,
        any_background=views.any_background,
    )
    progress(Progress("encode", 1, steps))
    found = fit(
        scene,
        views,
        utility,
        budget or config.encode.budget,
        config.train,
        seed=config.seed,
        iterations=iterations,
        states=training_states(folder, scene),
        trained=lambda done: progress(Progress("encode", 1 + done, steps)),
    )
    progress(Progress("encode", steps - 2, steps))
    lost = {
        "encoding_loss": round(found.loss.whole, 4),
        "encoding_loss_moving": None if found.loss.moving is None else round(found.loss.moving, 4),
    }
    manifest = _write(folder, views, found.scene, lost, settings=found.settings, utility=found.utility)
    progress(Progress("encode", steps, steps))
    settings = found.settings
    return Encoded(
        manifest, settings.coarseness, settings.dynamic_share, found.loss, len(scene.static), scene.dynamic_splats
    )


@interruptible()
def encode_kept(run: Path, chunks: SceneChunks, progress: ProgressCallback) -> None:
    """Write the scene folder of scene.npz of `chunks` that hold its splats already, without a loss.

    Raises:
        InputError: a file of the run is damaged.
    """
    from hgs_core.runs.encode_inputs import trained_scene, views_of_run

    folder = RunFolder(run)
    scene = trained_scene(folder)
    progress(Progress("encode", 0, 1))
    _write(folder, views_of_run(folder, folder.read_spec(), scene), scene, {}, chunks=chunks)
    progress(Progress("encode", 1, 1))


def _write(
    folder: RunFolder, views: EncodeViews, scene: HybridScene[Floats], told: dict[str, Any], **how: Any
) -> Manifest:
    """Write the scene folder; `how` is the rest of the arguments of `encode_scene`."""
    from hgs_core.codec import encode_scene
    from hgs_core.fit.find_seen_limits import with_seen_limits
    from hgs_core.render.thumbnail import thumbnail
    from hgs_core.runs.sound import scene_sound
    from hgs_core.runs.training import told_of_training

    starts = views.start_views(scene)
    summary = json.loads(folder.train_summary.read_text())
    return encode_scene(
        scene,
        folder.scene,
        cameras=views.cameras,
        closer=views.closer,
        times=views.times,
        title=views.title,
        thumbnail=partial(thumbnail, scene, views.first_camera(starts)),
        training=told_of_training(summary) | told,
        trained=views.rig,
        narrowed=partial(with_seen_limits, scene=scene, cameras=views.rig),
        start_views=starts,
        up=views.up,
        audio=scene_sound(folder, folder.read_spec(), views.capture, scene.start, scene.end),
        **how,
    )
