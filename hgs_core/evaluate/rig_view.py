"""A camera's picture as the training cameras would show it: through their mean lens, with their median colour map."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor

from hgs_core.render.colour_affine import colour_affine, identity_affine
from hgs_core.render.lens_falloff import falloff_gain
from hgs_core.scene.camera import Camera

__all__ = ["RigView"]


class RigView:
    """The lens and colours that a camera of the capture has if it is like those in training, which alone are known.

    Nothing here is fitted to a picture of the camera itself.
    """

    def __init__(self, falloff: Sequence[float], colour_map: Sequence[Sequence[float]] | None, camera: Camera) -> None:
        """Take the mean falloff [2] and the median colour map [3, 4] of the training cameras (None: the identity)."""
        self._gain = falloff_gain(torch.tensor(falloff), camera)
        self._map = identity_affine(1)[0] if colour_map is None else torch.tensor(colour_map)

    def darkened(self, picture: Tensor) -> Tensor:
        """Return a picture [3, H, W] of the scene through the lens alone."""
        return picture * self._gain

    def shown(self, picture: Tensor) -> Tensor:
        """Return a picture [3, H, W] of the scene through the lens and with the colours, in [0, 1]."""
        return colour_affine(self.darkened(picture), self._map).clamp(0, 1)
