"""The history of a training: its curves over the iterations, and its profile."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

__all__ = ["TrainingHistory"]

_CURVES = ("iteration", "seconds", "loss", "psnr", "static", "dynamic")
_SMOOTHING = 0.9  # smoothing of the loss and the PSNR from report to report
_MOST_POINTS = 1000  # points of a curve; beyond it every other one is dropped


@dataclass
class TrainingHistory:
    """Grows with the training and is part of its checkpoints."""

    curves: dict[str, list[float]] = field(default_factory=lambda: {name: [] for name in _CURVES})
    profile: dict[str, float] = field(default_factory=dict)  # seconds by activity
    labels_changed: dict[str, int] = field(default_factory=lambda: {"to_static": 0, "to_dynamic": 0})  # splats
    births: int = 0  # splats
    infilled: int = 0  # splats put on still pixels that were wrong
    pruned: int = 0  # splats that no view needed
    stride: int = 1  # reports per point of the curves
    loss: float = math.nan  # smoothed, of the training views
    psnr: float = math.nan  # smoothed, dB, of the training views as the scene shows them
    _reports: int = 0

    def follow(self, loss: float, psnr: float) -> None:
        """Smooth the loss and the PSNR of a view into those of the run."""
        fresh = math.isnan(self.loss)
        self.loss = loss if fresh else _SMOOTHING * self.loss + (1 - _SMOOTHING) * loss
        self.psnr = psnr if fresh else _SMOOTHING * self.psnr + (1 - _SMOOTHING) * psnr

    def relabelled(self, to_static: int, to_dynamic: int) -> None:
        """Count splats with a changed label."""
        self.labels_changed["to_static"] += to_static
        self.labels_changed["to_dynamic"] += to_dynamic

    def report(self, iteration: int, seconds: float, static: int, dynamic: int) -> None:
        """Add a point to the curves; a curve never holds more than 1,000."""
        self._reports += 1
        if self._reports % self.stride or math.isnan(self.loss):
            return
        values = (iteration, seconds, self.loss, self.psnr, static, dynamic)
        for name, value in zip(_CURVES, values, strict=True):
            self.curves[name].append(float(value))
        if len(self.curves["iteration"]) > _MOST_POINTS:
            self.stride *= 2
            self.curves = {name: values[1::2] for name, values in self.curves.items()}

    @contextmanager
    def timed(self, activity: str) -> Iterator[None]:
        """Add the time of the block to an activity of the profile."""
        started = time.perf_counter()
        yield
        self.profile[activity] = self.profile.get(activity, 0.0) + time.perf_counter() - started

    def state(self) -> dict[str, Any]:
        """Return plain values for a checkpoint."""
        return {
            "curves": self.curves,
            "profile": self.profile,
            "labels_changed": self.labels_changed,
            "births": self.births,
            "infilled": self.infilled,
            "pruned": self.pruned,
            "stride": self.stride,
            "loss": self.loss,
            "psnr": self.psnr,
            "reports": self._reports,
        }

    @staticmethod
    def restored(state: dict[str, Any]) -> TrainingHistory:
        """Return the history that `state` described."""
        values = dict(state)
        return TrainingHistory(_reports=values.pop("reports"), **values)
