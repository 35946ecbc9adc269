"""Splats of unknown origin against the pictures of a capture: drawn antialiased, and not."""

from __future__ import annotations

import numpy as np
import torch
from numpy.typing import NDArray

from hgs_core.capture.capture import Capture
from hgs_core.render.rasterize import rasterize
from hgs_core.render.threads import one_torch_thread
from hgs_core.runs.run_config import RunConfig
from hgs_core.scene.splats import HybridScene
from hgs_core.train.targets import target_picture

__all__ = ["photographed_errors"]

VIEWS = 6  # compared views, spread over cameras and time


def photographed_errors(
    scene: HybridScene[NDArray[np.float32]], capture: Capture, config: RunConfig
) -> dict[bool, float]:
    """Return the mean squared error of pictures of a capture, drawn antialiased (True) and not (False).

    Cameras that `config` holds out are not looked at.

    Raises:
        InputError: a picture cannot be read.
    """
    tensors = scene.map(torch.from_numpy)
    trained = list(config.capture.training_cameras(capture))
    errors: dict[bool, list[float]] = {True: [], False: []}
    with one_torch_thread():
        for number in range(min(VIEWS, len(trained) * len(capture.times))):
            index, frame = trained[number * len(trained) // VIEWS], number * len(capture.times) // VIEWS
            camera, seconds = capture.cameras[index], capture.moment(index, frame)
            segment = tensors.segment_at(min(max(seconds, scene.start), scene.end))
            true = target_picture(capture, index, frame, camera)
            for antialiased, found in errors.items():
                drawn = rasterize(
                    tensors.static,
                    segment.dynamic,
                    camera,
                    segment.normalised(seconds),
                    antialiased=antialiased,
                    background=scene.background,
                    gradients="none",
                )
                found.append(float(((drawn.rgb.clamp(0, 1) - true) ** 2).mean()))
    return {antialiased: float(np.mean(found)) for antialiased, found in errors.items()}
