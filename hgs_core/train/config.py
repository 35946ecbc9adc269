"""Everything that decides a training run, in one dataclass; free of torch, so that the API can validate it."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

from hgs_core.base.errors import InputError
from hgs_core.base.old_names import with_new_names
from hgs_core.base.storable_text import require_storable
from hgs_core.train.field_checks import Range, check_fields, require_known

__all__ = ["BUDGETS", "PRESETS", "LearningRates", "TrainConfig"]

BUDGETS: dict[str, float] = {"low": 0.8, "default": 0.1, "high": 0.02}
"""What encoding may cost the training views, dB; others lose less (docs/experiments/)."""

PRESETS: dict[str, dict[str, Any]] = {
    "preview": {
        "iterations": 2_500, "dynamic_points": 5_000,
        "max_static": 35_000, "max_dynamic": 8_000, "coarse_until": 0.4,
    },
    "standard": {},
    "best": {
        "iterations": 40_000, "static_points": 10_000, "dynamic_points": 10_000,
        "max_static": 120_000, "max_dynamic": 25_000, "coarse_until": 0.15,
    },
}  # fmt: skip
"""What each preset changes of the defaults: a first picture in minutes, a finished scene, the best there is."""

_CHOICES: dict[str, tuple[Any, ...]] = {
    "preset": (*PRESETS, "imported"),
    "backend": ("auto", "cpu", "triton", "reference"),
    "labels": ("auto", "dynamic", "static"),
    "stages": ("together", "interleaved", "separate"),
    "motion_order": (1, 2, 3, 5),
    "birth_rounds": (0, 1, 2),
    "density": ("gradient", "relocation"),
    "budget": tuple(BUDGETS),
}

_SHARE = (0.0, 1.0)
_RANGES: dict[str, Range] = {
    "downscale": (1, 512),  # an 8K picture is 16 pixels wide then, the least that a capture may have
    "seed": (0, 2**53 - 1),  # the largest whole number that every reader of JSON keeps, browsers too
    "iterations": (1, 1_000_000),  # 25 times those of `best`: days of a machine
    "static_points": (0, 1_000_000),  # a point for every second pixel of a Full HD picture
    "dynamic_points": (0, 1_000_000),
    "init_interval": (0.001, 1e6),  # a camera of 1000 frames a second; longer than any capture: one moment
    "max_static": (1, 10_000_000),  # with gradients and Adam's moments about 10 GB
    "max_dynamic": (0, 1_000_000),  # the same for a segment of ten seconds
    "densify_from": _SHARE,
    "densify_until": _SHARE,
    "densify_every": (1, 1_000_000),  # the most iterations there are: never
    "grow_gradient": (0.0, 1e3),  # a gradient of the loss, which is at most 1, is far below: none is refined
    "clone_scale": (0.0, 1e3),  # a splat of many times the scene's extent: none is split
    "prune_opacity": _SHARE,
    "prune_contribution": _SHARE,
    "dssim": _SHARE,
    "settle_from": _SHARE,
    "settled": _SHARE,
    "coarse_until": _SHARE,
    "still_pixels": (0.0, 1e5),  # wider than any picture: whatever does not fade is still
    "restless_error": _SHARE,  # colours lie in 0 to 1
    "infill": _SHARE,
    "segment_frames": (2, 1_000_000),  # nine hours at 30 frames per second: never cut
    "checkpoint_every": (1, 100_000),  # what a killed worker loses at most: hours
    "frame_memory_mib": (1, 1 << 20),  # a TiB, more than machines have
}

_MOST_HELD_OUT = 1000  # cameras; no rig has as many
_LONGEST_NAME = 255  # characters; file systems have no longer names, and cameras are called as their files


@dataclass(frozen=True)
class LearningRates:
    """Adam step sizes. Those of positions are multiplied by the scene's extent; sources in docs/training.md."""

    position: float = 1e-3
    position_final: float = 5e-5  # log-linear decay from `position`
    motion: float = 0.4  # of the higher motion coefficients, in multiples of `position`, per power of the life
    rotation: float = 3e-3
    turning: float = 1e-3  # of the linear rotation coefficient
    log_scale: float = 1e-2
    opacity: float = 5e-2
    rgb: float = 5e-3
    time_center: float = 1e-3
    time_log_precision: float = 3e-2
    colour_correction: float = 1e-3

    def __post_init__(self) -> None:
        """Check every rate.

        Raises:
            InputError: names the rate, the value and the range.
        """
        check_fields(self, "config.learning_rates", _RATES)


# Adam moves a parameter by about its rate: 10 multiplies a size by e^10 at once.
_RATES: dict[str, Range] = dict.fromkeys((field.name for field in dataclasses.fields(LearningRates)), (0.0, 10.0))


@dataclass(frozen=True)
class TrainConfig:
    """How to train one run. An iteration draws one view; `stages` says how the two sets learn from it.

    Equal configs on equal captures give equal bits, for any number of threads.
    """

    preset: str = "standard"
    hold_out: tuple[str, ...] = ()  # camera names that neither training nor initialisation may see
    downscale: int = 1  # pictures are reduced by this factor when they are read, for training and scores alike
    seed: int = 0
    iterations: int = 12_000
    static_points: int = 6_000  # initial points asked for; more of them stand at wrong depths
    dynamic_points: int = 8_000  # the same of what moves, for every second of the capture
    init_interval: float = 1 / 3  # seconds between the moments that dynamic points are taken from (interleaved frames)
    max_static: int = 80_000  # splat budgets
    max_dynamic: int = 15_000  # for every second of a segment
    density: str = "gradient"  # gradient: clone and split where the loss pulls; relocation: copy by opacity, and jitter
    densify_from: float = 0.04  # shares of `iterations`
    densify_until: float = 0.6
    densify_every: int = 50  # iterations
    grow_gradient: float = 2e-4  # screen-gradient norm per half image width above which a splat is refined
    clone_scale: float = 0.01  # a splat larger than this share of the extent is split instead of cloned
    prune_opacity: float = 0.005
    prune_contribution: float = 0.01  # remove splats of less blending weight in every training pixel; 0: none
    dssim: float = 0.2  # lambda of the loss
    settle_from: float = 0.6  # share of `iterations` after which steps of all but positions become smaller
    settled: float = 0.02  # what is left of them at the end
    steps_by_life: bool = True  # a dynamic splat's steps are smaller the shorter it lives (docs/training.md)
    coarse_until: float = 0.25  # share of `iterations` trained at half resolution
    colour_correction: bool = True  # learn an affine colour map per training camera; scenes do not keep them
    labels: str = "auto"  # auto: from masks; dynamic, static: all splats alike
    adaptive_labels: bool = True  # labels follow what splats do
    still_pixels: float = 0.25  # a dynamic splat of constant opacity that moves less becomes static
    restless_error: float = 0.05  # a static splat whose mean colour error varies more becomes dynamic; 0: none
    birth_rounds: int = 2  # times that splats are added where moving pixels are wrong: 0, 1 or 2
    infill: float = 0.03  # share of `max_static` that may be added at once where still pixels are wrong; 0: none
    stages: str = "together"  # together (one step for both sets), interleaved (statics first), separate (drawn alone)
    motion_order: int = 3  # degree of the position polynomial: 1, 2, 3 or 5
    segment_frames: int = 150  # longest segment; all segments share the statics of the first
    antialiased: bool = True  # draw so, now and in every viewer: right from any distance (docs/training.md)
    checkpoint_every: int = 500  # iterations
    frame_memory_mib: int = 4096  # for decoded frames; a longer capture is visited in blocks that fit
    backend: str = "auto"
    budget: str = "default"  # of the encoded scene: one of `BUDGETS`
    learning_rates: LearningRates = dataclasses.field(default_factory=LearningRates)

    def __post_init__(self) -> None:
        """Check every field.

        Raises:
            InputError: names the field, the value, and the range or the choices.
        """
        check_fields(self, "config", _RANGES, _CHOICES)
        if not isinstance(self.learning_rates, LearningRates):
            raise InputError("config.learning_rates", "is not an object", "give {name: rate}")
        _check_hold_out(self.hold_out)

    def first_dynamic_points(self, seconds: float) -> int:
        """Return the points of what moves that a capture of so many seconds starts with; of one second at least."""
        return round(self.dynamic_points * max(1.0, seconds))

    def splat_budgets(self, seconds: float) -> tuple[int, int]:
        """Return how many static and dynamic splats a segment of so many seconds may have; of one second at least.

        What moves is made of splats that live for a part of the time, so that longer segments need more. A set that all
        splats start in has the budget of both.
        """
        moving = round(self.max_dynamic * max(1.0, seconds))
        both = self.max_static + moving
        return both if self.labels == "static" else self.max_static, both if self.labels == "dynamic" else moving

    @classmethod
    def for_preset(cls, preset: str, **overrides: Any) -> TrainConfig:
        """Return a preset's config with fields replaced; nested learning rates as {"learning_rates": {...}}.

        Raises:
            InputError: an unknown preset or field, or a value of the wrong type or range.

        Example:
            >>> import hgs_core as hgs
            >>> config = hgs.TrainConfig.for_preset("preview", hold_out=["cam00"], learning_rates={"rgb": 0.01})
            >>> config.iterations, config.hold_out, config.learning_rates.rgb
            (2500, ('cam00',), 0.01)
        """
        if preset not in PRESETS:
            raise InputError("preset", f"unknown preset {preset!r}", f"use one of {', '.join(PRESETS)}")
        return cls.from_json({"preset": preset, **PRESETS[preset], **with_new_names(overrides, "config")})

    def to_json(self) -> dict[str, Any]:
        """Return the plain form that run.json stores."""
        return dataclasses.asdict(self) | {"hold_out": list(self.hold_out)}

    @classmethod
    def from_json(cls, value: dict[str, Any]) -> TrainConfig:
        """Read what `to_json` wrote, also in earlier versions; absent fields take their defaults.

        Raises:
            InputError: an unknown field, or a value of the wrong type or range.
        """
        fields = with_new_names(value, "config")
        require_known(cls, fields, "config")
        rates = fields.get("learning_rates")
        if isinstance(rates, dict):
            require_known(LearningRates, rates, "config.learning_rates")
            fields["learning_rates"] = LearningRates(**rates)
        if isinstance(fields.get("hold_out"), list):
            fields["hold_out"] = tuple(fields["hold_out"])
        return cls(**fields)


def _check_hold_out(names: tuple[str, ...]) -> None:
    if not isinstance(names, tuple) or not all(isinstance(name, str) for name in names):
        raise InputError("config.hold_out", "is not a list of camera names")
    if len(names) > _MOST_HELD_OUT:
        raise InputError("config.hold_out", f"{len(names)} names are too many", f"give at most {_MOST_HELD_OUT}")
    for name in names:
        require_storable("config.hold_out", name, _LONGEST_NAME)
    twice = next((name for place, name in enumerate(names) if name in names[:place]), None)
    if twice is not None:
        raise InputError("config.hold_out", f"camera {twice} is named twice")
