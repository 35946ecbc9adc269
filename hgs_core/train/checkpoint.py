"""Training state on disk: replaced atomically, so that a run killed at any moment can go on from the last one."""

from __future__ import annotations

import math
import pickle
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor

from hgs_core.base.atomic import replacing
from hgs_core.base.errors import InputError
from hgs_core.render.types import ScreenStatistics
from hgs_core.scene.splats import DynamicSplats, StaticSplats
from hgs_core.train.colour_correction import CameraColours, ColourCorrection
from hgs_core.train.history import TrainingHistory
from hgs_core.train.parameter_mean import ParameterMean
from hgs_core.train.rmsprop import RmsProp
from hgs_core.train.time_shifts import TimeShifts
from hgs_core.train.train_config import TrainConfig
from hgs_core.train.training_views import TrainingView

__all__ = ["TrainState", "fresh_state", "load_state", "save_state"]

_FORMAT = 6


@dataclass
class TrainState:
    """All that the next iteration depends on, besides the config and the capture."""

    iteration: int  # iterations done
    seconds: float  # spent training so far
    static: StaticSplats[Tensor]
    dynamic: DynamicSplats[Tensor]
    static_optimiser: RmsProp[StaticSplats[Tensor]]
    dynamic_optimiser: RmsProp[DynamicSplats[Tensor]]
    statistics: ScreenStatistics
    correction: ColourCorrection | None  # None: cameras are not corrected, or agree well enough not to be
    history: TrainingHistory
    time_shifts: TimeShifts | None = None  # None: clocks are taken as they are
    static_mean: ParameterMean[StaticSplats[Tensor]] = field(default_factory=ParameterMean)
    dynamic_mean: ParameterMean[DynamicSplats[Tensor]] = field(default_factory=ParameterMean)

    def figures(self) -> dict[str, float]:
        """Return the figures worth watching."""
        figures = {"static": float(len(self.static)), "dynamic": float(len(self.dynamic))}
        psnr, loss = self.history.psnr, self.history.loss
        return figures if math.isnan(psnr) else figures | {"psnr": psnr, "loss": loss}

    def to(self, device: torch.device) -> None:
        """Move everything that steps touch to a device."""
        self.static = self.static.map(lambda array: array.to(device))
        self.dynamic = self.dynamic.map(lambda array: array.to(device))
        self.static_optimiser, self.dynamic_optimiser = (
            self.static_optimiser.to(device),
            self.dynamic_optimiser.to(device),
        )
        self.correction = None if self.correction is None else self.correction.to(device)
        self.static_mean, self.dynamic_mean = self.static_mean.to(device), self.dynamic_mean.to(device)

    def replace(self, static: StaticSplats[Tensor], dynamic: DynamicSplats[Tensor]) -> None:
        """Go on with other splats, already known to their optimisers; screen statistics and means begin anew."""
        self.static, self.dynamic = static, dynamic
        self.static_mean, self.dynamic_mean = ParameterMean(), ParameterMean()
        self.statistics = ScreenStatistics.zeros(len(static) + len(dynamic))

    def follow_means(self, *, statics: bool) -> None:
        """Let the mean of the dynamics follow, and that of the statics if they learn."""
        self.dynamic_mean.follow(self.dynamic)
        if statics:
            self.static_mean.follow(self.static)

    def become_means(self) -> None:
        """Let the splats become their means; a set without one stays as it is."""
        self.static, self.dynamic = self.static_mean.of(self.static), self.dynamic_mean.of(self.dynamic)
        self.static_mean, self.dynamic_mean = ParameterMean(), ParameterMean()

    def move_static(self, rates: Mapping[str, float | Tensor], seen: ScreenStatistics, opacity_penalty: float) -> None:
        """Step the statics by their gradients, and all of their opacities down; count the visible ones.

        The penalty is a share of an opacity's step, towards transparency. What pictures ask for comes back; what none
        or few of them do is gone in the end.
        """
        self.statistics.add(seen, slice(0, len(self.static)))
        self.static_optimiser.step(self.static, rates)
        self.static.opacity_logits.sub_(opacity_penalty * rates["opacity_logits"])

    def move_dynamic(
        self,
        living: DynamicSplats[Tensor],
        rows: Tensor,
        rates: Mapping[str, float | Tensor],
        seen: ScreenStatistics,
        opacity_penalty: float,
    ) -> None:
        """Step the dynamics `rows` [R] by the gradients of `living`, which are these, as `move_static` does."""
        self.statistics.add(seen, len(self.static) + rows.cpu().numpy())
        self.dynamic_optimiser.step(self.dynamic, rates, living, rows)
        self.dynamic.opacity_logits[rows] -= opacity_penalty * rates["opacity_logits"]

    def colours(self, view: TrainingView) -> CameraColours | None:
        """Return the colours of the view's camera as they are; None: it shows those of the scene."""
        return None if self.correction is None else self.correction.of(view.place)

    def shown(self, picture: Tensor, view: TrainingView) -> Tensor:
        """Return a picture [3, H, W] with the colours that the view's camera gives it."""
        colours = self.colours(view)
        return picture if colours is None else colours.shown(picture, view.camera)


def fresh_state(
    static: StaticSplats[Tensor], dynamic: DynamicSplats[Tensor], cameras: int, config: TrainConfig
) -> TrainState:
    """Return the state before the first iteration, with `cameras` training cameras."""
    return TrainState(
        0,
        0.0,
        static,
        dynamic,
        RmsProp.of(static),
        RmsProp.of(dynamic),
        ScreenStatistics.zeros(len(static) + len(dynamic)),
        ColourCorrection(cameras, falloff=config.lens_falloff) if config.colour_correction else None,
        TrainingHistory(),
        TimeShifts(cameras) if config.time_shifts else None,
    )


def save_state(path: Path, state: TrainState) -> None:
    """Write a checkpoint; the old one stays until the new one is complete."""
    value = {
        "format": _FORMAT,
        "iteration": state.iteration,
        "seconds": state.seconds,
        "static": _plain(state.static),
        "dynamic": _plain(state.dynamic),
        "static_optimiser": state.static_optimiser.state(),
        "dynamic_optimiser": state.dynamic_optimiser.state(),
        "statistics": {f.name: torch.from_numpy(getattr(state.statistics, f.name)) for f in fields(ScreenStatistics)},
        "correction": None if state.correction is None else state.correction.state(),
        "history": state.history.state(),
        "time_shifts": None if state.time_shifts is None else state.time_shifts.state(),
        "static_mean": state.static_mean.state(),
        "dynamic_mean": state.dynamic_mean.state(),
    }
    with replacing(path) as file:
        torch.save(value, file)


def load_state(path: Path) -> TrainState:
    """Read a checkpoint.

    Raises:
        InputError: the file is damaged or of another version.
    """
    try:
        value = torch.load(path, map_location="cpu", weights_only=True)
        if value["format"] != _FORMAT:
            raise InputError(path, f"checkpoint format {value['format']}, expected {_FORMAT}", "start a new run")
        return TrainState(
            iteration=int(value["iteration"]),
            seconds=float(value["seconds"]),
            static=StaticSplats(**value["static"]),
            dynamic=DynamicSplats(**value["dynamic"]),
            static_optimiser=_optimiser(StaticSplats, value["static_optimiser"]),
            dynamic_optimiser=_optimiser(DynamicSplats, value["dynamic_optimiser"]),
            statistics=ScreenStatistics(**{name: _owned(t) for name, t in value["statistics"].items()}),
            correction=None if value["correction"] is None else ColourCorrection.restored(value["correction"]),
            history=TrainingHistory.restored(value["history"]),
            time_shifts=None if value["time_shifts"] is None else TimeShifts.restored(value["time_shifts"]),
            static_mean=ParameterMean.restored(StaticSplats, value["static_mean"]),
            dynamic_mean=ParameterMean.restored(DynamicSplats, value["dynamic_mean"]),
        )
    except (KeyError, TypeError, RuntimeError, EOFError, pickle.UnpicklingError) as error:
        raise InputError(path, f"unreadable checkpoint ({type(error).__name__})", "delete it to start over") from error


def _plain(splats: StaticSplats[Tensor] | DynamicSplats[Tensor]) -> dict[str, Tensor]:
    return {name: array.detach() for name, array in splats.items()}


def _optimiser(kind: type[Any], value: dict[str, Any]) -> RmsProp[Any]:
    return RmsProp(kind(**value["moments"]), value["updated"], int(value["steps"]))


def _owned(tensor: Tensor) -> np.ndarray[Any, Any]:
    return np.array(tensor.numpy())
