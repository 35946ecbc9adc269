"""An affine colour map and a lens falloff per training camera, which seldom agree on exposure and white balance.

A scene that must explain such differences does so with splats that only one camera sees, which every other view then
shows as fog. The maps are training state: scenes, the codec and viewers know nothing of them.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import torch
from torch import Tensor

from hgs_core.render.camera_colours import camera_colours, camera_colours_pulled
from hgs_core.render.colour_affine import identity_affine
from hgs_core.render.types import WHOLE, Window
from hgs_core.scene.camera import Camera
from hgs_core.train.rmsprop import rmsprop_update

__all__ = ["CameraColours", "ColourCorrection"]

_STEEPEST = 0.375  # largest coefficient of a falloff, either sign: no corner is darker than a quarter of the middle


class CameraColours(NamedTuple):
    """One camera's change of colours, or the gradient towards it."""

    affine: Tensor  # [3, 4], `[A | b]` of A rgb + b
    falloff: Tensor | None  # [2], coefficients of the lens falloff (`falloff_gain`); None: none is learned

    def shown(self, picture: Tensor, camera: Camera, window: Window = WHOLE) -> Tensor:
        """Return a window [3, h, w] of a picture of the scene as that camera, at the picture's size, would show it."""
        return camera_colours(picture, self.affine, self.falloff, camera, window)

    def pulled(self, gradient: Tensor, picture: Tensor, camera: Camera, window: Window = WHOLE) -> Tensor:
        """Return a loss's gradient [3, h, w] towards a window of a picture from that towards the shown one."""
        return camera_colours_pulled(gradient, picture, self.affine, self.falloff, camera, window)

    def gradient(self) -> CameraColours:
        """Return the gradients of the tensors, which have some."""
        assert self.affine.grad is not None
        return CameraColours(self.affine.grad, None if self.falloff is None else self.falloff.grad)


class ColourCorrection:
    """The colours of C cameras, their moments, and the number of steps each has taken.

    The mean of the maps is kept at the identity: the scene has the colours that the cameras show on average in the
    middle of their pictures.
    """

    def __init__(self, cameras: int, *, falloff: bool = True) -> None:
        """Start from maps that change nothing; `falloff`: whether that of lenses is learned."""
        self.affine = identity_affine(cameras)  # [C, 3, 4]
        self.falloff = torch.zeros(cameras, 2) if falloff else None
        self._identity = identity_affine(cameras)
        self._moments = torch.zeros_like(self.affine)
        self._falloff_moments = torch.zeros(cameras, 2)
        self._steps = torch.zeros(cameras, dtype=torch.int64)

    def of(self, place: int) -> CameraColours:
        """Return the colours of a camera as they are."""
        return CameraColours(self.affine[place], None if self.falloff is None else self.falloff[place])

    def learning(self, place: int) -> CameraColours:
        """Return the colours of a camera as new tensors that gradients reach."""
        affine, falloff = self.of(place)
        return CameraColours(
            affine.clone().requires_grad_(True), None if falloff is None else falloff.clone().requires_grad_(True)
        )

    def step(self, place: int, gradient: CameraColours, rate: float, falloff_rate: float) -> None:
        """Take a step on one camera's colours, then centre all maps on the identity."""
        self._steps[place] += 1
        steps = int(self._steps[place])
        rmsprop_update(self.affine[place], gradient.affine, self._moments[place], rate, steps)
        self.affine -= (self.affine - self._identity).mean(0)
        if self.falloff is not None and gradient.falloff is not None:
            moments = self._falloff_moments[place]
            rmsprop_update(self.falloff[place], gradient.falloff, moments, falloff_rate, steps)
            self.falloff[place].clamp_(-_STEEPEST, _STEEPEST)

    def to(self, device: torch.device) -> ColourCorrection:
        """Return it with its maps on a device."""
        moved = ColourCorrection(len(self.affine))
        moved.affine, moved._identity = self.affine.to(device), self._identity.to(device)
        moved.falloff = None if self.falloff is None else self.falloff.to(device)
        moved._moments, moved._falloff_moments = self._moments.to(device), self._falloff_moments.to(device)
        moved._steps = self._steps
        return moved

    def state(self) -> dict[str, Any]:
        """Return plain tensors for a checkpoint."""
        return {
            "affine": self.affine,
            "moments": self._moments,
            "steps": self._steps,
            "falloff": self.falloff,
            "falloff_moments": self._falloff_moments,
        }

    @classmethod
    def restored(cls, state: dict[str, Any]) -> ColourCorrection:
        """Return the correction that `state` described."""
        correction = cls(len(state["affine"]))
        correction.affine, correction._steps = state["affine"], state["steps"]
        correction._moments = state["moments"]
        correction.falloff, correction._falloff_moments = state["falloff"], state["falloff_moments"]
        return correction
