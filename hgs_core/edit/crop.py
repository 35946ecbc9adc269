"""Cropping: which splats lie inside of a box or a ball, moving ones over all of the life in which they are seen."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from hgs_core.base.arrays import Doubles, Floats, Mask
from hgs_core.base.errors import InputError
from hgs_core.edit.regions import Region
from hgs_core.edit.viewed_scene import Edit, ViewedScene, shown_until
from hgs_core.interchange.changes import Action, Change, nonzero
from hgs_core.scene.motion import position, recentred
from hgs_core.scene.splats import DynamicSplats
from hgs_core.scene.temporal import lifetime

__all__ = ["crop", "paths_inside"]

REAL = 1e-7  # imaginary part below which a root is a crossing


def crop(viewed: ViewedScene, region: Region, *, inverse: bool = False, touching: bool = False) -> Edit:
    """Keep the splats with a centre inside `region`, or outside with `inverse`, for as long as they can be seen.

    Splats whose path crosses the border, and those that are never seen, are left out; `touching` keeps the former.

    Raises:
        InputError: nothing would be left.
    """
    scene, where = viewed.scene, f"{'outside' if inverse else 'inside'} of the {region.name}"
    still = region.contains(scene.static.means) != inverse
    keeps: list[Mask] = []
    crossing = unseen = 0
    for number, segment in enumerate(scene.segments):
        always, ever, seen = paths_inside(segment.dynamic, region, segment.normalised(shown_until(scene, number)))
        crosses = ever & ~always
        keeps.append((seen & ~ever if inverse else always) | (crosses & touching))
        crossing, unseen = crossing + int(crosses.sum()), unseen + int((~seen).sum())
    kept = dataclasses.replace(
        scene,
        static=scene.static.take(still),
        segments=tuple(
            dataclasses.replace(segment, dynamic=segment.dynamic.take(keep))
            for segment, keep in zip(scene.segments, keeps, strict=True)
        ),
    )
    total = len(scene.static) + scene.dynamic_splats
    left = len(kept.static) + kept.dynamic_splats
    if left == 0:
        raise InputError(f"--{region.name}", f"no splat of {total:,} stays {where}", "choose another place or size")
    other = 0 if touching else crossing
    return Edit(
        dataclasses.replace(viewed, scene=kept),
        nonzero(
            (
                Change(Action.LEFT_OUT, "splats", total - left - other - unseen, total, f"they are not {where}"),
                Change(Action.LEFT_OUT, "splats", other, total, f"they cross the border of the {region.name}"),
                Change(Action.LEFT_OUT, "splats", unseen, total, "they are never seen"),
            )
        ),
    )


def paths_inside(dynamic: DynamicSplats[Floats], region: Region, until: float) -> tuple[Mask, Mask, Mask]:
    """Return which splats [M] are inside all of the time, which at some time, and which are seen at all.

    The time is that of a splat's life between 0 and `until`, normalised time. Between two moments at which a path
    meets the border it stays on one side of it, so that the moments in between decide, without sampling.
    """
    start, end = lifetime(dynamic)
    start, end = np.maximum(start, 0.0), np.minimum(end, until)
    seen = np.asarray(start <= end)
    offset = np.where(seen, start - dynamic.time_centers, 0.0)
    length = np.where(seen, end - start, 0.0)
    motion = dynamic.motion.astype(np.float64)
    shifted = np.stack(recentred(motion, offset[:, None]), axis=1)
    path = region.local(shifted * (length[:, None] ** np.arange(motion.shape[1]))[..., None])  # time in [0, 1]
    hull = _control_points(path)
    always: Mask = region.holds(hull).all(axis=1)  # type: ignore[assignment]
    never = region.misses(hull.min(axis=1), hull.max(axis=1))
    ever = always.copy()
    for i in np.flatnonzero(seen & ~always & ~never):
        moments = _between_crossings(region.borders(path[i]))
        inside = region.holds(position(path[i], moments[:, None]))
        always[i], ever[i] = inside.all(), inside.any()
    return always & seen, ever & seen, seen


def _control_points(path: Doubles) -> Doubles:
    """Return the Bezier points [M, K, 3] of polynomials [M, K, 3] over [0, 1]: their hull holds the path."""
    degree = path.shape[1] - 1
    rows = [[math.comb(i, j) / math.comb(degree, j) for j in range(degree + 1)] for i in range(degree + 1)]
    return np.asarray(np.einsum("ij,mjc->mic", np.array(rows), path))


def _between_crossings(polynomials: list[Doubles]) -> Doubles:
    """Return a moment in [0, 1] between each two neighbours of all zeros of the polynomials there, and of 0 and 1."""
    zeros = [np.roots(one[::-1]) for one in polynomials]
    found = np.concatenate(zeros)
    real = found.real[np.abs(found.imag) < REAL]
    edges = np.unique(np.concatenate([[0.0, 1.0], real[(real > 0) & (real < 1)]]))
    return np.asarray((edges[1:] + edges[:-1]) / 2)
