"""Cameras of COLMAP: sparse/0/cameras and images, .bin or .txt; or one such model for each frame.

An image of the model gives its camera. A capture of fixed cameras has one image for each camera (cam00.png, or
cam00/0000.png), or all frames of a camera in a folder of its own, whose poses agree. SpacetimeGaussians writes a model
for every frame, colmap_0/sparse/0, colmap_1/sparse/0, ...: their cameras must agree.
"""

from __future__ import annotations

import re
from collections import defaultdict
from pathlib import Path, PurePosixPath

import numpy as np

from hgs_core.base.errors import InputError
from hgs_core.capture.cameras.colmap_model import ColmapCamera, ColmapImage, model_files, read_model
from hgs_core.capture.cameras.rig import CalibratedCamera, CameraFormat, Rig
from hgs_core.capture.colmap_lens import colmap_intrinsics
from hgs_core.capture.picture import list_folders

__all__ = ["COLMAP"]

_FOLDERS = ("sparse/0", "sparse", "colmap/sparse/0", "colmap/sparse", "colmap", "sparse_", "sparse_/0", ".")
_OF_A_FRAME = re.compile(r"(?:colmap|frame|time|t)?[_-]?(\d+)")
_SAME_TURN = 2e-3  # radians, and
_SAME_PLACE = 2e-3  # of the rig's radius, by which poses of one camera may differ: structure from motion is not exact


def _read(capture: Path, file: Path) -> Rig:
    folders = _models_of_frames(capture) or [file.parent]
    first: tuple[dict[int, ColmapCamera], list[ColmapImage]] | None = None
    files: list[Path] = []
    agreed: dict[str, ColmapImage] = {}
    for folder in folders:
        found = model_files(folder)
        assert found is not None, folder
        files += found
        cameras, images = read_model(*found)
        if first is None:
            first = cameras, images
            agreed = {image.name: image for image in images}
            continue
        for name in agreed.keys() ^ {image.name for image in images}:
            problem = f"{name} is in this model or in that of {folders[0].relative_to(capture)}, but not in both"
            raise InputError(found[1], problem, "every frame needs the same cameras")
        radius = _radius(list(agreed.values()))
        for image in images:
            if not _same_pose(image, agreed[image.name], radius):
                problem = f"the camera of {image.name} is not where {folders[0].relative_to(capture)} has it"
                raise InputError(found[1], problem, "only captures with fixed cameras are supported")
    assert first is not None
    return Rig(tuple(files), _fixed_cameras(files[1], *first))


def _fixed_cameras(file: Path, cameras: dict[int, ColmapCamera], images: list[ColmapImage]) -> list[CalibratedCamera]:
    folders: dict[str, list[ColmapImage]] = defaultdict(list)
    for image in images:
        folders[str(PurePosixPath(image.name).parent)].append(image)
    radius = _radius(images)
    found = []
    for folder, inside in folders.items():
        stands = len(inside) > 1 and folder != "." and all(_same_pose(image, inside[0], radius) for image in inside)
        if stands:
            found.append(_camera(file, inside[0], cameras, (folder, PurePosixPath(folder).name)))
            continue
        for image in inside:
            path = PurePosixPath(image.name)
            whole = str(path.with_suffix(""))
            names = (whole, path.parent.name, path.stem) if len(inside) == 1 and folder != "." else (whole, path.stem)
            found.append(_camera(file, image, cameras, names))
    return sorted(found, key=lambda camera: camera.names[0])


def _camera(
    file: Path, image: ColmapImage, cameras: dict[int, ColmapCamera], names: tuple[str, ...]
) -> CalibratedCamera:
    camera, where = cameras[image.camera], f"{file}, image {image.name}"
    try:
        fx, fy, cx, cy, lens = colmap_intrinsics(camera.model, camera.parameters)
    except ValueError as error:
        raise InputError(where, str(error), "export it with a perspective or fisheye model") from error
    size = float(camera.width), float(camera.height)
    unique = tuple(dict.fromkeys(name for name in names if name))
    return CalibratedCamera(where, unique, image.world_to_camera, (fx, fy), (cx, cy), size, lens)


def _radius(images: list[ColmapImage]) -> float:
    places = np.array([-i.world_to_camera[:3, :3].T @ i.world_to_camera[:3, 3] for i in images])
    return float(np.linalg.norm(places - places.mean(axis=0), axis=1).max()) if len(places) > 1 else 0.0


def _same_pose(first: ColmapImage, second: ColmapImage, radius: float) -> bool:
    a, b = first.world_to_camera, second.world_to_camera
    turn = np.linalg.norm(a[:3, :3] - b[:3, :3]) / np.sqrt(2)  # the angle, for small ones
    moved = np.linalg.norm(a[:3, :3].T @ a[:3, 3] - b[:3, :3].T @ b[:3, 3])
    return bool(turn <= _SAME_TURN and moved <= _SAME_PLACE * radius + 1e-9)


def _models_of_frames(capture: Path) -> list[Path]:
    """Return the folders of one model for each frame, in order; empty if there are no two."""
    found = []
    for name in list_folders(capture):
        number = _OF_A_FRAME.fullmatch(name)
        if number:
            folder = next((f for f in (capture / name / "sparse/0", capture / name / "sparse") if model_files(f)), None)
            if folder is not None:
                found.append((int(number[1]), folder))
    return [folder for _, folder in sorted(found)] if len(found) > 1 else []


def _find(capture: Path) -> Path | None:
    for name in _FOLDERS:
        if found := model_files(capture / name):
            return found[1]
    folders = _models_of_frames(capture)
    found = model_files(folders[0]) if folders else None
    return found[1] if found else None


COLMAP = CameraFormat("COLMAP", "sparse/0/cameras.bin and images.bin (or .txt)", _find, _read)
