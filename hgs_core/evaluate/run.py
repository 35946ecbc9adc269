"""Scores of a finished run: the encoded scene as viewers see it, against the cameras' pictures."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import torch
from torch import Tensor

from hgs_core.base.atomic import write_bytes
from hgs_core.base.bounded_map import bounded_map
from hgs_core.base.cores import core_pool
from hgs_core.base.errors import InputError
from hgs_core.base.progress import Progress, ProgressCallback, silent
from hgs_core.capture.capture import Capture
from hgs_core.codec import Manifest, decode_scene, load_manifest
from hgs_core.evaluate.camera_scores import CameraScores, FrameScores, combine
from hgs_core.evaluate.magnified import MagnifiedScorer
from hgs_core.evaluate.picture_scores import PictureScorer
from hgs_core.evaluate.rig_view import RigView
from hgs_core.evaluate.truth import Truth
from hgs_core.metrics.lpips import NETWORK
from hgs_core.render.fixed_view import FixedView
from hgs_core.render.threads import one_torch_thread
from hgs_core.runs.run_folder import RunFolder
from hgs_core.scene.camera import Camera
from hgs_core.scene.splats import HybridScene

__all__ = ["evaluate_run"]


def evaluate_run(
    run: Path,
    progress: ProgressCallback = silent,
    *,
    cameras: Sequence[str] | None = None,
    all_cameras: bool = False,
    truth: Path | None = None,
    masks: Path | None = None,
    lpips: Path | None = None,
    flip: bool = False,
    magnify: Sequence[int] = (),
    backend: str = "auto",
) -> dict[str, Any]:
    """Render the decoded scene at every frame of some cameras and compare; writes eval.json.

    Args:
        run: the run's folder.
        progress: told after every picture.
        cameras: names of the cameras to score; those held out by default.
        all_cameras: score every camera of the capture instead.
        truth: folder of pictures to score against instead of the capture's (`Truth`).
        masks: folder of masks of what moves; without it the capture's own are used, or what moves in the truth.
        lpips: file of the weights (`Lpips`); without it there is no LPIPS.
        flip: whether to compute FLIP.
        magnify: factors, 2 to 8, of larger pictures to score at a few moments of every camera, with nearer eyes.
        backend: that draws (`hgs_core.render.rasterize`).

    Returns:
        The fields of eval.json (docs/evaluation.md). A score that was not measured is None.

    Raises:
        InputError: the run is not finished, its capture is gone or has changed, a camera is unknown, a file of the
            truth, the masks or the weights is missing or wrong, FLIP is not installed, or the backend cannot run here.

    Example:
        >>> import hgs_core as hgs
        >>> from pathlib import Path
        >>> scores = hgs.evaluate_run(Path("run"))
        >>> scores["cameras"], scores["frames"], scores["psnr"] > 10
        (['2'], 6, True)
    """
    folder = RunFolder(run)
    spec = folder.read_spec()
    if not folder.train_summary.exists() or not folder.manifest.exists():
        raise InputError(run, "the run has no encoded scene yet", "finish it with hgs train")
    scorer = PictureScorer(lpips, flip)
    capture = folder.open_capture(spec)
    held_out = [capture.camera_index(name) for name in spec.config.capture.hold_out]
    chosen = held_out if cameras is None else [capture.camera_index(name) for name in cameras]
    indices = range(len(capture.cameras)) if all_cameras else list(dict.fromkeys(chosen))
    reduced = spec.config.capture
    source = Truth(
        capture, indices, pictures=truth, masks=masks, downscale=reduced.downscale, reductions=reduced.reductions
    )
    manifest = load_manifest(folder.manifest)
    summary = json.loads(folder.train_summary.read_text())
    falloff, colour_map = summary.get("lens_falloff"), summary.get("colour_map")
    rig = None if falloff is None else partial(RigView, falloff, colour_map)
    late = summary.get("time_shifts") or {}
    scores = {index: CameraScores() for index in indices}
    names = {index: capture.cameras[index].name for index in indices}
    scene = decode_scene(folder.scene).map(torch.from_numpy)
    magnified = MagnifiedScorer(scene, manifest, capture, source, backend).scores(indices, magnify) if magnify else None
    _score(scene, manifest, rig, late, capture, source, scorer, scores, backend, progress)
    totals = manifest.totals
    result = {
        **combine(list(scores.values())),
        "lpips_network": None if lpips is None else NETWORK,
        "lens_falloff": falloff,
        "colour_map": colour_map,
        "magnified": magnified,
        "bytes_total": totals.bytes_static
        + totals.bytes_dynamic
        + manifest.bytes_audio
        + folder.manifest.stat().st_size,
        "bytes_static": totals.bytes_static,
        "bytes_dynamic": totals.bytes_dynamic,
        "splats_static": totals.splats_static,
        "splats_dynamic": totals.splats_dynamic,
        "train_seconds": summary["seconds"],
        "frames": len(capture.times),
        "cameras": list(names.values()),
        "cameras_trained_on": [name for index, name in names.items() if index not in held_out],
        "truth": source.of_pictures,
        "masks": source.of_masks,
        "per_camera": {names[index]: combine([camera]) for index, camera in scores.items()},
        "per_frame": {names[index]: camera.per_frame() for index, camera in scores.items()},
    }
    write_bytes(folder.evaluation, json.dumps(result, indent=1, allow_nan=False).encode())
    return result


def _score(
    scene: HybridScene[Tensor],
    manifest: Manifest,
    rig: Callable[[Camera], RigView] | None,  # lens and colours of the training cameras
    late: Mapping[str, float],  # training camera -> seconds of its learned clock
    capture: Capture,
    source: Truth,
    scorer: PictureScorer,
    scores: Mapping[int, CameraScores],  # camera -> scores, to be filled
    backend: str,
    progress: ProgressCallback,
) -> None:
    """Draw every frame of every camera in turn; the frames drawn last are scored on all cores."""
    views = {camera.name: camera for camera in manifest.cameras}
    total, done, decibels = len(scores) * len(capture.times), 0, 0.0
    with one_torch_thread(), core_pool() as pool:
        for index, gathered in scores.items():
            camera = views[capture.cameras[index].name]
            as_rig = None if rig is None else rig(camera)
            view = FixedView(
                scene.static,
                camera,
                background=scene.background,
                antialiased=scene.antialiased,
                backend=backend,
                rig=manifest.rig,
            )
            of_frame = partial(_frame_scores, scorer, source, index, as_rig)
            drawn = _drawn(scene, capture, source, index, view, late.get(camera.name, 0.0))
            for frame in bounded_map(pool, of_frame, drawn):
                gathered.add(frame)
                decibels += gathered.frames["psnr"][-1] or 0.0
                done += 1
                progress(Progress("evaluate", done, total, {"psnr": decibels / done}))
            gathered.finish()


def _drawn(
    scene: HybridScene[Tensor], capture: Capture, source: Truth, index: int, view: FixedView, late: float
) -> Iterator[tuple[int, Tensor, Tensor]]:
    """Yield every frame of a camera with its picture and its truth, [3, H, W] each."""
    for frame, seconds in enumerate(capture.times):
        segment = scene.segment_at(float(seconds))
        moment = segment.normalised(capture.moment(index, frame) + late)
        yield frame, view.frame(segment.dynamic, moment).rgb.clamp(0, 1), source.picture(index, frame)


def _frame_scores(
    scorer: PictureScorer, source: Truth, index: int, rig: RigView | None, drawn: tuple[int, Tensor, Tensor]
) -> FrameScores:
    frame, picture, truth = drawn
    return FrameScores.of(scorer, picture, truth, source.moving(index, frame), rig)
