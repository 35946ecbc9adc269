"""Cameras that silhouettes show late or early: wrong times are told from wrong poses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hgs_core.check.epipolar import Rig
from hgs_core.check.findings import Finding
from hgs_core.check.silhouette_pairs import SilhouettePair
from hgs_core.check.trials import Trial, best_trial

__all__ = ["Late", "find_late", "moved_error"]

_LATER = 6  # steps between moments by which a camera is tried to be late or early

SilhouettePairs = Mapping[tuple[int, int], SilhouettePair]


@dataclass(frozen=True)
class Late:
    """A camera with other times than the others, with which poses fit."""

    camera: int
    steps: int  # moments behind the others
    error: float  # pixels that are left
    trial: Trial  # the poses with which that is so

    def finding(self, names: Sequence[str], told: str, frames_of_step: float) -> Finding:
        """Return the finding; `told` says where poses do not fit."""
        frames = round(self.steps * frames_of_step)
        way = "behind" if frames > 0 else "ahead of"
        problem = (
            f"{told}, and fits where its frames are about {abs(frames)} {way} the others' ({self.error:.1f} px then)"
        )
        return Finding(False, (names[self.camera],), problem, "let hgs sync write sync.json, then check again")


def find_late(
    trials: Sequence[Trial], pairs: SilhouettePairs, cameras: Sequence[int], before: float, fits: float
) -> Late | None:
    """Return the one of some cameras that is late or early, with one of the trials of poses; None if that fits nowhere.

    Args:
        trials: of poses; one may leave them as they are.
        pairs: the silhouettes of every two cameras.
        cameras: that may be late.
        before: pixels by which poses do not fit.
        fits: pixels below which they do.
    """
    steps = [step for step in range(-_LATER, _LATER + 1) if step]
    moves = [(camera, step) for step in sorted(steps, key=abs) for camera in cameras]
    best: list[tuple[float, int, int]] = []
    for trial in trials:
        errors = {pair: one.errors(trial.rig, *pair, range(-_LATER, _LATER + 1)) for pair, one in pairs.items()}
        best.append(
            min((_with_move(errors, camera, step), camera, step) for camera, step in moves) if moves else (np.inf, 0, 0)
        )
    found = best_trial(trials, before, [error for error, _, _ in best], fits)
    if found is None:
        return None
    error, camera, step = best[found]
    return Late(camera, step, error, trials[found])


def moved_error(pairs: SilhouettePairs, rig: Rig, camera: int, step: int) -> float | None:
    """Return the median error of a camera's pairs with its moments `step` later; None for no step."""
    if step == 0:
        return None
    mine = {pair: one for pair, one in pairs.items() if camera in pair}
    errors = [one.errors(rig, *pair, [step if pair[0] == camera else -step])[0] for pair, one in mine.items()]
    told = [error for error in errors if not np.isnan(error)]
    return float(np.median(told)) if told else None


def _with_move(errors: Mapping[tuple[int, int], npt.NDArray[np.float64]], camera: int, step: int) -> float:
    """Return the mean of all pairs with the moments of a camera `step` later; infinity where too few are left."""
    own = [
        one[_LATER + (step if pair[0] == camera else -step if pair[1] == camera else 0)] for pair, one in errors.items()
    ]
    mean = float(np.mean(own))
    return np.inf if np.isnan(mean) else mean
