"""Findings about footage that no camera is of."""

from __future__ import annotations

from collections.abc import Sequence

from hgs_core.base.wording import counted
from hgs_core.check.findings import Finding

__all__ = ["judge_left_out"]

_MOST_LEFT_OUT = 1 / 3  # share of the footage; with more missing the calibration is hardly of this capture
_MOST_NAMED = 12


def judge_left_out(cameras: int, left_out: Sequence[str]) -> list[Finding]:
    """Find footage beside the cameras' that the calibration has no camera for."""
    if not left_out:
        return []
    there = cameras + len(left_out)
    named = ", ".join(left_out[:_MOST_NAMED]) + (", ..." if len(left_out) > _MOST_NAMED else "")
    problem = f"the calibration has {counted(cameras, 'camera')} for the footage of {there}: none for {named}"
    cure = "calibrate all cameras together, or move what is no camera's to a folder called other"
    return [Finding(len(left_out) > _MOST_LEFT_OUT * there, (), problem, cure)]
