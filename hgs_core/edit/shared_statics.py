"""Static splats of two takes of one set: drawn together every wall would stand there twice.

Splats of two trainings are never the same, but they lie on the same surfaces and have their colours.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hgs_core.base.arrays import Floats, Mask
from hgs_core.points.neighbours import nearest_neighbours
from hgs_core.scene.opacities import opacities_of
from hgs_core.scene.rows import rows_of
from hgs_core.scene.splats import StaticSplats, joined

__all__ = ["SharedStatics", "shared_statics"]

NEIGHBOURS = 8
LIKE = 0.15  # largest difference of a channel
TOUCHING = 2.0  # sums of largest standard deviations
ONE_SET = 0.5  # least share of matching splats with which both takes show one set
WHOLE_SET = 0.7  # share from which the rest belongs to it, too
SEEN = 0.05  # opacity of splats that tell


@dataclass(frozen=True)
class SharedStatics:
    """The static splats of two scenes, told apart by when each may be shown."""

    always: StaticSplats[Floats]
    first: StaticSplats[Floats]  # shown without the second
    second: StaticSplats[Floats]  # shown without the first
    twice: int  # splats that both have to the bit, of which one is kept

    @property
    def by_time(self) -> int:
        """How many splats are not shown always."""
        return len(self.first) + len(self.second)


def shared_statics(first: StaticSplats[Floats], second: StaticSplats[Floats]) -> SharedStatics:
    """Split the splats of two scenes into a shared set and those of each alone.

    Splats that both have to the bit are kept once. If half of the others of either lie on others of the same colour of
    the other scene, these are shown by time; of a scene with seven tenths such, all its others are.
    """
    again = np.isin(rows_of(second), rows_of(first))
    same = np.isin(rows_of(first), rows_of(second))
    own = second.take(~again)
    lies = _on_the_other(first.take(~same), own)
    shown = (_seen(first.take(~same)), _seen(own))
    shares = [float(part[seen].mean()) if seen.any() else 0.0 for part, seen in zip(lies, shown, strict=True)]
    if max(shares) < ONE_SET:
        return SharedStatics(joined([first, own]), first.take(slice(0, 0)), own.take(slice(0, 0)), int(again.sum()))
    rest = first.take(~same)
    parts = [part | (share >= WHOLE_SET) for part, share in zip(lies, shares, strict=True)]
    always = joined([first.take(same), rest.take(~parts[0]), own.take(~parts[1])])
    return SharedStatics(always, rest.take(parts[0]), own.take(parts[1]), int(again.sum()))


def _seen(splats: StaticSplats[Floats]) -> Mask:
    return np.asarray(opacities_of(splats.opacity_logits) >= SEEN)


def _on_the_other(first: StaticSplats[Floats], second: StaticSplats[Floats]) -> tuple[Mask, Mask]:
    """Return which splats of each scene lie on one of the other that has their colour."""
    both = joined([first, second])
    of_first = np.arange(len(both)) < len(first)
    found = np.zeros(len(both), np.bool_)
    seen = np.flatnonzero(_seen(both))
    if len(seen) > NEIGHBOURS and len(first) and len(second):
        places, rgb = both.means[seen].astype(np.float64), both.rgb[seen].astype(np.float64)
        sizes = np.exp(both.log_scales[seen].astype(np.float64).max(axis=1))
        near = nearest_neighbours(places, NEIGHBOURS)
        away = np.linalg.norm(places[near] - places[:, None], axis=2)
        touches = away <= TOUCHING * (sizes[near] + sizes[:, None])
        alike = np.abs(rgb[near] - rgb[:, None]).max(axis=2) <= LIKE
        other = of_first[seen][near] != of_first[seen][:, None]
        found[seen] = (touches & alike & other).any(axis=1)
    return found[: len(first)], found[len(first) :]
