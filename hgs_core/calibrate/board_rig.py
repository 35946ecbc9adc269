"""Poses and lenses of a rig from sightings of a board: metres, and no need to share a view of the scene itself."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from hgs_core.base.errors import InputError
from hgs_core.calibrate.board import Board, Sighting, open_cv
from hgs_core.calibrate.structure import Solution, SolvedCamera

__all__ = ["cameras_of_board"]

_FIRST_FOCAL = 1.2  # longer sides; the default for too few sightings
_FEWEST_FOR_LENS = 4  # sightings by one camera from which its own lens is estimated first
_ROUNDS = 60
_OUTLIER = 2.0  # pixels from which on a corner counts less
_STRAIGHT = 10.0  # square pixels that a distortion coefficient of 1 costs: as much as corners that are 0.3 off for 0.1
_LARGEST_ERROR = 2.0  # pixels on average
_SETTLED = 1e-7  # share of the squared error that a round must win

Floats = npt.NDArray[np.float64]


@dataclass
class _State:
    """The unknowns: lenses (f, k1, k2) and poses (axis times angle, place) of cameras and of the board."""

    lenses: Floats  # [C, 3]
    cameras: Floats  # [C, 6] from the world
    boards: Floats  # [M, 6] to the world

    def moved(self, step: Floats) -> _State:
        lenses, cameras, boards = (part.size for part in (self.lenses, self.cameras, self.boards))
        a, b, c = np.split(step[: lenses + cameras + boards], [lenses, lenses + cameras])
        return _State(self.lenses + a.reshape(-1, 3), self.cameras + b.reshape(-1, 6), self.boards + c.reshape(-1, 6))


def cameras_of_board(
    where: Path,
    names: Sequence[str],
    sizes: Sequence[tuple[int, int]],  # width and height of each camera's pictures
    board: Board,
    sightings: Sequence[Sighting],
    focal: float | None = None,  # pixels, of all cameras, for lenses without distortion
    floor: bool = False,  # whether the board lies on the floor where it is first seen
) -> Solution:
    """Return the cameras in metres. With `floor` y is 0 on it, and the origin is the board's middle there.

    Raises:
        InputError: a camera does not see the board, or is joined to the others by no moment; or the corners do not fit
            any poses.
    """
    cure = "show the board to neighbouring cameras at the same moment, near enough that its markers are sharp"
    blind = [name for i, name in enumerate(names) if not any(one.camera == i for one in sightings)]
    if blind:
        raise InputError(where, f"the board is not seen by {', '.join(blind)}", f"is it the one described? Else {cure}")
    moments = sorted({one.moment for one in sightings})
    state, joined = _first(sizes, board, sightings, moments, focal)
    apart = [name for name, there in zip(names, joined, strict=True) if not there]
    if apart:
        raise InputError(where, f"{', '.join(apart)} never sees the board while the others do", cure)
    state, error = _adjusted(state, sizes, board, sightings, moments, focal is None)
    if error > _LARGEST_ERROR:
        problem = f"the poses that fit the board best leave {error:.1f} px on average"
        raise InputError(where, problem, "is its size in squares right, are the videos in step, and is it flat?")
    to_floor = _matrix(state.boards[0]) if floor else np.eye(4)
    if floor:
        middle = np.eye(4)
        middle[:3, 3] = board.square * np.array([board.columns, board.rows, 0]) / 2
        to_floor = to_floor @ middle @ _LYING
    cameras = []
    for index, (name, (width, height)) in enumerate(zip(names, sizes, strict=True)):
        focal_length, k1, k2 = state.lenses[index].tolist()
        pose = _matrix(state.cameras[index]) @ to_floor
        corners = sum(len(one.corners) for one in sightings if one.camera == index)
        lens = (focal_length, width / 2, height / 2, k1, k2)
        cameras.append(SolvedCamera(name, width, height, "RADIAL", lens, pose, corners))
    points = np.concatenate([board.corners @ _matrix(row)[:3, :3].T + row[3:] for row in state.boards])
    if floor:
        back = np.linalg.inv(to_floor)
        points = points @ back[:3, :3].T + back[:3, 3]
    return Solution(tuple(cameras), np.asarray(points), error)


# A board that lies on the floor has its z, which points away from who looks at it, downwards: our y.
_LYING = np.array([[1.0, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]])


def _first(
    sizes: Sequence[tuple[int, int]],
    board: Board,
    sightings: Sequence[Sighting],
    moments: Sequence[int],
    focal: float | None,
) -> tuple[_State, npt.NDArray[np.bool_]]:
    """Return where to begin: lenses and poses one sighting at a time, and which cameras that has joined."""
    cv2, count = open_cv(), len(sizes)
    lenses = np.zeros((count, 3))
    for camera, size in enumerate(sizes):
        lenses[camera, 0] = focal or _own_focal(board, [s for s in sightings if s.camera == camera], size)
    seen: dict[tuple[int, int], tuple[Floats, float]] = {}  # pose of the board for the camera, and how sure it is
    for one in sightings:
        matrix = _intrinsics(lenses[one.camera], sizes[one.camera])
        found, turn, place = cv2.solvePnP(board.corners[one.corners], one.xy, matrix, None, flags=cv2.SOLVEPNP_IPPE)
        if found:
            pose = _matrix(np.concatenate([turn.ravel(), place.ravel()]))
            seen[one.camera, moments.index(one.moment)] = pose, float(len(one.corners))
    cameras: dict[int, Floats] = {
        max(range(count), key=lambda c: sum(w for (a, _), (_, w) in seen.items() if a == c)): np.eye(4)
    }
    boards: dict[int, Floats] = {}
    while True:  # the surest sighting that joins something
        edges = [(w, c, m) for (c, m), (_, w) in seen.items() if (c in cameras) != (m in boards)]
        if not edges:
            break
        _, camera, moment = max(edges)
        pose = seen[camera, moment][0]
        if camera in cameras:
            boards[moment] = np.linalg.inv(cameras[camera]) @ pose
        else:
            cameras[camera] = pose @ np.linalg.inv(boards[moment])
    joined = np.array([camera in cameras for camera in range(count)])
    rows = np.array([_vector(cameras.get(camera, np.eye(4))) for camera in range(count)])
    return _State(lenses, rows, np.array([_vector(boards.get(m, np.eye(4))) for m in range(len(moments))])), joined


def _own_focal(board: Board, sightings: Sequence[Sighting], size: tuple[int, int]) -> float:
    """Return the focal length that a camera's own sightings tell, or a usual one where they are few."""
    usual = _FIRST_FOCAL * max(size)
    if len(sightings) < _FEWEST_FOR_LENS:
        return usual
    cv2 = open_cv()
    flags = cv2.CALIB_USE_INTRINSIC_GUESS | cv2.CALIB_FIX_PRINCIPAL_POINT | cv2.CALIB_FIX_ASPECT_RATIO
    flags |= cv2.CALIB_ZERO_TANGENT_DIST | cv2.CALIB_FIX_K1 | cv2.CALIB_FIX_K2 | cv2.CALIB_FIX_K3
    objects = [board.corners[one.corners].astype(np.float32) for one in sightings]
    images = [one.xy.astype(np.float32) for one in sightings]
    guess = _intrinsics(np.array([usual, 0, 0]), size)
    matrix = cv2.calibrateCamera(objects, images, size, guess, np.zeros(5), flags=flags)[1]
    told = float(matrix[0, 0])
    return told if 0.3 * max(size) < told < 10 * max(size) else usual


def _adjusted(
    state: _State,
    sizes: Sequence[tuple[int, int]],
    board: Board,
    sightings: Sequence[Sighting],
    moments: Sequence[int],
    lenses: bool,
) -> tuple[_State, float]:
    """Return the best fit to all corners, and the mean error in pixels: Levenberg-Marquardt, robust to outliers.

    The poses as a whole may move freely, which damping holds.
    """
    damping, before = 1e-3, np.inf
    normal, right, cost, error = _equations(state, sizes, board, sightings, moments, lenses)
    for _ in range(_ROUNDS):
        diagonal = np.diag(normal).copy()
        fixed = diagonal < 1e-12
        diagonal[fixed] = 1.0
        step = np.asarray(np.linalg.solve(normal + np.diag(damping * diagonal + fixed), right), np.float64)
        trial = state.moved(step)
        tried = _equations(trial, sizes, board, sightings, moments, lenses)
        if tried[2] < cost:
            before, state, (normal, right, cost, error) = cost, trial, tried
            damping = max(damping / 5, 1e-9)
            if before - cost < _SETTLED * before:
                break
        else:
            damping *= 5
            if damping > 1e9:
                break
    return state, error


def _equations(
    state: _State,
    sizes: Sequence[tuple[int, int]],
    board: Board,
    sightings: Sequence[Sighting],
    moments: Sequence[int],
    lenses: bool,
) -> tuple[Floats, Floats, float, float]:
    """Return the normal equations of a step, the robust cost, and the mean error in pixels."""
    cv2 = open_cv()
    first_camera, first_board = state.lenses.size, state.lenses.size + state.cameras.size
    size = first_board + state.boards.size
    normal, right, cost, total, count = np.zeros((size, size)), np.zeros(size), 0.0, 0.0, 0
    for one in sightings:
        moment = moments.index(one.moment)
        lens, camera, pose = state.lenses[one.camera], state.cameras[one.camera], state.boards[moment]
        both = cv2.composeRT(pose[:3], pose[3:], camera[:3], camera[3:])
        turn, place = both[0], both[1]
        of_turn, of_place = np.hstack(both[2:6]), np.hstack(both[6:10])  # [3, 12] by board's and camera's parameters
        matrix = _intrinsics(lens, sizes[one.camera])
        shown, by = cv2.projectPoints(board.corners[one.corners], turn, place, matrix, np.array([*lens[1:], 0, 0]))[:2]
        left = (one.xy - shown.reshape(-1, 2)).ravel()
        poses = by[:, :3] @ of_turn + by[:, 3:6] @ of_place
        own = np.column_stack([by[:, 6] + by[:, 7], by[:, 10], by[:, 11]])  # fx and fy are one
        if not lenses:
            own[:] = 0.0
        columns = np.concatenate(
            [
                3 * one.camera + np.arange(3),
                first_board + 6 * moment + np.arange(6),
                first_camera + 6 * one.camera + np.arange(6),
            ]
        )
        jacobian = np.hstack([own, poses])
        far = np.repeat(np.hypot(left[::2], left[1::2]), 2)
        weights = np.minimum(1.0, _OUTLIER / np.maximum(far, 1e-9))  # Huber's
        normal[np.ix_(columns, columns)] += jacobian.T @ (weights[:, None] * jacobian)
        right[columns] += jacobian.T @ (weights * left)
        near = far[::2]
        cost += float(np.where(near < _OUTLIER, near**2, 2 * _OUTLIER * near - _OUTLIER**2).sum())
        total, count = total + float(near.sum()), count + len(near)
    for camera, lens in enumerate(
        state.lenses
    ):  # few sightings at the edges leave the distortion open: it is small then
        bends = 3 * camera + np.array([1, 2])
        normal[bends, bends] += _STRAIGHT
        right[bends] -= _STRAIGHT * lens[1:]
        cost += _STRAIGHT * float((lens[1:] ** 2).sum())
    return normal, right, cost, total / max(count, 1)


def _intrinsics(lens: Floats, size: tuple[int, int]) -> Floats:
    return np.array([[lens[0], 0, size[0] / 2], [0, lens[0], size[1] / 2], [0, 0, 1.0]])


def _matrix(row: Floats) -> Floats:
    pose: Any = np.eye(4)
    pose[:3, :3] = open_cv().Rodrigues(np.asarray(row[:3], np.float64))[0]
    pose[:3, 3] = row[3:]
    return np.asarray(pose)


def _vector(pose: Floats) -> Floats:
    return np.concatenate([open_cv().Rodrigues(pose[:3, :3])[0].ravel(), pose[:3, 3]])
