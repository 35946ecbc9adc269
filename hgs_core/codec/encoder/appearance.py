"""Codes of the attributes shared by static and dynamic splats: shape, rotation, opacity, colour."""

from __future__ import annotations

import numpy as np

from hgs_core.base.arrays import Doubles, Whole
from hgs_core.codec.encoder.prepare import PreparedStatics
from hgs_core.codec.encoder.rate_distortion import choose, neighbours
from hgs_core.codec.encoder.rotation_coding import turn_between, vector_to_quats
from hgs_core.codec.encoder.steps import TURN_AGAINST_SCALE, Steps, screen_deviations
from hgs_core.codec.format.quantise import uneased
from hgs_core.scene.rotations import product

__all__ = ["appearance_numbers", "rotation_numbers", "turning_cost"]

COARSEST_ROTATION_ROUNDING = 9  # powers of two by which a rotation's numbers may be rounded more coarsely
THINNEST_AXIS = 1e-3  # share of the blur; thinner axes count as this thick


def appearance_numbers(splats: PreparedStatics, steps: Steps) -> dict[str, Whole]:
    """Return the numbers [N, C] of log_scale, opacity and rgb, in multiples of the chunk's steps."""
    return {
        "log_scale": _scale_numbers(splats, steps),
        "opacity": _plain_numbers(uneased(splats.opacity), steps.opacity, steps.own_opacity, low=1),
        "rgb": _plain_numbers(splats.rgb, steps.rgb, steps.own_rgb, chain=True),
    }


def _plain_numbers(values: Doubles, step: float, own: Doubles, *, low: int | None = None, chain: bool = False) -> Whole:
    exact = values / step
    candidates = neighbours(exact)
    if low is not None:
        candidates = np.maximum(candidates, low)
    cost = (((candidates - exact[:, None]) * (step / own)[:, None, None]) ** 2).sum(axis=2)
    return choose(candidates, cost, chain=chain)


def _scale_numbers(splats: PreparedStatics, steps: Steps) -> Whole:
    """Return multiples of the shape step, chosen among those that differ by about a step once they are blurred.

    An axis much thinner than the blur has few numbers to choose from; a long one has all. Where thin axes decide how
    strong a splat is (antialiasing), numbers beside the plain ones, finely and coarsely, are candidates too.
    """
    log_scales, strength = splats.log_scale, splats.strength_by_scale
    floor = np.log(steps.blur)
    exact = (np.logaddexp(2 * log_scales, 2 * floor) / 2 - floor) / steps.shape  # steps above the blur alone
    candidates = np.maximum(neighbours(exact), 0)
    levels = np.arange(int(candidates.max()) + 1, dtype=np.float64)
    levels[0] = 0.5  # no thickness at all has no logarithm
    blurred = 2 * levels * steps.shape
    numbers = np.rint((floor + (blurred + np.log(-np.expm1(-blurred))) / 2) / steps.shape).astype(np.int64)
    weight = (steps.shape / steps.own_shape)[:, None, None]
    if not strength.any():
        cost = (((candidates - exact[:, None]) * weight) ** 2).sum(axis=2)
        return choose(numbers[candidates], cost, chain=True)
    plain = np.maximum(log_scales, floor + np.log(THINNEST_AXIS)) / steps.shape
    found = neighbours(plain)
    rounded = np.rint(plain).astype(np.int64)
    coarse = []
    for first in (1, 2):  # the axes that are told coarsely: the thinnest, or the two thinner ones
        for k in (2, 4, 8, 16):
            one = rounded.copy()
            one[:, first:] = np.rint(plain[:, first:] / k).astype(np.int64) * k
            coarse.append(one)
    found = np.concatenate([found, np.stack(coarse, axis=1)], axis=1)
    thick = (np.logaddexp(2 * found * steps.shape, 2 * floor) / 2 - floor) / steps.shape
    off = (thick - exact[:, None]) ** 2 + strength[:, None] * (found - plain[:, None]) ** 2
    return choose(found, (off * weight**2).sum(axis=2), chain=True)


def turning_cost(splats: PreparedStatics, turns: Doubles, own_shape: Doubles) -> Doubles:
    """Return the squared errors [N, ...] in squared steps of turning splats about their axes by `turns` [N, ..., 3]."""
    a, b, c = screen_deviations(splats).T
    uneven = np.stack([b / c - c / b, a / c - c / a, a / b - b / a], axis=1) / own_shape[:, None]
    weight = TURN_AGAINST_SCALE * uneven**2 + splats.strength_by_turn / own_shape[:, None] ** 2
    return np.asarray((turns**2 * weight.reshape(len(weight), *(1,) * (turns.ndim - 2), 3)).sum(axis=-1))


def rotation_numbers(splats: PreparedStatics, quats: Doubles, steps: Steps) -> Whole:
    """Return the numbers [N, 3] of the vector parts of canonical quaternions [N, 4].

    Candidates are coarser roundings, the turn about each axis left out (a needle or a disc looks the same however it
    is turned about its own axis), and no rotation at all.
    """
    exact = quats[:, 1:] / steps.rotation
    found = [np.rint(exact / 2**k) * 2**k for k in range(COARSEST_ROTATION_ROUNDING)]
    found.append(np.zeros_like(exact))
    for axis in range(3):
        for k in (2, 4, 6):
            coarse = np.rint(exact)
            coarse[:, axis] = np.rint(exact[:, axis] / 2**k) * 2**k
            found.append(coarse)
        untwisted = _untwisted(quats, axis)[:, 1:] / steps.rotation
        for k in (0, 1, 2, 3, 4, 6):
            rounded = np.rint(untwisted / 2**k) * 2**k
            rounded[:, axis] = 0
            found.append(rounded)
    candidates = np.stack(found, axis=1)
    vectors = candidates * steps.rotation
    inside = (vectors**2).sum(axis=2) < 1 - 1e-6
    decoded = vector_to_quats(np.where(inside[..., None], vectors, 0.0))
    cost = turning_cost(splats, turn_between(quats[:, None], decoded), steps.own_shape)
    # Zero (no rotation) is always inside, so that there is a choice.
    cost = np.where(inside, cost, np.inf)
    return choose(candidates.astype(np.int64), cost)


def _untwisted(quats: Doubles, axis: int) -> Doubles:
    """Return quaternions [N, 4] turned about one of the splat's axes until that component is zero."""
    w, x = quats[:, 0], quats[:, 1 + axis]
    length = np.hypot(w, x)
    twist = np.zeros_like(quats)
    twist[:, 0], twist[:, 1 + axis] = w / length, -x / length
    turned = product(quats, twist)
    return turned * np.where(turned[:, :1] < 0, -1.0, 1.0)
