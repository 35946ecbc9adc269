"""Training state on disk: replaced atomically, so that a run killed at any moment can go on from the last one."""

from __future__ import annotations

import pickle
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor

from hgs_core.atomic import replacing
from hgs_core.errors import InputError
from hgs_core.render.types import ScreenStatistics
from hgs_core.scene.splats import DynamicSplats, StaticSplats
from hgs_core.train.adam import Adam

__all__ = ["TrainState", "load_state", "save_state"]

_FORMAT = 2


@dataclass
class TrainState:
    """All that the next cycle depends on, besides the config and the capture."""

    cycle: int  # cycles done
    seconds: float  # spent training so far
    static: StaticSplats[Tensor]
    dynamic: DynamicSplats[Tensor]
    static_adam: Adam[StaticSplats[Tensor]]
    dynamic_adam: Adam[DynamicSplats[Tensor]]
    statistics: ScreenStatistics


def save_state(path: Path, state: TrainState) -> None:
    """Write a checkpoint; the old one stays until the new one is complete."""
    value = {
        "format": _FORMAT,
        "cycle": state.cycle,
        "seconds": state.seconds,
        "static": _plain(state.static),
        "dynamic": _plain(state.dynamic),
        "static_adam": state.static_adam.state(),
        "dynamic_adam": state.dynamic_adam.state(),
        "statistics": {f.name: torch.from_numpy(getattr(state.statistics, f.name)) for f in fields(ScreenStatistics)},
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
            cycle=int(value["cycle"]),
            seconds=float(value["seconds"]),
            static=StaticSplats(**value["static"]),
            dynamic=DynamicSplats(**value["dynamic"]),
            static_adam=_adam(StaticSplats, value["static_adam"]),
            dynamic_adam=_adam(DynamicSplats, value["dynamic_adam"]),
            statistics=ScreenStatistics(**{name: _owned(t) for name, t in value["statistics"].items()}),
        )
    except (KeyError, TypeError, RuntimeError, EOFError, pickle.UnpicklingError) as error:
        raise InputError(path, f"unreadable checkpoint ({type(error).__name__})", "delete it to start over") from error


def _plain(splats: StaticSplats[Tensor] | DynamicSplats[Tensor]) -> dict[str, Tensor]:
    return {name: array.detach() for name, array in splats.items()}


def _adam(kind: type[Any], value: dict[str, Any]) -> Adam[Any]:
    return Adam(kind(**value["first"]), kind(**value["second"]), int(value["steps"]))


def _owned(tensor: Tensor) -> np.ndarray[Any, Any]:
    return np.array(tensor.numpy())
