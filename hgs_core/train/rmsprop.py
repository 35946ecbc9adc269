"""RMSprop over a struct of arrays with rows that come and go; a step may see a part of them.

After Tieleman and Hinton, 2012. It is Adam without its first moments: a splat moves in the steps that show it, and in
no other.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import torch
from torch import Tensor

from hgs_core.native import library
from hgs_core.native.rmsprop import rmsprop_step
from hgs_core.render.triton.device import available
from hgs_core.scene.splats import DynamicSplats, StaticSplats

__all__ = ["RmsProp", "rmsprop_update"]

S = TypeVar("S", StaticSplats[Tensor], DynamicSplats[Tensor])

BETA, EPSILON = 0.999, 1e-15


@dataclass
class RmsProp(Generic[S]):
    """The moments of one set of splats: mean squares of the gradients, over the steps that did not show a splat too.

    In a step that does not show a splat its gradient is zero. Its moments then only fall, which is made good when it is
    next shown: what such steps cost does not depend on how many splats there are.
    """

    moments: S
    updated: Tensor  # [N] int64: the step after which the moments of a row are up to date
    steps: int = 0

    @staticmethod
    def of(splats: S) -> RmsProp[S]:
        """Return an optimiser that has seen no gradient of `splats` yet."""
        return RmsProp(splats.map(torch.zeros_like), torch.zeros(len(splats), dtype=torch.int64))

    def step(
        self, splats: S, rates: Mapping[str, float | Tensor], shown: S | None = None, rows: Tensor | None = None
    ) -> None:
        """Update `splats` in place; arrays without a gradient stay.

        Args:
            splats: the parameters.
            rates: a step size per field; or a tensor of them, one for every row or part of a row that was shown.
            shown: the splats that were drawn, with their gradients; None: `splats` themselves.
            rows: [R] int64, which of `splats` these are, none twice; None: all of them.
        """
        self.steps += 1
        seen = splats if shown is None else shown
        decays = self._decays(rows)
        with torch.no_grad():
            for name, parameter in splats.items():
                gradient = getattr(seen, name).grad
                if gradient is not None and len(gradient):
                    moments = getattr(self.moments, name)
                    rmsprop_update(parameter, gradient, moments, rates[name], self.steps, rows=rows, decays=decays)
                getattr(seen, name).grad = None

    def _decays(self, rows: Tensor | None) -> Tensor | None:
        """Return the remaining shares of rows' moments after the steps since their update; None: `BETA` for all."""
        before = self.updated if rows is None else self.updated[rows]
        missed = self.steps - before
        if rows is None:
            self.updated.fill_(self.steps)
            if bool((missed == 1).all()):
                return None
        else:
            self.updated[rows] = self.steps
        return torch.pow(BETA, missed.float())

    def to(self, device: torch.device) -> RmsProp[S]:
        """Return it with its moments on a device."""
        return RmsProp(self.moments.map(lambda a: a.to(device)), self.updated.to(device), self.steps)

    def select(self, rows: Tensor, added: int) -> None:
        """Keep the moments of `rows` and append `added` rows of zeros."""
        self.moments = self.moments.map(lambda a: torch.cat([a[rows], a.new_zeros((added, *a.shape[1:]))]))
        self.updated = torch.cat([self.updated[rows], self.updated.new_full((added,), self.steps)])

    def state(self) -> dict[str, Any]:
        """Return plain tensors for a checkpoint."""
        return {"moments": dict(self.moments.items()), "updated": self.updated, "steps": self.steps}


def rmsprop_update(
    parameter: Tensor,
    gradient: Tensor,
    moments: Tensor,
    rate: float | Tensor,
    step: int,
    *,
    rows: Tensor | None = None,
    decays: Tensor | None = None,
) -> None:
    """Change one array in place by its `step`-th RMSprop update (from 1); its moments follow.

    The gradient is that of `rows` [R] alone, if they are given, and `decays` [R] says what is left of their moments
    (None: `BETA`). The rate is one step size, or a tensor of the gradient's shape but for last dimensions of 1, over
    which it is the same. Float32 arrays on the CPU use the compiled kernel where there is one, those on a CUDA device
    the Triton one.

    Raises:
        ValueError: rates of another shape, or a step below 1.
    """
    if step < 1:
        raise ValueError(f"step counts from 1, got {step}")
    factors, step_size = (_factors(rate, gradient), 1.0) if isinstance(rate, Tensor) else (None, rate)
    correction = 1 - BETA**step
    if parameter.device.type == "cpu" and parameter.dtype == torch.float32 and library.available():
        rmsprop_step(
            parameter.detach().numpy(),
            gradient.contiguous().numpy(),
            moments.numpy(),
            step_size,
            correction,
            beta=BETA,
            epsilon=EPSILON,
            factors=None if factors is None else factors.numpy(),
            rows=None if rows is None else rows.numpy(),
            decays=None if decays is None else decays.numpy(),
        )
        return
    if available(parameter):
        from hgs_core.train.triton.rmsprop import rmsprop_step as rmsprop_step_triton

        rmsprop_step_triton(
            parameter,
            gradient.contiguous(),
            moments,
            step_size,
            correction,
            beta=BETA,
            epsilon=EPSILON,
            factors=factors,
            rows=rows,
            decays=decays,
        )
        return
    row_shape = (-1, *[1] * (gradient.dim() - 1))
    left = BETA if decays is None else decays.to(moments.dtype).reshape(row_shape)
    before = moments if rows is None else moments[rows]
    after = before * left + (1 - BETA) * gradient * gradient
    moved = rate * gradient / ((after / correction).sqrt() + EPSILON)
    if rows is None:
        moments.copy_(after)
        parameter.sub_(moved)
    else:
        moments[rows] = after
        parameter[rows] -= moved


def _factors(rates: Tensor, gradient: Tensor) -> Tensor:
    """Return rates as the kernels take them: one after the other, each for equally many values of the gradient."""
    dimensions = gradient.dim()
    if not any(rates.shape == (*gradient.shape[:k], *[1] * (dimensions - k)) for k in range(dimensions + 1)):
        raise ValueError(f"rates of shape {tuple(rates.shape)} are not for rows of {tuple(gradient.shape)}")
    return rates.to(gradient.dtype).reshape(-1)
