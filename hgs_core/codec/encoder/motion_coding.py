"""Motion and rotation polynomials of dynamic splats: the least of them that a budget allows, in whole numbers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hgs_core.base.arrays import Doubles, Whole
from hgs_core.codec.encoder.appearance import rotation_numbers, turning_cost
from hgs_core.codec.encoder.prepare import PreparedDynamics
from hgs_core.codec.encoder.rate_distortion import EXCHANGE, choose, neighbours
from hgs_core.codec.encoder.rotation_coding import canonical, turn_between, vector_to_quats
from hgs_core.codec.encoder.steps import Steps
from hgs_core.codec.format.attributes import MOTION_ORDERS
from hgs_core.codec.format.quantise import float32_below
from hgs_core.scene.motion import position as place
from hgs_core.scene.polynomials import polynomial_fit, powers
from hgs_core.scene.rotations import product

__all__ = ["CHECKED_MOMENTS", "Path", "highest_order", "motion_numbers", "turning_numbers"]

CHECKED_MOMENTS = 9  # moments of a visible life with weighed and checked errors
ORDER_COST_BITS = {0: 0.0, 1: 16.0, 2: 32.0, 3: 48.0, 5: 80.0}  # bits, about; these orders can be written
COST_OF_TURNING = 24.0
LARGEST_PATH_SHIFT = 3.0  # steps by which a path may be off, faded, where a lower order is worth it
LARGEST_PATH_ERROR = 7.9  # steps by which all that is left out and rounded may shift it: 8 are an error of the encoder
COARSEST_COEFFICIENT_ROUNDING = 6  # powers of two by which coefficients may be rounded more coarsely
NEAR_ROUNDINGS = 27 + 2  # roundings within a few steps
LARGEST_TURN_MISFIT = 1.0  # squared steps by which a turn may miss its path
LEAST_QUATERNION_W = 0.2  # least w of a quaternion coded as vector part over w
LEAST_INDEPENDENT_SHARE = 1e-6  # least share of a coefficient that lower ones cannot represent
CONJUGATE = (1.0, -1.0, -1.0, -1.0)


@dataclass(frozen=True)
class Path:
    """Where splats are and how they are turned over their visible lives."""

    times: Doubles  # [N, CHECKED_MOMENTS] normalised, from the first to the last moment at which the splat is seen
    fade: Doubles  # [N, CHECKED_MOMENTS] opacity over peak opacity
    positions: Doubles  # [N, CHECKED_MOMENTS, 3]
    quats: Doubles  # [N, CHECKED_MOMENTS, 4] unit

    @staticmethod
    def of(splats: PreparedDynamics, start: Doubles, end: Doubles) -> Path:
        """Sample the splats between normalised times `start` and `end` [N]."""
        times = start[:, None] + (end - start)[:, None] * np.linspace(0.0, 1.0, CHECKED_MOMENTS)
        d = times - splats.time_center
        fade = np.exp(-np.exp(splats.time_log_precision) * d * d)
        d = d[..., None]
        positions = place(splats.motion[:, None], d)
        quats = splats.rotation[:, None] + d * splats.turning[:, None]
        length = np.linalg.norm(quats, axis=2, keepdims=True)
        vanished = length < 1e-12
        quats = np.where(vanished, (1.0, 0.0, 0.0, 0.0), quats / np.where(vanished, 1.0, length))
        return Path(times, fade, positions, quats)

    @property
    def weights(self) -> Doubles:
        """The share [N, CHECKED_MOMENTS] of each moment in a splat's effect on the pictures."""
        squares = self.fade**2 + 1e-12
        return np.asarray(squares / squares.sum(axis=1, keepdims=True))


def highest_order(splats: PreparedDynamics) -> int:
    """Return the order of the polynomials by which splats move, 3 or 5."""
    return int(splats.motion.shape[1]) - 1


def motion_numbers(
    path: Path, offsets: Doubles, steps: Steps, highest: int = 3
) -> tuple[dict[str, tuple[Whole, float]], Whole]:
    """Fit polynomials in `offsets` [N, 9] (from the centre, in scaled time), of the lowest order that is worth it.

    `highest` is the order, 3 or 5, that none is above.

    Returns:
        position [N, 3] and, for the splats that have them, velocity, acceleration, jerk, snap and crackle, each with
        its step; and the orders [N], 0 to 3 or 5.
    """
    # Each coefficient alone may shift a path by `LARGEST_PATH_SHIFT`, which can add up to more than is allowed.
    careful = np.zeros(len(offsets), bool)
    while True:
        numbers, orders, errors = _motion_numbers(path, offsets, steps, highest, careful)
        worse = (errors > LARGEST_PATH_ERROR * steps.position) & ~careful
        if not worse.any():
            return numbers, orders
        careful |= worse


def _motion_numbers(
    path: Path, offsets: Doubles, steps: Steps, highest: int, careful: NDArray[np.bool_]
) -> tuple[dict[str, tuple[Whole, float]], Whole, Doubles]:
    """Do the same, and return by how much paths are off [N], faded.

    Splats that are `careful` [N] have the highest order and the nearest whole numbers.
    """
    # Relative to the path's middle, so that nothing is lost far from the origin.
    middle = path.positions[:, CHECKED_MOMENTS // 2]
    goal = path.positions - middle[:, None]
    basis = powers(offsets, highest)
    orders = _cheapest_orders(path, offsets, goal, steps, highest, careful)
    numbers: dict[str, tuple[Whole, float]] = {}
    residual = goal.copy()
    for order in range(highest, 0, -1):
        subset = np.flatnonzero(orders >= order)
        if len(subset):
            found, step = _coefficient(path, offsets, residual, steps, order, subset, careful)
            numbers[MOTION_ORDERS[order - 1]] = found, step
            residual[subset] -= basis[subset, :, order, None] * (found * step)[:, None]
    constant = (residual * path.weights[..., None]).sum(axis=1) + middle
    whole = np.rint(constant / steps.position).astype(np.int64)
    numbers["position"] = whole, steps.position
    error = residual + (middle - whole * steps.position)[:, None]
    return numbers, orders, (np.abs(error).max(axis=2) * path.fade).max(axis=1)


def _cheapest_orders(
    path: Path, offsets: Doubles, goal: Doubles, steps: Steps, highest: int, careful: NDArray[np.bool_]
) -> Whole:
    """Return the orders [N] with the least sum of squared errors and of bits."""
    basis = powers(offsets, highest)
    tried = [order for order in ORDER_COST_BITS if order <= highest]
    costs = []
    for order in tried:
        fitted = polynomial_fit(offsets, order, goal, path.weights)
        error = np.abs(goal - basis[..., : order + 1] @ fitted)
        cost = ((error**2).sum(axis=2) * path.weights).sum(axis=1) / steps.own_position**2
        excess = (error.max(axis=2) * path.fade).max(axis=1) > LARGEST_PATH_SHIFT * steps.position
        refused = (excess | careful) & (order < highest)
        costs.append(cost + EXCHANGE * ORDER_COST_BITS[order] + np.where(refused, np.inf, 0.0))
    return np.asarray(np.array(tried)[np.argmin(np.stack(costs, axis=1), axis=1)])


def _coefficient(
    path: Path,
    offsets: Doubles,
    residual: Doubles,
    steps: Steps,
    order: int,
    subset: NDArray[np.intp],
    careful: NDArray[np.bool_],
) -> tuple[Whole, float]:
    """Return the whole numbers [M, 3] of one coefficient of a subset of splats, and their step."""
    times, weights, fade = offsets[subset], path.weights[subset], path.fade[subset]
    own = steps.own_position[subset]
    independent_part = _independent_part(times, order, weights)
    share = np.sqrt((independent_part**2 * weights).sum(axis=1)) + LEAST_INDEPENDENT_SHARE
    reach = (np.abs(independent_part) * fade).max(axis=1) + LEAST_INDEPENDENT_SHARE
    step = _coefficient_step(own / share, LARGEST_PATH_SHIFT * steps.position / reach)
    exact = polynomial_fit(times, order, residual[subset], weights)[:, order] / step
    candidates = _roundings(exact)
    error = (candidates - exact[:, None]) * step
    cost = ((error * (share / own)[:, None, None]) ** 2).sum(axis=2)
    too_far = np.abs(error).max(axis=2) * reach[:, None] > LARGEST_PATH_SHIFT * steps.position
    too_far |= careful[subset, None]
    too_far[:, 0] = False
    return choose(candidates, np.where(too_far, np.inf, cost)), step


def _coefficient_step(own: Doubles, largest: Doubles) -> float:
    """Return the step of a coefficient that splats alone would have as `own` [M] and at most as `largest` [M]."""
    return float32_below(min(float((own**-2.0).mean() ** -0.5), float(largest.min())))


def _roundings(exact: Doubles) -> Whole:
    """Return whole numbers [M, K, 3] near `exact` [M, 3], the nearest first, then its neighbours and coarser ones."""
    coarse = [np.rint(exact / 2**k) * 2**k for k in range(1, COARSEST_COEFFICIENT_ROUNDING)]
    return np.concatenate(
        [neighbours(exact), np.stack([*coarse, np.zeros_like(exact)], axis=1).astype(np.int64)], axis=1
    )


def _independent_part(offsets: Doubles, order: int, weights: Doubles) -> Doubles:
    """Return the part [M, J] of a power of `offsets` [M, J] that lower powers cannot represent."""
    # Relative to their middle: there the power differs by lower ones alone, and nothing is lost far from the centre.
    near = offsets - offsets.mean(axis=1, keepdims=True)
    power = near[..., None] ** order
    return np.asarray((power - powers(near, order - 1) @ polynomial_fit(near, order - 1, power, weights))[..., 0])


def turning_numbers(
    splats: PreparedDynamics, path: Path, offsets: Doubles, shift: Doubles, exponents: NDArray[np.int32], steps: Steps
) -> tuple[dict[str, tuple[Whole, float]], NDArray[np.bool_]]:
    """Decide which splats turn by more than is worth leaving out; `shift` [N, 1] moves the centre in time.

    A turn is fitted with a coefficient r1 whose w is 0: the vector part over w is then linear in `offsets` (as of
    `motion_numbers`), and what r1 has along r0 would only change how fast a splat turns within its life. Splats that
    turn too far for that keep their own coefficients.

    Returns:
        rotation [N, 3] and, if any splat turns, its turning [M, 4] in scaled time, with steps; and which do, [N].
    """
    still, quats = _still(splats, path)
    slopes = quats[..., 1:] / np.maximum(quats[..., :1], LEAST_QUATERNION_W)
    fitted = polynomial_fit(offsets, 1, slopes, path.weights)  # [N, 2, 3]
    cost = _turned_cost(splats, quats, still[:, None], path.weights, steps)
    turned = _turned_cost(splats, quats, _unit(powers(offsets, 1) @ fitted), path.weights, steps)
    far = (turned > LARGEST_TURN_MISFIT) & (cost > LARGEST_TURN_MISFIT + EXCHANGE * COST_OF_TURNING)
    turns = far | (turned + EXCHANGE * COST_OF_TURNING < cost)
    rotation = rotation_numbers(splats, still, steps)
    numbers: dict[str, tuple[Whole, float]] = {"rotation": (rotation, steps.rotation)}
    if not turns.any():
        return numbers, turns
    some, weights, own_shape = splats.take(turns), path.weights[turns], steps.own_shape[turns]
    offset = offsets[turns]
    w = 1 / np.sqrt(1 + (fitted[turns, 0] ** 2).sum(axis=1))[:, None]
    rest = _independent_part(offset, 1, weights)
    share = np.sqrt((rest**2 * weights).sum(axis=1)) + LEAST_INDEPENDENT_SHARE
    step = float32_below(steps.rotation * float((share**2).mean() ** -0.5))
    exact = fitted[turns, 1] * w / step
    candidates = _roundings(exact)
    off = np.zeros((*candidates.shape[:2], 4))
    off[..., 1:] = (candidates - exact[:, None]) * (step * share)[:, None, None]
    angles = 2 * product((still[turns] * CONJUGATE)[:, None], off)[..., 1:]
    chosen = choose(candidates, turning_cost(some, angles, own_shape))
    left = slopes[turns] - offset[..., None] * (chosen * step / w)[:, None]
    constant = _unit((left * weights[..., None]).sum(axis=1))
    rows = np.concatenate([np.zeros((len(chosen), 1), np.int64), chosen], axis=1)
    if far.any():
        constant[far[turns]], turning = _own_turn(splats.take(far), shift[far], exponents[far])
        rows[far[turns]] = np.rint(turning / step).astype(np.int64)
    # What does not show of a rotation must yet be near it, since the turn goes on from there.
    exact = constant[:, 1:] / steps.rotation
    candidates = _roundings(exact)[:, :NEAR_ROUNDINGS]
    vectors = candidates * steps.rotation
    inside = (vectors**2).sum(axis=2) < 1 - 1e-6
    angles = turn_between(constant[:, None], vector_to_quats(np.where(inside[..., None], vectors, 0.0)))
    rotation[turns] = choose(candidates, np.where(inside, turning_cost(some, angles, own_shape), np.inf))
    return numbers | {"turning": (rows, step)}, turns


def _still(splats: PreparedDynamics, path: Path) -> tuple[Doubles, Doubles]:
    """Return how splats are turned when they are brightest [N, 4], and near to that at all moments [N, 9, 4]."""
    brightest = path.quats[np.arange(len(path.quats)), path.fade.argmax(axis=1)]
    turn, _ = canonical(brightest, splats.log_scale)
    still = product(brightest, turn)
    still = still * np.where(still[:, :1] < 0, -1.0, 1.0)
    quats = product(path.quats, turn[:, None])
    return still, quats * np.where((quats * still[:, None]).sum(axis=2, keepdims=True) < 0, -1.0, 1.0)


def _own_turn(splats: PreparedDynamics, shift: Doubles, exponents: NDArray[np.int32]) -> tuple[Doubles, Doubles]:
    """Return unit r0 and r1 ([M, 4], [M, 4]) in scaled time as the splats have them."""
    rotation = splats.rotation + shift * splats.turning
    turning = splats.turning * np.exp2(-exponents.astype(np.float64))[:, None]
    length = np.maximum(np.linalg.norm(rotation, axis=1, keepdims=True), 1e-3)
    turn, _ = canonical(rotation / length, splats.log_scale)
    rotation, turning = product(rotation / length, turn), product(turning / length, turn)
    sign = np.where(rotation[:, :1] < 0, -1.0, 1.0)
    return rotation * sign, turning * sign


def _unit(slopes: Doubles) -> Doubles:
    """Return the unit quaternions [..., 4] of which the vector part over w is `slopes` [..., 3]."""
    quats = np.concatenate([np.ones_like(slopes[..., :1]), slopes], axis=-1)
    return np.asarray(quats / np.linalg.norm(quats, axis=-1, keepdims=True))


def _turned_cost(splats: PreparedDynamics, quats: Doubles, others: Doubles, weights: Doubles, steps: Steps) -> Doubles:
    """Return the squared errors [N], in squared steps, of turning as `others` say instead of `quats` [N, J, 4]."""
    turns = turn_between(quats, others)
    return np.asarray((turning_cost(splats, turns, steps.own_shape) * weights).sum(axis=1))
