"""The picture by which people see how far a training is, drawn anew while it runs."""

from __future__ import annotations

from pathlib import Path

import torch

from hgs_core.base.atomic import write_bytes
from hgs_core.base.progress import Progress
from hgs_core.render.rasterize import rasterize
from hgs_core.render.thumbnail import as_jpeg, thumbnail_size
from hgs_core.scene.camera import Camera
from hgs_core.train.checkpoint import TrainState
from hgs_core.train.train_config import TrainConfig

__all__ = ["Preview"]

_PICTURES = 40  # pictures of a training, evenly spread


class Preview:
    """Draws a training into one file, at its first report and at every fortieth of it."""

    def __init__(self, file: Path, camera: Camera, config: TrainConfig) -> None:
        """Draw the view of `camera`, at most 480 pixels wide, into the JPEG `file`."""
        self._file = file
        self._camera = thumbnail_size(camera)
        self._config = config
        self._drawn = -1

    def follow(self, state: TrainState, progress: Progress) -> None:
        """Draw the splats at the middle of their segment's time, if it is time for another picture.

        Raises:
            OSError: the file cannot be written.
        """
        number = progress.done * _PICTURES // max(progress.total, 1)
        if number == self._drawn:
            return
        self._drawn = number
        with torch.no_grad():
            render = rasterize(
                state.static,
                state.dynamic,
                self._camera,
                0.5,
                backend=self._config.backend,
                gradients="none",
                antialiased=self._config.antialiased,
            )
        write_bytes(self._file, as_jpeg(render.rgb))
