"""Changes before quantisation that no picture shows; everything after keeps error bounds."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from hgs_core.base.arrays import Doubles
from hgs_core.base.errors import InputError
from hgs_core.codec.encoder.antialiased_weights import strength_weights
from hgs_core.codec.encoder.encode_settings import EncodeSettings
from hgs_core.codec.encoder.rotation_coding import canonical
from hgs_core.codec.encoder.utility import SetUtility, estimated_utility, pixels_per_unit
from hgs_core.scene.camera import Camera
from hgs_core.scene.motion import position as place
from hgs_core.scene.opacities import opacities_of
from hgs_core.scene.rotations import product, unit_quaternions, units_and_norms
from hgs_core.scene.splat_limits import LARGEST_COLOUR, LARGEST_COORDINATE, LARGEST_LOG_SCALE
from hgs_core.scene.splats import DynamicSplats, StaticSplats
from hgs_core.scene.temporal import lifetime

__all__ = ["PreparedDynamics", "PreparedStatics", "prepare_dynamic", "prepare_static"]

LARGEST_TIME = 1000.0  # |mu|, in lengths of the segment
LEAST_UTILITY = 1e-4  # splats below have the steps of this utility
NEGLIGIBLE_OPACITY = 1 / 255  # below it no pixel is touched
STEADY_LOG_OPACITY = 1e-4  # a splat whose ln(opacity) changes less than this in its segment does not fade
MEANINGFUL_INFINITIES = {
    "log_scales": (-math.inf,),  # no thickness
    "opacity_logits": (-math.inf, math.inf),  # opacities of 0 and 1
    "time_log_precisions": (-math.inf, math.inf),  # no fading, no duration
}


@dataclass(frozen=True)
class PreparedStatics:
    """N splats in float64 with unit rotations, and the facts that their steps depend on."""

    row: Doubles  # [N, 1] place among the splats that were prepared
    position: Doubles  # [N, 3] world units; of dynamic splats the motion's constant
    rotation: Doubles  # [N, 4]
    log_scale: Doubles  # [N, 3]
    opacity: Doubles  # [N, 1]
    rgb: Doubles  # [N, 3]
    utility: Doubles  # [N, 1] (`utility.py`)
    scale: Doubles  # [N, 1] pixels per world unit
    strength_by_scale: Doubles  # [N, 3] zeros without antialiasing (`antialiased_weights.py`)
    strength_by_turn: Doubles  # [N, 3] zeros without antialiasing

    def __len__(self) -> int:
        """Return the number of splats."""
        return len(self.position)

    def take(self, index: NDArray[Any]) -> Self:
        """Return the splats that `index` selects."""
        chosen = {field.name: getattr(self, field.name)[index] for field in dataclasses.fields(self)}
        return dataclasses.replace(self, **chosen)


@dataclass(frozen=True)
class PreparedDynamics(PreparedStatics):
    """Moving splats, in the normalised time of their segment."""

    motion: Doubles  # [N, K, 3] coefficients, constant first; K is 4 or 6
    turning: Doubles  # [N, 4] derivative of the rotation
    time_center: Doubles  # [N, 1]
    time_log_precision: Doubles  # [N, 1]


P = TypeVar("P", bound=PreparedStatics)


@dataclass(frozen=True)
class _Sizing:
    """The views that size splats, and the least utility that keeps them."""

    points: Doubles  # [N, 3] places at which the cameras see the splats
    cameras: Sequence[Camera]
    utility: SetUtility | None  # None: guessed
    shown: Doubles | float  # share of the time for which a splat shows
    prune: float
    antialiased: bool


def prepare_static(
    splats: StaticSplats[NDArray[np.floating[Any]]],
    cameras: Sequence[Camera],
    utility: SetUtility | None,
    settings: EncodeSettings,
    *,
    antialiased: bool = False,
) -> PreparedStatics:
    """Drop splats that show too little, name the axes canonically, limit scales; guess utilities if `utility` is None.

    Raises:
        InputError: a number that is not finite or too large; names the splat and the field.
    """
    _check("static splat", splats.items())
    position = np.asarray(splats.means, np.float64)
    _check_size("static splat", "means", position, LARGEST_COORDINATE)
    quats = unit_quaternions(splats.quats)
    turn, log_scale = canonical(quats, _log_scale(splats.log_scales))
    quats = product(quats, turn)
    common = _common(splats.opacity_logits, splats.rgb)
    rotation = quats * np.where(quats[:, :1] < 0, -1.0, 1.0)
    sizing = _Sizing(position, cameras, utility, 1.0, settings.prune, antialiased)
    measured = _measured(log_scale, common["opacity"][:, 0], sizing)
    splats_of_set = PreparedStatics(position=position, rotation=rotation, log_scale=log_scale, **common, **measured)
    return _kept(splats_of_set, sizing, settings)


def prepare_dynamic(
    splats: DynamicSplats[NDArray[np.floating[Any]]],
    shown_until: float,
    frame: float,
    cameras: Sequence[Camera],
    utility: SetUtility | None,
    settings: EncodeSettings,
    *,
    antialiased: bool = False,
) -> PreparedDynamics:
    """Do the same for the splats of a segment that is shown for normalised times [0, `shown_until`].

    Splats that do not live then are dropped. `frame` is the interval between frames in normalised time.

    Raises:
        InputError: a number that is not finite or too large; names the splat and the field.
    """
    _check("dynamic splat", splats.items())
    start, end = lifetime(splats)
    motion = np.asarray(splats.motion, np.float64)
    rotation, turning = _rotation_polynomial(np.asarray(splats.rotation, np.float64))
    turn, log_scale = canonical(rotation, _log_scale(splats.log_scales))
    rotation, turning = product(rotation, turn), product(turning, turn)
    center = np.asarray(splats.time_centers, np.float64)[:, None]
    furthest = np.maximum(np.abs(center), np.abs(shown_until - center))
    with np.errstate(divide="ignore"):
        steady = np.log(STEADY_LOG_OPACITY) - 2 * np.log(furthest)
    briefest = math.log(math.log(255.0)) - 2 * math.log(settings.shortest_life * frame)
    precision = np.asarray(splats.time_log_precisions, np.float64)[:, None]
    precision = np.clip(precision, np.minimum(steady, briefest), briefest)
    alive = (start <= shown_until) & (end >= 0)
    living = alive[:, None]
    _check_size("dynamic splat", "time_centers", np.where(living, center, 0.0), LARGEST_TIME)
    for order in range(motion.shape[1]):
        reach = motion[:, order] * np.maximum(1.0, furthest) ** order
        _check_size("dynamic splat", "motion", np.where(living, reach, 0.0), LARGEST_COORDINATE)
    common = {name: array[alive] for name, array in _common(splats.opacity_logits, splats.rgb).items()}
    motion, center, log_scale = motion[alive], center[alive], log_scale[alive]
    start, end = np.clip(start[alive], 0, shown_until), np.clip(end[alive], 0, shown_until)
    midway = ((start + end) / 2)[:, None] - center
    share = (end - start) / max(shown_until, 1e-9) / 3  # it is brightest for about a third of its life
    known = None if utility is None else utility.take(alive)
    sizing = _Sizing(place(motion, midway), cameras, known, share, settings.prune_dynamic, antialiased)
    prepared = PreparedDynamics(
        position=motion[:, 0],
        rotation=rotation[alive],
        log_scale=log_scale,
        motion=motion,
        turning=turning[alive],
        time_center=center,
        time_log_precision=precision[alive],
        **common,
        **_measured(log_scale, common["opacity"][:, 0], sizing),
    )
    return _kept(prepared, sizing, settings)


def _measured(log_scale: Doubles, opacity: Doubles, sizing: _Sizing) -> dict[str, Doubles]:
    """Return utility, scale and, still zero, the strengths of antialiasing by field."""
    points = sizing.points
    scale = pixels_per_unit(points, sizing.cameras) if len(points) else np.zeros(0)
    if sizing.utility is None:
        known = estimated_utility(log_scale, opacity, scale, sizing.shown)
    else:
        known = sizing.utility.shown
    none = np.zeros_like(log_scale)
    return {
        "utility": np.maximum(known, LEAST_UTILITY)[:, None],
        "scale": scale[:, None],
        "strength_by_scale": none,
        "strength_by_turn": none,
    }


def _kept(splats: P, sizing: _Sizing, settings: EncodeSettings) -> P:
    """Drop splats that show too little, and add the strengths of antialiasing."""
    kept = splats.opacity[:, 0] >= NEGLIGIBLE_OPACITY
    if sizing.utility is not None:
        kept &= sizing.utility.missed >= sizing.prune * settings.coarseness**2
    splats = splats.take(kept)
    if not sizing.antialiased:
        return splats
    by_scale, by_turn = strength_weights(np.exp(splats.log_scale) * splats.scale)
    return dataclasses.replace(splats, strength_by_scale=by_scale, strength_by_turn=by_turn)


def _log_scale(log_scales: NDArray[Any]) -> Doubles:
    return np.minimum(np.asarray(log_scales, np.float64), LARGEST_LOG_SCALE)


def _common(logits: NDArray[Any], rgb: NDArray[Any]) -> dict[str, Doubles]:
    """Return opacity, colour and row by field."""
    return {
        "opacity": opacities_of(logits)[:, None],
        "rgb": np.clip(np.asarray(rgb, np.float64), -LARGEST_COLOUR, LARGEST_COLOUR),
        "row": np.arange(len(rgb), dtype=np.float64)[:, None],
    }


def _rotation_polynomial(rotation: Doubles) -> tuple[Doubles, Doubles]:
    """Scale r0 + d r1 so that r0 is a unit quaternion; r1 alone where r0 is next to nothing beside it.

    The scale and the sign of a quaternion do not change its rotation. Where |r0| < |r1| / 1000 the rotation is that of
    r1 at all times but for an instant around d = 0.
    """
    swapped = np.linalg.norm(rotation[:, 0], axis=1) < 1e-3 * np.linalg.norm(rotation[:, 1], axis=1)
    constant = np.where(swapped[:, None], rotation[:, 1], rotation[:, 0])
    linear = np.where(swapped[:, None], 0.0, rotation[:, 1])
    unit, norm = units_and_norms(constant)
    return unit, linear / norm


def _check(what: str, fields: Any) -> None:
    for name, array in fields:
        if len(array) == 0:
            return
        numbers = np.asarray(array).reshape(len(array), -1)
        valid = np.isfinite(numbers) | np.isin(numbers, MEANINGFUL_INFINITIES.get(name, ()))
        if not valid.all():
            splat = int(np.argmin(valid.all(axis=1)))
            raise InputError(f"{what} {splat}", f"{name} is not a finite number", "train the scene again")


def _check_size(what: str, field: str, values: Doubles, largest: float) -> None:
    size = np.abs(values).max(axis=1, initial=0.0)
    if (size > largest).any():
        splat = int(np.argmax(size))
        raise InputError(f"{what} {splat}", f"{field} reaches {size[splat]:.3g}, more than {largest:.0e}")
