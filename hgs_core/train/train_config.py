"""How a training goes; free of torch, so that the API can validate it."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from typing import Any

from hgs_core.base.config_fields import Range, check_fields
from hgs_core.train.density_config import DensityConfig

__all__ = ["MOVING_FROM", "LabelConfig", "LearningRates", "TrainConfig"]

MOVING_FROM = 0.3
"""Share of the iterations that pass before moving steps: first the room behind is there, and births begin."""

_SHARE = (0.0, 1.0)


@dataclass(frozen=True)
class LabelConfig:
    """Which splats are static and which dynamic."""

    initial: str = "auto"  # auto: from masks; dynamic, static: all splats alike
    adaptive: bool = True  # labels follow what splats do
    still_pixels: float = 0.25  # a dynamic splat of constant opacity that moves less becomes static
    restless_error: float = 0.05  # a static splat whose mean colour error varies more becomes dynamic; 0: none

    def __post_init__(self) -> None:
        """Check every field.

        Raises:
            InputError: names the field, the value, and the range or the choices.
        """
        ranges: dict[str, Range] = {
            "still_pixels": (0.0, 1e5),  # wider than any picture: whatever does not fade is still
            "restless_error": _SHARE,  # colours lie in 0 to 1
        }
        check_fields(self, "config.train.labels", ranges, {"initial": ("auto", "dynamic", "static")})


@dataclass(frozen=True)
class LearningRates:
    """Step sizes of RMSprop. Those of positions are multiplied by the scene's extent; sources in docs/training.md."""

    position: float = 1e-3
    position_final: float = 5e-5  # log-linear decay from `position`
    motion: float = 0.4  # higher motion coefficients, multiples of `position`, for each power of the life
    rotation: float = 3e-3
    turning: float = 1e-3  # linear rotation coefficient
    log_scale: float = 1e-2
    opacity: float = 5e-2
    rgb: float = 5e-3
    time_center: float = 1e-3
    time_log_precision: float = 3e-2
    colour_correction: float = 1e-3
    lens_falloff: float = 2e-3
    time_shift: float = 0.01  # frames

    def __post_init__(self) -> None:
        """Check every rate.

        Raises:
            InputError: names the rate, the value and the range.
        """
        check_fields(self, "config.train.learning_rates", _RATES)


# A step moves a parameter by about its rate: 10 multiplies a size by e^10 at once.
_RATES: dict[str, Range] = dict.fromkeys((rate.name for rate in dataclasses.fields(LearningRates)), (0.0, 10.0))

_CHOICES: dict[str, tuple[Any, ...]] = {
    "stages": ("together", "interleaved", "separate"),
    "motion_order": (1, 2, 3, 5),
    "backend": ("auto", "cpu", "triton", "reference"),
}

_RANGES: dict[str, Range] = {
    "iterations": (1, 1_000_000),  # 50 times those of `standard`: days of a machine
    "later_share": (0.001, 1.0),
    "segment_frames": (2, 1_000_000),  # nine hours at 30 frames per second: never cut
    "elongation": (1.0, 1e6),  # no picture is a million pixels long
    "dssim": _SHARE,
    "coarse_until": _SHARE,
    "moving_steps": (0.0, 100.0),  # a training of moving tiles
    "settle_from": _SHARE,
    "settled": _SHARE,
    "hold_from": _SHARE,
    "held_statics": (0.0, 100.0),  # undoes settling to a hundredth
    "average_from": _SHARE,
    "checkpoint_every": (1, 100_000),  # the most that a killed worker loses: hours
}


@dataclass(frozen=True)
class TrainConfig:
    """How to train. An iteration draws one view; `stages` says how the two sets learn from it."""

    iterations: int = 20_000
    stages: str = "together"  # together (one step for both sets), interleaved (statics first), separate (drawn alone)
    motion_order: int = 3  # degree of the position polynomial: 1, 2, 3 or 5
    segment_frames: int = 150  # longest segment; all segments share the statics of the first
    later_share: float = 1.0  # share of `iterations` that segments after the first take
    antialiased: bool = True  # draw so, now and in every viewer: right from any distance (docs/training.md)
    elongation: float = 20.0  # longest axis of a splat in multiples of its middle one, at most (docs/training.md)
    colour_correction: bool = True  # learn an affine colour map per training camera; scenes do not keep them
    lens_falloff: bool = True  # and how its lens darkens the picture towards the corners
    time_shifts: bool = True  # and by how much of a frame its clock is late (docs/training.md)
    dssim: float = 0.2  # lambda of the loss
    coarse_until: float = 0.25  # share of `iterations` trained at half resolution
    moving_steps: float = 3.0  # further ones per iteration, of the dynamics alone where masks say it moves; 0: none
    settle_from: float = 0.6  # share of `iterations` after which steps of all but positions become smaller
    settled: float = 0.02  # share of step sizes left at the end, without a hold before
    hold_from: float = 0.85  # share of `iterations` after which all steps stay as large as they are; 1: they fall on
    held_statics: float = 3.0  # the statics' steps then, positions too, in multiples of what they are
    average_from: float = 0.9  # share of `iterations` whose later splats' mean is the result; 1: the last ones are
    steps_by_life: bool = True  # a dynamic splat's steps are smaller the shorter it lives (docs/training.md)
    checkpoint_every: int = 500  # iterations
    backend: str = "auto"
    density: DensityConfig = field(default_factory=DensityConfig)
    labels: LabelConfig = field(default_factory=LabelConfig)
    learning_rates: LearningRates = field(default_factory=LearningRates)

    def __post_init__(self) -> None:
        """Check every field.

        Raises:
            InputError: names the field, the value, and the range or the choices.
        """
        check_fields(self, "config.train", _RANGES, _CHOICES)

    @property
    def later(self) -> TrainConfig:
        """The config of the segments after the first, which take over its statics and colour maps."""
        return dataclasses.replace(self, iterations=max(1, round(self.later_share * self.iterations)))

    def splat_budgets(self, seconds: float) -> tuple[int, int]:
        """Return how many static and dynamic splats a segment of so many seconds may have; of one second at least.

        What moves is made of splats that live for a part of the time, so that longer segments need more. A set that all
        splats start in has the budget of both.
        """
        still, moving = self.density.max_static, round(self.density.max_dynamic * max(1.0, seconds))
        both, initial = still + moving, self.labels.initial
        return both if initial == "static" else still, both if initial == "dynamic" else moving
