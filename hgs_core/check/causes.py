"""Why poses do not fit: mistakes that people make are tried, and the one that makes the matches fit is named."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import combinations

import numpy as np
import numpy.typing as npt

from hgs_core.check.epipolar import ComparedPairs, Pair, Pairs, Rig, pair_errors
from hgs_core.check.readings import known_axes, readings, rotations
from hgs_core.check.trials import FITS, Cause, Trial, best_trial, fitting
from hgs_core.check.turning import turned_to_fit

__all__ = ["cause_of_camera", "cause_of_rig", "mean_error", "reading_trials", "swapped_cameras"]

Floats = npt.NDArray[np.float64]

_COUNTED = 0.8  # share of pairs, the smallest errors first
_FOCALS = np.exp(np.linspace(np.log(0.4), np.log(2.5), 75))
_UNITS = {0.01: "centimetres", 0.001: "millimetres", 0.1: "decimetres", 0.0254: "inches", 0.3048: "feet"}
_FEW = 6  # cameras; among more, a majority tells which are swapped
_RATIOS = (0.25, 1 / 3, 0.5, 2 / 3, 0.75, 4 / 3, 1.5, 2.0, 3.0, 4.0)  # focal lengths of pictures that were scaled
_NEAR, _AS_WELL = 0.02, 1.5  # share by which a focal length may differ from that, and its error from the least


def cause_of_rig(rig: Rig, pairs: ComparedPairs, names: Sequence[str], fits: float = FITS) -> Cause | None:
    """Return the mistake that was made with all cameras alike, None if none of those tried explains the matches.

    Silhouettes may stand for matches; `fits` is the distance in pixels below which these are explained. Poses that are
    reflections are a mistake even where matches lie as they say.
    """
    before = np.inf if rig.mirrored else mean_error(rig, pairs)
    trials = reading_trials(rig, names)
    if not rig.mirrored:
        focal, exact = _best_focal(lambda factor: mean_error(rig.with_focal(factor), pairs))
        trials.append(_focal_trial(rig.with_focal(focal), focal, "all cameras", exact))
        matches = {pair: one for pair, one in pairs.items() if isinstance(one, Pair)}
        trials += _lenses(rig, matches) if matches else []
    errors = [mean_error(trial.rig, trial.pairs or pairs) for trial in trials]
    found = best_trial(trials, before, errors, fits)
    return None if found is None else trials[found].cause(rig, errors[found])


def reading_trials(rig: Rig, names: Sequence[str]) -> list[Trial]:
    """Return the rig with its matrices read in all other ways, and with those of two cameras exchanged."""
    count = len(names)
    orders = []
    if count <= _FEW:
        for a, b in combinations(range(count), 2):
            order = list(range(count))
            order[a], order[b] = b, a
            problem = f"{names[a]} and {names[b]} are swapped"
            orders.append((tuple(order), problem, "exchange their files or their poses"))
    by_text = sorted(range(count), key=lambda number: names[number])
    if by_text != sorted(by_text):
        row_of = {camera: row for row, camera in enumerate(by_text)}
        problem = "the poses are in the order of the names as text, in which 10 comes before 2"
        orders.append((tuple(row_of[i] for i in range(count)), problem, "put them in order of the numbers"))
    trials = []
    if not rig.mirrored:
        trials = [Trial(rig.rearranged(order), problem, cure, cost=1.2, order=order) for order, problem, cure in orders]
    for reading in readings(rig.poses):
        read = Rig(rig.intrinsics, reading.poses(rig.poses))
        trials.append(Trial(read, reading.problem(), reading.cure(), cost=reading.cost))
        if reading.usual:
            trials += [
                Trial(
                    read.rearranged(order), f"{reading.problem()}, and {problem}", reading.cure(), cost=1.3, order=order
                )
                for order, problem, _ in orders
            ]
    return trials


def cause_of_camera(
    rig: Rig, pairs: ComparedPairs, camera: int, agreeing: Sequence[int], fits: float = FITS
) -> Cause | None:
    """Return the mistake that was made with one camera, None if none of those tried explains its matches."""
    mine = {pair: one for pair, one in pairs.items() if camera in pair and set(pair) <= {camera, *agreeing}}
    if not mine:
        return None
    before = mean_error(rig, mine)
    pose = rig.poses[camera]
    trials = []
    for axes in rotations():
        trials.append(_turned_trial(rig.with_pose(camera, axes @ pose), axes))
        undone = axes.T @ np.linalg.inv(pose) @ axes.T
        trials.append(
            Trial(rig.with_pose(camera, undone), "its pose is inverted", "save the inverse of its matrix", cost=2)
        )
    focal, exact = _best_focal(lambda factor: mean_error(rig.with_focal(factor, camera), mine))
    trials.append(_focal_trial(rig.with_focal(focal, camera), focal, "the camera", exact))
    centre = rig.centres()[camera]
    for unit, name in _UNITS.items():
        for scale, words in ((unit, name), (1 / unit, f"a unit of 1/{unit:g}")):
            moved = pose.copy()
            moved[:3, 3] = -pose[:3, :3] @ (centre * scale)
            problem = f"its position is in another unit: times {scale:g} it fits ({words} among metres?)"
            trials.append(Trial(rig.with_pose(camera, moved), problem, "give all positions in one unit"))
    matches = {pair: one for pair, one in mine.items() if isinstance(one, Pair)}
    if matches:
        fitted, degrees = turned_to_fit(rig, matches, camera)
        problem = f"it is turned by {degrees:.1f} degrees from where its pose says, as after a knock"
        trials.append(
            Trial(rig.with_pose(camera, fitted), problem, "calibrate it again, or leave it out", cost=3, exact=False)
        )
    errors = [mean_error(trial.rig, mine) for trial in trials]
    found = best_trial(trials, before, errors, fits)
    return None if found is None else trials[found].cause(rig, errors[found])


def swapped_cameras(
    rig: Rig, pairs: ComparedPairs, odd: Sequence[int], agreeing: Sequence[int], fits: float = FITS
) -> list[tuple[int, int]]:
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
        if all(mine and fitting(mean_error(exchanged, mine), mean_error(rig, mine), fits) for mine in both):
            found.append((a, b))
    return found


def mean_error(rig: Rig, pairs: ComparedPairs) -> float:
    """Return the mean of the pairs' medians without the worst fifth, possibly chance matches."""
    errors = np.sort(list(pair_errors(rig, pairs).values()))
    return float(errors[: int(np.ceil(_COUNTED * len(errors)))].mean())


def _turned_trial(rig: Rig, axes: Floats) -> Trial:
    if axes[2, 2] == 1:
        degrees = round(float(np.degrees(np.arctan2(axes[1, 0], axes[0, 0])))) % 360
        words = f"its picture is turned by {degrees} degrees{', upside down' if degrees == 180 else ''}"
        return Trial(rig, words, "turn its pictures, or calibrate it as they are")
    return Trial(rig, f"its pose has other axes than the others'{known_axes(axes)}", "save all poses alike")


def _focal_trial(rig: Rig, factor: float, whose: str, exact: bool) -> Trial:
    problem = f"the focal length of {whose} is wrong: {factor:.2f} times it fits"
    return Trial(rig, problem, "give it in pixels of these pictures, or calibrate again", cost=1.2, exact=exact)


def _best_focal(error: Callable[[float], float]) -> tuple[float, bool]:
    """Return the factor that fits best, and whether it is that of pictures that were scaled: a simple ratio."""
    coarse = min(_FOCALS, key=error)
    step = _FOCALS[1] / _FOCALS[0]
    best = float(min(coarse * step ** np.linspace(-1, 1, 21), key=error))
    for ratio in _RATIOS:
        if abs(best / ratio - 1) < _NEAR and error(ratio) < _AS_WELL * error(best):
            return ratio, True
    return best, False


def _lenses(rig: Rig, pairs: Pairs) -> list[Trial]:
    """Pictures of bent lenses taken for pinhole pictures: equidistant fisheyes, and one radial coefficient."""

    def straight(radius: Callable[[Floats], Floats]) -> Pairs:
        return {
            (a, b): Pair(_bent(rig, a, one.first, radius), _bent(rig, b, one.second, radius), one.weight)
            for (a, b), one in pairs.items()
        }

    fisheye = "the pictures are of fisheye lenses and were taken for pinhole pictures"
    cure = "undistort them first, or give the lens with the poses"
    trials = [Trial(rig, fisheye, cure, straight(lambda r: np.tan(np.minimum(r, 1.5))), exact=False)]
    bends = [k for k in np.linspace(-0.4, 0.4, 33) if abs(k) > 0.02]
    best = min(bends, key=lambda k: mean_error(rig, straight(lambda r: r * (1 + k * r * r))))
    distorted = "the pictures are distorted and were taken for pinhole pictures"
    trials.append(Trial(rig, distorted, cure, straight(lambda r: r * (1 + best * r * r)), cost=1.3, exact=False))
    return trials


def _bent(rig: Rig, camera: int, pixels: Floats, radius: Callable[[Floats], Floats]) -> Floats:
    """Return the pixels moved along rays from the principal point; `radius` takes and gives units of the focal."""
    k = rig.intrinsics[camera]
    local = (pixels - k[:2, 2]) / np.diag(k)[:2]
    r = np.maximum(np.linalg.norm(local, axis=1, keepdims=True), 1e-9)
    return np.asarray(local * (radius(r) / r) * np.diag(k)[:2] + k[:2, 2])
