"""Mistakes undone on trial, and the one that explains the matches."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from hgs_core.capture.cameras.corrected_poses import CORRECTIONS_FILE, CorrectedCamera
from hgs_core.check.epipolar import ComparedPairs, Rig
from hgs_core.check.findings import Finding

__all__ = ["FITS", "Cause", "Correction", "Trial", "best_trial", "fitting"]

Floats = npt.NDArray[np.float64]

FITS = 1.5  # pixels: a mistake is found where undoing it brings the matches that near ...
_GAIN = 0.4  # ... and to that share of the error before
_RIVAL = 1.5  # share of the error below which another reading of the poses fits as well: nothing tells then
_SAME = 0.02  # share of the lenses, turns and baselines by which rigs differ that are one


@dataclass(frozen=True)
class Correction:
    """One camera with a mistake undone."""

    pose: Floats  # [4, 4] world-to-camera
    calibration: int  # camera that has the right size and lens
    focal: float  # factor of its focal length


@dataclass(frozen=True)
class Cause:
    """A mistake that explains the matches."""

    problem: str
    cure: str
    error: float | None = None  # pixels that are left once it is undone; None: not measured
    corrections: Mapping[int, Correction] = field(
        default_factory=dict
    )  # keys: cameras; empty: nothing undoes it exactly

    def finding(
        self, stops: bool, cameras: tuple[str, ...], told: str, names: Sequence[str], digits: int = 1
    ) -> Finding:
        """Return the finding on cameras, or on all: `told` says where poses do not fit, `names` are all cameras'."""
        corrected = tuple(
            CorrectedCamera(names[camera], one.pose, names[one.calibration], one.focal)
            for camera, one in self.corrections.items()
        )
        cure = f"{self.cure}, or let hgs check --fix-poses write {CORRECTIONS_FILE}" if corrected else self.cure
        left = "" if self.error is None else f" ({self.error:.{digits}f} px then)"
        problem = f"{told}: {self.problem}{left}"
        return Finding(stops, cameras, problem, cure, corrected=corrected)


@dataclass(frozen=True)
class Trial:
    """A rig with one mistake undone."""

    rig: Rig
    problem: str
    cure: str
    pairs: ComparedPairs | None = None  # matches with a mistake of the pictures undone
    cost: float = 1.0  # the error counts for so many times as much: rare mistakes need better proof
    order: tuple[int, ...] | None = None  # camera of each one's calibration; None: its own
    exact: bool = True  # whether undoing it leaves nothing to be calibrated again

    def cause(self, before: Rig, error: float) -> Cause:
        """Return the cause that it is of a rig, with pixels left."""
        order = self.order or tuple(range(len(before.poses)))
        found = {}
        for camera, source in enumerate(order):
            focal = float(self.rig.intrinsics[camera, 0, 0] / before.intrinsics[source, 0, 0])
            pose = self.rig.poses[camera]
            if source != camera or focal != 1.0 or not np.array_equal(pose, before.poses[camera]):
                found[camera] = Correction(pose, source, focal)
        return Cause(self.problem, self.cure, error, found if self.exact else {})


def best_trial(trials: Sequence[Trial], before: float, errors: Sequence[float], fits: float = FITS) -> int | None:
    """Return the number of the trial that explains the matches; None without one, or where two do alike."""
    measured = [(error * trial.cost, number) for number, (trial, error) in enumerate(zip(trials, errors, strict=True))]
    least, number = min(measured)
    if not fitting(errors[number], before, fits):
        return None
    rivals = (trials[other] for cost, other in measured if other != number and cost < _RIVAL * least)
    if any(rival.pairs is None and not _one_rig(trials[number].rig, rival.rig) for rival in rivals):
        return None
    return number


def fitting(after: float, before: float, fits: float) -> bool:
    """Return whether pixels after a mistake is undone are below `fits` and explain those before."""
    return after < fits and after < _GAIN * before


def _one_rig(one: Rig, other: Rig) -> bool:
    """Whether two rigs are one but for where the world begins and how large it is."""
    if np.abs(one.intrinsics - other.intrinsics).max() > _SAME * np.abs(one.intrinsics).max():
        return False
    moves = [rig.poses @ np.linalg.inv(rig.poses[0]) for rig in (one, other)]
    longest = [max(1e-300, float(np.linalg.norm(move[:, :3, 3], axis=1).max())) for move in moves]
    turned = np.abs(moves[0][:, :3, :3] - moves[1][:, :3, :3]).max()
    apart = np.abs(moves[0][:, :3, 3] / longest[0] - moves[1][:, :3, 3] / longest[1]).max()
    return bool(max(turned, apart) < _SAME)
