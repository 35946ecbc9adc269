"""The size of a training as large as a public capture."""

from __future__ import annotations

from hgs_core.runs.training_size import SegmentSize, TrainingSize

__all__ = ["LARGE"]

LARGE = TrainingSize(  # 16 cameras of 300 frames, 1352x1014
    cameras=16,
    training_cameras=15,
    frames=300,
    filmed_pixels=1352 * 1014,
    pixels=1352 * 1014,
    straightened=0.0,
    moments=32,
    masked=False,
    aligned=False,
    first_static=30_000,
    first_dynamic=80_000,
    segments=(SegmentSize(150, 80_000, 75_000),) * 2,
    iterations=20_000,
    coarse_until=0.25,
    moving_steps=3.0,
    by_segment=False,
)
"""Sixteen cameras of 300 frames, one of them held out."""
