"""One affine colour map per training camera: cameras of a capture seldom agree on exposure and white balance.

A scene that must explain such differences does so with splats that only one camera sees, which every other view then
shows as fog. The maps are training state: scenes, the codec and viewers know nothing of them.
"""

from __future__ import annotations

from typing import Any

import torch
from torch import Tensor

from hgs_core.render.colour_affine import colour_affine, identity_affine
from hgs_core.train.rmsprop import rmsprop_update

__all__ = ["ColourCorrection"]


class ColourCorrection:
    """The maps `A rgb + b` of C cameras, their moments, and the number of steps each has taken.

    The mean of the maps is kept at the identity: the scene has the colours that the cameras show on average.
    """

    def __init__(self, cameras: int) -> None:
        """Start from maps that change nothing."""
        self.affine = identity_affine(cameras)  # [C, 3, 4]
        self._identity = identity_affine(cameras)
        self._moments = torch.zeros_like(self.affine)
        self._steps = torch.zeros(cameras, dtype=torch.int64)

    def corrected(self, picture: Tensor, camera: int) -> tuple[Tensor, Tensor]:
        """Return a picture [3, H, W] as that camera would show it, and the map [3, 4] that its gradient reaches."""
        affine = self.affine[camera].clone().requires_grad_(True)
        return colour_affine(picture, affine), affine

    def step(self, camera: int, gradient: Tensor, rate: float) -> None:
        """Take a step on one camera's map, then centre all maps on the identity."""
        self._steps[camera] += 1
        rmsprop_update(self.affine[camera], gradient, self._moments[camera], rate, int(self._steps[camera]))
        self.affine -= (self.affine - self._identity).mean(0)

    def to(self, device: torch.device) -> ColourCorrection:
        """Return it with its maps on a device."""
        moved = ColourCorrection(len(self.affine))
        moved.affine, moved._identity = self.affine.to(device), self._identity.to(device)
        moved._moments = self._moments.to(device)
        moved._steps = self._steps
        return moved

    def state(self) -> dict[str, Any]:
        """Return plain tensors for a checkpoint."""
        return {"affine": self.affine, "moments": self._moments, "steps": self._steps}

    @classmethod
    def restored(cls, state: dict[str, Any]) -> ColourCorrection:
        """Return what `state` described, also in earlier versions, whose optimiser had two moments."""
        correction = cls(len(state["affine"]))
        correction.affine, correction._steps = state["affine"], state["steps"]
        correction._moments = state["moments"] if "moments" in state else state["second"]
        return correction
