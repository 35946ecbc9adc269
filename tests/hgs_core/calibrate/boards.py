"""A board that is held before five cameras, rendered from its print."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hgs_core.calibrate.board import Board
from hgs_core.scene.camera import Camera, looking_at

BOARD = Board(7, 5, square=0.08, marker=0.06)
CAMERAS, FRAMES = 5, 6
WIDTH, HEIGHT, FOCAL = 640, 480, 610.0
_PRINT = 40  # pixels of a square


def rig() -> list[Camera]:
    """Cameras on an arc, 2 m from the middle of the room and 1.2 m above the floor, which is y = 0."""
    found = []
    for number in range(CAMERAS):
        angle = 0.35 * (number - 2)
        pose = looking_at([2 * np.sin(angle), -1.2, -2 * np.cos(angle)], [0.0, -0.6, 0.0])
        found.append(Camera(f"cam{number}", WIDTH, HEIGHT, FOCAL, FOCAL, WIDTH / 2, HEIGHT / 2, pose))
    return found


def board_pose(frame: int) -> npt.NDArray[np.float64]:
    """Where the board is held, from its own axes to the world's; at frame 0 it lies on the floor."""
    pose = np.eye(4)
    if frame == 0:
        pose[:3, :3] = [[1, 0, 0], [0, 0, 1], [0, -1, 0]]
        pose[:3, 3] = [-0.28, 0.0, 0.2]
        return pose
    a, b = 0.5 * np.sin(1.7 * frame), 0.4 * np.cos(2.3 * frame)
    turn = np.array([[np.cos(a), 0, np.sin(a)], [0, 1, 0], [-np.sin(a), 0, np.cos(a)]])
    tilt = np.array([[1, 0, 0], [0, np.cos(b), -np.sin(b)], [0, np.sin(b), np.cos(b)]])
    pose[:3, :3] = turn @ tilt
    pose[:3, 3] = np.array([0.3 * np.sin(frame), -0.7 + 0.1 * np.cos(frame), 0.2 * np.cos(2 * frame)]) - pose[
        :3, :3
    ] @ [0.28, 0.2, 0]
    return pose


def photograph(camera: Camera, frame: int) -> npt.NDArray[np.uint8]:
    """Return the picture [H, W, 3] of a camera, without distortion."""
    import cv2

    aruco = cv2.aruco
    family = aruco.getPredefinedDictionary(getattr(aruco, f"DICT_{BOARD.dictionary}"))
    pattern = aruco.CharucoBoard((BOARD.columns, BOARD.rows), BOARD.square, BOARD.marker, family)
    size = BOARD.columns * _PRINT, BOARD.rows * _PRINT
    print_ = cv2.copyMakeBorder(pattern.generateImage(size), 20, 20, 20, 20, cv2.BORDER_CONSTANT, value=255)
    to_metres = np.array([[BOARD.square / _PRINT, 0, 0], [0, BOARD.square / _PRINT, 0], [0, 0, 0], [0, 0, 1]])
    to_metres[:2, 3 - 1] = 0.5 * BOARD.square / _PRINT - 20 * BOARD.square / _PRINT  # the first pixel's centre
    to_pixels = np.array([[camera.fx, 0, camera.cx - 0.5], [0, camera.fy, camera.cy - 0.5], [0, 0, 1.0]])
    flat = to_pixels @ (camera.world_to_camera @ board_pose(frame) @ to_metres)[:3]
    grey = cv2.warpPerspective(
        print_,
        flat,
        (camera.width, camera.height),
        flags=cv2.INTER_AREA,
        borderMode=cv2.BORDER_CONSTANT,
        borderValue=110,
    )
    return np.repeat(cv2.GaussianBlur(grey, (3, 3), 0.6)[..., None], 3, axis=2)
