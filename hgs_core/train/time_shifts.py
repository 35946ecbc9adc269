"""A shift of the clock per training camera, learned with the scene: videos are seldom in step to a part of a frame.

The shifts are training state: scenes, the codec and viewers know nothing of them.
"""

from __future__ import annotations

from typing import Any

import torch
from torch import Tensor

from hgs_core.scene.splats import DynamicSplats
from hgs_core.train.rmsprop import rmsprop_update

__all__ = ["TimeShifts"]


class TimeShifts:
    """The seconds by which C cameras took their frames later than the capture says; their mean stays 0."""

    def __init__(self, cameras: int) -> None:
        """Start in step."""
        self.seconds = torch.zeros(cameras)
        self._moments = torch.zeros(cameras)
        self._steps = [0] * cameras

    def of(self, place: int) -> float:
        """Return the shift of a camera in seconds."""
        return float(self.seconds[place])

    def step(self, place: int, dynamic: DynamicSplats[Tensor], rate: float) -> None:
        """Take a step of about `rate` seconds on one camera's shift, by the gradients of the splats that it saw.

        A dynamic splat depends on the moment by its distance from its centre alone. The derivative by the moment is
        therefore that by the centres with the opposite sign, added up.
        """
        towards = dynamic.time_centers.grad
        if towards is None or rate == 0:
            return
        gradient = -towards.sum().cpu().reshape(1)
        self._steps[place] += 1
        own = slice(place, place + 1)
        rmsprop_update(self.seconds[own], gradient, self._moments[own], rate, self._steps[place])
        self.seconds -= self.seconds.mean()

    def state(self) -> dict[str, Any]:
        """Return plain values for a checkpoint."""
        return {"seconds": self.seconds, "moments": self._moments, "steps": self._steps}

    @classmethod
    def restored(cls, state: dict[str, Any]) -> TimeShifts:
        """Return the shifts that `state` described."""
        shifts = cls(len(state["seconds"]))
        shifts.seconds, shifts._moments, shifts._steps = state["seconds"], state["moments"], state["steps"]
        return shifts
