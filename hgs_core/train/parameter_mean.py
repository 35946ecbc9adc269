"""The mean of a set's parameters over the last iterations of a training: Polyak averaging.

After Polyak and Juditsky (1992), whose steps keep their size while the mean comes to rest; of networks, stochastic
weight averaging (Izmailov et al., "Averaging Weights Leads to Wider Optima and Better Generalization", UAI 2018).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import torch
from torch import Tensor

from hgs_core.scene.splats import DynamicSplats, StaticSplats

__all__ = ["ParameterMean"]

S = TypeVar("S", StaticSplats[Tensor], DynamicSplats[Tensor])


@dataclass
class ParameterMean(Generic[S]):
    """The running sums of one set of splats. Rows must stay the same ones: begin anew where they change."""

    sums: S | None = None  # float64; None: of nothing so far
    count: int = 0  # added sets of splats

    def follow(self, splats: S) -> None:
        """Add the splats as they are now."""
        self.count += 1
        if self.sums is None:
            self.sums = splats.map(lambda array: array.detach().to(torch.float64, copy=True))
            return
        for name, array in splats.items():
            getattr(self.sums, name).add_(array.detach())

    def of(self, splats: S) -> S:
        """Return the mean, float32; `splats` themselves if nothing was added yet."""
        return splats if self.sums is None else self.sums.map(lambda array: (array / self.count).float())

    def to(self, device: torch.device) -> ParameterMean[S]:
        """Return it with its sums on a device."""
        return self if self.sums is None else ParameterMean(self.sums.map(lambda a: a.to(device)), self.count)

    def state(self) -> dict[str, Any]:
        """Return plain tensors for a checkpoint."""
        return {"sums": None if self.sums is None else dict(self.sums.items()), "count": self.count}

    @classmethod
    def restored(cls, kind: type[S], state: dict[str, Any]) -> ParameterMean[S]:
        """Return the mean that `state` described, for splats of this kind."""
        return cls(None if state["sums"] is None else kind(**state["sums"]), int(state["count"]))
