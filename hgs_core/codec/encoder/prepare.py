"""Changes before quantisation that no picture shows; everything after keeps error bounds."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hgs_core.base.arrays import Doubles
from hgs_core.base.errors import InputError
from hgs_core.codec.encoder.antialiased_weights import strength_weights
from hgs_core.codec.encoder.encode_settings import EncodeSettings
from hgs_core.codec.encoder.rotation_coding import canonical
from hgs_core.codec.encoder.utility import SetUtility, estimated_utility, pixels_per_unit
from hgs_core.codec.format.attributes import MOTION_ORDERS
from hgs_core.scene.camera import Camera
from hgs_core.scene.motion import position as place
from hgs_core.scene.opacities import opacities_of
from hgs_core.scene.rotations import product, unit_quaternions, units_and_norms
from hgs_core.scene.splat_limits import LARGEST_COLOUR, LARGEST_COORDINATE, LARGEST_LOG_SCALE
from hgs_core.scene.splats import DynamicSplats, StaticSplats
from hgs_core.scene.temporal import lifetime

__all__ = ["Prepared", "prepare_dynamic", "prepare_static"]

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
class Prepared:
    """Splats as float64 arrays by attribute name ("position" [N, 3], "opacity" [N, 1], ...), with unit rotations.

    Beside what is stored there are "row" [N, 1], the splat's place among those that were prepared, "utility" [N, 1] and
    "scale" [N, 1], pixels per world unit (`weights.py`), and "strength_by_scale" and "strength_by_turn" [N, 3]
    (`antialiasing.py`), zeros where nothing is antialiased. A dynamic set also has the motion polynomial's "velocity",
    "acceleration", "jerk" [N, 3] and "turning" [N, 4], in normalised time; a set of the fifth
    order "snap" and "crackle" [N, 3], too.
    """

    values: Mapping[str, Doubles]

    def __len__(self) -> int:
        """Return the number of splats."""
        return len(self.values["position"])

    def take(self, index: NDArray[Any]) -> Prepared:
        """Return the splats that `index` selects."""
        return Prepared({name: array[index] for name, array in self.values.items()})


def prepare_static(
    splats: StaticSplats[NDArray[np.floating[Any]]],
    cameras: Sequence[Camera],
    utility: SetUtility | None,
    settings: EncodeSettings,
    *,
    antialiased: bool = False,
) -> Prepared:
    """Drop splats that show too little, name the axes canonically, limit scales; guess utilities if `utility` is None.

    Raises:
        InputError: a number that is not finite or too large; names the splat and the field.
    """
    _check("static splat", splats.items())
    values = _common(splats.log_scales, splats.opacity_logits, splats.rgb)
    values["position"] = np.asarray(splats.means, np.float64)
    _check_size("static splat", "means", values["position"], LARGEST_COORDINATE)
    quats = unit_quaternions(splats.quats)
    turn, values["log_scale"] = canonical(quats, values["log_scale"])
    quats = product(quats, turn)
    values["rotation"] = quats * np.where(quats[:, :1] < 0, -1.0, 1.0)
    return _weighed(values, values["position"], cameras, utility, 1.0, settings.prune, settings, antialiased)


def prepare_dynamic(
    splats: DynamicSplats[NDArray[np.floating[Any]]],
    shown_until: float,
    frame: float,
    cameras: Sequence[Camera],
    utility: SetUtility | None,
    settings: EncodeSettings,
    *,
    antialiased: bool = False,
) -> Prepared:
    """Do the same for the splats of a segment that is shown for normalised times [0, `shown_until`].

    Splats that do not live then are dropped. `frame` is the interval between frames in normalised time.

    Raises:
        InputError: a number that is not finite or too large; names the splat and the field.
    """
    _check("dynamic splat", splats.items())
    start, end = lifetime(splats)
    values = _common(splats.log_scales, splats.opacity_logits, splats.rgb)
    motion = np.asarray(splats.motion, np.float64)
    rotation, turning = _rotation_polynomial(np.asarray(splats.rotation, np.float64))
    turn, values["log_scale"] = canonical(rotation, values["log_scale"])
    center = np.asarray(splats.time_centers, np.float64)[:, None]
    values |= {
        "position": motion[:, 0],
        **{name: motion[:, order] for order, name in enumerate(MOTION_ORDERS[: motion.shape[1] - 1], start=1)},
        "rotation": product(rotation, turn),
        "turning": product(turning, turn),
        "time_center": center,
    }
    furthest = np.maximum(np.abs(center), np.abs(shown_until - center))
    with np.errstate(divide="ignore"):
        steady = np.log(STEADY_LOG_OPACITY) - 2 * np.log(furthest)
    briefest = math.log(math.log(255.0)) - 2 * math.log(settings.shortest_life * frame)
    precision = np.asarray(splats.time_log_precisions, np.float64)[:, None]
    values["time_log_precision"] = np.clip(precision, np.minimum(steady, briefest), briefest)
    alive = (start <= shown_until) & (end >= 0)
    living = alive[:, None]
    _check_size("dynamic splat", "time_centers", np.where(living, center, 0.0), LARGEST_TIME)
    for order in range(motion.shape[1]):
        reach = motion[:, order] * np.maximum(1.0, furthest) ** order
        _check_size("dynamic splat", "motion", np.where(living, reach, 0.0), LARGEST_COORDINATE)
    values = {name: array[alive] for name, array in values.items()}
    start, end = np.clip(start[alive], 0, shown_until), np.clip(end[alive], 0, shown_until)
    midway = ((start + end) / 2)[:, None] - values["time_center"]
    halfway = place(motion[alive], midway)
    share = (end - start) / max(shown_until, 1e-9) / 3  # it is brightest for about a third of its life
    known = None if utility is None else utility.take(alive)
    return _weighed(values, halfway, cameras, known, share, settings.prune_dynamic, settings, antialiased)


def _weighed(
    values: dict[str, Doubles],
    points: Doubles,
    cameras: Sequence[Camera],
    utility: SetUtility | None,
    shown: Doubles | float,
    prune: float,
    settings: EncodeSettings,
    antialiased: bool,
) -> Prepared:
    """Add utility, scale and antialiased shapes, and drop splats that show too little."""
    opacity = values["opacity"][:, 0]
    scale = pixels_per_unit(points, cameras) if len(points) else np.zeros(0)
    kept = opacity >= NEGLIGIBLE_OPACITY
    if utility is None:
        known = estimated_utility(values["log_scale"], opacity, scale, shown)
    else:
        known = utility.shown
        kept &= utility.missed >= prune * settings.coarseness**2
    values["utility"] = np.maximum(known, LEAST_UTILITY)[:, None]
    values["scale"] = scale[:, None]
    values = {name: array[kept] for name, array in values.items()}
    none = np.zeros_like(values["log_scale"])
    values["strength_by_scale"], values["strength_by_turn"] = (
        strength_weights(np.exp(values["log_scale"]) * values["scale"]) if antialiased else (none, none)
    )
    return Prepared(values)


def _common(log_scales: NDArray[Any], logits: NDArray[Any], rgb: NDArray[Any]) -> dict[str, Doubles]:
    return {
        "log_scale": np.minimum(np.asarray(log_scales, np.float64), LARGEST_LOG_SCALE),
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
