"""Scores of a finished run: what a viewer would see of the encoded scene, against the cameras held out."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import torch

from hgs_core.atomic import write_bytes
from hgs_core.codec import decode_scene, load_manifest
from hgs_core.errors import InputError
from hgs_core.evaluate.psnr import psnr
from hgs_core.evaluate.ssim import ssim
from hgs_core.progress import Progress, ProgressCallback
from hgs_core.render.fixed_view import FixedView
from hgs_core.render.threads import one_torch_thread
from hgs_core.run_folder import RunFolder
from hgs_core.train.targets import target_picture

__all__ = ["evaluate_run"]


def evaluate_run(run: Path, progress: ProgressCallback) -> dict[str, Any]:
    """Render the decoded scene at every frame of every held-out camera and compare; writes eval.json.

    Returns:
        psnr (dB, mean over frames and cameras), ssim (data range 1), bytes_total, bytes_static, bytes_dynamic,
        splats_static, splats_dynamic, train_seconds, frames (per camera), cameras (the names scored). Without held-out
        cameras psnr and ssim are None.

    Raises:
        InputError: the run is not finished or its capture is gone or has changed.
    """
    folder = RunFolder(run)
    spec = folder.read_spec()
    if not folder.train_summary.exists() or not folder.manifest.exists():
        raise InputError(run, "the run has no encoded scene yet", "finish it with hgs train")
    capture = spec.open_capture()
    manifest = load_manifest(folder.manifest)
    scene = decode_scene(folder.scene).map(torch.from_numpy)
    cameras = [capture.camera_index(name) for name in spec.config.hold_out]
    views = {camera.name: camera for camera in manifest.cameras}
    scores: list[tuple[float, float]] = []
    total = len(cameras) * len(capture.times)
    with one_torch_thread():
        for index in cameras:
            camera = views[capture.cameras[index].name]
            view = FixedView(scene.static, camera, background=manifest.background, antialiased=manifest.antialiased)
            for frame, seconds in enumerate(capture.times):
                segment = scene.segment_at(float(seconds))
                picture = view.frame(segment.dynamic, segment.normalised(float(seconds))).rgb.clamp(0, 1)
                truth = target_picture(capture, index, frame, camera)
                scores.append((psnr(picture, truth), ssim(picture, truth)))
                progress(Progress("evaluate", len(scores), total, {"psnr": _mean([s[0] for s in scores]) or 0.0}))
    totals = manifest.totals
    result = {
        "psnr": _mean([score[0] for score in scores]),
        "ssim": _mean([score[1] for score in scores]),
        "bytes_total": totals.bytes_static + totals.bytes_dynamic + folder.manifest.stat().st_size,
        "bytes_static": totals.bytes_static,
        "bytes_dynamic": totals.bytes_dynamic,
        "splats_static": totals.splats_static,
        "splats_dynamic": totals.splats_dynamic,
        "train_seconds": json.loads(folder.train_summary.read_text())["seconds"],
        "frames": len(capture.times),
        "cameras": list(spec.config.hold_out),
    }
    write_bytes(folder.evaluation, json.dumps(result, indent=1).encode())
    return result


def _mean(values: list[float]) -> float | None:
    return sum(values) / len(values) if values else None
