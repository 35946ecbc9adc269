"""Cameras of COLMAP: sparse/0/cameras and images, .bin or .txt; or one such model for each frame.

An image of the model gives its camera. Of several models (sparse/0, sparse/1, ...) the one counts that has most of the
cameras whose footage lies in the folder. A capture of fixed cameras has one image for each camera (cam00.png, or
cam00/0000.png), or all frames of a camera in a folder of its own, whose poses agree; their median is the camera's.
SpacetimeGaussians writes a model for every frame, colmap_0/sparse/0, colmap_1/sparse/0, ...: their cameras must agree.
"""

from __future__ import annotations

import dataclasses
import re
from collections import defaultdict
from pathlib import Path, PurePosixPath

from hgs_core.base.errors import InputError
from hgs_core.base.wording import counted
from hgs_core.capture.cameras.colmap_model import ColmapCamera, ColmapImage, model_files, read_model
from hgs_core.capture.cameras.rig import CalibratedCamera, CameraFormat, Rig
from hgs_core.capture.cameras.steady_pose import differing, median_pose, rig_radius, same_pose, spread, strays
from hgs_core.capture.files.named_files import plain_name
from hgs_core.capture.footage import find_places
from hgs_core.capture.lenses.colmap_lens import colmap_intrinsics
from hgs_core.capture.pictures.picture import list_folders

__all__ = ["COLMAP"]

_FOLDERS = (
    "sparse",
    "colmap/sparse",
    "colmap",
    "sparse_",
    ".",
)  # folders of models, or of folders 0, 1, ... with models
_NUMBER = re.compile(r"[0-9]{1,4}")
_OF_A_FRAME = re.compile(r"(?:colmap|frame|time|t)?[_-]?(\d+)")


def _read(capture: Path, file: Path) -> Rig:
    of_frames = _models_of_frames(capture)
    folders = of_frames if file.parent in of_frames else [file.parent]
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
        radius = rig_radius([image.world_to_camera for image in agreed.values()])
        for image in images:
            if not same_pose(image.world_to_camera, agreed[image.name].world_to_camera, radius):
                problem = f"the camera of {image.name} is not where {folders[0].relative_to(capture)} has it"
                raise InputError(found[1], problem, "only captures with fixed cameras are supported")
    assert first is not None
    found_cameras, differ = _fixed_cameras(files[1], *first)
    notes = [differing(differ)] if differ else []
    return Rig(tuple(files), found_cameras, notes=(*_of_others(capture, file), *notes))


def _fixed_cameras(
    file: Path, cameras: dict[int, ColmapCamera], images: list[ColmapImage]
) -> tuple[list[CalibratedCamera], str]:
    """Return the cameras, and by how much poses of one differ."""
    folders: dict[str, list[ColmapImage]] = defaultdict(list)
    for image in images:
        folders[str(_path(image).parent)].append(image)
    radius = rig_radius([image.world_to_camera for image in images])
    found, standing = [], []
    for folder, inside in folders.items():
        poses = [image.world_to_camera for image in inside]
        if len(inside) > 1 and folder != "." and all(same_pose(pose, poses[0], radius) for pose in poses):
            standing.append(poses)
            one = dataclasses.replace(inside[0], world_to_camera=median_pose(poses))
            found.append(_camera(file, one, cameras, (folder, PurePosixPath(folder).name)))
            continue
        if folder != "." and (stray := strays(poses, radius)):
            problem = f"{inside[stray[0]].name} has another pose than most pictures of its camera"
            more = f", and {len(stray) - 1} more like this" if len(stray) > 1 else ""
            cure = "remove it from the model: colmap image_deleter, or its two lines of images.txt"
            raise InputError(file, f"{problem}{more}", cure)
        for image in inside:
            path = _path(image)
            whole = str(path.with_suffix("")) if path.name else image.name
            names = (whole, path.parent.name, path.stem) if len(inside) == 1 and folder != "." else (whole, path.stem)
            found.append(_camera(file, image, cameras, names))
    return sorted(found, key=lambda camera: camera.names[0]), spread(standing, radius)


def _path(image: ColmapImage) -> PurePosixPath:
    return PurePosixPath(image.name.replace("\\", "/"))


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


def _models(capture: Path) -> list[Path]:
    """Return the folders of all models but those of frames: of each folder 0, 1, ... in it first."""
    found = []
    for name in _FOLDERS:
        below = list_folders(capture / name) if name != "." else []
        numbers = sorted((one for one in below if _NUMBER.fullmatch(one)), key=int)
        found += [folder for one in (*numbers, ".") if model_files(folder := capture / name / one)]
    return found


def _ranked(capture: Path) -> list[tuple[Path, tuple[int, int, int]]]:
    """Return the folders of all models, the best first, and the reason for the best.

    That are cameras with footage, cameras, and bytes of images; none of a damaged model. Its number means nothing.
    """
    folders = _models(capture)
    if len(folders) < 2:
        return [(folder, (0, 0, 0)) for folder in folders]
    footage = {plain_name(one.name) for place in find_places(capture) for one in place.footage}
    ranks = [_rank(folder, footage) for folder in folders]
    return sorted(zip(folders, ranks, strict=True), key=lambda pair: pair[1], reverse=True)  # the first among equals


def _rank(folder: Path, footage: set[str]) -> tuple[int, int, int]:
    files = model_files(folder)
    assert files is not None, folder
    try:
        cameras, _ = _fixed_cameras(files[1], *read_model(*files))
    except InputError:
        return 0, 0, 0
    seen = sum(any(plain_name(name) in footage for name in camera.names) for camera in cameras)
    return seen, len(cameras), files[1].stat().st_size


def _of_others(capture: Path, file: Path) -> list[str]:
    """Say which model is taken, where there are several."""
    cameras = {folder: rank[1] for folder, rank in _ranked(capture)}
    if len(cameras) < 2 or file.parent not in cameras:
        return []
    named = {folder: f"{folder.relative_to(capture)} ({counted(count, 'camera')})" for folder, count in cameras.items()}
    left = ", ".join(name for folder, name in named.items() if folder != file.parent)
    return [f"the cameras are those of {named[file.parent]}; {left} is left aside"]


def _find(capture: Path) -> Path | None:
    folders = _models_of_frames(capture)
    models = _ranked(capture)
    folder = models[0][0] if models else folders[0] if folders else None
    found = model_files(folder) if folder is not None else None
    return found[1] if found else None


COLMAP = CameraFormat("COLMAP", "sparse/0/cameras.bin and images.bin (or .txt)", _find, _read)
