"""Motion and rotation polynomials of dynamic splats: the least of them that a budget allows, in whole numbers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hgs_core.codec.appearance import rotation_numbers, turning_cost
from hgs_core.codec.attributes import MOTION_ORDERS
from hgs_core.codec.choose import EXCHANGE
from hgs_core.codec.prepare import Prepared
from hgs_core.codec.rotations import canonical, product, turn_between
from hgs_core.codec.steps import Steps
from hgs_core.scene.motion import position as place

__all__ = ["MOMENTS", "Path", "highest_order", "least_squares", "motion_numbers", "turning_numbers"]

MOMENTS = 9  # of a splat's visible life at which errors are weighed and checked
# Steps of the coefficients m1 to m5 in steps of the position. An error of a high order is mostly made good by the
# lower ones, which are fitted after it, and counts most where the splat has faded.
MOTION_STEPS = (3.0, 8.0, 16.0, 32.0, 64.0)
TURNING_STEP = 2.0  # in steps of the rotation
COST_OF_ORDERS = {0: 0.0, 1: 10.0, 2: 18.0, 3: 25.0, 5: 37.0}  # bits, about; these orders can be written
COST_OF_TURNING = 24.0
LARGEST_SHIFT = 3.0  # steps by which a path may be off, faded, where a lower order is worth it

Doubles = NDArray[np.float64]
Whole = NDArray[np.int64]


@dataclass(frozen=True)
class Path:
    """Where splats are and how they are turned over their visible lives."""

    times: Doubles  # [N, MOMENTS] normalised, from the first to the last moment at which the splat is seen
    fade: Doubles  # [N, MOMENTS] opacity over peak opacity
    positions: Doubles  # [N, MOMENTS, 3]
    quats: Doubles  # [N, MOMENTS, 4] unit

    @staticmethod
    def of(splats: Prepared, start: Doubles, end: Doubles) -> Path:
        """Sample the splats between normalised times `start` and `end` [N]."""
        times = start[:, None] + (end - start)[:, None] * np.linspace(0.0, 1.0, MOMENTS)
        d = times - splats.values["time_center"]
        fade = np.exp(-np.exp(splats.values["time_log_precision"]) * d * d)
        names = ("position", *MOTION_ORDERS[: highest_order(splats)])
        motion = np.stack([splats.values[name] for name in names], axis=1)
        d = d[..., None]
        positions = place(motion[:, None], d)
        quats = splats.values["rotation"][:, None] + d * splats.values["turning"][:, None]
        length = np.linalg.norm(quats, axis=2, keepdims=True)
        vanished = length < 1e-12
        quats = np.where(vanished, (1.0, 0.0, 0.0, 0.0), quats / np.where(vanished, 1.0, length))
        return Path(times, fade, positions, quats)

    @property
    def weights(self) -> Doubles:
        """The share [N, MOMENTS] of each moment in what a splat does to the pictures."""
        squares = self.fade**2 + 1e-12
        return np.asarray(squares / squares.sum(axis=1, keepdims=True))


def highest_order(splats: Prepared) -> int:
    """Return the order of the polynomials by which splats move, 3 or 5."""
    return sum(name in splats.values for name in MOTION_ORDERS)


def motion_numbers(
    path: Path, offsets: Doubles, steps: Steps, highest: int = 3
) -> tuple[dict[str, tuple[Whole, float]], Whole]:
    """Fit polynomials in `offsets` [N, MOMENTS] (from the centre, in scaled time), the lowest order that is worth it.

    `highest` is the order, 3 or 5, that none is above.

    Returns:
        position [N, 3] and, for the splats that have them, velocity, acceleration, jerk, snap and crackle, each with
        its step; and the orders [N], 0 to 3 or 5.
    """
    # Relative to the path's middle, so that nothing is lost far from the origin.
    middle = path.positions[:, MOMENTS // 2]
    goal = path.positions - middle[:, None]
    powers = np.stack([offsets**k for k in range(highest + 1)], axis=2)
    tried = [order for order in COST_OF_ORDERS if order <= highest]
    own = steps.own_position[:, None]
    costs = []
    for order in tried:
        fitted = least_squares(powers[..., : order + 1], goal, path.weights)
        error = np.abs(goal - powers[..., : order + 1] @ fitted)
        cost = ((error**2).sum(axis=2) * path.weights).sum(axis=1) / own[:, 0] ** 2
        excess = (error.max(axis=2) * path.fade).max(axis=1) > LARGEST_SHIFT * steps.position
        costs.append(cost + EXCHANGE * COST_OF_ORDERS[order] + np.where(excess & (order < highest), np.inf, 0.0))
    orders = np.array(tried)[np.argmin(np.stack(costs, axis=1), axis=1)]
    numbers: dict[str, tuple[Whole, float]] = {}
    left = goal
    for order in range(highest, 0, -1):
        members = np.flatnonzero(orders >= order)
        if not len(members):
            continue
        step = float(np.float32(MOTION_STEPS[order - 1] * steps.position))
        basis = powers[members]
        leading = np.rint(
            least_squares(basis[..., : order + 1], left[members], path.weights[members])[:, order] / step
        ).astype(np.int64)
        numbers[MOTION_ORDERS[order - 1]] = leading, step
        left = left.copy()
        left[members] -= basis[..., order : order + 1] * (leading * step)[:, None]
    constant = (left * path.weights[..., None]).sum(axis=1) + middle
    numbers["position"] = np.rint(constant / steps.position).astype(np.int64), steps.position
    return numbers, orders


def least_squares(basis: Doubles, goal: Doubles, weights: Doubles) -> Doubles:
    """Return the coefficients [N, K, 3] of weighted least squares of `basis` [N, J, K] to `goal` [N, J, 3].

    Lives so short that the moments cannot tell the orders apart get the least coefficients.
    """
    weighted = np.swapaxes(basis * weights[..., None], 1, 2)
    matrix = weighted @ basis
    ridge = 1e-9 * np.trace(matrix, axis1=1, axis2=2)[:, None, None] * np.eye(basis.shape[2])
    return np.asarray(np.linalg.solve(matrix + ridge, weighted @ goal))


def turning_numbers(
    splats: Prepared, path: Path, shift: Doubles, exponents: NDArray[np.int32], steps: Steps
) -> tuple[dict[str, tuple[Whole, float]], NDArray[np.bool_]]:
    """Decide which splats turn by more than is worth leaving out; `shift` [N, 1] moves the centre in time.

    Returns:
        rotation [N, 3] and, if any splat turns, its turning [M, 4] in scaled time, with steps; and which do, [N].
    """
    rotation = splats.values["rotation"] + shift * splats.values["turning"]
    turning = splats.values["turning"] * np.exp2(-exponents.astype(np.float64))[:, None]
    length = np.linalg.norm(rotation, axis=1, keepdims=True)
    whole = length[:, 0] > 1e-3
    length = np.where(whole[:, None], length, 1.0)
    brightest = path.quats[np.arange(len(rotation)), path.fade.argmax(axis=1)]
    turns = turn_between(brightest[:, None], path.quats)
    cost = (turning_cost(splats, turns, steps.own_shape) * path.weights).sum(axis=1)
    turning_splats = whole & (cost > EXCHANGE * COST_OF_TURNING)
    constant = np.where(turning_splats[:, None], rotation / length, brightest)
    turn, _ = canonical(constant, splats.values["log_scale"])
    constant = product(constant, turn)
    sign = np.where(constant[:, :1] < 0, -1.0, 1.0)
    constant, turning = constant * sign, product(turning / length, turn) * sign
    numbers: dict[str, tuple[Whole, float]] = {"rotation": (rotation_numbers(splats, constant, steps), steps.rotation)}
    if turning_splats.any():
        plain = np.rint(constant[turning_splats, 1:] / steps.rotation).astype(np.int64)
        numbers["rotation"][0][turning_splats] = plain
        step = float(np.float32(TURNING_STEP * steps.rotation))
        numbers["turning"] = np.rint(turning[turning_splats] / step).astype(np.int64), step
    return numbers, turning_splats
