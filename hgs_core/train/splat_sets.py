"""Choosing, adding and joining the splats of a set while its optimiser follows."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
import torch
from torch import Tensor

from hgs_core.base.arrays import Mask
from hgs_core.scene.splats import DynamicSplats, StaticSplats
from hgs_core.train.rmsprop import RmsProp

__all__ = ["Mask", "joined", "kept", "rows_of"]

S = TypeVar("S", StaticSplats[Tensor], DynamicSplats[Tensor])


def joined(*sets: S) -> S:
    """Return the rows of all sets, in order, as one set."""
    kind = type(sets[0])
    return kind(*(torch.cat(arrays) for arrays in zip(*((a for _, a in s.items()) for s in sets), strict=True)))


def kept(splats: S, optimiser: RmsProp[S], mask: Mask | None, added: S | None = None) -> S:
    """Return the splats of `mask` [N] (None: all) and then those added, for which the optimiser has no moments yet."""
    rows = torch.arange(len(splats)) if mask is None else rows_of(mask)
    optimiser.select(rows, 0 if added is None else len(added))
    left = splats.take(rows)
    return left if added is None else joined(left, added)


def rows_of(mask: Mask) -> Tensor:
    """Return the indices of the rows that a mask [N] marks."""
    return torch.from_numpy(np.flatnonzero(mask))
