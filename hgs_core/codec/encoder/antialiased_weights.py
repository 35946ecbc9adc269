"""The weights of thin axes in antialiased pictures: a splat shows in proportion to its coverage.

There the opacity is o sqrt(det C0 / det C) (docs/numerics.md, "Antialiasing"): an axis far thinner than a pixel still
decides how strong the splat is, and so does a turn that shows more or less of it. Without antialiasing neither does.
"""

from __future__ import annotations

import numpy as np

from hgs_core.base.arrays import Doubles
from hgs_core.scene.low_pass import LOW_PASS

__all__ = ["strength_weights"]

VIEW_DIRECTIONS = 24  # evenly spread over a half sphere: a splat may be turned in any way
LARGEST_VARIANCE = 1e4  # px^2: wider axes change no more
GOLDEN_ANGLE = np.pi * (3 - np.sqrt(5))


def strength_weights(deviations: Doubles) -> tuple[Doubles, Doubles]:
    """Return how much ln of a splat's strength changes with ln of its deviations and with turns about its axes.

    Args:
        deviations: standard deviations [N, 3] along the splats' axes, pixels.

    Returns:
        The mean over all directions of view of the squared derivatives by ln of each deviation, [N, 3], and by an angle
        about each axis (per radian), [N, 3].
    """
    squares = np.clip(deviations**2, 1e-12, LARGEST_VARIANCE)
    scale, turn = np.zeros_like(squares), np.zeros_like(squares)
    for i in range(VIEW_DIRECTIONS):
        z = (i + 0.5) / VIEW_DIRECTIONS
        angle = GOLDEN_ANGLE * i
        view = np.array([np.sqrt(1 - z * z) * np.cos(angle), np.sqrt(1 - z * z) * np.sin(angle), z])
        seen = view**2
        # Of the ellipse that the ellipsoid throws along `view`: the determinant has a part for each pair of axes.
        pairs = squares[:, (1, 2, 0)] * squares[:, (2, 0, 1)] * seen
        determinant = pairs.sum(axis=1)
        trace = (squares * (1 - seen)).sum(axis=1)
        blurred = determinant + LOW_PASS * trace + LOW_PASS**2
        # ln strength = (ln determinant - ln blurred) / 2
        fade, share = 1 / determinant - 1 / blurred, LOW_PASS / blurred
        by_axis = pairs[:, (1, 2, 0)] + pairs[:, (2, 0, 1)]  # half the derivative of the determinant by ln
        scale += (fade[:, None] * by_axis - share[:, None] * squares * (1 - seen)) ** 2
        # A turn about an axis mixes the other two: the view's components b and c, with derivatives -c and b.
        mixed = (view[[1, 2, 0]] * view[[2, 0, 1]])[None]
        b, c = squares[:, (1, 2, 0)], squares[:, (2, 0, 1)]
        turn += (mixed * (b - c) * (fade[:, None] * squares - share[:, None])) ** 2
    return scale / VIEW_DIRECTIONS, turn / VIEW_DIRECTIONS
