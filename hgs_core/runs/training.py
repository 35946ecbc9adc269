"""The training of a run's capture, and its published facts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from hgs_core.base.progress import ProgressCallback
from hgs_core.native.machine import machine_facts
from hgs_core.runs.run_folder import RunFolder
from hgs_core.runs.training_inputs import training_inputs
from hgs_core.train.capture_training import save_trained, train_capture

__all__ = ["told_of_training", "train_run"]

_NOT_PUBLISHED = {"machine", "history", "profile"}  # parts of train.json that viewers do not need


def train_run(folder: RunFolder, progress: ProgressCallback) -> dict[str, Any]:
    """Train from the last checkpoints, or from the points, to scene.npz; return the content of train.json."""
    spec = folder.read_spec()
    capture = folder.open_capture(spec)
    inputs = training_inputs(folder, capture, spec.config)
    summary = train_capture(inputs, folder.checkpoint, progress, folder.preview)
    save_trained(folder.trained, inputs, folder.checkpoint)
    return summary | {"machine": machine_facts()}


def told_of_training(summary: Mapping[str, Any]) -> dict[str, Any]:
    """Return the facts of a training for a scene's manifest."""
    return {name: value for name, value in summary.items() if name not in _NOT_PUBLISHED}
