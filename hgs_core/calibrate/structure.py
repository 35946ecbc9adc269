"""Structure from motion of a rig: COLMAP's mappers on features of several moments, each matched within itself."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import numpy.typing as npt
from PIL import Image

from hgs_core.base.cores import core_pool
from hgs_core.base.progress import Progress, ProgressCallback
from hgs_core.calibrate.calibration_views import View
from hgs_core.points.features import mutual_matches
from hgs_core.points.matching import likely_pairs

__all__ = ["Solution", "SolvedCamera", "solve"]

_FEWEST_MATCHES = 15  # matches of a pair
_FIRST_FOCAL = 1.0  # longer sides; a first guess between phones and action cameras
_DIFFERENT_LENSES = 0.6  # pixels of error with one lens for all, from which on each its own is tried
_LOSS_SCALE = 0.5  # pixels
_SEED = 0

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class SolvedCamera:
    """A camera that was found."""

    name: str
    width: int
    height: int
    model: str  # COLMAP's name
    parameters: tuple[float, ...]
    world_to_camera: Floats  # [4, 4], in units of its own
    observations: int  # features that points of the scene explain


@dataclass(frozen=True)
class Solution:
    """The largest part of a rig that fits together."""

    cameras: tuple[SolvedCamera, ...]
    points: Floats  # [P, 3]
    error: float  # mean reprojection error, pixels


def solve(views: Sequence[View], progress: ProgressCallback) -> Solution | None:
    """Find the cameras of as many views as fit together; None if not even two do.

    Views without known intrinsics share one focal length and one radial coefficient per size of pictures, unless each
    its own fits better. Equal input gives equal results.
    """
    from hgs_core.points.colmap_points import pycolmap

    pycolmap.logging.minloglevel = 3  # nothing: what the mappers warn of, later steps repair
    matches = _match(views, progress)
    best = _best_model(pycolmap, views, matches, same_lens=True, progress=progress)
    if best is not None and not all(view.known for view in views) and best.error > _DIFFERENT_LENSES:
        other = _best_model(pycolmap, views, matches, same_lens=False, progress=progress)
        if other is not None and (len(other.cameras), -other.error) > (len(best.cameras), -best.error):
            best = other
    return None if best is None else best


def _best_model(
    pycolmap: Any,
    views: Sequence[View],
    matches: dict[tuple[int, int], npt.NDArray[np.uint32]],
    *,
    same_lens: bool,
    progress: ProgressCallback,
) -> Solution | None:
    """Map globally, and where that leaves a view out, step by step; return the model with most views."""
    known = all(view.known for view in views)
    with TemporaryDirectory(prefix="hgs-cameras-") as folder:
        database = Path(folder) / "database.db"
        _write_database(pycolmap, Path(folder), database, views, matches, same_lens)
        pycolmap.geometric_verification(database, verifier_options=pycolmap.GeometricVerifierOptions(num_threads=1))
        best: Any = None
        for number, mapper in enumerate((_global, _incremental)):
            progress(Progress("mapping", number, 2))
            pycolmap.set_random_seed(_SEED)
            for model in mapper(pycolmap, database, Path(folder), known):
                if best is None or _rank(model) > _rank(best):
                    best = model
            if best is not None and best.num_reg_images() == len(views):
                break
        progress(Progress("mapping", 2, 2))
        if best is None or best.num_reg_images() < 2:
            return None
        _refine(pycolmap, best, known)
        return _solution(best, views)


def _refine(pycolmap: Any, model: Any, known: bool) -> None:
    """Adjust everything once more with a loss that outliers hardly count in: mappers stop at a looser one."""
    options = pycolmap.BundleAdjustmentOptions()
    options.refine_focal_length = options.refine_extra_params = not known
    options.print_summary = False
    options.ceres.loss_function_type = pycolmap.LossFunctionType.CAUCHY
    options.ceres.loss_function_scale = _LOSS_SCALE
    options.ceres.solver_options.num_threads = 1
    chosen = pycolmap.BundleAdjustmentConfig()
    for image in model.reg_image_ids():
        chosen.add_image(image)
    chosen.fix_gauge(pycolmap.BundleAdjustmentGauge.TWO_CAMS_FROM_WORLD)
    pycolmap.create_default_bundle_adjuster(options, chosen, model).solve()  # bundle_adjustment() writes to stderr


def _rank(model: Any) -> tuple[int, int]:
    return model.num_reg_images(), len(model.points3D)


def _match(views: Sequence[View], progress: ProgressCallback) -> dict[tuple[int, int], npt.NDArray[np.uint32]]:
    starts = [np.cumsum([0, *(len(one.xy) for one in view.features)]) for view in views]
    wanted = likely_pairs([view.features for view in views])

    def of_pair(pair: tuple[int, int]) -> npt.NDArray[np.uint32]:
        a, b = pair
        found = [
            mutual_matches(one, other) + np.array([starts[a][moment], starts[b][moment]], np.uint32)
            for moment, (one, other) in enumerate(zip(views[a].features, views[b].features, strict=True))
        ]
        return np.concatenate(found).astype(np.uint32)

    result = {}
    with core_pool() as pool:
        for done, (pair, rows) in enumerate(zip(wanted, pool.map(of_pair, wanted), strict=True), 1):
            if len(rows) >= _FEWEST_MATCHES:
                result[pair] = rows
            progress(Progress("matches", done, len(wanted)))
    return result


def _write_database(
    pycolmap: Any,
    folder: Path,
    database: Path,
    views: Sequence[View],
    matches: dict[tuple[int, int], npt.NDArray[np.uint32]],
    same_lens: bool,
) -> None:
    pictures = folder / "pictures"
    pictures.mkdir()
    with pycolmap.Database.open(str(database)):
        pass
    names = [f"{number:05d}.png" for number in range(len(views))]
    for name, view in zip(names, views, strict=True):
        Image.new("L", (view.width, view.height)).save(pictures / name)  # COLMAP asks for the size alone
    for group in _alike(views, same_lens):
        options = pycolmap.ImageReaderOptions()
        options.camera_model = "PINHOLE" if views[group[0]].known else "SIMPLE_RADIAL"
        options.default_focal_length_factor = _FIRST_FOCAL
        mode = pycolmap.CameraMode.PER_IMAGE if views[group[0]].known else pycolmap.CameraMode.SINGLE
        pycolmap.import_images(database, pictures, mode, [names[number] for number in group], options)
    with pycolmap.Database.open(str(database)) as store:
        images = {image.name: image for image in store.read_all_images()}
        for name, view in zip(names, views, strict=True):
            if view.known is not None:
                camera = store.read_camera(images[name].camera_id)
                camera.params = [view.known.fx, view.known.fy, view.known.cx, view.known.cy]
                camera.has_prior_focal_length = True
                store.update_camera(camera)
            places = np.concatenate([one.xy for one in view.features]).astype(np.float32)
            store.write_keypoints(images[name].image_id, places)
        for (a, b), rows in matches.items():
            store.write_matches(images[names[a]].image_id, images[names[b]].image_id, rows)


def _alike(views: Sequence[View], same_lens: bool) -> list[list[int]]:
    """Return the views in groups that share a lens: those of one size without known intrinsics, or each alone."""
    groups: dict[object, list[int]] = {}
    for number, view in enumerate(views):
        groups.setdefault(number if view.known or not same_lens else (view.width, view.height), []).append(number)
    return list(groups.values())


def _global(pycolmap: Any, database: Path, folder: Path, known: bool) -> list[Any]:
    options = pycolmap.GlobalPipelineOptions(num_threads=1, random_seed=_SEED)
    options.min_model_size = 2
    for part in (options.mapper, options.mapper.rotation_averaging, options.mapper.global_positioning):
        part.random_seed = _SEED
    options.mapper.num_threads = 1
    options.mapper.global_positioning.use_gpu = False
    options.mapper.bundle_adjustment.ceres.use_gpu = False
    options.mapper.bundle_adjustment.refine_focal_length = not known
    options.mapper.bundle_adjustment.refine_extra_params = not known
    (folder / "global").mkdir()
    return list(pycolmap.global_mapping(database, folder / "pictures", folder / "global", options).values())


def _incremental(pycolmap: Any, database: Path, folder: Path, known: bool) -> list[Any]:
    options = pycolmap.IncrementalPipelineOptions(num_threads=1, random_seed=_SEED)
    options.min_model_size, options.extract_colors = 2, False
    if known:
        options.ba_refine_focal_length = options.ba_refine_principal_point = options.ba_refine_extra_params = False
    (folder / "incremental").mkdir()
    return list(pycolmap.incremental_mapping(database, folder / "pictures", folder / "incremental", options).values())


def _solution(model: Any, views: Sequence[View]) -> Solution:
    cameras = []
    for image in sorted(model.images.values(), key=lambda image: str(image.name)):
        if image.has_pose:
            view, camera = views[int(Path(image.name).stem)], model.cameras[image.camera_id]
            pose = np.eye(4)
            pose[:3] = image.cam_from_world().matrix()
            lens = tuple(float(value) for value in camera.params)
            cameras.append(
                SolvedCamera(view.name, view.width, view.height, camera.model.name, lens, pose, image.num_points3D)
            )
    points = np.array([point.xyz for point in model.points3D.values()]).reshape(-1, 3)
    return Solution(tuple(cameras), points, float(model.compute_mean_reprojection_error()))
