"""Everything that decides a run, stage by stage; free of torch, so that the API can validate it."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from hgs_core.base.config_fields import Range, check_fields, with_fields
from hgs_core.base.errors import InputError
from hgs_core.capture.capture_config import CaptureConfig
from hgs_core.fit.fit_config import EncodeConfig
from hgs_core.points.points_config import PointsConfig
from hgs_core.runs.config_names import by_stage
from hgs_core.train.train_config import TrainConfig

__all__ = ["PRESETS", "RunConfig"]

PRESETS: dict[str, dict[str, Any]] = {
    "preview": {
        "points.static": 12_000,
        "points.dynamic": 5_000,
        "points.discs": True,
        "train.iterations": 3_200,
        "train.coarse_until": 0.4,
        "train.moving_steps": 1.0,
        "train.density.max_static": 35_000,
        "train.density.max_dynamic": 12_000,
        "encode.fine_tune": 0.0,
    },
    "standard": {},
    "best": {
        "points.static": 45_000,
        "points.dynamic": 10_000,
        "train.moving_steps": 9.0,
        "train.density.max_static": 120_000,
        "train.density.max_dynamic": 25_000,
        "train.density.static_opacity_penalty": 0.025,
    },
}
"""The changes of each preset to the defaults: a first picture in minutes, a finished scene, the best there is."""

_SEEDS: dict[str, Range] = {"seed": (0, 2**53 - 1)}  # up to what every reader of JSON keeps, browsers too


@dataclass(frozen=True)
class RunConfig:
    """How to make a scene of a capture. Equal configs on equal captures give equal bits, for any number of threads."""

    preset: str = "standard"
    seed: int = 0  # seed of all random numbers
    capture: CaptureConfig = field(default_factory=CaptureConfig)
    points: PointsConfig = field(default_factory=PointsConfig)
    train: TrainConfig = field(default_factory=TrainConfig)
    encode: EncodeConfig = field(default_factory=EncodeConfig)

    def __post_init__(self) -> None:
        """Check every field.

        Raises:
            InputError: names the field, the value, and the range or the choices.
        """
        check_fields(self, "config", _SEEDS, {"preset": (*PRESETS, "imported")})

    @classmethod
    def for_preset(cls, preset: str, **overrides: Any) -> RunConfig:
        """Return a preset's config with fields replaced, as `changed` does.

        Raises:
            InputError: an unknown preset or field, or a value of the wrong type or range.

        Example:
            >>> import hgs_core as hgs
            >>> config = hgs.RunConfig.for_preset("preview", capture={"hold_out": ["cam00"]}, train={"dssim": 0.1})
            >>> config.train.iterations, config.train.dssim, config.capture.hold_out
            (3200, 0.1, ('cam00',))
        """
        if preset not in PRESETS:
            raise InputError.of_field("preset", f"unknown preset {preset!r}", f"use one of {', '.join(PRESETS)}")
        return cls(preset=preset).changed(PRESETS[preset]).changed(overrides)

    def changed(self, values: Mapping[str, Any]) -> RunConfig:
        """Return the config with fields replaced: `{"train": {"iterations": 20}}` or `{"train.iterations": 20}`.

        Raises:
            InputError: an unknown field, one that is given twice, or a value of the wrong type or range.
        """
        return with_fields(self, by_stage(values), "config")

    def to_json(self) -> dict[str, Any]:
        """Return the plain form that run.json stores."""
        plain = dataclasses.asdict(self)
        for name in ("hold_out", "downscale_cameras"):
            plain["capture"][name] = list(plain["capture"][name])
        return plain

    @classmethod
    def from_json(cls, value: Mapping[str, Any]) -> RunConfig:
        """Read the plain form; absent fields take their defaults.

        Raises:
            InputError: an unknown field, or a value of the wrong type or range.
        """
        return cls().changed(value)
