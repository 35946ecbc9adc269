"""The rules of density control; free of torch, so that the API can validate them."""

from __future__ import annotations

from dataclasses import dataclass

from hgs_core.base.config_fields import Range, check_fields

__all__ = ["DensityConfig"]

_SHARE = (0.0, 1.0)


@dataclass(frozen=True)
class DensityConfig:
    """How many splats there may be, and by which rules they are added and removed."""

    max_static: int = 80_000  # splat budgets
    max_dynamic: int = 15_000  # splats for every second of a segment
    start: float = 0.04  # shares of the iterations
    end: float = 0.6
    every: int = 50  # iterations
    grow_gradient: float = 8e-4  # pull per half image width above which a splat is refined
    clone_scale: float = 0.01  # a splat larger than this share of the extent is split instead of cloned
    prune_opacity: float = 0.005
    prune_contribution: float = 0.01  # remove splats of less blending weight in every training pixel; 0: none
    birth_rounds: int = 2  # times that splats are added where moving pixels are wrong: 0, 1 or 2
    static_opacity_penalty: float = 0.05  # share of an opacity's step by which every static fades in a step; 0: none
    dynamic_opacity_penalty: float = 0.005  # the same, of the dynamics that live then
    infill: float = 0.03  # share of `max_static` that may be added at once where still pixels are wrong; 0: none

    def __post_init__(self) -> None:
        """Check every field.

        Raises:
            InputError: names the field, the value, and the range or the choices.
        """
        check_fields(self, "config.train.density", _DENSITY, {"birth_rounds": (0, 1, 2)})


_DENSITY: dict[str, Range] = {
    "max_static": (1, 10_000_000),  # about 8 GB, gradients and moments included
    "max_dynamic": (0, 1_000_000),  # the same for a segment of ten seconds
    "start": _SHARE,
    "end": _SHARE,
    "every": (1, 1_000_000),  # the most iterations there are: never
    "grow_gradient": (0.0, 1e3),  # pulls of the loss, which is at most 1, are far below: none is refined
    "clone_scale": (0.0, 1e3),  # a splat of many times the scene's extent: none is split
    "prune_opacity": _SHARE,
    "prune_contribution": _SHARE,
    "static_opacity_penalty": _SHARE,
    "dynamic_opacity_penalty": _SHARE,
    "infill": _SHARE,
}
