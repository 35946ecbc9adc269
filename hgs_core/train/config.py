"""Everything that decides a training run, in one dataclass; free of torch, so that the API can validate it."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

from hgs_core.base.errors import InputError

__all__ = ["BUDGETS", "PRESETS", "LearningRates", "TrainConfig"]

BUDGETS: dict[str, float] = {"low": 0.8, "default": 0.1, "high": 0.02}
"""What encoding may cost the training views, dB; others lose less (docs/experiments/)."""


_CHOICES: dict[str, tuple[Any, ...]] = {
    "backend": ("auto", "cpu", "triton", "reference"),
    "labels": ("auto", "dynamic", "static"),
    "stages": ("together", "interleaved", "separate"),
    "motion_order": (1, 2, 3, 5),
    "birth_rounds": (0, 1, 2),
    "density": ("gradient", "relocation"),
    "budget": tuple(BUDGETS),
}


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


@dataclass(frozen=True)
class TrainConfig:
    """How to train one run. A cycle draws one view; `stages` says how the two sets learn from it.

    Equal configs on equal captures give equal bits, for any number of threads.
    """

    preset: str = "standard"
    hold_out: tuple[str, ...] = ()  # camera names that neither training nor initialisation may see
    downscale: int = 1  # pictures are reduced by this factor when they are read, for training and scores alike
    seed: int = 0
    cycles: int = 12_000
    static_points: int = 6_000  # initial points asked for; more of them stand at wrong depths
    dynamic_points: int = 8_000  # the same of what moves, for every second of the capture
    init_interval: float = 1 / 3  # seconds between the moments that dynamic points are taken from (interleaved frames)
    max_static: int = 80_000  # splat budgets
    max_dynamic: int = 15_000  # for every second of a segment
    density: str = "gradient"  # gradient: clone and split where the loss pulls; relocation: copy by opacity, and jitter
    densify_from: float = 0.04  # shares of `cycles`
    densify_until: float = 0.6
    densify_every: int = 50  # cycles
    grow_gradient: float = 2e-4  # screen-gradient norm per half image width above which a splat is refined
    clone_scale: float = 0.01  # a splat larger than this share of the extent is split instead of cloned
    prune_opacity: float = 0.005
    prune_contribution: float = 0.01  # splats of less weight in every pixel of every training view are removed; 0: none
    dssim: float = 0.2  # lambda of the loss
    settle_from: float = 0.6  # share of `cycles` after which steps of all but positions become smaller
    settled: float = 0.02  # what is left of them at the end
    steps_by_life: bool = True  # a dynamic splat's steps are smaller the shorter it lives (docs/training.md)
    coarse_until: float = 0.25  # share of `cycles` trained at half resolution
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
    checkpoint_every: int = 500  # cycles
    frame_memory_mib: int = 4096  # for decoded frames; a longer capture is visited in blocks that fit
    backend: str = "auto"
    budget: str = "default"  # of the encoded scene: one of `BUDGETS`
    learning_rates: LearningRates = dataclasses.field(default_factory=LearningRates)

    def __post_init__(self) -> None:
        """Check every range.

        Raises:
            InputError: names the field and the range it must lie in.
        """
        for name, low in (
            ("downscale", 1), ("seed", 0), ("cycles", 1), ("static_points", 0), ("dynamic_points", 0),
            ("max_static", 1), ("max_dynamic", 0), ("densify_every", 1), ("checkpoint_every", 1),
            ("frame_memory_mib", 1), ("segment_frames", 2),
        ):  # fmt: skip
            value = getattr(self, name)
            if value < low:
                raise InputError(f"config.{name}", f"{value} is too small", f"give {low} or more")
        for name in (
            "densify_from",
            "densify_until",
            "prune_opacity",
            "prune_contribution",
            "dssim",
            "coarse_until",
            "infill",
            "settle_from",
            "settled",
        ):
            value = getattr(self, name)
            if not 0 <= value <= 1:
                raise InputError(f"config.{name}", f"{value} is not a share", "give a number from 0 to 1")
        for name, known in _CHOICES.items():
            value = getattr(self, name)
            if value not in known:
                raise InputError(f"config.{name}", f"unknown choice {value!r}", f"use {_any_of(known)}")
        if not self.init_interval > 0:
            raise InputError("config.init_interval", f"{self.init_interval} s is not positive", "give seconds above 0")
        if self.still_pixels < 0 or self.restless_error < 0:
            raise InputError("config.still_pixels, config.restless_error", "a threshold is negative", "give 0 or more")
        if len(set(self.hold_out)) != len(self.hold_out):
            raise InputError("config.hold_out", f"a camera is named twice in {','.join(self.hold_out)}")

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
            >>> config.cycles, config.hold_out, config.learning_rates.rgb
            (2500, ('cam00',), 0.01)
        """
        if preset not in PRESETS:
            raise InputError("preset", f"unknown preset {preset!r}", f"use one of {', '.join(PRESETS)}")
        return cls.from_json({"preset": preset, **PRESETS[preset], **overrides})

    def to_json(self) -> dict[str, Any]:
        """Return the plain form that run.json stores."""
        return dataclasses.asdict(self) | {"hold_out": list(self.hold_out)}

    @classmethod
    def from_json(cls, value: dict[str, Any]) -> TrainConfig:
        """Read what `to_json` wrote; absent fields take their defaults.

        Raises:
            InputError: an unknown field, or a value of the wrong type or range.
        """
        rates = value.get("learning_rates", {})
        if isinstance(rates, LearningRates):
            rates = dataclasses.asdict(rates)
        if not isinstance(rates, dict):
            raise InputError("config.learning_rates", f"{rates!r} is not an object")
        fields = {k: v for k, v in value.items() if k != "learning_rates"}
        hold_out = fields.get("hold_out", ())
        if isinstance(hold_out, str) or not all(isinstance(name, str) for name in hold_out):
            raise InputError("config.hold_out", f"{hold_out!r} is not a list of camera names")
        fields["hold_out"] = tuple(hold_out)
        return cls(**_typed(cls, fields, "config"), learning_rates=_learning_rates(rates))


def _learning_rates(value: dict[str, Any]) -> LearningRates:
    rates = LearningRates(**_typed(LearningRates, value, "config.learning_rates"))
    for name, rate in dataclasses.asdict(rates).items():
        if not rate >= 0:
            raise InputError(f"config.learning_rates.{name}", f"{rate} is negative")
    return rates


def _any_of(choices: tuple[Any, ...]) -> str:
    """Return "a, b or c"."""
    return f"{', '.join(str(c) for c in choices[:-1])} or {choices[-1]}"


def _typed(cls: type[Any], value: dict[str, Any], where: str) -> dict[str, Any]:
    """Check the names and coerce the numbers of a dataclass's fields."""
    types = {field.name: str(field.type) for field in dataclasses.fields(cls)}
    result: dict[str, Any] = {}
    for name, given in value.items():
        if name not in types:
            raise InputError(f"{where}.{name}", "unknown field", f"known are {', '.join(sorted(types))}")
        number = isinstance(given, int | float) and not isinstance(given, bool)
        if types[name] == "int" and not (number and float(given).is_integer()):
            raise InputError(f"{where}.{name}", f"{given!r} is not a whole number")
        if types[name] == "float" and not number:
            raise InputError(f"{where}.{name}", f"{given!r} is not a number")
        if types[name] == "str" and not isinstance(given, str):
            raise InputError(f"{where}.{name}", f"{given!r} is not a string")
        if types[name] == "bool" and not isinstance(given, bool):
            raise InputError(f"{where}.{name}", f"{given!r} is not true or false")
        result[name] = {"int": int, "float": float}.get(types[name], lambda x: x)(given)
    return result


PRESETS: dict[str, dict[str, Any]] = {
    "preview": {
        "cycles": 2_500, "dynamic_points": 5_000,
        "max_static": 35_000, "max_dynamic": 8_000, "coarse_until": 0.4,
    },
    "standard": {},
    "best": {
        "cycles": 40_000, "static_points": 10_000, "dynamic_points": 10_000,
        "max_static": 120_000, "max_dynamic": 25_000, "coarse_until": 0.15,
    },
}  # fmt: skip
"""What each preset changes of the defaults: a first picture in minutes, a finished scene, the best there is."""
