"""Why poses do not fit: mistakes that people make are tried, and the one that makes the matches fit is named."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import permutations, product

import numpy as np
import numpy.typing as npt

from hgs_core.check.epipolar import Pair, Pairs, Rig, pair_errors
from hgs_core.check.turning import turned_to_fit

__all__ = ["Cause", "cause_of_camera", "cause_of_rig", "swapped_cameras"]

Floats = npt.NDArray[np.float64]

FITS = 1.5  # pixels: a mistake is found where undoing it brings the matches that near ...
_GAIN = 0.4  # ... and to that share of the error before
_COUNTED = 0.8  # share of pairs, the smallest errors first
_FOCALS = np.exp(np.linspace(np.log(0.4), np.log(2.5), 75))
_UNITS = {0.01: "centimetres", 0.001: "millimetres", 0.1: "decimetres", 0.0254: "inches", 0.3048: "feet"}
_AXES = ("right", "down", "forward")
_OPPOSITE = {"right": "left", "down": "up", "forward": "backwards"}


@dataclass(frozen=True)
class Cause:
    """A mistake that explains the matches."""

    problem: str
    cure: str
    error: float  # pixels that are left once it is undone


@dataclass(frozen=True)
class _Trial:
    rig: Rig
    problem: str
    cure: str
    pairs: Pairs | None = None  # matches with a mistake of the pictures undone
    cost: float = 1.0  # the error counts for so many times as much: rare mistakes need better proof


def cause_of_rig(rig: Rig, pairs: Pairs, names: Sequence[str]) -> Cause | None:
    """Return the mistake that was made with all cameras alike, None if none of those tried explains the matches."""
    before = _error(rig, pairs)
    trials = [*_axes_of_rig(rig), *_inverse_of_rig(rig), *_order_of_names(rig, names)]
    focal = _best_focal(lambda factor: _error(rig.with_focal(factor), pairs))
    trials.append(_focal_trial(rig.with_focal(focal), focal, "all cameras"))
    trials += _lenses(rig, pairs)
    return _best(trials, before, lambda trial: _error(trial.rig, trial.pairs or pairs))


def cause_of_camera(rig: Rig, pairs: Pairs, camera: int, agreeing: Sequence[int]) -> Cause | None:
    """Return the mistake that was made with one camera, None if none of those tried explains its matches."""
    mine = {pair: one for pair, one in pairs.items() if camera in pair and set(pair) <= {camera, *agreeing}}
    if not mine:
        return None
    before = _error(rig, mine)
    pose = rig.poses[camera]
    trials = []
    for axes in _rotations():
        trials.append(_turned_trial(rig.with_pose(camera, axes @ pose), axes))
        undone = axes.T @ np.linalg.inv(pose) @ axes.T
        trials.append(
            _Trial(rig.with_pose(camera, undone), "its pose is inverted", "save the inverse of its matrix", cost=2)
        )
    focal = _best_focal(lambda factor: _error(rig.with_focal(factor, camera), mine))
    trials.append(_focal_trial(rig.with_focal(focal, camera), focal, "the camera"))
    centre = rig.centres()[camera]
    for unit, name in _UNITS.items():
        for scale, words in ((unit, name), (1 / unit, f"a unit of 1/{unit:g}")):
            moved = pose.copy()
            moved[:3, 3] = -pose[:3, :3] @ (centre * scale)
            problem = f"its position is in another unit: times {scale:g} it fits ({words} among metres?)"
            trials.append(_Trial(rig.with_pose(camera, moved), problem, "give all positions in one unit"))
    fitted, degrees = turned_to_fit(rig, mine, camera)
    problem = f"it is turned by {degrees:.1f} degrees from where its pose says, as after a knock"
    trials.append(_Trial(rig.with_pose(camera, fitted), problem, "calibrate it again, or leave it out", cost=3))
    return _best(trials, before, lambda trial: _error(trial.rig, mine))


def swapped_cameras(rig: Rig, pairs: Pairs, odd: Sequence[int], agreeing: Sequence[int]) -> list[tuple[int, int]]:
    """Return the pairs of odd cameras that fit with each other's poses."""
    found = []
    for a, b in ((a, b) for a in odd for b in odd if a < b):
        order = list(range(len(rig.poses)))
        order[a], order[b] = b, a
        exchanged = rig.rearranged(order)
        both = [
            {pair: one for pair, one in pairs.items() if camera in pair and set(pair) <= {camera, *agreeing}}
            for camera in (a, b)
        ]
        if all(mine and _fits(_error(exchanged, mine), _error(rig, mine)) for mine in both):
            found.append((a, b))
    return found


def _best(trials: Iterable[_Trial], before: float, error: Callable[[_Trial], float]) -> Cause | None:
    measured = [(error(trial), number, trial) for number, trial in enumerate(trials)]
    after, _, trial = min(measured, key=lambda entry: (entry[0] * entry[2].cost, entry[1]))
    return Cause(trial.problem, trial.cure, after) if _fits(after, before) else None


def _fits(after: float, before: float) -> bool:
    return after < FITS and after < _GAIN * before


def _error(rig: Rig, pairs: Pairs) -> float:
    """Return the mean of the pairs' medians without the worst fifth, possibly chance matches."""
    errors = np.sort(list(pair_errors(rig, pairs).values()))
    return float(errors[: int(np.ceil(_COUNTED * len(errors)))].mean())


def _rotations() -> list[Floats]:
    """Return the 24 rotations [4, 4] that exchange axes, the identity first."""
    found = []
    for order, signs in product(permutations(range(3)), product((1.0, -1.0), repeat=3)):
        turn = np.eye(4)
        turn[:3, :3] = np.diag(signs) @ np.eye(3)[list(order)]
        if np.linalg.det(turn) > 0:
            found.append(turn)
    return found


def _axes_of_rig(rig: Rig) -> list[_Trial]:
    trials = []
    for axes in _rotations()[1:]:
        read = ", ".join(f"{name} is {_direction(axes, number)}" for number, name in enumerate(_AXES))
        problem = f"the poses have other axes than this layout's: what is read as {read}{_known_axes(axes)}"
        cure = "save the poses with the axes of their layout (docs/captures.md)"
        trials.append(_Trial(Rig(rig.intrinsics, axes @ rig.poses), problem, cure))
    return trials


def _direction(axes: Floats, read: int) -> str:
    """Return in words where the axis that is read as number `read` truly points."""
    true = int(np.abs(axes[:3, read]).argmax())
    return _AXES[true] if axes[true, read] > 0 else _OPPOSITE[_AXES[true]]


def _known_axes(axes: Floats) -> str:
    known: dict[tuple[tuple[int, ...], ...], str] = {
        ((1, 0, 0), (0, -1, 0), (0, 0, -1)): "OpenGL's axes for OpenCV's, or the other way round",
        ((0, 1, 0), (1, 0, 0), (0, 0, -1)): "OpenCV's columns in poses_bounds.npy, which has LLFF's",
        ((0, 1, 0), (-1, 0, 0), (0, 0, 1)): "OpenGL's columns in poses_bounds.npy, which has LLFF's",
    }
    words = known.get(tuple(tuple(int(v) for v in row) for row in axes[:3, :3].tolist()))
    return f" ({words})" if words else ""


def _inverse_of_rig(rig: Rig) -> list[_Trial]:
    problem = "the poses are inverted: world-to-camera where this layout has camera-to-world, or the other way round"
    inverse = np.linalg.inv(rig.poses)
    return [
        _Trial(Rig(rig.intrinsics, axes @ inverse), problem, "save the inverse of each matrix") for axes in _rotations()
    ]


def _order_of_names(rig: Rig, names: Sequence[str]) -> list[_Trial]:
    """Poses in the order of the names as text, where 10 comes before 2."""
    order = sorted(range(len(names)), key=lambda number: names[number])
    row_of = {camera: row for row, camera in enumerate(order)}
    if order == sorted(order):
        return []
    problem = "the poses are in the order of the names as text, in which 10 comes before 2"
    return [_Trial(rig.rearranged([row_of[i] for i in range(len(names))]), problem, "put them in order of the numbers")]


def _turned_trial(rig: Rig, axes: Floats) -> _Trial:
    if axes[2, 2] == 1:
        degrees = round(float(np.degrees(np.arctan2(axes[1, 0], axes[0, 0])))) % 360
        words = f"its picture is turned by {degrees} degrees{', upside down' if degrees == 180 else ''}"
        return _Trial(rig, words, "turn its pictures, or calibrate it as they are")
    return _Trial(rig, f"its pose has other axes than the others'{_known_axes(axes)}", "save all poses alike")


def _focal_trial(rig: Rig, factor: float, whose: str) -> _Trial:
    problem = f"the focal length of {whose} is wrong: {factor:.2f} times it fits"
    return _Trial(rig, problem, "give it in pixels of these pictures, or calibrate again", cost=1.2)


def _best_focal(error: Callable[[float], float]) -> float:
    coarse = min(_FOCALS, key=error)
    step = _FOCALS[1] / _FOCALS[0]
    return float(min(coarse * step ** np.linspace(-1, 1, 21), key=error))


def _lenses(rig: Rig, pairs: Pairs) -> list[_Trial]:
    """Pictures of bent lenses taken for pinhole pictures: equidistant fisheyes, and one radial coefficient."""

    def straight(radius: Callable[[Floats], Floats]) -> Pairs:
        return {
            (a, b): Pair(_bent(rig, a, one.first, radius), _bent(rig, b, one.second, radius), one.weight)
            for (a, b), one in pairs.items()
        }

    fisheye = "the pictures are of fisheye lenses and were taken for pinhole pictures"
    cure = "undistort them first, or give the lens with the poses"
    trials = [_Trial(rig, fisheye, cure, straight(lambda r: np.tan(np.minimum(r, 1.5))))]
    bends = [k for k in np.linspace(-0.4, 0.4, 33) if abs(k) > 0.02]
    best = min(bends, key=lambda k: _error(rig, straight(lambda r: r * (1 + k * r * r))))
    distorted = "the pictures are distorted and were taken for pinhole pictures"
    trials.append(_Trial(rig, distorted, cure, straight(lambda r: r * (1 + best * r * r)), cost=1.3))
    return trials


def _bent(rig: Rig, camera: int, pixels: Floats, radius: Callable[[Floats], Floats]) -> Floats:
    """Return the pixels moved along rays from the principal point; `radius` takes and gives units of the focal."""
    k = rig.intrinsics[camera]
    local = (pixels - k[:2, 2]) / np.diag(k)[:2]
    r = np.maximum(np.linalg.norm(local, axis=1, keepdims=True), 1e-9)
    return np.asarray(local * (radius(r) / r) * np.diag(k)[:2] + k[:2, 2])
