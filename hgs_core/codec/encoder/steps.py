"""The quantiser steps of a chunk, and those that each of its splats would have alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hgs_core.base.arrays import Doubles
from hgs_core.codec.encoder.encode_settings import EncodeSettings
from hgs_core.codec.encoder.prepare import PreparedStatics
from hgs_core.codec.encoder.utility import grades
from hgs_core.codec.format.quantise import float32_below, uneased
from hgs_core.scene.low_pass import LOW_PASS

__all__ = [
    "BLUR_DEVIATION",
    "CENTER_STEP",
    "FINEST_SHARE",
    "LARGEST_CENTER_STEP",
    "LARGEST_PRECISION_STEP",
    "PRECISION_STEP",
    "TURN_AGAINST_SCALE",
    "Steps",
    "ideal_position_steps",
    "screen_deviations",
]

BLUR_DEVIATION = 0.1  # pixels of standard deviation: rendering adds more, so thinner axes need not be told apart
# A turn by t between axes of deviations a and b, (a/b - b/a)^2 t^2 / 4, against a change of one axis by e, 3/4 e^2.
TURN_AGAINST_SCALE = 1 / 3
# Per cent of splats that are no longer and thinner than what the rotation's step is made for.
ROTATION_STEP_PERCENTILE = 98.0
FINEST_OPACITY = 2.0**-9
FINEST_ROTATION = 2.0**-13
FINEST_SHARE = 2.0**-21  # a step below this share of a coordinate costs more bits than float32 is worth
# Of the opacity's step. The opacity sigma exp(-s d^2) changes by at most sigma / e for a unit of ln s, and for a unit
# of mu 2^e by at most about 2 sigma.
PRECISION_STEP = 5.0
CENTER_STEP = 1.2
LARGEST_PRECISION_STEP = 0.5
LARGEST_CENTER_STEP = 0.1


def screen_deviations(splats: PreparedStatics) -> Doubles:
    """Return the standard deviations [N, 3] along a splat's axes as the capture shows them, pixels."""
    return np.sqrt(np.exp(2 * splats.log_scale) * splats.scale**2 + LOW_PASS)


def ideal_position_steps(splats: PreparedStatics, settings: EncodeSettings) -> Doubles:
    """Return the step [N] in world units that each splat alone would have: a share of its radius on the screen."""
    radius = 1 / np.sqrt((1 / screen_deviations(splats) ** 2).mean(axis=1))
    width = settings.coarseness / np.sqrt(splats.utility[:, 0])
    pixels = np.minimum(settings.position_step * width * radius, settings.largest_position_step)
    size = np.abs(splats.position).max(axis=1)
    return np.asarray(np.maximum(pixels / splats.scale[:, 0], size * FINEST_SHARE))


@dataclass(frozen=True)
class Steps:
    """Steps of a chunk (float32), and of every splat alone; the latter, "own_*", weigh errors against bits."""

    position: float  # world units
    blur: float  # world units
    shape: float
    rotation: float
    opacity: float  # step of the number that `eased` maps to the opacity
    rgb: float
    own_position: Doubles  # [N]
    own_shape: Doubles
    own_opacity: Doubles
    own_rgb: Doubles

    @staticmethod
    def of(splats: PreparedStatics, settings: EncodeSettings) -> Steps:
        """Derive the steps of a chunk of splats of about one grade: the finest grade counts."""
        utility = splats.utility[:, 0]
        width = settings.coarseness * 2.0 ** -float(grades(utility).max())
        own_width = np.minimum(settings.coarseness / np.sqrt(utility), settings.coarseness * 2.0**6)
        own_position = ideal_position_steps(splats, settings)
        position = splats.position
        finest = max(
            float(np.abs(position).max()) * FINEST_SHARE / 2,
            float((position.max(axis=0) - position.min(axis=0)).max()) * 2.0**-23,
            1e-30,
        )
        s = settings
        own_shape = np.minimum(s.shape_step * own_width, s.largest_shape_step)
        opacity = splats.opacity[:, 0]
        x = uneased(opacity)
        slope = 6 * x * (1 - x) + 1e-3
        own_opacity = np.minimum(s.opacity_step * own_width * (opacity + 1e-3) / slope, s.largest_opacity_step)
        deviations = np.sort(screen_deviations(splats), axis=1)
        uneven = deviations[:, 2] / deviations[:, 0] - deviations[:, 0] / deviations[:, 2]
        strength = splats.strength_by_turn.max(axis=1) / TURN_AGAINST_SCALE
        uneven = np.sqrt(uneven**2 + strength)
        rotation = s.rotation_step / max(float(np.percentile(uneven / own_shape, ROTATION_STEP_PERCENTILE)), 1e-9)
        rotation = min(max(rotation, FINEST_ROTATION), s.largest_rotation_step)
        return Steps(
            position=float32_below(max(float((own_position**-2.0).mean() ** -0.5), finest) * 1.0000002),
            blur=float(np.float32(BLUR_DEVIATION / float(np.median(splats.scale)))),
            shape=float32_below(min(s.shape_step * width, s.largest_shape_step)),
            rotation=float32_below(rotation),
            opacity=float32_below(max(float((own_opacity**-2.0).mean() ** -0.5), FINEST_OPACITY)),
            rgb=float32_below(min(s.rgb_step * width, s.largest_rgb_step)),
            own_position=own_position,
            own_shape=own_shape,
            own_opacity=own_opacity,
            own_rgb=np.minimum(s.rgb_step * own_width, s.largest_rgb_step),
        )
